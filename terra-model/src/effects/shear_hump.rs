//! Shear stress peaks before it settles (dense or crusted soil).
//!
//! # Equation
//! E -> E (1 + e (j/K) e^(1 - j/K))
//!
//! # Reference
//! J. Y. Wong, J. Preston-Thomas, J. Terramechanics 19(4), 1983; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Shear stress peaks before it settles (dense or crusted soil).
#[derive(Clone, Copy, Debug, Default)]
pub struct ShearHump;

impl Effect for ShearHump {
    const NAME: &'static str = "shear-hump";
    const SUMMARY: &'static str = "shear stress peaks before it settles (dense or crusted soil)";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 5.0],
        0.35,
        "height of the peak over the plateau",
    )];
    const EQUATION: &'static str = "E -> E (1 + e (j/K) e^(1 - j/K))";
    const REFERENCE: &'static str =
        "J. Y. Wong, J. Preston-Thomas, J. Terramechanics 19(4), 1983; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::ShearHump];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "pull and torque peak at slip .05 to .3, then drop";
    const ISOLATED_BY: &'static str = "a shear test of the soil";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.shear_hump += e[0];
    }
}
