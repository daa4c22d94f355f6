//! Another form of slip-sinkage: soil dug away under the wheel.

use crate::contact::Contact;
use crate::effect::{Effect, Scope, Touch};
use crate::effects::SlipSinkage;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::{Param, Scale};
use crate::real::Real;

/// A slipping wheel digs soil away and rests deeper: z + e s/(1 - s), and pushes a front of that depth.
///
/// # Equation
/// z -> z + z_j, z_j = e |s|/(1 - |s|) with |s| held at .9, D -> D - b k ((z + z_j)^(n+1) - z^(n+1))/(n+1)
///
/// # Reference
/// A. R. Reece, Proc. Inst. Mech. Eng. 180(2):45-66, 1965: slip sinkage of lugs h i/(1 - i); the resistance is
/// Bekker's, 1969.
#[derive(Clone, Copy, Debug, Default)]
pub struct Excavation;

impl Effect for Excavation {
    const NAME: &'static str = <SlipSinkage as Effect>::NAME;
    const FORM: &'static str = "excavation";
    const SUMMARY: &'static str = "a slipping wheel digs soil away and rests deeper: z + e s/(1 - s), and pushes a front of that depth";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "m",
        min: 0.0,
        max: 0.2,
        scale: Scale::Linear,
        prior_sd: 0.01,
        doc: "depth dug at half slip",
    }];
    const REFERENCE: &'static str = "A. R. Reece, Proc. Inst. Mech. Eng. 180(2):45-66, 1965: slip sinkage of lugs h i/(1 - i); the resistance is Bekker's, 1969";
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const SCOPE: Scope = <SlipSinkage as Effect>::SCOPE;
    const REGIME: &'static str = <SlipSinkage as Effect>::REGIME;
    const ISOLATED_BY: &'static str = <SlipSinkage as Effect>::ISOLATED_BY;

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        mut forces: WheelForces<T>,
    ) -> WheelForces<T> {
        let (Some(k), Some(n), Some(z)) = (soil.stiffness, soil.sinkage_exponent, forces.sinkage)
        else {
            return forces;
        };
        let s = at.slip.abs().min_of(T::from(0.9));
        let dug = e[0] * s / (T::one() - s);
        let power = n + 1.0;
        // What is not yet sunk at all still has a depth to take the power of.
        let before = z.max_of(T::from(1e-9));
        let work = (before + dug).pow_pos(power) - before.pow_pos(power);
        let force = at.width * k * work / power;
        forces.sinkage = Some(z + dug);
        forces.drawbar_pull -= force;
        forces.parts.other -= force;
        forces
    }
}
