//! Other forms of multipass: a rut already paid for, soil whose strength grew rather than its stiffness.

use super::compaction_work;
use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::Multipass;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The rut is there: the earlier wheel paid for its compaction.
///
/// # Equation
/// D -> D + e (1 - e^(-passes)) b k z^(n+1)/(n+1), the work of compaction per length
///
/// # Reference
/// M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969 (repetitive loading); chosen form.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rut;

impl Effect for Rut {
    form_of!(Multipass);
    const FORM: &'static str = "rut";
    const SUMMARY: &'static str = "the rut is there: the earlier wheel paid for its compaction";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 1.0],
        0.3,
        "share of the work of compaction that a track worn in saves",
    )];
    const EQUATION: &'static str =
        "D -> D + e (1 - e^(-passes)) b k z^(n+1)/(n+1), the work of compaction per length";
    const REFERENCE: &'static str = "M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969 (repetitive loading); chosen form";
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const READS: &'static [Circumstance] = &[Circumstance::EarlierPasses];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> =
        Some(&[Circumstance::EarlierPasses]);

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let Some(work) = compaction_work(soil, at, forces) else {
            return;
        };
        let saved = work * e[0] * -(-at.earlier_passes).exp_m1();
        forces.drawbar_pull += saved;
        forces.parts.other += saved;
    }
}

/// Soil packed by earlier passes is stronger in shear, not stiffer.
///
/// # Equation
/// M = e (1 - e^(-passes)): c (1 + M), tan φ (1 + .3 M), K/(1 + M)
///
/// # Reference
/// D. Holm, 3rd Int. Conf. ISTVS, 1969 (repeated passes raise density and strength); chosen form.
#[derive(Clone, Copy, Debug, Default)]
pub struct PackedStrength;

impl Effect for PackedStrength {
    form_of!(Multipass);
    const FORM: &'static str = "packed-strength";
    const SUMMARY: &'static str = "soil packed by earlier passes is stronger in shear, not stiffer";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 10.0],
        0.5,
        "relative gain of cohesion after many passes",
    )];
    const EQUATION: &'static str =
        "M = e (1 - e^(-passes)): c (1 + M), tan φ (1 + .3 M), K/(1 + M)";
    const REFERENCE: &'static str = "D. Holm, 3rd Int. Conf. ISTVS, 1969 (repeated passes raise density and strength); chosen form";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction, Hook::ShearModulus];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::EarlierPasses];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> =
        Some(&[Circumstance::EarlierPasses]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let gain = e[0] * -(-at.earlier_passes).exp_m1();
        at.hooks.cohesion *= gain + 1.0;
        at.hooks.friction *= gain * 0.3 + 1.0;
        at.hooks.shear_modulus = at.hooks.shear_modulus / (gain + 1.0);
    }
}
