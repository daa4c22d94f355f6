//! Other forms of friction between motor and wheel: a peak at standstill, a film of lubricant.

use crate::effect::{Effect, Touch};
use crate::effects::{DrivetrainCoulombFriction, DrivetrainViscousFriction};
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// Dry friction that is half as large again at standstill, and falls as the wheel turns.
///
/// # Equation
/// the motor delivers e tanh(ω/.1 rad/s) (1 + e^(-(ω/.5 rad/s)²)/2) more
///
/// # Reference
/// Stribeck's curve with Gaussian decay, as B. Armstrong-Hélouvry et al., Automatica 30(7):1083-1138, 1994 (recalled);
/// chosen ratio and speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stribeck;

impl Effect for Stribeck {
    form_of!(DrivetrainCoulombFriction);
    const FORM: &'static str = "stribeck";
    const SUMMARY: &'static str =
        "dry friction that is half as large again at standstill, and falls as the wheel turns";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "N m",
        [0.0, 500.0],
        2.0,
        "friction torque at the turning wheel",
    )];
    const SHARE: f64 = 0.032;
    const EQUATION: &'static str =
        "the motor delivers e tanh(ω/.1 rad/s) (1 + e^(-(ω/.5 rad/s)²)/2) more";
    const REFERENCE: &'static str = "Stribeck's curve, as B. Armstrong-Hélouvry et al., Automatica 30(7):1083-1138, 1994 (recalled); chosen ratio and speed";
    const TOUCHES: &'static [Touch] = &[Touch::Loads];

    fn loads<T: Real>(
        &self,
        e: &[T],
        _vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        mut loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        for (torque, w) in loads.wheel_torque.iter_mut().zip(motion.wheel_speed) {
            let standstill = (-(w * 2.0).squared()).exp() * 0.5;
            *torque += e[0] * (w * 10.0).tanh() * (standstill + 1.0);
        }
        loads
    }
}

/// Churned lubricant of rolling bearings: friction that grows with the two-thirds power of speed.
///
/// # Equation
/// the motor delivers e ω/(ω² + (.1 rad/s)²)^(1/6) more: e ω^(2/3) but for a smooth start
///
/// # Reference
/// A. Palmgren, Ball and Roller Bearing Engineering, 1959 (recalled): M_0 ~ (ν n)^(2/3).
#[derive(Clone, Copy, Debug, Default)]
pub struct Lubricant;

impl Effect for Lubricant {
    form_of!(DrivetrainViscousFriction);
    const FORM: &'static str = "lubricant";
    const SUMMARY: &'static str = "churned lubricant of rolling bearings: friction that grows with the two-thirds power of speed";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "N m s^(2/3)",
        EITHER_SIGN,
        1.0,
        "friction torque at 1 rad/s",
    )];
    const SHARE: f64 = 0.04;
    const EQUATION: &'static str =
        "the motor delivers e ω/(ω² + (.1 rad/s)²)^(1/6) more: e ω^(2/3) but for a smooth start";
    const REFERENCE: &'static str =
        "A. Palmgren, Ball and Roller Bearing Engineering, 1959 (recalled): M_0 ~ (ν n)^(2/3)";
    const TOUCHES: &'static [Touch] = &[Touch::Loads];

    fn loads<T: Real>(
        &self,
        e: &[T],
        _vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        mut loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        for (torque, w) in loads.wheel_torque.iter_mut().zip(motion.wheel_speed) {
            let slow = (w.squared() + 0.01).pow_pos(T::from(-1.0 / 6.0));
            *torque += e[0] * w * slow;
        }
        loads
    }
}
