//! What follows from the 18 states: slip, normal load and share of drawbar pull of each wheel, and the forces of one side
//! with everything their comparison with a terrain model needs. Covariances by exact linear propagation G P Gᵀ.
//!
//! # Equation
//! Speed of a wheel's centre v ∓ r t_w/2 (left -, right +); library slip of R w against it; loads from the estimated
//! a_x, not the measured one: N_f = (m g l_r cos(pitch) - h (F_L + F_R))/(2L) a wheel, N_r = (m g l_f cos(pitch) + h (F_L + F_R))/(2L);
//! right wheels x (1 + λ), left wheels x (1 - λ), λ = 2 h v r/(g cos(pitch) t_w), in a turn.
//!
//! # Reference
//! L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", SPIE (2008). The share in proportion to
//! load is that paper's split; the division between front and rear is not observable, so it is no estimate.

use nalgebra::DMatrix;
use terra_model::{
    Dual8, ModelError, Real, STANDSTILL_SPEED, Vehicle, jacobian, library_slip, slip_from_speeds,
};

use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::spaces::longitudinal_robot::{F, GRAVITY, R, STATES, T, V, W};

/// A number with its 1-sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// The number.
    pub value: f64,
    /// Its standard deviation.
    pub sd: f64,
}

/// Whether a slip means anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipState {
    /// Yes.
    Moving,
    /// Rim and wheel centre below 0.05 m/s: slip is (R w - v)/0.05 m/s, and not for comparison with models.
    NearStandstill,
    /// Rim and wheel centre move in opposite directions: outside every model.
    AgainstMotion,
}

/// What the filter says about one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelEstimate {
    /// w \[rad/s\].
    pub wheel_speed: Value,
    /// Resistive torque \[N m\].
    pub torque: Value,
    /// Library slip \[1\]; `None` when the wheel turns against its motion.
    pub slip: Option<Value>,
    /// What that slip is worth.
    pub slip_state: SlipState,
    /// Normal load \[N\]; at or below zero the wheel lifts.
    pub normal_load: Value,
    /// Share of the side's force in proportion to load \[N\]; no estimate, hence without sd. `None` without load on the side.
    pub drawbar_share: Option<f64>,
}

/// The two sides of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Wheels fl, rl.
    Left,
    /// Wheels fr, rr.
    Right,
}

impl Side {
    /// Index of the front and the rear wheel in fl, fr, rl, rr.
    pub fn wheels(self) -> [usize; 2] {
        match self {
            Side::Left => [0, 2],
            Side::Right => [1, 3],
        }
    }

    /// Index of the side in arrays of two.
    pub fn index(self) -> usize {
        match self {
            Side::Left => 0,
            Side::Right => 1,
        }
    }

    /// -1 left, +1 right, as in [`Contact::side`](terra_model::Contact::side).
    pub fn sign(self) -> f64 {
        match self {
            Side::Left => -1.0,
            Side::Right => 1.0,
        }
    }
}

/// Forces of one side and the contacts of its front and rear wheel, jointly.
#[derive(Clone, Debug, PartialEq)]
pub struct SideForces {
    /// Which side.
    pub side: Side,
    /// \[F_side N, T_f N m, T_r N m, slip_f, W_f N, slip_r, W_r N\].
    pub vector: [f64; 7],
    /// Its covariance G P Gᵀ (7 x 7).
    pub covariance: DMatrix<f64>,
    /// Speed of the front and rear wheel's centre \[m/s\] (the same for both).
    pub travel_speed: f64,
    /// w of the front and rear wheel \[rad/s\].
    pub wheel_speed: [f64; 2],
    /// r \[rad/s\].
    pub yaw_rate: f64,
    /// What the two slips are worth.
    pub slip_state: [SlipState; 2],
}

/// Speed of the centre of wheel `q`.
fn travel<S: Real>(x: &[S], vehicle: &Vehicle<f64>, q: usize) -> S {
    let half = if q.is_multiple_of(2) {
        -vehicle.track / 2.0
    } else {
        vehicle.track / 2.0
    };
    x[V] + x[R] * half
}

/// Normal load of wheel `q`.
fn load<S: Real>(x: &[S], p: &Vehicle<f64>, q: usize) -> S {
    let transfer = (x[F[0]] + x[F[1]]) * (p.cg_height / (2.0 * p.wheelbase));
    let weight = p.mass * GRAVITY * p.pitch.cos() / (2.0 * p.wheelbase);
    let half_axle = if q < 2 {
        -transfer + weight * (p.wheelbase - p.cg_to_front_axle)
    } else {
        transfer + weight * p.cg_to_front_axle
    };
    let side = if q.is_multiple_of(2) { -1.0 } else { 1.0 };
    let per_turn = 2.0 * p.cg_height / (GRAVITY * p.pitch.cos() * p.track);
    half_axle + half_axle * (x[V] * x[R]) * (side * per_turn)
}

fn slip_state(x: &[f64], vehicle: &Vehicle<f64>, q: usize) -> SlipState {
    match slip_from_speeds(x[W[q]] * vehicle.wheel_radius, travel(x, vehicle, q)) {
        Ok((_, true)) => SlipState::Moving,
        Ok((_, false)) => SlipState::NearStandstill,
        Err(_) => SlipState::AgainstMotion,
    }
}

/// Library slip of wheel `q` under the rule that `state` asks for.
fn slip<S: Real>(x: &[S], vehicle: &Vehicle<f64>, q: usize, state: SlipState) -> S {
    let (rim, travel) = (x[W[q]] * vehicle.wheel_radius, travel(x, vehicle, q));
    if state == SlipState::Moving {
        return library_slip(rim, travel);
    }
    let ahead = (rim - travel) / STANDSTILL_SPEED;
    (rim + travel).select_lt(S::zero(), -ahead, ahead)
}

/// Values of `f` at the belief's mean, and their covariance.
fn through(
    belief: &Gaussian,
    f: impl Fn(&[Dual8]) -> Vec<Dual8>,
) -> Result<(Vec<f64>, DMatrix<f64>), FilterError> {
    if belief.dim() != STATES {
        return Err(FilterError::Size {
            what: "belief",
            expected: STATES,
            found: belief.dim(),
        });
    }
    let (value, g) = jacobian(belief.mean.as_slice(), |x| Ok::<_, FilterError>(f(x)))?;
    let mut covariance = &g * &belief.covariance * g.transpose();
    crate::gaussian::symmetrise(&mut covariance);
    crate::gaussian::check_finite("derived quantity", &value)?;
    crate::gaussian::check_finite("covariance of derived quantities", covariance.as_slice())?;
    Ok((value, covariance))
}

/// Slip, load, torque and share of each wheel (fl, fr, rl, rr) with 1-sigma.
///
/// # Errors
/// [`FilterError::Size`] unless the belief has the 18 states of the robot.
pub fn wheel_estimates(
    belief: &Gaussian,
    vehicle: &Vehicle<f64>,
) -> Result<[WheelEstimate; 4], FilterError> {
    if belief.dim() != STATES {
        return Err(FilterError::Size {
            what: "belief",
            expected: STATES,
            found: belief.dim(),
        });
    }
    let x = belief.mean.as_slice();
    let states: [SlipState; 4] = std::array::from_fn(|q| slip_state(x, vehicle, q));
    let (value, covariance) = through(belief, |x| {
        let mut y = Vec::with_capacity(16);
        for q in 0..4 {
            let slip = match states[q] {
                SlipState::AgainstMotion => Dual8::from(0.0),
                state => slip(x, vehicle, q, state),
            };
            y.extend([x[W[q]], x[T[q]], slip, load(x, vehicle, q)]);
        }
        y
    })?;
    let at = |k: usize| Value {
        value: value[k],
        sd: covariance[(k, k)].sqrt(),
    };
    Ok(std::array::from_fn(|q| {
        let both = load(x, vehicle, q % 2) + load(x, vehicle, q % 2 + 2);
        WheelEstimate {
            wheel_speed: at(4 * q),
            torque: at(4 * q + 1),
            slip: (states[q] != SlipState::AgainstMotion).then(|| at(4 * q + 2)),
            slip_state: states[q],
            normal_load: at(4 * q + 3),
            drawbar_share: (both > 0.0).then(|| x[F[q % 2]] * value[4 * q + 3] / both),
        }
    }))
}

/// The stacked vector of one side, with its joint covariance.
///
/// # Errors
/// [`FilterError::Model`] when a wheel of the side turns against its motion or carries no load: no terrain model covers
/// that; [`FilterError::Size`] unless the belief has the 18 states of the robot.
pub fn side_forces(
    belief: &Gaussian,
    vehicle: &Vehicle<f64>,
    side: Side,
) -> Result<SideForces, FilterError> {
    if belief.dim() != STATES {
        return Err(FilterError::Size {
            what: "belief",
            expected: STATES,
            found: belief.dim(),
        });
    }
    let x = belief.mean.as_slice();
    let [front, rear] = side.wheels();
    let states = [slip_state(x, vehicle, front), slip_state(x, vehicle, rear)];
    for (q, state) in side.wheels().into_iter().zip(states) {
        if state == SlipState::AgainstMotion {
            slip_from_speeds(x[W[q]] * vehicle.wheel_radius, travel(x, vehicle, q))?;
        }
        let carried = load(x, vehicle, q);
        if carried.is_nan() || carried <= 0.0 {
            return Err(FilterError::Model(ModelError::Contact {
                quantity: "normal load",
                value: carried,
                expected: "a positive load: the wheel lifts",
            }));
        }
    }
    let (value, covariance) = through(belief, |x| {
        vec![
            x[F[side.index()]],
            x[T[front]],
            x[T[rear]],
            slip(x, vehicle, front, states[0]),
            load(x, vehicle, front),
            slip(x, vehicle, rear, states[1]),
            load(x, vehicle, rear),
        ]
    })?;
    let mut vector = [0.0; 7];
    vector.copy_from_slice(&value);
    Ok(SideForces {
        side,
        vector,
        covariance,
        travel_speed: travel(x, vehicle, front),
        wheel_speed: [x[W[front]], x[W[rear]]],
        yaw_rate: x[R],
        slip_state: states,
    })
}
