//! The logged ground speed has an offset.
//!
//! # Equation
//! v_reported = v + e
//!
//! # Reference
//! definition (instrumental bias, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The logged ground speed has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct GroundSpeedBias;

impl Effect for GroundSpeedBias {
    const NAME: &'static str = "ground-speed-bias";
    const SUMMARY: &'static str = "the logged ground speed has an offset";
    const PARAMS: &'static [Param] = &[Param::magnitude("m/s", EITHER_SIGN, 0.05, "offset")];
    const EQUATION: &'static str = "v_reported = v + e";
    const REFERENCE: &'static str = "definition (instrumental bias, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::GroundSpeed];
    const REGIME: &'static str = "slip at low speed";
    const ISOLATED_BY: &'static str = "log the vehicle standing";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::GroundSpeed {
            truth + e[0]
        } else {
            truth
        }
    }
}
