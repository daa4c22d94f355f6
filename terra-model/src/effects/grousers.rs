//! Lugs shear the soil at their tips.
//!
//! # Equation
//! R -> R + e in the shear displacement and in the arm of the shear torque
//!
//! # Reference
//! L. Ding et al., J. Terramechanics 48(1):27-45, 2011; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Lugs shear the soil at their tips.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grousers;

impl Effect for Grousers {
    const NAME: &'static str = "grousers";
    const SUMMARY: &'static str = "lugs shear the soil at their tips";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "m",
        [0.0, 0.2],
        0.015,
        "effective lug height",
    )];
    const SHARE: f64 = 0.059;
    const EQUATION: &'static str =
        "R -> R + e in the shear displacement and in the arm of the shear torque";
    const REFERENCE: &'static str =
        "L. Ding et al., J. Terramechanics 48(1):27-45, 2011; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::LugHeight];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "pull and torque up, most on cohesive soil";
    const ISOLATED_BY: &'static str = "the same wheel with and without lugs";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.lug_height += e[0];
    }
}
