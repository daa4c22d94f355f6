//! Other forms of terrain drift: strength instead of stiffness, ground that comes and goes.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::TerrainDrift;
use crate::model::Soil;
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The soil's strength changes along the path, its stiffness does not.
///
/// # Equation
/// c e^(e x/8 m), tan φ e^(e x/24 m)
///
/// # Reference
/// chosen form: c varies more over a field than φ, as K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624,
/// 1999.
#[derive(Clone, Copy, Debug, Default)]
pub struct StrengthDrift;

impl Effect for StrengthDrift {
    form_of!(TerrainDrift);
    const FORM: &'static str = "strength";
    const SUMMARY: &'static str =
        "the soil's strength changes along the path, its stiffness does not";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.4,
        "relative change of cohesion over 8 m",
    )];
    const EQUATION: &'static str = "c e^(e x/8 m), tan φ e^(e x/24 m)";
    const REFERENCE: &'static str = "chosen form: c varies more over a field than φ, as K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::Path];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Path]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.cohesion *= (e[0] * at.path / 8.0).exp();
        at.hooks.friction *= (e[0] * at.path / 24.0).exp();
    }
}

/// The soil changes along the path and comes back.
///
/// # Equation
/// k e^(e sin(2π x/8 m)), c e^(e sin(2π x/8 m)/2)
///
/// # Reference
/// chosen form: stiffness with a scale of fluctuation of metres, as K. K. Phoon, F. H. Kulhawy, Can. Geotech. J.
/// 36(4):612-624, 1999.
#[derive(Clone, Copy, Debug, Default)]
pub struct Undulating;

impl Effect for Undulating {
    form_of!(TerrainDrift);
    const FORM: &'static str = "undulating";
    const SUMMARY: &'static str = "the soil changes along the path and comes back";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.4,
        "relative change of stiffness from mean to crest",
    )];
    const EQUATION: &'static str = "k e^(e sin(2π x/8 m)), c e^(e sin(2π x/8 m)/2)";
    const REFERENCE: &'static str = "chosen form: stiffness with a scale of fluctuation of metres, as K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness, Hook::Cohesion];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::Path];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Path]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let (wave, _) = (at.path * (std::f64::consts::TAU / 8.0)).sin_cos();
        at.hooks.stiffness *= (e[0] * wave).exp();
        at.hooks.cohesion *= (e[0] * wave * 0.5).exp();
    }
}
