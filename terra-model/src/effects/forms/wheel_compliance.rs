//! Other forms of wheel compliance: a larger circle whose size depends on the sinkage, and on the load.

use super::{REFERENCE_DEPTH, bekker_sinkage};
use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::WheelCompliance;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Load at which the deflection of a springy wheel is quoted \[N\].
const REFERENCE_LOAD: f64 = 250.0;

/// Factor on the radius of the circle that meets the ground.
///
/// # Equation
/// (sqrt(1 + x²) + x)², x² = f/z, f the deflection, z the sinkage
fn substitute<T: Real>(x: T) -> T {
    ((x.squared() + 1.0).sqrt() + x).squared()
}

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
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let Some(z) = bekker_sinkage(soil, at) else {
            return;
        };
        let x = e[0] * (T::from(REFERENCE_DEPTH) / z).sqrt();
        at.hooks.contact_radius *= substitute(x);
    }
}

/// A wheel that is a spring deflects in proportion to its load, and meets the ground on a larger circle.
///
/// # Equation
/// contact radius R (sqrt(1 + x²) + x)², x² = f/z, f = e² (20 mm) W/(250 N): x = e sqrt((W/250 N) (20 mm/z_0)), z_0 Bekker's
/// sinkage
///
/// # Reference
/// I. C. Schmid, J. Terramechanics 32(1):3-26, 1995: the larger substitute circle (recalled); a linear spring for the tyre.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinearSpring;

impl Effect for LinearSpring {
    form_of!(WheelCompliance);
    const FORM: &'static str = "linear-spring";
    const SUMMARY: &'static str = "a wheel that is a spring deflects in proportion to its load, and meets the ground on a larger circle";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 2.0],
        0.15,
        "root of the deflection at 250 N over 20 mm",
    )];
    const EQUATION: &'static str = "contact radius R (sqrt(1 + x²) + x)², x² = f/z, f = e² (20 mm) W/(250 N): x = e sqrt((W/250 N) (20 mm/z_0)), z_0 Bekker's sinkage";
    const REFERENCE: &'static str = "I. C. Schmid, J. Terramechanics 32(1):3-26, 1995: the larger substitute circle (recalled); a linear spring for the tyre";
    const NEEDS: &'static [Hook] = &[Hook::ContactRadius];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let Some(z) = bekker_sinkage(soil, at) else {
            return;
        };
        let load = at.normal_load.max_of(T::from(1e-9)) / REFERENCE_LOAD;
        let x = e[0] * (load * (T::from(REFERENCE_DEPTH) / z)).sqrt();
        at.hooks.contact_radius *= substitute(x);
    }
}
