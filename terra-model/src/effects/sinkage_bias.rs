//! The sinkage sensor has an offset.
//!
//! # Equation
//! z_reported = z + e
//!
//! # Reference
//! definition (instrumental bias, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The sinkage sensor has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct SinkageBias;

impl Effect for SinkageBias {
    const NAME: &'static str = "sinkage-bias";
    const SUMMARY: &'static str = "the sinkage sensor has an offset";
    const PARAMS: &'static [Param] = &[Param::magnitude("m", EITHER_SIGN, 0.002, "offset")];
    const SHARE: f64 = 0.0078;
    const EQUATION: &'static str = "z_reported = z + e";
    const REFERENCE: &'static str = "definition (instrumental bias, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::Sinkage];
    const SCOPE: Scope = Scope::Rig;
    const REGIME: &'static str = "sinkage only, at every slip";
    const ISOLATED_BY: &'static str = "log the wheel resting on a plate on the surface";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::Sinkage {
            truth + e[0]
        } else {
            truth
        }
    }
}
