//! The wheel radius is not the one in the file.
//!
//! # Equation
//! R -> R (1 + e), in the contact and in the slip
//!
//! # Reference
//! J. Borenstein, L. Feng, IEEE Trans. Robotics and Automation 12(6):869-880, 1996 (uncertain wheel diameters); chosen
//! prior.

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The wheel radius is not the one in the file.
#[derive(Clone, Copy, Debug, Default)]
pub struct WheelRadiusError;

impl Effect for WheelRadiusError {
    const NAME: &'static str = "wheel-radius-error";
    const SUMMARY: &'static str = "the wheel radius is not the one in the file";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [-0.5, 1.0],
        0.04,
        "relative error of the radius",
    )];
    const EQUATION: &'static str = "R -> R (1 + e), in the contact and in the slip";
    const REFERENCE: &'static str = "J. Borenstein, L. Feng, IEEE Trans. Robotics and Automation 12(6):869-880, 1996 (uncertain wheel diameters); chosen prior";
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "slip offset at low slip; torque over pull";
    const ISOLATED_BY: &'static str = "measure the loaded radius with a tape";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let factor = e[0] + 1.0;
        // Rim speed R ω over travel speed grows by the factor: driving 1 - s = v/(R ω), braking 1 + s = R ω/v.
        // Written as changes of s, so that e = 0 changes no bit.
        let driving = at.slip + (T::one() - at.slip) * e[0] / factor;
        let braking = at.slip + (at.slip + 1.0) * e[0];
        let from_driving =
            driving.select_lt(T::zero(), T::one() / (T::one() - driving) - 1.0, driving);
        let from_braking =
            T::zero().select_lt(braking, T::one() - T::one() / (braking + 1.0), braking);
        at.slip = at.slip.select_lt(T::zero(), from_braking, from_driving);
        at.radius *= factor;
    }
}
