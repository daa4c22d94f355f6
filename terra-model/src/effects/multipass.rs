//! Soil compacted by earlier passes is stiffer and stronger.
//!
//! # Equation
//! M = e (1 - exp(-passes)): k (1 + M), K/(1 + .5 M), c (1 + .3 M)
//!
//! # Reference
//! S. Senatore, C. Sandu, J. Terramechanics 48(4):265-276, 2011; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Soil compacted by earlier passes is stiffer and stronger.
#[derive(Clone, Copy, Debug, Default)]
pub struct Multipass;

impl Effect for Multipass {
    const NAME: &'static str = "multipass";
    const SUMMARY: &'static str = "soil compacted by earlier passes is stiffer and stronger";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 10.0],
        0.8,
        "relative stiffening after many passes",
    )];
    const EQUATION: &'static str =
        "M = e (1 - exp(-passes)): k (1 + M), K/(1 + .5 M), c (1 + .3 M)";
    const REFERENCE: &'static str =
        "S. Senatore, C. Sandu, J. Terramechanics 48(4):265-276, 2011; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness, Hook::ShearModulus, Hook::Cohesion];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::EarlierPasses];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> =
        Some(&[Circumstance::EarlierPasses]);
    const REGIME: &'static str =
        "sinkage of the rear wheels down, their torque too at low slip; second axle and own rut";
    const ISOLATED_BY: &'static str = "a second pass in the same rut";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let gain = e[0] * -(-at.earlier_passes).exp_m1();
        at.hooks.stiffness *= gain + 1.0;
        at.hooks.shear_modulus = at.hooks.shear_modulus / (gain * 0.5 + 1.0);
        at.hooks.cohesion *= gain * 0.3 + 1.0;
    }
}
