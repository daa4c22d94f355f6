//! The normal load on the rig differs from the logged one.
//!
//! # Equation
//! W_true = (1 + e) W_reported
//!
//! # Reference
//! definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior.

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Scope, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The normal load on the rig differs from the logged one.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoadError;

impl Effect for LoadError {
    const NAME: &'static str = "load-error";
    const SUMMARY: &'static str = "the normal load on the rig differs from the logged one";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.9, 5.0],
        0.1,
        "relative error of the load",
    )];
    const EQUATION: &'static str = "W_true = (1 + e) W_reported";
    const REFERENCE: &'static str =
        "definition (sensitivity of a measuring system, JCGM 200:2012); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const SCOPE: Scope = Scope::Rig;
    const REGIME: &'static str = "pull, torque and sinkage with the load";
    const ISOLATED_BY: &'static str = "put the wheel on a scale";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.normal_load *= e[0] + 1.0;
    }
}
