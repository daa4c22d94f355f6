//! Other forms of grousers: shear on the sides of the block between the lugs, a lug that pushes soil.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::Grousers;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The block of soil between lugs shears at its sides too.
///
/// # Equation
/// c (1 + 2 h/b), tan φ (1 + .64 (h/b) acot(h/b)), h = e
///
/// # Reference
/// M. G. Bekker, Off-the-Road Locomotion, 1960, as in Wong, Theory of Ground Vehicles: thrust of grousers on a track; both factors also
/// in Z. Q. Li, L. K. Bingham, Terramechanics for LTV Modeling and Simulation, NASA white paper.
#[derive(Clone, Copy, Debug, Default)]
pub struct SideWalls;

impl Effect for SideWalls {
    form_of!(Grousers);
    const FORM: &'static str = "side-walls";
    const SUMMARY: &'static str = "the block of soil between lugs shears at its sides too";
    const PARAMS: &'static [Param] = &[Param::magnitude("m", [0.0, 0.2], 0.015, "lug height")];
    const SHARE: f64 = 0.059;
    const EQUATION: &'static str = "c (1 + 2 h/b), tan φ (1 + .64 (h/b) acot(h/b)), h = e";
    const REFERENCE: &'static str = "M. G. Bekker, Off-the-Road Locomotion, 1960, as in Wong, Theory of Ground Vehicles: thrust of grousers on a track";
    const NEEDS: &'static [Hook] = &[Hook::Cohesion, Hook::Friction];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let ratio = e[0] / at.width;
        let acot = -ratio.atan() + std::f64::consts::FRAC_PI_2;
        at.hooks.cohesion *= ratio * 2.0 + 1.0;
        at.hooks.friction *= ratio * acot * 0.64 + 1.0;
    }
}

/// The lug at the bottom pushes the soil behind it until that gives way.
///
/// # Equation
/// F = b (γ e²/2 N_p + p e N_p + 2 c e sqrt(N_p)) tanh(10 s), N_p = tan²(45° + φ/2), p = W/(b sqrt(2 R z + e²)),
/// γ = 15 kN/m³: D -> D + F, T -> T + F (R + e/2)
///
/// # Reference
/// Rankine's passive pressure of soil under a surcharge, as M. G. Bekker, 1969 (recalled); one lug at work, under the mean
/// pressure p of the contact, and the way it builds up with slip are chosen.
#[derive(Clone, Copy, Debug, Default)]
pub struct PassiveLug;

impl Effect for PassiveLug {
    form_of!(Grousers);
    const FORM: &'static str = "passive-lug";
    const SUMMARY: &'static str =
        "the lug at the bottom pushes the soil behind it until that gives way";
    const PARAMS: &'static [Param] = &[Param::magnitude("m", [0.0, 0.2], 0.01, "lug height")];
    const SHARE: f64 = 0.039;
    const EQUATION: &'static str = "F = b (γ e²/2 N_p + p e N_p + 2 c e sqrt(N_p)) tanh(10 s), N_p = tan²(45° + φ/2), p = W/(b sqrt(2 R z + e²)), γ = 15 kN/m³: D -> D + F, T -> T + F (R + e/2)";
    const REFERENCE: &'static str = "Rankine passive pressure on a lug, as M. G. Bekker, 1969 (recalled); one lug at work, its surcharge and its mobilisation with slip are chosen";
    const NEEDS_SOIL: &'static [&'static str] = &["cohesion", "friction_angle"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        /// γ \[N/m³\].
        const UNIT_WEIGHT: f64 = 15_000.0;
        let (Some(c), Some(phi), Some(z)) = (soil.cohesion, soil.friction_angle, forces.sinkage)
        else {
            return;
        };
        let height = e[0];
        let root = (phi * 0.5 + std::f64::consts::FRAC_PI_4).tan();
        // What is not yet sunk at all still has a length to divide by.
        let length = (at.radius * z.max_of(T::from(1e-9)) * 2.0 + height.squared()).sqrt();
        let surcharge = at.normal_load / (at.width * length);
        let push = root.squared() * (height * (0.5 * UNIT_WEIGHT) + surcharge) + c * root * 2.0;
        let force = at.width * height * push * (at.slip * 10.0).tanh();
        forces.drawbar_pull += force;
        forces.parts.lug_thrust += force;
        forces.resistive_torque += force * (at.radius + height * 0.5);
    }
}
