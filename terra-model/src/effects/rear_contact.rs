//! Soil behind the wheel rebounds and stays in contact.
//!
//! # Equation
//! θ2 = -e θ1
//!
//! # Reference
//! J. Y. Wong, Theory of Ground Vehicles; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Soil behind the wheel rebounds and stays in contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct RearContact;

impl Effect for RearContact {
    const NAME: &'static str = "rear-contact";
    const SUMMARY: &'static str = "soil behind the wheel rebounds and stays in contact";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 0.9],
        0.35,
        "exit angle over entry angle",
    )];
    const EQUATION: &'static str = "θ2 = -e θ1";
    const REFERENCE: &'static str = "J. Y. Wong, Theory of Ground Vehicles; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::ExitRatio];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "pull up, sinkage down; elastic soil, clay";
    const ISOLATED_BY: &'static str = "stress sensors in the rim, or sinkage beside pull";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.exit_ratio += e[0];
    }
}
