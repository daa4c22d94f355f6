//! The logged torque is off by a factor.
//!
//! # Equation
//! T_true = (1 + e) T_reported
//!
//! # Reference
//! definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Touch};
use crate::param::Param;
use crate::real::Real;

/// The logged torque is off by a factor.
#[derive(Clone, Copy, Debug, Default)]
pub struct TorqueScale;

impl Effect for TorqueScale {
    const NAME: &'static str = "torque-scale";
    const SUMMARY: &'static str = "the logged torque is off by a factor";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.9, 10.0],
        0.12,
        "relative error of the torque constant or efficiency",
    )];
    const EQUATION: &'static str = "T_true = (1 + e) T_reported";
    const REFERENCE: &'static str =
        "definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::WheelTorque];
    const REGIME: &'static str = "torque only, at every slip";
    const ISOLATED_BY: &'static str = "calibrate the motor on a brake or a lever arm";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::WheelTorque {
            truth / (e[0] + 1.0)
        } else {
            truth
        }
    }
}
