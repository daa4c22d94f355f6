//! The wheel flattens and meets the ground on a larger radius.
//!
//! # Equation
//! contact radius R (1 + e), torque arm R
//!
//! # Reference
//! M. G. Bekker, Theory of Land Locomotion, 1956; chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The wheel flattens and meets the ground on a larger radius.
#[derive(Clone, Copy, Debug, Default)]
pub struct WheelCompliance;

impl Effect for WheelCompliance {
    const NAME: &'static str = "wheel-compliance";
    const SUMMARY: &'static str = "the wheel flattens and meets the ground on a larger radius";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 5.0],
        0.3,
        "relative growth of the contact radius",
    )];
    const EQUATION: &'static str = "contact radius R (1 + e), torque arm R";
    const REFERENCE: &'static str =
        "M. G. Bekker, Theory of Land Locomotion, 1956; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::ContactRadius];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "sinkage down under heavy load";
    const ISOLATED_BY: &'static str = "load the wheel on hard ground and measure the footprint";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.contact_radius *= e[0] + 1.0;
    }
}
