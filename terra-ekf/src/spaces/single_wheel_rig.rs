//! `single-wheel-rig`: torque and drawbar pull of one wheel on a testbed.
//!
//! # Equation
//! w' = (T_m - T - b_w w)/I_w, T'' and D'' white, v' white (the carriage is driven from outside); measured [w, v, D].
//! Input: the motor's torque at the wheel T_m.
//!
//! # Reference
//! The wheel equation is eq. 3 of L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", SPIE (2008).

use nalgebra::{DMatrix, DVector};
use terra_model::Scalar;

use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::state_space::{Dims, StateSpace};
use crate::structure::Blocks;

/// Index of w \[rad/s\].
pub const W: usize = 0;
/// Index of v \[m/s\].
pub const V: usize = 1;
/// Index of T \[N m\].
pub const T: usize = 2;
/// Index of T' \[N m/s\].
pub const T_RATE: usize = 3;
/// Index of D \[N\].
pub const D: usize = 4;
/// Index of D' \[N/s\].
pub const D_RATE: usize = 5;

/// The state space `single-wheel-rig`, with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleWheelRig {
    /// I_w \[kg m²\].
    pub inertia: f64,
    /// b_w \[N m s\].
    pub damping: f64,
    /// 1-sigma of w \[rad/s\], v \[m/s\], D \[N\] per sample.
    pub sensor_sd: [f64; 3],
    /// Square roots of the spectral densities of w' \[rad/s/√s\] and v' \[m/s/√s\].
    pub process: [f64; 2],
    /// q_T \[N² m²/s³\].
    pub torque_walk: f64,
    /// q_D \[N²/s³\].
    pub drawbar_walk: f64,
    /// 1-sigma before the first sample of w, v, T, T', D, D'.
    pub prior_sd: [f64; 6],
}

impl SingleWheelRig {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`FilterError::Config`].
    pub fn checked(self) -> Result<Self, FilterError> {
        let positive = [self.inertia]
            .into_iter()
            .chain(self.sensor_sd)
            .chain(self.prior_sd);
        for value in positive {
            if !(1e-100..1e100).contains(&value) {
                return Err(FilterError::Config {
                    key: "inertia, sensor_sd, prior_sd",
                    value,
                    expected: "a positive number",
                });
            }
        }
        for value in [
            self.damping,
            self.process[0],
            self.process[1],
            self.torque_walk,
            self.drawbar_walk,
        ] {
            if !(0.0..1e100).contains(&value) {
                return Err(FilterError::Config {
                    key: "damping, process, walks",
                    value,
                    expected: "a number that is not negative",
                });
            }
        }
        Ok(self)
    }
}

impl Default for SingleWheelRig {
    /// A small testbed: wheel of 5 kg, slow carriage, load cell of .5 N.
    fn default() -> Self {
        SingleWheelRig {
            inertia: 0.05,
            damping: 0.02,
            sensor_sd: [0.02, 0.002, 0.5],
            process: [0.2, 0.02],
            torque_walk: 1e2,
            drawbar_walk: 1e3,
            prior_sd: [0.5, 0.1, 20.0, 500.0, 100.0, 1000.0],
        }
    }
}

impl StateSpace for SingleWheelRig {
    fn name(&self) -> &'static str {
        "single-wheel-rig"
    }
    fn summary(&self) -> &'static str {
        "torque and drawbar pull of one wheel on a testbed"
    }
    fn reference(&self) -> &'static str {
        "L. E. Ray, Autonomous terrain parameter estimation for wheeled vehicles, SPIE (2008), eq. 3"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: 6,
            input: 1,
            measurement: 3,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &[
            "wheel_speed_rad_s",
            "travel_speed_m_s",
            "torque_N_m",
            "torque_rate_N_m_s",
            "drawbar_pull_N",
            "drawbar_pull_rate_N_s",
        ]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &["motor_torque"]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &["wheel_speed", "travel_speed", "drawbar_pull"]
    }

    fn rate<S: Scalar>(&self, x: &[S], u: &[f64], rate: &mut [S]) -> Result<(), FilterError> {
        rate[W] = (-x[T] - x[W] * self.damping + u[0]) / self.inertia;
        rate[V] = S::zero();
        rate[T] = x[T_RATE];
        rate[T_RATE] = S::zero();
        rate[D] = x[D_RATE];
        rate[D_RATE] = S::zero();
        Ok(())
    }

    fn measure<S: Scalar>(&self, x: &[S], z: &mut [S]) -> Result<(), FilterError> {
        z[0] = x[W];
        z[1] = x[V];
        z[2] = x[D];
        Ok(())
    }

    fn process_noise(&self) -> DMatrix<f64> {
        let [w, v] = self.process;
        DMatrix::from_diagonal(&DVector::from_row_slice(&[
            w * w,
            v * v,
            0.0,
            self.torque_walk,
            0.0,
            self.drawbar_walk,
        ]))
    }

    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_iterator(
            3,
            self.sensor_sd.iter().map(|s| s * s),
        ))
    }

    fn prior(&self) -> Gaussian {
        Gaussian::independent(&[0.0; 6], &self.prior_sd)
    }

    fn linear(&self) -> bool {
        true
    }
    fn affine_input(&self) -> bool {
        true
    }

    fn blocks(&self) -> Blocks {
        Blocks::Groups {
            basis: DMatrix::identity(6, 6),
            groups: vec![vec![W, T, T_RATE], vec![V], vec![D, D_RATE]],
        }
    }
}
