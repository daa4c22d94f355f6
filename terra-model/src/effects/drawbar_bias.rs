//! The load cell of the drawbar has an offset.
//!
//! # Equation
//! D_reported = D + e
//!
//! # Reference
//! definition (instrumental bias, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The load cell of the drawbar has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct DrawbarBias;

impl Effect for DrawbarBias {
    const NAME: &'static str = "drawbar-bias";
    const SUMMARY: &'static str = "the load cell of the drawbar has an offset";
    const PARAMS: &'static [Param] = &[Param::magnitude("N", EITHER_SIGN, 2.0, "offset")];
    // A load cell is chosen for the load: a fiftieth of it is 2 N at 100 N.
    const SHARE: f64 = 0.02;
    const EQUATION: &'static str = "D_reported = D + e";
    const REFERENCE: &'static str = "definition (instrumental bias, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::DrawbarPull];
    const SCOPE: Scope = Scope::Rig;
    const REGIME: &'static str = "pull only, at every slip";
    const ISOLATED_BY: &'static str = "log the unloaded load cell";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::DrawbarPull {
            truth + e[0]
        } else {
            truth
        }
    }
}
