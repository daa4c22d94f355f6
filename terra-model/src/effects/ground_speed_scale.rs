//! The logged ground speed is off by a factor.
//!
//! # Equation
//! v_reported = (1 + e) v
//!
//! # Reference
//! definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Touch};
use crate::param::Param;
use crate::real::Real;

/// The logged ground speed is off by a factor.
#[derive(Clone, Copy, Debug, Default)]
pub struct GroundSpeedScale;

impl Effect for GroundSpeedScale {
    const NAME: &'static str = "ground-speed-scale";
    const SUMMARY: &'static str = "the logged ground speed is off by a factor";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.9, 5.0],
        0.05,
        "relative error of the speed",
    )];
    const EQUATION: &'static str = "v_reported = (1 + e) v";
    const REFERENCE: &'static str =
        "definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::GroundSpeed];
    const REGIME: &'static str = "slip at low slip";
    const ISOLATED_BY: &'static str = "drive a measured distance on hard ground";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::GroundSpeed {
            truth * (e[0] + 1.0)
        } else {
            truth
        }
    }
}
