//! Another form of lateral slip: soil that is sheared sideways gives less pull, and no side force.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::SkidSteerLateralSlip;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Only the pull is less where wheels are dragged sideways: what resists the turn is the vehicle's damping in yaw alone.
///
/// # Equation
/// j_y = R (1 - i)(θ1 - θ) tan β_e, tan β_e = e tan β, τ_x = τ j_x/|j| with |j| = hypot(j_x, j_y) in E; no side force
///
/// # Reference
/// G. Ishigami, A. Miwa, K. Nagatani, K. Yoshida, J. Field Robotics 24(3):233-250, 2007 (j_y); a vehicle whose wheels' side
/// forces stand in its damping in yaw, as in L. E. Ray, Proc. SPIE 2008, eq. 2; chosen form and prior.
#[derive(Clone, Copy, Debug, Default)]
pub struct PullOnly;

impl Effect for PullOnly {
    form_of!(SkidSteerLateralSlip);
    const FORM: &'static str = "pull-only";
    const SUMMARY: &'static str = "only the pull is less where wheels are dragged sideways";
    const PARAMS: &'static [Param] = <SkidSteerLateralSlip as Effect>::PARAMS;
    const EQUATION: &'static str = "j_y = R (1 - i)(θ1 - θ) tan β_e, tan β_e = e tan β, τ_x = τ j_x/|j| with |j| = hypot(j_x, j_y) in E; no side force";
    const REFERENCE: &'static str = "G. Ishigami, A. Miwa, K. Nagatani, K. Yoshida, J. Field Robotics 24(3):233-250, 2007; side forces stand in the damping in yaw as in L. E. Ray, Proc. SPIE 2008, eq. 2; chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::LateralSlip];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const READS: &'static [Circumstance] = &[Circumstance::SlipAngle];
    const FLAT: bool = true;

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        // Where the contact slides sideways already its side force is there without this.
        at.hooks.pull_only = at.hooks.lateral_slip.is_none();
        SkidSteerLateralSlip.before(e, soil, at);
    }
}
