//! The mass is not the one in the file.
//!
//! # Equation
//! m -> m (1 + e)
//!
//! # Reference
//! definition (mass in Newton's second law and in the axle loads); chosen prior.

use crate::effect::{Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::Vehicle;

/// The mass is not the one in the file.
#[derive(Clone, Copy, Debug, Default)]
pub struct MassError;

impl Effect for MassError {
    const NAME: &'static str = "mass-error";
    const SUMMARY: &'static str = "the mass is not the one in the file";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.9, 5.0],
        0.12,
        "relative error of the mass",
    )];
    const EQUATION: &'static str = "m -> m (1 + e)";
    const REFERENCE: &'static str =
        "definition (mass in Newton's second law and in the axle loads); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Vehicle];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "loads everywhere, force under acceleration";
    const ISOLATED_BY: &'static str = "weigh the vehicle";

    fn vehicle<T: Real>(&self, e: &[T], mut vehicle: Vehicle<T>) -> Vehicle<T> {
        vehicle.mass *= e[0] + 1.0;
        vehicle
    }
}
