//! Other forms of lateral bulldozing: a destructive surface on the flank that meets the soil, earth pressure as it is swept.

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::LateralBulldozing;
use crate::effects::bulldozing::push_per_width;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The flank below the surface cuts soil along a plane that rises from its foot, as long as the wheel is sunk.
///
/// # Equation
/// side force against the sideways motion of e ∫ R_b dx tanh(10 tan β) over the sunken segment, length 2 sqrt(2 R z),
/// with the mean depth 2 z/3 and mean square depth 8 z²/15 of a parabola: R_b = D1 (c h + D2 γ h²/2), D1 = cot X +
/// tan(X + φ), D2 = cot X + cot² X tan φ, X = 45° - φ/2, γ = 15 kN/m³
///
/// # Reference
/// E. Hegedus, ATAC RR-14, 1960, as G. Ishigami et al., J. Field Robotics 24(3), 2007; D1, D2 and R_b as an open code after
/// that paper has them. A quotient cot² X/cot φ is cot² X tan φ, which clay without friction has too.
#[derive(Clone, Copy, Debug, Default)]
pub struct CuttingFlank;

impl Effect for CuttingFlank {
    form_of!(LateralBulldozing);
    const FORM: &'static str = "cutting-flank";
    const SUMMARY: &'static str =
        "the flank below the surface cuts soil along a plane that rises from its foot";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 20.0],
        1.0,
        "share of the bulldozing resistance of the flank",
    )];
    const EQUATION: &'static str = "side force against the sideways motion of e ∫ R_b dx tanh(10 tan β) over the sunken segment, length 2 sqrt(2 R z), with the mean depth 2 z/3 and mean square depth 8 z²/15 of a parabola: R_b = D1 (c h + D2 γ h²/2), D1 = cot X + tan(X + φ), D2 = cot X + cot² X tan φ, X = 45° - φ/2, γ = 15 kN/m³";
    const REFERENCE: &'static str = "E. Hegedus, ATAC RR-14, 1960, as G. Ishigami et al., J. Field Robotics 24(3), 2007 (as an open code after that paper has it)";
    const NEEDS_SOIL: &'static [&'static str] = &["cohesion", "friction_angle"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const READS: &'static [Circumstance] = &[Circumstance::SlipAngle];

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
        /// γ \[N/m³\].
        const UNIT_WEIGHT: f64 = 15_000.0;
        let x = -phi * 0.5 + std::f64::consts::FRAC_PI_4;
        let cot = T::one() / x.tan();
        let first = cot + (x + phi).tan();
        let second = cot + cot.squared() * phi.tan();
        let chord = (at.radius * z.max_of(T::from(1e-12)) * 2.0).sqrt() * 2.0;
        let mean = c * z * (2.0 / 3.0) + second * z.squared() * (0.5 * UNIT_WEIGHT * 8.0 / 15.0);
        let share = (at.slip_angle.tan() * 10.0).tanh();
        forces.lateral_force -= e[0] * chord * first * mean * share;
    }
}

/// Earth pressure on the flank grows with what it sweeps.
///
/// # Equation
/// side force against the sideways motion of .12 e L (Fb/b) sin β, Fb/b as the default form
///
/// # Reference
/// Passive earth pressure (Rankine) as the default form; K. Yoshida, G. Ishigami, IROS 2004, for sin β (recalled).
#[derive(Clone, Copy, Debug, Default)]
pub struct SweptPressure;

impl Effect for SweptPressure {
    form_of!(LateralBulldozing);
    const FORM: &'static str = "swept-pressure";
    const SUMMARY: &'static str = "earth pressure on the flank grows with what it sweeps";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 100.0],
        4.0,
        "share of the passive earth pressure on .12 wheelbases of a flank that moves straight sideways",
    )];
    const EQUATION: &'static str =
        "side force against the sideways motion of .12 e L (Fb/b) sin β, Fb/b as the default form";
    const REFERENCE: &'static str =
        "Rankine passive pressure; K. Yoshida, G. Ishigami, IROS 2004, for sin β (recalled)";
    const NEEDS_SOIL: &'static [&'static str] = &["cohesion", "friction_angle"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const READS: &'static [Circumstance] = &[Circumstance::SlipAngle];

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        if let Some(push) = push_per_width(soil, forces) {
            let tan = at.slip_angle.tan();
            // sin β
            let share = tan / (tan.squared() + 1.0).sqrt();
            forces.lateral_force -= e[0] * 0.12 * at.wheelbase * push * share;
        }
    }
}
