//! `planar-robot`: a skid-steered robot in the plane, with sideways speed and sideways force.
//!
//! # Equation
//! v_x' = ΣF_x/m + v_y r - g sin(pitch), v_y' = (Y_f + Y_r)/m - v_x r,
//! r' = (M_x + l_f Y_f - l_r Y_r)/I_zz, w_q' = (T_q - Tr_q - b_w w_q)/I_w; forces and resistive torques are second-order
//! walks. Longitudinal forces by side (M_x = (t_w/2)(F_R - F_L)) or by axle (M_x = 0). State \[v_x v_y r | w x4 |
//! (Tr, Tr') x4 | (F, F') x2 | (Y_f, Y_f') (Y_r, Y_r')\]; measured \[a_x, w x4, v_x, r, a_y = (Y_f + Y_r)/m, v_y\].
//!
//! Three equations cannot tell four forces apart: by side, a sideways couple of the axles and a lengthwise couple of the
//! sides turn the robot alike; by axle, the division between front and rear shows nowhere. The rank is 21 of 23 in both.
//!
//! # Reference
//! Planar rigid-body motion in body axes, as in J. Y. Wong, *Theory of Ground Vehicles*, Wiley (2008), section 5.2, with
//! the wheels and walks of L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", SPIE (2008).

use nalgebra::{DMatrix, DVector};
use terra_model::{STANDSTILL_SPEED, Scalar, Vehicle};

use super::longitudinal_robot::{
    GRAVITY, LongitudinalRobot, PriorSpread, ProcessNoise, SensorNoise,
};
use crate::derived::Value;
use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::state_space::{Dims, StateSpace};

/// Index of v_x \[m/s\].
pub const V_X: usize = 0;
/// Index of v_y \[m/s\].
pub const V_Y: usize = 1;
/// Index of r \[rad/s\].
pub const R: usize = 2;
/// Indices of w \[rad/s\], by wheel.
pub const W: [usize; 4] = [3, 4, 5, 6];
/// Indices of the resistive torques \[N m\], by wheel; each rate follows its torque.
pub const T: [usize; 4] = [7, 9, 11, 13];
/// Indices of the longitudinal forces \[N\], left and right or front and rear; each rate follows its force.
pub const F: [usize; 2] = [15, 17];
/// Indices of the lateral forces of the front and rear axle \[N\], left positive; each rate follows its force.
pub const Y: [usize; 2] = [19, 21];
/// Number of states.
pub const STATES: usize = 23;
/// Number of channels.
pub const CHANNELS: usize = 9;

/// How the longitudinal force is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Division {
    /// Left and right side.
    #[default]
    BySide,
    /// Front and rear axle.
    ByAxle,
}

/// The state space `planar-robot`.
#[derive(Clone, Copy, Debug)]
pub struct PlanarRobot {
    vehicle: Vehicle<f64>,
    sensors: SensorNoise,
    /// 1-sigma of a_y \[m/s²\] and v_y \[m/s\].
    sideways: [f64; 2],
    process: ProcessNoise,
    prior: PriorSpread,
    division: Division,
}

impl PlanarRobot {
    /// A robot with its noise; `sideways` is the 1-sigma of a_y \[m/s²\] and v_y \[m/s\]. The yaw damping of the vehicle is
    /// not used: sideways forces take its place.
    ///
    /// # Errors
    /// [`FilterError::Config`] with the number that is not legal.
    pub fn new(
        vehicle: Vehicle<f64>,
        sensors: SensorNoise,
        sideways: [f64; 2],
        process: ProcessNoise,
        prior: PriorSpread,
        division: Division,
    ) -> Result<Self, FilterError> {
        // The same numbers under the same rules.
        LongitudinalRobot::new(vehicle, sensors, process, prior)?;
        for value in sideways {
            if !(1e-100..1e100).contains(&value) {
                return Err(FilterError::Config {
                    key: "noise of accel_y, lateral_speed",
                    value,
                    expected: "a positive number",
                });
            }
        }
        Ok(PlanarRobot {
            vehicle,
            sensors,
            sideways,
            process,
            prior,
            division,
        })
    }

    /// The light robot of the reproduction of Ray 2008.
    ///
    /// # Errors
    /// None with these values.
    pub fn light() -> Result<Self, FilterError> {
        let vehicle = *LongitudinalRobot::light()?.vehicle();
        Self::new(
            vehicle,
            SensorNoise::default(),
            [0.05, 0.02],
            ProcessNoise::default(),
            PriorSpread::default(),
            Division::default(),
        )
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Vehicle<f64> {
        &self.vehicle
    }
}

/// Slip angle of each wheel \[rad\], the direction of its centre's motion against its plane, left positive, with 1-sigma;
/// `None` below .05 m/s, where there is no direction.
///
/// # Equation
/// α_q = atan((v_y + x_q r)/|v_x ∓ r t_w/2|), x = l_f in front and -l_r behind.
///
/// # Errors
/// [`FilterError::Size`] unless the belief has the 23 states.
pub fn slip_angles(
    belief: &Gaussian,
    vehicle: &Vehicle<f64>,
) -> Result<[Option<Value>; 4], FilterError> {
    if belief.dim() != STATES {
        return Err(FilterError::Size {
            what: "belief",
            expected: STATES,
            found: belief.dim(),
        });
    }
    let speeds = |x: [f64; 3], q: usize| {
        let half = if q.is_multiple_of(2) { -0.5 } else { 0.5 } * vehicle.track;
        let along = if q < 2 {
            vehicle.cg_to_front_axle
        } else {
            vehicle.cg_to_front_axle - vehicle.wheelbase
        };
        (x[0] + half * x[2], x[1] + along * x[2], half, along)
    };
    let x = [belief.mean[V_X], belief.mean[V_Y], belief.mean[R]];
    Ok(std::array::from_fn(|q| {
        let (ahead, aside, half, along) = speeds(x, q);
        let square = ahead * ahead + aside * aside;
        if square < STANDSTILL_SPEED * STANDSTILL_SPEED {
            return None;
        }
        // dα = (|ahead| d aside - aside d|ahead|)/square.
        let (da, ds) = (-aside * ahead.signum() / square, ahead.abs() / square);
        let g = [(V_X, da), (V_Y, ds), (R, da * half + ds * along)];
        let mut variance = 0.0;
        for (i, a) in g {
            for (j, b) in g {
                variance += a * b * belief.covariance[(i, j)];
            }
        }
        Some(Value {
            value: aside.atan2(ahead.abs()),
            sd: variance.max(0.0).sqrt(),
        })
    }))
}

impl StateSpace for PlanarRobot {
    fn name(&self) -> &'static str {
        "planar-robot"
    }
    fn summary(&self) -> &'static str {
        "speeds, wheel torques, lengthwise and sideways forces of a skid-steered robot in the plane"
    }
    fn reference(&self) -> &'static str {
        "J. Y. Wong, Theory of Ground Vehicles, Wiley (2008), sec. 5.2; L. E. Ray, SPIE (2008)"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: STATES,
            input: 4,
            measurement: CHANNELS,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &[
            "ground_speed_m_s",
            "lateral_speed_m_s",
            "yaw_rate_rad_s",
            "wheel_speed_fl_rad_s",
            "wheel_speed_fr_rad_s",
            "wheel_speed_rl_rad_s",
            "wheel_speed_rr_rad_s",
            "resistive_torque_fl_N_m",
            "resistive_torque_rate_fl_N_m_s",
            "resistive_torque_fr_N_m",
            "resistive_torque_rate_fr_N_m_s",
            "resistive_torque_rl_N_m",
            "resistive_torque_rate_rl_N_m_s",
            "resistive_torque_rr_N_m",
            "resistive_torque_rate_rr_N_m_s",
            "longitudinal_force_1_N",
            "longitudinal_force_rate_1_N_s",
            "longitudinal_force_2_N",
            "longitudinal_force_rate_2_N_s",
            "lateral_force_front_N",
            "lateral_force_rate_front_N_s",
            "lateral_force_rear_N",
            "lateral_force_rate_rear_N_s",
        ]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &[
            "wheel_torque_fl",
            "wheel_torque_fr",
            "wheel_torque_rl",
            "wheel_torque_rr",
        ]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &[
            "a_x", "w_fl", "w_fr", "w_rl", "w_rr", "v", "r", "a_y", "v_y",
        ]
    }

    fn rate<S: Scalar>(&self, x: &[S], u: &[f64], rate: &mut [S]) -> Result<(), FilterError> {
        let p = &self.vehicle;
        let (front, rear) = (p.cg_to_front_axle, p.wheelbase - p.cg_to_front_axle);
        rate[V_X] = (x[F[0]] + x[F[1]]) / p.mass + x[V_Y] * x[R] - GRAVITY * p.pitch.sin();
        rate[V_Y] = (x[Y[0]] + x[Y[1]]) / p.mass - x[V_X] * x[R];
        let sideways = x[Y[0]] * front - x[Y[1]] * rear;
        let couple = match self.division {
            Division::BySide => (x[F[1]] - x[F[0]]) * (p.track / 2.0),
            Division::ByAxle => S::zero(),
        };
        rate[R] = (sideways + couple) / p.yaw_inertia;
        for q in 0..4 {
            rate[W[q]] = (-x[T[q]] - x[W[q]] * p.wheel_damping + u[q]) / p.wheel_inertia;
        }
        for walk in T.into_iter().chain(F).chain(Y) {
            rate[walk] = x[walk + 1];
            rate[walk + 1] = S::zero();
        }
        Ok(())
    }

    fn measure<S: Scalar>(&self, x: &[S], z: &mut [S]) -> Result<(), FilterError> {
        z[0] = (x[F[0]] + x[F[1]]) / self.vehicle.mass;
        for q in 0..4 {
            z[1 + q] = x[W[q]];
        }
        z[5] = x[V_X];
        z[6] = x[R];
        z[7] = (x[Y[0]] + x[Y[1]]) / self.vehicle.mass;
        z[8] = x[V_Y];
        Ok(())
    }

    fn process_noise(&self) -> DMatrix<f64> {
        let p = &self.process;
        let mut q = DVector::zeros(STATES);
        q[V_X] = p.speed * p.speed;
        q[V_Y] = p.speed * p.speed;
        q[R] = p.yaw_rate * p.yaw_rate;
        for wheel in 0..4 {
            q[W[wheel]] = p.wheel_speed * p.wheel_speed;
            q[T[wheel] + 1] = p.torque_walk;
        }
        for k in 0..2 {
            q[F[k] + 1] = p.force_walk[k];
            q[Y[k] + 1] = p.force_walk[k];
        }
        DMatrix::from_diagonal(&q)
    }

    fn measurement_noise(&self) -> DMatrix<f64> {
        let s = &self.sensors;
        let w = s.wheel_speed;
        let [a_y, v_y] = self.sideways;
        let sd = [s.accel_x, w, w, w, w, s.ground_speed, s.yaw_rate, a_y, v_y];
        DMatrix::from_diagonal(&DVector::from_iterator(CHANNELS, sd.iter().map(|x| x * x)))
    }

    fn prior(&self) -> Gaussian {
        let p = &self.prior;
        let mut sd = [p.rate; STATES];
        (sd[V_X], sd[V_Y], sd[R]) = (p.speed, p.speed, p.yaw_rate);
        for q in 0..4 {
            sd[W[q]] = p.wheel_speed;
            sd[T[q]] = p.torque;
        }
        for k in F.into_iter().chain(Y) {
            sd[k] = p.force;
        }
        Gaussian::independent(&[0.0; STATES], &sd)
    }
}
