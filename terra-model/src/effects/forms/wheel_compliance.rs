//! Another form of wheel compliance: a larger circle whose size depends on the sinkage.

use super::{REFERENCE_DEPTH, bekker_sinkage};
use crate::contact::{Contact, Hook};
use crate::effect::{Effect, Touch};
use crate::effects::WheelCompliance;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The deflected wheel meets the ground on a larger circle, the larger the less it sinks.
///
/// # Equation
/// contact radius R (sqrt(1 + x²) + x)², x² = f/z: x = e sqrt(20 mm/z_0), z_0 Bekker's sinkage
///
/// # Reference
/// I. C. Schmid, J. Terramechanics 32(1):3-26, 1995: the larger substitute circle (recalled).
#[derive(Clone, Copy, Debug, Default)]
pub struct SubstituteCircle;

impl Effect for SubstituteCircle {
    form_of!(WheelCompliance);
    const FORM: &'static str = "substitute-circle";
    const SUMMARY: &'static str =
        "the deflected wheel meets the ground on a larger circle, the larger the less it sinks";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 2.0],
        0.15,
        "root of deflection over 20 mm",
    )];
    const EQUATION: &'static str = "contact radius R (sqrt(1 + x²) + x)², x² = f/z: x = e sqrt(20 mm/z_0), z_0 Bekker's sinkage";
    const REFERENCE: &'static str =
        "I. C. Schmid, J. Terramechanics 32(1):3-26, 1995: the larger substitute circle (recalled)";
    const NEEDS: &'static [Hook] = &[Hook::ContactRadius];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let Some(z) = bekker_sinkage(soil, at) else {
            return;
        };
        let x = e[0] * (T::from(REFERENCE_DEPTH) / z).sqrt();
        at.hooks.contact_radius *= ((x.squared() + 1.0).sqrt() + x).squared();
    }
}
