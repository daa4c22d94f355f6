//! Another form of the shear hump: strength that the soil of the whole contact loses as it is sheared.

use super::bekker_sinkage;
use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::ShearHump;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The soil under the wheel is strongest at some shear displacement, and weaker once it is sheared on.
///
/// # Equation
/// c and tan φ times (1 + e x e^(1 - x)), x = |s| l/(2 K), l = sqrt(2 R z_0), z_0 Bekker's sinkage: the hump of the default
/// form at the mean shear displacement of the contact
///
/// # Reference
/// J. Y. Wong, J. Preston-Thomas, J. Terramechanics 19(4), 1983 (peak and residual strength); chosen form and prior.
#[derive(Clone, Copy, Debug, Default)]
pub struct PeakStrength;

impl Effect for PeakStrength {
    form_of!(ShearHump);
    const FORM: &'static str = "peak-strength";
    const SUMMARY: &'static str = "the soil under the wheel is strongest at some shear displacement, and weaker once it is sheared on";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 5.0],
        0.35,
        "peak strength over the plateau's, less 1",
    )];
    const EQUATION: &'static str = "c and tan φ times (1 + e x e^(1 - x)), x = |s| l/(2 K), l = sqrt(2 R z_0), z_0 Bekker's sinkage: the hump of the default form at the mean shear displacement of the contact";
    const REFERENCE: &'static str = "J. Y. Wong, J. Preston-Thomas, J. Terramechanics 19(4), 1983 (peak and residual strength); chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent", "shear_modulus"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let (Some(z), Some(k)) = (bekker_sinkage(soil, at), soil.shear_modulus) else {
            return;
        };
        let length = (z.max_of(T::from(1e-12)) * at.radius * 2.0).sqrt();
        let x = at.slip.abs() * length / (k * 2.0);
        let gain = e[0] * x * (-x + 1.0).exp() + 1.0;
        at.hooks.cohesion *= gain;
        at.hooks.friction *= gain;
    }
}
