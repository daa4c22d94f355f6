//! Friction between motor and wheel that grows with speed.
//!
//! # Equation
//! the motor delivers e ω more
//!
//! # Reference
//! B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7):1083-1138, 1994 (viscous friction); chosen prior.

use crate::effect::{Effect, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// Friction between motor and wheel that grows with speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct DrivetrainViscousFriction;

impl Effect for DrivetrainViscousFriction {
    const NAME: &'static str = "drivetrain-viscous-friction";
    const SUMMARY: &'static str = "friction between motor and wheel that grows with speed";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "N m s",
        EITHER_SIGN,
        0.8,
        "friction coefficient at the wheel",
    )];
    const SHARE: f64 = 0.05;
    const EQUATION: &'static str = "the motor delivers e ω more";
    const REFERENCE: &'static str = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7):1083-1138, 1994 (viscous friction); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Loads];
    const REGIME: &'static str = "torque against wheel speed";
    const ISOLATED_BY: &'static str = "spin the lifted wheel at two speeds";

    fn loads<T: Real>(
        &self,
        e: &[T],
        _vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        mut loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        for (torque, w) in loads.wheel_torque.iter_mut().zip(motion.wheel_speed) {
            *torque += e[0] * w;
        }
        loads
    }
}
