//! The gyroscope has an offset.
//!
//! # Equation
//! r_reported = r + e
//!
//! # Reference
//! P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2013 (gyroscope bias);
//! chosen prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The gyroscope has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct YawRateBias;

impl Effect for YawRateBias {
    const NAME: &'static str = "yaw-rate-bias";
    const SUMMARY: &'static str = "the gyroscope has an offset";
    const PARAMS: &'static [Param] = &[Param::magnitude("rad/s", EITHER_SIGN, 0.01, "offset")];
    const EQUATION: &'static str = "r_reported = r + e";
    const REFERENCE: &'static str = "P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2013 (gyroscope bias); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::YawRate];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "slip of left against right at low speed";
    const ISOLATED_BY: &'static str = "log the vehicle standing";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::YawRate {
            truth + e[0]
        } else {
            truth
        }
    }
}
