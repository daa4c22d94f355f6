//! Something is towed.
//!
//! # Equation
//! forward force - e sign(v)
//!
//! # Reference
//! J. Y. Wong, Theory of Ground Vehicles (drawbar load in the longitudinal balance); a constant load and its prior are
//! chosen.

use crate::effect::{Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// Something is towed.
#[derive(Clone, Copy, Debug, Default)]
pub struct TowLoad;

impl Effect for TowLoad {
    const NAME: &'static str = "tow-load";
    const SUMMARY: &'static str = "something is towed";
    const PARAMS: &'static [Param] = &[Param::magnitude("N", [0.0, 10000.0], 40.0, "towing force")];
    const SHARE: f64 = 0.16;
    const EQUATION: &'static str = "forward force - e sign(v)";
    const REFERENCE: &'static str = "J. Y. Wong, Theory of Ground Vehicles (drawbar load in the longitudinal balance); a constant load and its prior are chosen";
    const TOUCHES: &'static [Touch] = &[Touch::Loads];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "sum of forces, at every slip; a line at the ground's height, so that no load moves between axles";
    const ISOLATED_BY: &'static str = "load cell at the hitch, or firm ground";

    fn loads<T: Real>(
        &self,
        e: &[T],
        _vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        mut loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        // Smooth through standstill over .05 m/s, where a tow line goes slack.
        loads.force_x -= e[0] * (motion.speed / 0.05).tanh();
        loads
    }
}
