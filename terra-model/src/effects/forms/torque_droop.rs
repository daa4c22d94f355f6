//! Other forms of torque droop: a hyperbola, a knee.

use crate::effect::{Channel, Effect, Touch};
use crate::effects::TorqueDroop;
use crate::param::Param;
use crate::real::Real;

/// The motor saturates: the logged torque rises first with the square of the torque, then in proportion.
///
/// # Equation
/// T_reported = T_true (1 + e (sqrt(1 + (T/60 N m)²) - 1))
///
/// # Reference
/// hyperbolic magnetisation curve of a saturating motor; chosen form.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hyperbola;

impl Effect for Hyperbola {
    form_of!(TorqueDroop);
    const FORM: &'static str = "hyperbola";
    const SUMMARY: &'static str = "the motor saturates: the logged torque rises first with the square of the torque, then in proportion";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 10.0],
        0.5,
        "relative error far above 60 N m, a torque of 60 N m at a time",
    )];
    const EQUATION: &'static str = "T_reported = T_true (1 + e (sqrt(1 + (T/60 N m)²) - 1))";
    const REFERENCE: &'static str =
        "hyperbolic magnetisation curve of a saturating motor; chosen form";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::WheelTorque];

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel != Channel::WheelTorque {
            return truth;
        }
        let over = ((truth * (1.0 / 60.0)).squared() + 1.0).sqrt() - 1.0;
        truth * (e[0] * over + 1.0)
    }
}

/// The logged torque is right up to a knee at 10 N m and too large above it.
///
/// # Equation
/// T_reported = T_true (1 + e x²/(1 + x)), x = (|T| - 10 N m)/50 N m above the knee, 0 below
///
/// # Reference
/// knee of the magnetisation curve of a motor; chosen form.
#[derive(Clone, Copy, Debug, Default)]
pub struct Knee;

impl Effect for Knee {
    form_of!(TorqueDroop);
    const FORM: &'static str = "knee";
    const SUMMARY: &'static str =
        "the logged torque is right up to a knee at 10 N m and too large above it";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 10.0],
        0.5,
        "relative error at 60 N m, times two",
    )];
    const EQUATION: &'static str =
        "T_reported = T_true (1 + e x²/(1 + x)), x = (|T| - 10 N m)/50 N m above the knee, 0 below";
    const REFERENCE: &'static str = "knee of the magnetisation curve of a motor; chosen form";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::WheelTorque];

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel != Channel::WheelTorque {
            return truth;
        }
        let over = ((truth.abs() - 10.0) * (1.0 / 50.0)).max_of(T::zero());
        truth * (e[0] * over.squared() / (over + 1.0) + 1.0)
    }
}
