//! The load cell of the drawbar is off by a factor.
//!
//! # Equation
//! D_reported = (1 + e) D
//!
//! # Reference
//! definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;

/// The load cell of the drawbar is off by a factor.
#[derive(Clone, Copy, Debug, Default)]
pub struct DrawbarGain;

impl Effect for DrawbarGain {
    const NAME: &'static str = "drawbar-gain";
    const SUMMARY: &'static str = "the load cell of the drawbar is off by a factor";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.9, 5.0],
        0.05,
        "relative error of the load cell",
    )];
    const EQUATION: &'static str = "D_reported = (1 + e) D";
    const REFERENCE: &'static str =
        "definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::DrawbarPull];
    const SCOPE: Scope = Scope::Rig;
    const REGIME: &'static str = "pull only";
    const ISOLATED_BY: &'static str = "hang a known weight on the load cell";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::DrawbarPull {
            truth * (e[0] + 1.0)
        } else {
            truth
        }
    }
}
