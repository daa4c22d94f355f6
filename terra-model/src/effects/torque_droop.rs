//! The logged torque is off at high torque.
//!
//! # Equation
//! T_reported = T_true (1 + e (T / 60 N m)²)
//!
//! # Reference
//! A. E. Fitzgerald, C. Kingsley, S. D. Umans, Electric Machinery (saturation lowers the torque a current gives); chosen
//! form and prior.

use crate::effect::{Channel, Effect, Touch};
use crate::param::Param;
use crate::real::Real;

/// The logged torque is off at high torque.
#[derive(Clone, Copy, Debug, Default)]
pub struct TorqueDroop;

impl Effect for TorqueDroop {
    const NAME: &'static str = "torque-droop";
    const SUMMARY: &'static str = "the logged torque is off at high torque";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 10.0],
        0.25,
        "relative error at 60 N m",
    )];
    const EQUATION: &'static str = "T_reported = T_true (1 + e (T / 60 N m)²)";
    const REFERENCE: &'static str = "A. E. Fitzgerald, C. Kingsley, S. D. Umans, Electric Machinery (saturation lowers the torque a current gives); chosen form and prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::WheelTorque];
    const REGIME: &'static str = "torque at high torque";
    const ISOLATED_BY: &'static str = "a brake test up to the largest torque";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::WheelTorque {
            truth * (e[0] * (truth / 60.0).squared() + 1.0)
        } else {
            truth
        }
    }
}
