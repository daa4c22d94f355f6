//! Other forms of rate-stiffening: by the speed of the rim, by the strength in shear.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::RateStiffening;
use crate::model::Soil;
use crate::param::{EITHER_SIGN, Param};
use crate::real::Real;

/// Soil resists faster penetration more, and it is the rim that penetrates.
///
/// # Equation
/// k (max(|R ω|, |v|)/1 m/s)^e, at least .05 m/s
///
/// # Reference
/// W. Grahn, J. Terramechanics 28(4), 1991: p = k z^n (dz/dt)^m; the rim sinks with R ω sin θ.
#[derive(Clone, Copy, Debug, Default)]
pub struct RimSpeed;

impl Effect for RimSpeed {
    form_of!(RateStiffening);
    const FORM: &'static str = "rim-speed";
    const SUMMARY: &'static str =
        "soil resists faster penetration more, and it is the rim that penetrates";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.35,
        "exponent of speed",
    )];
    const EQUATION: &'static str = "k (max(|R ω|, |v|)/1 m/s)^e, at least .05 m/s";
    const REFERENCE: &'static str = "W. Grahn, J. Terramechanics 28(4), 1991: p = k z^n (dz/dt)^m; the rim sinks with R ω sin θ";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Speed]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let rim = (at.wheel_speed * at.radius).abs();
        let speed = rim.max_of(at.speed.abs()).max_of(T::from(0.05));
        at.hooks.stiffness *= speed.pow_pos(e[0]);
    }
}

/// Soil is stronger when it is sheared faster.
///
/// # Equation
/// c and tan φ times ((v_s + .05 m/s)/(1 m/s))^e, v_s = |R ω - v|
///
/// # Reference
/// power law of shear strength on rate (clays: a few percent a decade), as R. N. Yong, E. A. Fattah, N. Skiadas,
/// Vehicle Traction Mechanics, 1984 (recalled).
#[derive(Clone, Copy, Debug, Default)]
pub struct ShearRate;

impl Effect for ShearRate {
    form_of!(RateStiffening);
    const FORM: &'static str = "shear-rate";
    const SUMMARY: &'static str = "soil is stronger when it is sheared faster";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        EITHER_SIGN,
        0.15,
        "exponent of the sliding speed",
    )];
    const EQUATION: &'static str = "c and tan φ times ((v_s + .05 m/s)/(1 m/s))^e, v_s = |R ω - v|";
    const REFERENCE: &'static str = "power law of shear strength on rate (clays: a few percent a decade), as R. N. Yong, E. A. Fattah, N. Skiadas, Vehicle Traction Mechanics, 1984 (recalled)";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[Circumstance::Speed]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let slide = (at.wheel_speed * at.radius - at.speed).abs();
        let factor = (slide + 0.05).pow_pos(e[0]);
        at.hooks.cohesion *= factor;
        at.hooks.friction *= factor;
    }
}
