//! The proportional split: a side's force divided between its wheels in proportion to load. Kept to show its flaw.
//!
//! D/W is not constant in W, so the share of a wheel is biased (up to 40 N of 160 N under ordinary load transfer),
//! and the data hold nothing that could repair it: the division between front and rear is unobservable.
//!
//! # Equation
//! D_w = F_side W_w / Σ W.
//!
//! # Reference
//! L. E. Ray, Proc. SPIE, 2008, text below eq. 7. Do not use it for anything but that comparison.

use nalgebra::{DMatrix, DVector};

use crate::error::EstimatorError;
use crate::observation::ForceObservation;

/// The observation [D, T] of wheel `wheel` that the split makes of a side's sum and torques.
///
/// Noise of the loads that set the share is carried along. An observation of one wheel is returned as it is.
///
/// # Errors
/// [`EstimatorError::Observation`] unless one row sums the drawbar pulls of all wheels and one is the wheel's torque.
pub fn proportional_split(
    side: &ForceObservation,
    wheel: usize,
) -> Result<ForceObservation, EstimatorError> {
    side.check()?;
    let (m, w) = (side.forces.len(), side.contacts.len());
    if w == 1 && wheel == 0 {
        return Ok(side.clone());
    }
    let fail = |reason: String| EstimatorError::Observation {
        time: side.time,
        reason,
    };
    let row = |is_one: &dyn Fn(usize) -> bool| {
        (0..m).find(|&i| (0..3 * w).all(|k| side.map[(i, k)] == if is_one(k) { 1.0 } else { 0.0 }))
    };
    let sum = row(&|k| k % 3 == 0)
        .ok_or_else(|| fail("no row is the sum of the drawbar pulls".to_owned()))?;
    let torque = row(&|k| k == 3 * wheel + 1)
        .ok_or_else(|| fail(format!("no row is the torque of wheel {wheel}")))?;
    let contact = *side
        .contacts
        .get(wheel)
        .ok_or_else(|| fail(format!("it has no wheel {wheel}")))?;
    let total: f64 = side.contacts.iter().map(|c| c.normal_load).sum();
    if total.is_nan() || total <= 0.0 {
        return Err(fail(format!("the loads sum to {total} N")));
    }
    let share = contact.normal_load / total;

    // [D_w, T_w, slip_w, W_w] as a linear map of the side's forces, slips and loads around their estimates.
    let mut g = DMatrix::zeros(4, m + 2 * w);
    g[(0, sum)] = share;
    for k in 0..w {
        let own = if k == wheel { 1.0 } else { 0.0 };
        g[(0, m + 2 * k + 1)] = side.forces[sum] * (own - share) / total;
    }
    g[(1, torque)] = 1.0;
    g[(2, m + 2 * wheel)] = 1.0;
    g[(3, m + 2 * wheel + 1)] = 1.0;
    let mut map = DMatrix::zeros(2, 3);
    map[(0, 0)] = 1.0;
    map[(1, 1)] = 1.0;
    Ok(ForceObservation {
        time: side.time,
        group: side.group,
        forces: DVector::from_vec(vec![share * side.forces[sum], side.forces[torque]]),
        map,
        contacts: vec![contact],
        covariance: &g * &side.covariance * g.transpose(),
    })
}
