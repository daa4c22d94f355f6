//! `longitudinal-robot`: the 18-state force estimation of a four-wheeled, differentially steered robot.
//!
//! # Equation
//! v' = (F_L + F_R)/m - g sin(pitch), r' = ((t_w/2)(F_R - F_L) - M_res r)/I_zz, w_q' = (T_q - Tr_q - b_w w_q)/I_w,
//! Tr_q'' , F_L'', F_R'' white. State [v r | w x4 | (Tr, Tr') x4 | (F_L, F_L') (F_R, F_R')]; measured
//! [a_x = (F_L + F_R)/m, w x4, v, r]; inputs the four applied torques. Wheels fl, fr, rl, rr. Linear and
//! time-invariant (a pitch that is measured is a fifth input, so that the ground's slope may change); v_y r is neglected; normal loads are computed outside, from the estimated a_x.
//!
//! # Reference
//! L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", SPIE (2008), eqs 1-7.

use nalgebra::{DMatrix, DVector};
use terra_model::{Scalar, Vehicle};

use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::state_space::{Dims, StateSpace};
use crate::structure::Blocks;

/// Index of v \[m/s\].
pub const V: usize = 0;
/// Index of r \[rad/s\].
pub const R: usize = 1;
/// Indices of w \[rad/s\], by wheel.
pub const W: [usize; 4] = [2, 3, 4, 5];
/// Indices of the resistive torque \[N m\], by wheel.
pub const T: [usize; 4] = [6, 8, 10, 12];
/// Indices of its rate \[N m/s\], by wheel.
pub const T_RATE: [usize; 4] = [7, 9, 11, 13];
/// Indices of the net traction of the left and right side \[N\].
pub const F: [usize; 2] = [14, 16];
/// Indices of its rate \[N/s\].
pub const F_RATE: [usize; 2] = [15, 17];
/// Number of states.
pub const STATES: usize = 18;

/// Channel a_x \[m/s²\].
pub const Z_AX: usize = 0;
/// Channels w \[rad/s\], by wheel.
pub const Z_W: [usize; 4] = [1, 2, 3, 4];
/// Channel v \[m/s\].
pub const Z_V: usize = 5;
/// Channel r \[rad/s\].
pub const Z_R: usize = 6;
/// Number of channels.
pub const CHANNELS: usize = 7;
/// Names of the channels, in their order.
pub const CHANNEL_NAMES: [&str; CHANNELS] = ["a_x", "w_fl", "w_fr", "w_rl", "w_rr", "v", "r"];

/// g \[m/s²\].
pub const GRAVITY: f64 = 9.81;

/// 1-sigma of the sensors, per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// a_x \[m/s²\].
    pub accel_x: f64,
    /// w \[rad/s\].
    pub wheel_speed: f64,
    /// v \[m/s\].
    pub ground_speed: f64,
    /// r \[rad/s\].
    pub yaw_rate: f64,
}

impl Default for SensorNoise {
    /// The sensors of the reproduction of Ray 2008.
    fn default() -> Self {
        SensorNoise {
            accel_x: 0.05,
            wheel_speed: 0.05,
            ground_speed: 0.02,
            yaw_rate: 0.005,
        }
    }
}

/// Process noise: square roots of the spectral densities of v', r', w', and the walks of torque and force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessNoise {
    /// \[m/s/√s\].
    pub speed: f64,
    /// \[rad/s/√s\].
    pub yaw_rate: f64,
    /// \[rad/s/√s\].
    pub wheel_speed: f64,
    /// q_T of each wheel \[N² m²/s³\].
    pub torque_walk: f64,
    /// q_F of the left and the right side \[N²/s³\].
    pub force_walk: [f64; 2],
}

impl Default for ProcessNoise {
    /// The values whose NIS matches the data of the reproduction best.
    fn default() -> Self {
        ProcessNoise {
            speed: 0.05,
            yaw_rate: 0.02,
            wheel_speed: 0.5,
            torque_walk: 1e3,
            force_walk: [1e4; 2],
        }
    }
}

/// 1-sigma of the belief before the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorSpread {
    /// v \[m/s\].
    pub speed: f64,
    /// r \[rad/s\].
    pub yaw_rate: f64,
    /// w \[rad/s\].
    pub wheel_speed: f64,
    /// Tr \[N m\].
    pub torque: f64,
    /// F of a side \[N\].
    pub force: f64,
    /// Rates of both \[N m/s, N/s\].
    pub rate: f64,
}

impl Default for PriorSpread {
    fn default() -> Self {
        PriorSpread {
            speed: 0.1,
            yaw_rate: 0.02,
            wheel_speed: 0.5,
            torque: 50.0,
            force: 300.0,
            rate: 2000.0,
        }
    }
}

/// The state space `longitudinal-robot`.
#[derive(Clone, Copy, Debug)]
pub struct LongitudinalRobot {
    vehicle: Vehicle<f64>,
    pitch_input: bool,
    sensors: SensorNoise,
    process: ProcessNoise,
    prior: PriorSpread,
}

impl LongitudinalRobot {
    /// A robot with its noise.
    ///
    /// # Errors
    /// [`FilterError::Config`] with the number that is not legal.
    pub fn new(
        vehicle: Vehicle<f64>,
        sensors: SensorNoise,
        process: ProcessNoise,
        prior: PriorSpread,
    ) -> Result<Self, FilterError> {
        let check = |key, value: f64, legal: bool, expected| {
            if value.is_finite() && legal {
                Ok(())
            } else {
                Err(FilterError::Config {
                    key,
                    value,
                    expected,
                })
            }
        };
        for (key, value) in [
            ("mass", vehicle.mass),
            ("yaw inertia", vehicle.yaw_inertia),
            ("track", vehicle.track),
            ("wheelbase", vehicle.wheelbase),
            ("wheel radius", vehicle.wheel_radius),
            ("wheel inertia", vehicle.wheel_inertia),
            ("noise of accel_x", sensors.accel_x),
            ("noise of wheel_speed", sensors.wheel_speed),
            ("noise of ground_speed", sensors.ground_speed),
            ("noise of yaw_rate", sensors.yaw_rate),
            ("prior of speed", prior.speed),
            ("prior of yaw_rate", prior.yaw_rate),
            ("prior of wheel_speed", prior.wheel_speed),
            ("prior of torque", prior.torque),
            ("prior of force", prior.force),
            ("prior of rates", prior.rate),
        ] {
            // The square must neither vanish nor overflow.
            check(
                key,
                value,
                (1e-100..1e100).contains(&value),
                "a positive number",
            )?;
        }
        for (key, value) in [
            ("yaw damping", vehicle.yaw_damping),
            ("wheel damping", vehicle.wheel_damping),
            ("process noise of speed", process.speed),
            ("process noise of yaw_rate", process.yaw_rate),
            ("process noise of wheel_speed", process.wheel_speed),
            ("torque_walk", process.torque_walk),
            ("force_walk", process.force_walk[0]),
            ("force_walk", process.force_walk[1]),
        ] {
            check(
                key,
                value,
                (0.0..1e100).contains(&value),
                "a number that is not negative",
            )?;
        }
        let half_pi = std::f64::consts::FRAC_PI_2;
        check(
            "pitch",
            vehicle.pitch,
            vehicle.pitch.abs() < half_pi,
            "an angle in (-pi/2, pi/2)",
        )?;
        Ok(LongitudinalRobot {
            vehicle,
            pitch_input: false,
            sensors,
            process,
            prior,
        })
    }

    /// The light robot of the reproduction of Ray 2008: 100 kg, wheels of .508 x .15 m, default noise.
    ///
    /// # Errors
    /// None with these values.
    pub fn light() -> Result<Self, FilterError> {
        let vehicle = Vehicle {
            mass: 100.0,
            yaw_inertia: 10.0,
            track: 0.6,
            wheelbase: 0.6,
            cg_to_front_axle: 0.3,
            cg_height: 0.22,
            yaw_damping: 8.0,
            wheel_radius: 0.254,
            wheel_width: 0.15,
            wheel_inertia: 0.25,
            wheel_damping: 0.1,
            pitch: 0.0,
        };
        Self::new(
            vehicle,
            SensorNoise::default(),
            ProcessNoise::default(),
            PriorSpread::default(),
        )
    }

    /// The same robot with the pitch as its fifth input \[rad\], instead of the vehicle's own.
    #[must_use]
    pub fn with_pitch_input(self) -> Self {
        LongitudinalRobot {
            pitch_input: true,
            ..self
        }
    }

    /// The same robot with another mass \[kg\]: a payload at its centre of mass.
    ///
    /// # Errors
    /// [`FilterError::Config`] for a mass that is none.
    pub fn with_mass(self, mass: f64) -> Result<Self, FilterError> {
        let vehicle = Vehicle {
            mass,
            ..self.vehicle
        };
        let made = Self::new(vehicle, self.sensors, self.process, self.prior)?;
        Ok(LongitudinalRobot {
            pitch_input: self.pitch_input,
            ..made
        })
    }

    /// Whether the pitch is an input.
    pub fn has_pitch_input(&self) -> bool {
        self.pitch_input
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Vehicle<f64> {
        &self.vehicle
    }

    /// The prior's spread.
    pub fn prior_spread(&self) -> &PriorSpread {
        &self.prior
    }
}

impl StateSpace for LongitudinalRobot {
    fn name(&self) -> &'static str {
        "longitudinal-robot"
    }
    fn summary(&self) -> &'static str {
        "speeds, wheel torques and side forces of a four-wheeled robot that drives ahead"
    }
    fn reference(&self) -> &'static str {
        "L. E. Ray, Autonomous terrain parameter estimation for wheeled vehicles, SPIE (2008), eqs 1-7"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: STATES,
            input: 4 + usize::from(self.pitch_input),
            measurement: CHANNELS,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &[
            "ground_speed_m_s",
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
            "side_force_left_N",
            "side_force_rate_left_N_s",
            "side_force_right_N",
            "side_force_rate_right_N_s",
        ]
    }
    fn input_names(&self) -> &'static [&'static str] {
        const INPUTS: [&str; 5] = [
            "wheel_torque_fl",
            "wheel_torque_fr",
            "wheel_torque_rl",
            "wheel_torque_rr",
            "pitch",
        ];
        if self.pitch_input {
            &INPUTS
        } else {
            &INPUTS[..4]
        }
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &CHANNEL_NAMES
    }

    fn rate<S: Scalar>(&self, x: &[S], u: &[f64], rate: &mut [S]) -> Result<(), FilterError> {
        let p = &self.vehicle;
        let pitch = if self.pitch_input { u[4] } else { p.pitch };
        rate[V] = (x[F[0]] + x[F[1]]) / p.mass - GRAVITY * pitch.sin();
        rate[R] = ((x[F[1]] - x[F[0]]) * (p.track / 2.0) - x[R] * p.yaw_damping) / p.yaw_inertia;
        for q in 0..4 {
            rate[W[q]] = (-x[T[q]] - x[W[q]] * p.wheel_damping + u[q]) / p.wheel_inertia;
            rate[T[q]] = x[T_RATE[q]];
            rate[T_RATE[q]] = S::zero();
        }
        for side in 0..2 {
            rate[F[side]] = x[F_RATE[side]];
            rate[F_RATE[side]] = S::zero();
        }
        Ok(())
    }

    fn measure<S: Scalar>(&self, x: &[S], z: &mut [S]) -> Result<(), FilterError> {
        z[Z_AX] = (x[F[0]] + x[F[1]]) / self.vehicle.mass;
        for q in 0..4 {
            z[Z_W[q]] = x[W[q]];
        }
        z[Z_V] = x[V];
        z[Z_R] = x[R];
        Ok(())
    }

    fn process_noise(&self) -> DMatrix<f64> {
        let p = &self.process;
        let mut q = DVector::zeros(STATES);
        q[V] = p.speed * p.speed;
        q[R] = p.yaw_rate * p.yaw_rate;
        for wheel in 0..4 {
            q[W[wheel]] = p.wheel_speed * p.wheel_speed;
            q[T_RATE[wheel]] = p.torque_walk;
        }
        for side in 0..2 {
            q[F_RATE[side]] = p.force_walk[side];
        }
        DMatrix::from_diagonal(&q)
    }

    fn measurement_noise(&self) -> DMatrix<f64> {
        let s = &self.sensors;
        let w = s.wheel_speed;
        let sd = [s.accel_x, w, w, w, w, s.ground_speed, s.yaw_rate];
        DMatrix::from_diagonal(&DVector::from_iterator(CHANNELS, sd.iter().map(|x| x * x)))
    }

    fn prior(&self) -> Gaussian {
        let p = &self.prior;
        let mut sd = [p.rate; STATES];
        sd[V] = p.speed;
        sd[R] = p.yaw_rate;
        for q in 0..4 {
            sd[W[q]] = p.wheel_speed;
            sd[T[q]] = p.torque;
        }
        for side in F {
            sd[side] = p.force;
        }
        Gaussian::independent(&[0.0; STATES], &sd)
    }

    fn linear(&self) -> bool {
        true
    }
    fn affine_input(&self) -> bool {
        // A pitch comes in by its sine.
        !self.pitch_input
    }

    /// Four (w, T, T'), one (v, F_s, F_s'), one (r, F_d, F_d').
    fn blocks(&self) -> Blocks {
        let mut basis = DMatrix::identity(STATES, STATES);
        // Sum in the place of the left side, difference in that of the right.
        for (left, right) in [(F[0], F[1]), (F_RATE[0], F_RATE[1])] {
            basis[(left, right)] = 1.0;
            basis[(right, left)] = -1.0;
        }
        let mut groups: Vec<Vec<usize>> = (0..4).map(|q| vec![W[q], T[q], T_RATE[q]]).collect();
        groups.push(vec![V, F[0], F_RATE[0]]);
        groups.push(vec![R, F[1], F_RATE[1]]);
        Blocks::Groups { basis, groups }
    }
}
