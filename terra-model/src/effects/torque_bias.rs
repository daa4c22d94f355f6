//! The logged torque has an offset.
//!
//! # Equation
//! T_reported = T_true + e
//!
//! # Reference
//! definition (instrumental bias, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The logged torque has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct TorqueBias;

impl Effect for TorqueBias {
    const NAME: &'static str = "torque-bias";
    const SUMMARY: &'static str = "the logged torque has an offset";
    const PARAMS: &'static [Param] = &[Param::magnitude("N m", EITHER_SIGN, 1.5, "offset")];
    const SHARE: f64 = 0.024;
    const EQUATION: &'static str = "T_reported = T_true + e";
    const REFERENCE: &'static str = "definition (instrumental bias, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::WheelTorque];
    const REGIME: &'static str = "torque only, the same in both directions";
    const ISOLATED_BY: &'static str = "log the lifted, standing wheel";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::WheelTorque {
            truth + e[0]
        } else {
            truth
        }
    }
}
