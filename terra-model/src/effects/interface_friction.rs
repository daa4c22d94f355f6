//! The smooth rim slides before the soil shears.
//!
//! # Equation
//! c -> (1 - e) c, tan φ -> (1 - e) tan φ in the shear stress
//!
//! # Reference
//! J. G. Potyondy, Géotechnique 11(4), 1961; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The smooth rim slides before the soil shears.
#[derive(Clone, Copy, Debug, Default)]
pub struct InterfaceFriction;

impl Effect for InterfaceFriction {
    const NAME: &'static str = "interface-friction";
    const SUMMARY: &'static str = "the smooth rim slides before the soil shears";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 0.99],
        0.3,
        "strength lost at the interface",
    )];
    const EQUATION: &'static str = "c -> (1 - e) c, tan φ -> (1 - e) tan φ in the shear stress";
    const REFERENCE: &'static str =
        "J. G. Potyondy, Géotechnique 11(4), 1961; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "pull and torque down at every slip";
    const ISOLATED_BY: &'static str = "roughen the rim, or shear test against rim material";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.cohesion *= T::one() - e[0];
        at.hooks.friction *= T::one() - e[0];
    }
}
