//! Another form of lateral contrast: sides that differ in strength rather than in stiffness.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::LateralContrast;
use crate::model::Soil;
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The soil is stronger on one side, and as stiff on both.
///
/// # Equation
/// c e^(±e/2), tan φ e^(±e/6), + on the right
///
/// # Reference
/// chosen form: c varies more over a field than φ, as K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624,
/// 1999.
#[derive(Clone, Copy, Debug, Default)]
pub struct StrengthContrast;

impl Effect for StrengthContrast {
    form_of!(LateralContrast);
    const FORM: &'static str = "strength";
    const SUMMARY: &'static str = "the soil is stronger on one side, and as stiff on both";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.5,
        "log ratio of right to left cohesion",
    )];
    const EQUATION: &'static str = "c e^(±e/2), tan φ e^(±e/6), + on the right";
    const REFERENCE: &'static str = "chosen form: c varies more over a field than φ, as K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::Side];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Side]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.cohesion *= (e[0] * at.side * 0.5).exp();
        at.hooks.friction *= (e[0] * at.side * (1.0 / 6.0)).exp();
    }
}
