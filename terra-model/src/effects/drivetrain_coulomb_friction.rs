//! Dry friction between motor and wheel.
//!
//! # Equation
//! the motor delivers e tanh(ω / .1 rad/s) more
//!
//! # Reference
//! B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7):1083-1138, 1994 (Coulomb friction); chosen
//! smoothing and prior.

use crate::effect::{Effect, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// Dry friction between motor and wheel.
#[derive(Clone, Copy, Debug, Default)]
pub struct DrivetrainCoulombFriction;

impl Effect for DrivetrainCoulombFriction {
    const NAME: &'static str = "drivetrain-coulomb-friction";
    const SUMMARY: &'static str = "dry friction between motor and wheel";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "N m",
        [0.0, 500.0],
        2.0,
        "friction torque at the wheel",
    )];
    const SHARE: f64 = 0.032;
    const EQUATION: &'static str = "the motor delivers e tanh(ω / .1 rad/s) more";
    const REFERENCE: &'static str = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7):1083-1138, 1994 (Coulomb friction); chosen smoothing and prior";
    const TOUCHES: &'static [Touch] = &[Touch::Loads];
    const REGIME: &'static str = "torque offset at every slip; reversal changes its sign";
    const ISOLATED_BY: &'static str = "spin the lifted wheel both ways";

    fn loads<T: Real>(
        &self,
        e: &[T],
        _vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        mut loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        for (torque, w) in loads.wheel_torque.iter_mut().zip(motion.wheel_speed) {
            *torque += e[0] * (w * 10.0).tanh();
        }
        loads
    }
}
