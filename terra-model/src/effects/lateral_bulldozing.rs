//! A wheel dragged sideways pushes soil with its flank.
//!
//! # Equation
//! side force against the sideways motion of .12 e L (Fb/b) min(1, tan |β| / .1),
//! Fb/b = γ z² Np/2 + 2 c z sqrt(Np), Np = tan²(45° + φ/2), γ = 15 kN/m³
//!
//! # Reference
//! Passive earth pressure (Rankine) on the flank, as G. Ishigami et al., J. Field Robotics 24(3), 2007; chosen form and
//! prior.

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Scope, Touch};
use crate::effects::bulldozing::push_per_width;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// A wheel dragged sideways pushes soil with its flank.
#[derive(Clone, Copy, Debug, Default)]
pub struct LateralBulldozing;

impl Effect for LateralBulldozing {
    const NAME: &'static str = "lateral-bulldozing";
    const SUMMARY: &'static str = "a wheel dragged sideways pushes soil with its flank";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 20.0],
        1.5,
        "share of the passive earth pressure on .12 wheelbases of flank",
    )];
    const EQUATION: &'static str = "side force against the sideways motion of .12 e L (Fb/b) min(1, tan |β| / .1), Fb/b = γ z² Np/2 + 2 c z sqrt(Np), Np = tan²(45° + φ/2), γ = 15 kN/m³";
    const REFERENCE: &'static str = "Rankine passive pressure; G. Ishigami et al., J. Field Robotics 24(3), 2007; chosen form and prior";
    const NEEDS_SOIL: &'static [&'static str] = &["cohesion", "friction_angle"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const READS: &'static [Circumstance] = &[Circumstance::SlipAngle];
    const SCOPE: Scope = Scope::Drive;
    const REGIME: &'static str = "a moment against the turn, most in deep ruts";
    const ISOLATED_BY: &'static str = "turn in place on soft ground and on firm ground";

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
        let tan = at.slip_angle.tan() * 10.0;
        let share = tan.min_of(T::one()).max_of(-T::one());
        forces.lateral_force -= e[0] * 0.12 * at.wheelbase * push * share;
    }
}
