//! Other forms of interface friction: adhesion lost, friction lost. The default loses both alike.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::InterfaceFriction;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Soil sticks less to the rim than to itself: adhesion is a share of cohesion, and friction is the soil's own.
///
/// # Equation
/// c -> (1 - e) c in the shear stress
///
/// # Reference
/// J. G. Potyondy, Géotechnique 11(4):339-353, 1961: f_c = c_a/c apart from f_φ = δ/φ.
#[derive(Clone, Copy, Debug, Default)]
pub struct Adhesion;

impl Effect for Adhesion {
    form_of!(InterfaceFriction);
    const FORM: &'static str = "adhesion";
    const SUMMARY: &'static str = "soil sticks less to the rim than to itself";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 0.99],
        0.3,
        "share of cohesion lost at the interface",
    )];
    const EQUATION: &'static str = "c -> (1 - e) c in the shear stress";
    const REFERENCE: &'static str =
        "J. G. Potyondy, Géotechnique 11(4):339-353, 1961: f_c = c_a/c; chosen prior";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.cohesion *= T::one() - e[0];
    }
}

/// Soil rubs less on the rim than on itself: the angle of friction is a share of the soil's, and adhesion is its cohesion.
///
/// # Equation
/// tan φ -> tan((1 - e) φ) in the shear stress
///
/// # Reference
/// J. G. Potyondy, Géotechnique 11(4):339-353, 1961: f_φ = δ/φ.
#[derive(Clone, Copy, Debug, Default)]
pub struct SkinAngle;

impl Effect for SkinAngle {
    form_of!(InterfaceFriction);
    const FORM: &'static str = "skin-angle";
    const SUMMARY: &'static str = "soil rubs less on the rim than on itself";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 0.99],
        0.3,
        "share of the angle of friction lost at the interface",
    )];
    const EQUATION: &'static str = "tan φ -> tan((1 - e) φ) in the shear stress";
    const REFERENCE: &'static str =
        "J. G. Potyondy, Géotechnique 11(4):339-353, 1961: f_φ = δ/φ; chosen prior";
    const NEEDS: &'static [Hook] = &[Hook::Friction];
    const NEEDS_SOIL: &'static [&'static str] = &["friction_angle"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let Some(phi) = soil.friction_angle else {
            return;
        };
        // Clay without friction has none to lose, but a quotient to form.
        let phi = phi.max_of(T::from(1e-6));
        at.hooks.friction *= (phi * (T::one() - e[0])).tan() / phi.tan();
    }
}
