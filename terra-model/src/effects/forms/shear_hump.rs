//! Another form of the shear hump: strength that falls to a residual as the soil is worked.

use crate::contact::{Contact, Hook};
use crate::effect::{Effect, Scope, Touch};
use crate::effects::ShearHump;
use crate::model::Soil;
use crate::param::{Param, Scale};
use crate::real::Real;

/// The soil's strength falls to a residual as it is worked.
///
/// # Equation
/// c and tan φ times 1 - e (1 - e^(-(s/.2)²))
///
/// # Reference
/// A. W. Skempton, Géotechnique 14(2):77-102, 1964 (residual strength); its course with slip is chosen.
#[derive(Clone, Copy, Debug, Default)]
pub struct ResidualStrength;

impl Effect for ResidualStrength {
    const NAME: &'static str = <ShearHump as Effect>::NAME;
    const FORM: &'static str = "residual-strength";
    const SUMMARY: &'static str = "the soil's strength falls to a residual as it is worked";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "1",
        min: 0.0,
        max: 0.9,
        scale: Scale::Linear,
        prior_sd: 0.2,
        doc: "share of the strength lost at high slip",
    }];
    const REFERENCE: &'static str = "A. W. Skempton, Géotechnique 14(2):77-102, 1964 (residual strength); its course with slip is chosen";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const SCOPE: Scope = <ShearHump as Effect>::SCOPE;
    const REGIME: &'static str = <ShearHump as Effect>::REGIME;
    const ISOLATED_BY: &'static str = <ShearHump as Effect>::ISOLATED_BY;

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, mut at: Contact<T>) -> Contact<T> {
        let worked = -(-(at.slip * 5.0).squared()).exp_m1();
        let left = T::one() - e[0] * worked;
        at.hooks.cohesion *= left;
        at.hooks.friction *= left;
        at
    }
}
