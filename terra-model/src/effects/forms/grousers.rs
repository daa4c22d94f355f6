//! Another form of grousers: shear on the sides of the block between the lugs.

use crate::contact::{Contact, Hook};
use crate::effect::{Effect, Touch};
use crate::effects::Grousers;
use crate::model::Soil;
use crate::param::Param;
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
    form_of!(Grousers);
    const FORM: &'static str = "side-walls";
    const SUMMARY: &'static str = "the block of soil between lugs shears at its sides too";
    const PARAMS: &'static [Param] = &[Param::magnitude("m", [0.0, 0.2], 0.015, "lug height")];
    const REFERENCE: &'static str = "M. G. Bekker, Off-the-Road Locomotion, 1960, as in Wong, Theory of Ground Vehicles: thrust of grousers on a track";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, mut at: Contact<T>) -> Contact<T> {
        let ratio = e[0] / at.width;
        let acot = -ratio.atan() + std::f64::consts::FRAC_PI_2;
        at.hooks.cohesion *= ratio * 2.0 + 1.0;
        at.hooks.friction *= ratio * acot * 0.64 + 1.0;
        at
    }
}
