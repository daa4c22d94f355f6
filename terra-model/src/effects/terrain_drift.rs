//! The soil changes along the path.
//!
//! # Equation
//! k e^(e x / 8 m), c e^(e x / 16 m)
//!
//! # Reference
//! K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999 (trend of a soil over distance); chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The soil changes along the path.
#[derive(Clone, Copy, Debug, Default)]
pub struct TerrainDrift;

impl Effect for TerrainDrift {
    const NAME: &'static str = "terrain-drift";
    const SUMMARY: &'static str = "the soil changes along the path";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.4,
        "relative change over 8 m",
    )];
    const EQUATION: &'static str = "k e^(e x / 8 m), c e^(e x / 16 m)";
    const REFERENCE: &'static str = "K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999 (trend of a soil over distance); chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness, Hook::Cohesion];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::Path];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Path]);
    const REGIME: &'static str = "all channels, with path or time";
    const ISOLATED_BY: &'static str = "drive the same manoeuvre at both ends of the path";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.stiffness *= (e[0] * at.path / 8.0).exp();
        at.hooks.cohesion *= (e[0] * at.path / 16.0).exp();
    }
}
