//! Soil resists faster loading more.
//!
//! # Equation
//! k -> k (|v| / 1 m/s)^e, |v| >= .05 m/s
//!
//! # Reference
//! W. Grahn, J. Terramechanics 28(4), 1991; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// Soil resists faster loading more.
#[derive(Clone, Copy, Debug, Default)]
pub struct RateStiffening;

impl Effect for RateStiffening {
    const NAME: &'static str = "rate-stiffening";
    const SUMMARY: &'static str = "soil resists faster loading more";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.35,
        "exponent of speed",
    )];
    const EQUATION: &'static str = "k -> k (|v| / 1 m/s)^e, |v| >= .05 m/s";
    const REFERENCE: &'static str =
        "W. Grahn, J. Terramechanics 28(4), 1991; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Speed]);
    const REGIME: &'static str = "sinkage and pull at equal slip but different speed";
    const ISOLATED_BY: &'static str = "the same slip at two speeds";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let speed = at.speed.abs().max_of(T::from(0.05));
        at.hooks.stiffness *= speed.pow_pos(e[0]);
    }
}
