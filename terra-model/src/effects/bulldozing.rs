//! The wheel pushes soil ahead of it.
//!
//! # Equation
//! D -> D - e Fb, Fb = b (γ z² Np/2 + 2 c z sqrt(Np)), Np = tan²(45° + φ/2), γ = 15 kN/m³
//!
//! # Reference
//! M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969; passive earth pressure (Rankine).

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Touch};
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The wheel pushes soil ahead of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bulldozing;

impl Effect for Bulldozing {
    const NAME: &'static str = "bulldozing";
    const SUMMARY: &'static str = "the wheel pushes soil ahead of it";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 20.0],
        1.0,
        "share of the passive earth pressure of the sinkage depth",
    )];
    const EQUATION: &'static str =
        "D -> D - e Fb, Fb = b (γ z² Np/2 + 2 c z sqrt(Np)), Np = tan²(45° + φ/2), γ = 15 kN/m³";
    const REFERENCE: &'static str = "M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969; passive earth pressure (Rankine)";
    const NEEDS_SOIL: &'static [&'static str] = &["cohesion", "friction_angle"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "pull only, torque is blind; deep sinkage, heavy loads";
    const ISOLATED_BY: &'static str = "load cell on the drawbar beside the torque";

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        // `NEEDS_SOIL` keeps models without c and φ away; a model without sinkage pushes nothing.
        let Some(push) = push_per_width(soil, forces) else {
            return;
        };
        let force = at.width * push * e[0];
        forces.drawbar_pull -= force;
        forces.parts.bulldozing_resistance += force;
    }
}

/// Fb/b, the passive earth pressure on a plate as deep as the wheel sinks \[N/m\]; none where c, φ or z is unknown.
pub(super) fn push_per_width<T: Real>(soil: &Soil<T>, forces: &WheelForces<T>) -> Option<T> {
    /// γ \[N/m³\].
    const UNIT_WEIGHT: f64 = 15_000.0;
    let (c, phi, z) = (soil.cohesion?, soil.friction_angle?, forces.sinkage?);
    let passive = (phi * 0.5 + std::f64::consts::FRAC_PI_4).tan();
    Some(z * (passive.squared() * z * (0.5 * UNIT_WEIGHT) + c * passive * 2.0))
}
