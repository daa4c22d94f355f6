//! The centre of mass lies elsewhere along the vehicle.
//!
//! # Equation
//! front axle load m g (1/2 + e), centre of mass e L further forward
//!
//! # Reference
//! J. Y. Wong, Theory of Ground Vehicles (axle loads from the place of the centre of gravity); chosen prior.

use crate::effect::{Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::Vehicle;

/// The centre of mass lies elsewhere along the vehicle.
#[derive(Clone, Copy, Debug, Default)]
pub struct CgOffset;

impl Effect for CgOffset {
    const NAME: &'static str = "cg-offset";
    const SUMMARY: &'static str = "the centre of mass lies elsewhere along the vehicle";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.45, 0.45],
        0.08,
        "offset over wheelbase, forward positive",
    )];
    const EQUATION: &'static str =
        "front axle load m g (1/2 + e), centre of mass e L further forward";
    const REFERENCE: &'static str = "J. Y. Wong, Theory of Ground Vehicles (axle loads from the place of the centre of gravity); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Vehicle];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "front against rear, acceleration";
    const ISOLATED_BY: &'static str = "weigh both axles";

    fn vehicle<T: Real>(&self, e: &[T], mut vehicle: Vehicle<T>) -> Vehicle<T> {
        vehicle.cg_to_front_axle -= e[0] * vehicle.wheelbase;
        vehicle
    }
}
