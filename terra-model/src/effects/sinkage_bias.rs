//! The sinkage sensor has an offset.
//!
//! # Equation
//! z_reported = z + e
//!
//! # Reference
//! chosen form and prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::{Param, Scale};
use crate::real::Real;

/// The sinkage sensor has an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct SinkageBias;

impl Effect for SinkageBias {
    const NAME: &'static str = "sinkage-bias";
    const SUMMARY: &'static str = "the sinkage sensor has an offset";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "m",
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        scale: Scale::Linear,
        prior_sd: 0.002,
        doc: "offset",
    }];
    const REFERENCE: &'static str = "chosen form and prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
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
