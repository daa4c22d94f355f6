//! Other forms of bulldozing: bearing-capacity factors, a pile that rubs on the rim.

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::Bulldozing;
use crate::effects::bulldozing::push_per_width;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Soil is pushed aside ahead of the wheel as under a footing: resistance by bearing-capacity factors.
///
/// # Equation
/// D - e b (.67 c z K_c + .5 γ z² K_γ), K_c = (N_c - tan φ) cos² φ, K_γ = (2 N_γ/tan φ + 1) cos² φ, N_q = e^((3π/2 -
/// φ) tan φ)/(2 cos²(45° + φ/2)), N_c = (N_q - 1)/tan φ, N_γ = 2 (N_q + 1) tan φ/(1 + .4 sin 4φ), γ = 15 kN/m³
///
/// # Reference
/// M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969, with Terzaghi's factors as in Wong, Theory of Ground
/// Vehicles (recalled).
#[derive(Clone, Copy, Debug, Default)]
pub struct BearingCapacity;

impl Effect for BearingCapacity {
    form_of!(Bulldozing);
    const FORM: &'static str = "bearing-capacity";
    const SUMMARY: &'static str = "soil is pushed aside ahead of the wheel as under a footing: resistance by bearing-capacity factors";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 20.0],
        0.5,
        "share of the bearing resistance ahead",
    )];
    const EQUATION: &'static str = "D - e b (.67 c z K_c + .5 γ z² K_γ), K_c = (N_c - tan φ) cos² φ, K_γ = (2 N_γ/tan φ + 1) cos² φ, N_q = e^((3π/2 - φ) tan φ)/(2 cos²(45° + φ/2)), N_c = (N_q - 1)/tan φ, N_γ = 2 (N_q + 1) tan φ/(1 + .4 sin 4φ), γ = 15 kN/m³";
    const REFERENCE: &'static str = "M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969, with Terzaghi's factors as in Wong, Theory of Ground Vehicles (recalled)";
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
        let (Some(c), Some(phi), Some(z)) = (soil.cohesion, soil.friction_angle, forces.sinkage)
        else {
            return;
        };
        // γ \[N/m³\]; tan φ of clay without friction stands in a denominator.
        const UNIT_WEIGHT: f64 = 15_000.0;
        let phi = phi.max_of(T::from(1e-3));
        let (tan, (_, cos)) = (phi.tan(), phi.sin_cos());
        let (_, wedge) = (phi * 0.5 + std::f64::consts::FRAC_PI_4).sin_cos();
        let turn = (-phi + 1.5 * std::f64::consts::PI) * tan;
        let n_q = turn.exp() / (wedge.squared() * 2.0);
        let n_c = (n_q - 1.0) / tan;
        let (four, _) = (phi * 4.0).sin_cos();
        let n_weight = (n_q + 1.0) * tan * 2.0 / (four * 0.4 + 1.0);
        let k_c = (n_c - tan) * cos.squared();
        let k_weight = (n_weight * 2.0 / tan + 1.0) * cos.squared();
        let push = c * z * k_c * 0.67 + z.squared() * k_weight * (0.5 * UNIT_WEIGHT);
        let force = at.width * push * e[0];
        forces.drawbar_pull -= force;
        forces.parts.bulldozing_resistance += force;
    }
}

/// The pile ahead rubs on the rim as well as pushes it.
///
/// # Equation
/// D - e Fb, T + e Fb R tan φ tanh(10 s), Fb = b (γ z² N_p/2 + 2 c z sqrt(N_p))
///
/// # Reference
/// Coulomb friction of a passive wedge on the rim; chosen form.
#[derive(Clone, Copy, Debug, Default)]
pub struct RubbingPile;

impl Effect for RubbingPile {
    form_of!(Bulldozing);
    const FORM: &'static str = "rubbing-pile";
    const SUMMARY: &'static str = "the pile ahead rubs on the rim as well as pushes it";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 20.0],
        1.0,
        "share of the passive earth pressure that resists",
    )];
    const EQUATION: &'static str =
        "D - e Fb, T + e Fb R tan φ tanh(10 s), Fb = b (γ z² N_p/2 + 2 c z sqrt(N_p))";
    const REFERENCE: &'static str = "Coulomb friction of a passive wedge on the rim; chosen form";
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
        let (Some(push), Some(phi)) = (push_per_width(soil, forces), soil.friction_angle) else {
            return;
        };
        let force = at.width * push * e[0];
        forces.drawbar_pull -= force;
        forces.parts.bulldozing_resistance += force;
        forces.resistive_torque += force * at.radius * phi.tan() * (at.slip * 10.0).tanh();
    }
}
