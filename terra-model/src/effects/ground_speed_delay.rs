//! The logged ground speed is late.
//!
//! # Equation
//! v_reported(t) = v(t - e), to first order v - e dv/dt
//!
//! # Reference
//! I. Skog, P. Händel, IEEE Trans. Intelligent Transportation Systems 12(4):1014-1023, 2011 (time offset of a speed
//! reference); chosen prior.

use crate::effect::{Channel, Effect, Scope, Touch};
use crate::param::Param;
use crate::real::Real;

/// The logged ground speed is late.
#[derive(Clone, Copy, Debug, Default)]
pub struct GroundSpeedDelay;

impl Effect for GroundSpeedDelay {
    const NAME: &'static str = "ground-speed-delay";
    const SUMMARY: &'static str = "the logged ground speed is late";
    const PARAMS: &'static [Param] = &[Param::magnitude("s", [0.0, 2.0], 0.1, "delay")];
    const EQUATION: &'static str = "v_reported(t) = v(t - e), to first order v - e dv/dt";
    const REFERENCE: &'static str = "I. Skog, P. Händel, IEEE Trans. Intelligent Transportation Systems 12(4):1014-1023, 2011 (time offset of a speed reference); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::GroundSpeed];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "slip while the speed changes";
    const ISOLATED_BY: &'static str = "a speed step on hard ground";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, rate: T) -> T {
        if channel == Channel::GroundSpeed {
            truth - e[0] * rate
        } else {
            truth
        }
    }
}
