//! Another form of grousers: shear on the sides of the block between the lugs.

use crate::contact::{Contact, Hook};
use crate::effect::{Effect, Scope, Touch};
use crate::effects::Grousers;
use crate::model::Soil;
use crate::param::{Param, Scale};
use crate::real::Real;

/// The block of soil between lugs shears at its sides too.
///
/// # Equation
/// c (1 + 2 h/b), tan φ (1 + .64 (h/b) acot(h/b)), h = e
///
/// # Reference
/// M. G. Bekker, Off-the-Road Locomotion, 1960, as in Wong, Theory of Ground Vehicles: thrust of grousers on a track.
#[derive(Clone, Copy, Debug, Default)]
pub struct SideWalls;

impl Effect for SideWalls {
    const NAME: &'static str = <Grousers as Effect>::NAME;
    const FORM: &'static str = "side-walls";
    const SUMMARY: &'static str = "the block of soil between lugs shears at its sides too";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "m",
        min: 0.0,
        max: 0.2,
        scale: Scale::Linear,
        prior_sd: 0.015,
        doc: "lug height",
    }];
    const REFERENCE: &'static str = "M. G. Bekker, Off-the-Road Locomotion, 1960, as in Wong, Theory of Ground Vehicles: thrust of grousers on a track";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const SCOPE: Scope = <Grousers as Effect>::SCOPE;
    const REGIME: &'static str = <Grousers as Effect>::REGIME;
    const ISOLATED_BY: &'static str = <Grousers as Effect>::ISOLATED_BY;

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, mut at: Contact<T>) -> Contact<T> {
        let ratio = e[0] / at.width;
        let acot = -ratio.atan() + std::f64::consts::FRAC_PI_2;
        at.hooks.cohesion *= ratio * 2.0 + 1.0;
        at.hooks.friction *= ratio * acot * 0.64 + 1.0;
        at
    }
}
