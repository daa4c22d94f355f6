//! Air resistance.
//!
//! # Equation
//! forward force - e v |v|
//!
//! # Reference
//! J. Y. Wong, Theory of Ground Vehicles (aerodynamic resistance grows with the square of speed); chosen prior.

use crate::effect::{Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// Air resistance.
#[derive(Clone, Copy, Debug, Default)]
pub struct AeroDrag;

impl Effect for AeroDrag {
    const NAME: &'static str = "aero-drag";
    const SUMMARY: &'static str = "air resistance";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "N s²/m²",
        [0.0, 1000.0],
        8.0,
        "drag coefficient",
    )];
    const SHARE: f64 = 0.032;
    const EQUATION: &'static str = "forward force - e v |v|";
    const REFERENCE: &'static str = "J. Y. Wong, Theory of Ground Vehicles (aerodynamic resistance grows with the square of speed); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Loads];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "sum of forces at high speed";
    const ISOLATED_BY: &'static str = "coast down on hard ground";

    fn loads<T: Real>(
        &self,
        e: &[T],
        _vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        mut loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        loads.force_x -= e[0] * motion.speed * motion.speed.abs();
        loads
    }
}
