//! Another form of a late ground speed: a filter.

use crate::effect::{Channel, Effect, Late, Touch};
use crate::effects::GroundSpeedDelay;
use crate::param::Param;
use crate::real::Real;

/// The logged ground speed follows the true one through a filter of first order.
///
/// # Equation
/// e dv_reported/dt = v - v_reported
///
/// # Reference
/// K. J. Åström, R. M. Murray, Feedback Systems, 2008, section 6 (response of a system of first order); chosen prior.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstOrder;

impl Effect for FirstOrder {
    form_of!(GroundSpeedDelay);
    const FORM: &'static str = "first-order";
    const SUMMARY: &'static str =
        "the logged ground speed follows the true one through a filter of first order";
    const PARAMS: &'static [Param] = &[Param::magnitude("s", [0.0, 2.0], 0.1, "time constant")];
    const EQUATION: &'static str = "e dv_reported/dt = v - v_reported";
    const REFERENCE: &'static str = "K. J. Åström, R. M. Murray, Feedback Systems, 2008, section 6 (response of a system of first order); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::GroundSpeed];
    const LATE: Late = Late::Following;

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, rate: T) -> T {
        if channel == Channel::GroundSpeed {
            truth - e[0] * rate
        } else {
            truth
        }
    }
}
