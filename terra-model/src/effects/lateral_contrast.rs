//! The soil differs between left and right.
//!
//! # Equation
//! k e^(±e/2), + on the right
//!
//! # Reference
//! K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999 (soil differs over metres); chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Scope, Touch};
use crate::model::Soil;
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// The soil differs between left and right.
#[derive(Clone, Copy, Debug, Default)]
pub struct LateralContrast;

impl Effect for LateralContrast {
    const NAME: &'static str = "lateral-contrast";
    const SUMMARY: &'static str = "the soil differs between left and right";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.5,
        "log ratio of right to left stiffness",
    )];
    const EQUATION: &'static str = "k e^(±e/2), + on the right";
    const REFERENCE: &'static str = "K. K. Phoon, F. H. Kulhawy, Can. Geotech. J. 36(4):612-624, 1999 (soil differs over metres); chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::Side];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Side]);
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "left against right on straight runs, yaw";
    const ISOLATED_BY: &'static str = "drive the track back the other way";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.stiffness *= (e[0] * at.side * 0.5).exp();
    }
}
