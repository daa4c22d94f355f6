//! A wheel that does not steer is dragged sideways in a turn, and the soil's strength is shared between both directions.
//!
//! # Equation
//! j_y = R (1 - i)(θ1 - θ) tan β_e, tan β_e = e tan β, τ along (j_x, j_y) with |j| = hypot(j_x, j_y) in E;
//! on a vehicle tan |β| = L |r|/(2 |v|)
//!
//! # Reference
//! G. Ishigami, A. Miwa, K. Nagatani, K. Yoshida, J. Field Robotics 24(3):233-250, 2007 (j_y); chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// A wheel that does not steer is dragged sideways in a turn.
#[derive(Clone, Copy, Debug, Default)]
pub struct SkidSteerLateralSlip;

impl Effect for SkidSteerLateralSlip {
    const NAME: &'static str = "skid-steer-lateral-slip";
    const SUMMARY: &'static str = "a wheel that does not steer is dragged sideways in a turn";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 1.5],
        0.5,
        "share of the geometric slip angle that shears the soil",
    )];
    const EQUATION: &'static str = "j_y = R (1 - i)(θ1 - θ) tan β_e, tan β_e = e tan β, τ along (j_x, j_y) with |j| = hypot(j_x, j_y) in E; on a vehicle tan |β| = L |r|/(2 |v|)";
    const REFERENCE: &'static str = "G. Ishigami, A. Miwa, K. Nagatani, K. Yoshida, J. Field Robotics 24(3):233-250, 2007; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::LateralSlip];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::SlipAngle];
    const REGIME: &'static str = "pull down and a moment against the turn, in turns only";
    const ISOLATED_BY: &'static str = "turn at several yaw rates at the same speed";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let more = e[0] * at.slip_angle.tan();
        at.hooks.lateral_slip = Some(at.hooks.lateral_slip.map_or(more, |tan| tan + more));
    }
}
