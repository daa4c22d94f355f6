//! The accelerometer has an offset.
//!
//! # Equation
//! a_reported = a + e
//!
//! # Reference
//! P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2013 (accelerometer bias);
//! chosen prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The accelerometer has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct AccelBias;

impl Effect for AccelBias {
    const NAME: &'static str = "accel-bias";
    const SUMMARY: &'static str = "the accelerometer has an offset";
    const PARAMS: &'static [Param] = &[Param::magnitude("m/s²", EITHER_SIGN, 0.15, "offset")];
    const EQUATION: &'static str = "a_reported = a + e";
    const REFERENCE: &'static str = "P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2013 (accelerometer bias); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::AccelX];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "specific force, at every slip";
    const ISOLATED_BY: &'static str =
        "log the vehicle standing on level ground, then turned by 180°";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::AccelX {
            truth + e[0]
        } else {
            truth
        }
    }
}
