//! Other forms of slip-sinkage: soil dug away under the wheel, sinkage that grows in proportion.

use crate::contact::Contact;
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::SlipSinkage;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
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
    form_of!(SlipSinkage);
    const FORM: &'static str = "excavation";
    const SUMMARY: &'static str = "a slipping wheel digs soil away and rests deeper: z + e s/(1 - s), and pushes a front of that depth";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "m",
        [0.0, 0.2],
        0.01,
        "depth dug at half slip",
    )];
    const SHARE: f64 = 0.039;
    const EQUATION: &'static str = "z -> z + z_j, z_j = e |s|/(1 - |s|) with |s| held at .9, D -> D - b k ((z + z_j)^(n+1) - z^(n+1))/(n+1)";
    const REFERENCE: &'static str = "A. R. Reece, Proc. Inst. Mech. Eng. 180(2):45-66, 1965: slip sinkage of lugs h i/(1 - i); the resistance is Bekker's, 1969";
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let s = at.slip.abs().min_of(T::from(0.9));
        let dug = e[0] * s / (T::one() - s);
        deeper(soil, at, forces, dug);
    }
}

/// A slipping wheel sinks in proportion to what it sinks at rest, and pushes a front of that depth.
///
/// # Equation
/// z -> z (1 + e (f - 1)), f = (1 + |s|)/(1 - |s|/2), D -> D - b k (z'^(n+1) - z^(n+1))/(n+1)
///
/// # Reference
/// f: M. Lyasko, J. Terramechanics 47(1):21-31, 2010 (recalled); e = 1 is his, the resistance is Bekker's, 1969.
#[derive(Clone, Copy, Debug, Default)]
pub struct Proportional;

impl Effect for Proportional {
    form_of!(SlipSinkage);
    const FORM: &'static str = "proportional";
    const SUMMARY: &'static str = "a slipping wheel sinks in proportion to what it sinks at rest, and pushes a front of that depth";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 5.0],
        0.5,
        "share of the growth (1 + s)/(1 - s/2)",
    )];
    const EQUATION: &'static str = "z -> z (1 + e (f - 1)), f = (1 + |s|)/(1 - |s|/2), D -> D - b k (z'^(n+1) - z^(n+1))/(n+1)";
    const REFERENCE: &'static str = "M. Lyasko, J. Terramechanics 47(1):21-31, 2010 (recalled): (1 + i)/(1 - .5 i); the resistance is Bekker's, 1969";
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let Some(z) = forces.sinkage else {
            return;
        };
        let s = at.slip.abs();
        // f - 1 = 1.5 s/(1 - s/2)
        let growth = s * 1.5 / (-s * 0.5 + 1.0);
        deeper(soil, at, forces, z * e[0] * growth);
    }
}

/// The wheel rests `dug` deeper and compacts a front of that depth; unchanged where k, n or z is unknown.
fn deeper<T: Real>(soil: &Soil<T>, at: &Contact<T>, forces: &mut WheelForces<T>, dug: T) {
    let (Some(k), Some(n), Some(z)) = (soil.stiffness, soil.sinkage_exponent, forces.sinkage)
    else {
        return;
    };
    let power = n + 1.0;
    // What is not yet sunk at all still has a depth to take the power of.
    let before = z.max_of(T::from(1e-9));
    let work = (before + dug).pow_pos(power) - before.pow_pos(power);
    let force = at.width * k * work / power;
    forces.sinkage = Some(z + dug);
    forces.drawbar_pull -= force;
    forces.parts.other -= force;
}
