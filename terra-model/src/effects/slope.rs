//! The ground is inclined.
//!
//! # Equation
//! dv/dt - g sin e, loads by cos e; the accelerometer reads specific force
//!
//! # Reference
//! J. Y. Wong, Theory of Ground Vehicles (grade resistance); chosen prior.

use crate::effect::{Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::Vehicle;

/// The ground is inclined.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope;

impl Effect for Slope {
    const NAME: &'static str = "slope";
    const SUMMARY: &'static str = "the ground is inclined";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "rad",
        [-0.8, 0.8],
        0.0349,
        "inclination, nose-up positive",
    )];
    const EQUATION: &'static str =
        "dv/dt - g sin e, loads by cos e; the accelerometer reads specific force";
    const REFERENCE: &'static str =
        "J. Y. Wong, Theory of Ground Vehicles (grade resistance); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Vehicle];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "pull offset that does not depend on slip; heading";
    const ISOLATED_BY: &'static str = "drive the track back the other way, or log pitch";

    fn vehicle<T: Real>(&self, e: &[T], mut vehicle: Vehicle<T>) -> Vehicle<T> {
        vehicle.pitch += e[0];
        vehicle
    }
}
