//! The track is not the one in the file.
//!
//! # Equation
//! t_w -> t_w (1 + e)
//!
//! # Reference
//! J. Borenstein, L. Feng, IEEE Trans. Robotics and Automation 12(6):869-880, 1996 (uncertain effective wheelbase); chosen
//! prior.

use crate::effect::{Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::Vehicle;

/// The track is not the one in the file.
#[derive(Clone, Copy, Debug, Default)]
pub struct TrackWidthError;

impl Effect for TrackWidthError {
    const NAME: &'static str = "track-width-error";
    const SUMMARY: &'static str = "the track is not the one in the file";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.5, 2.0],
        0.05,
        "relative error of the track",
    )];
    const EQUATION: &'static str = "t_w -> t_w (1 + e)";
    const REFERENCE: &'static str = "J. Borenstein, L. Feng, IEEE Trans. Robotics and Automation 12(6):869-880, 1996 (uncertain effective wheelbase); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Vehicle];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "wheel speeds and yaw in turns";
    const ISOLATED_BY: &'static str = "measure the track with a tape";

    fn vehicle<T: Real>(&self, e: &[T], mut vehicle: Vehicle<T>) -> Vehicle<T> {
        vehicle.track *= e[0] + 1.0;
        vehicle
    }
}
