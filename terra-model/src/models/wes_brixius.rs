//! The mobility-number wheel: pull and torque of a tyre from the cone index alone.
//!
//! # Equation
//! Bn = (CI b d/W)(1 + 5 δ/h)/(1 + 3 b/d),  gross traction GT/W = .88 (1 - e^(-.1 Bn))(1 - e^(-7.5 s)) + .04,
//! motion resistance MR/W = 1/Bn + .04 + .5 s/sqrt(Bn),  D = GT - MR,  T = R GT. Driving only.
//!
//! # Units
//! CI \[Pa\], δ/h the deflection of the tyre over the height of its section \[1\]; d = 2R, b.
//!
//! # Reference
//! W. W. Brixius, "Traction prediction equations for bias ply tires", ASAE paper 87-1622, 1987; coefficients as in
//! ASAE D497 (recalled).

use crate::contact::Contact;
use crate::error::ModelError;
use crate::forces::WheelForces;
use crate::model::TerrainModel;
use crate::models::slots::checks::{self, Must, Values};
use crate::param::{Param, Scale};
use crate::real::{Real, Root};

/// The mobility-number wheel of Brixius.
#[derive(Clone, Copy, Debug, Default)]
pub struct WesBrixius;

impl TerrainModel for WesBrixius {
    const NAME: &'static str = "wes-brixius";
    const SUMMARY: &'static str = "pull and torque of a driven tyre from the cone index of the soil: a closed form of measurements";
    const PARAMS: &'static [Param] = &[
        Param {
            name: "cone_index",
            symbol: "CI",
            unit: "Pa",
            min: 1e3,
            max: 1e8,
            scale: Scale::Log,
            prior_sd: 0.5,
            doc: "mean resistance of the soil to a standard cone",
        },
        Param {
            name: "deflection_ratio",
            symbol: "δ/h",
            unit: "1",
            min: 0.0,
            max: 0.6,
            scale: Scale::Linear,
            prior_sd: 0.05,
            doc: "deflection of the tyre over the height of its section; 0 when rigid",
        },
    ];
    const EQUATION: &'static str = "\
Bn = (CI b d/W)(1 + 5 δ/h)/(1 + 3 b/d),  gross traction GT/W = .88 (1 - e^(-.1 Bn))(1 - e^(-7.5 s)) + .04,
motion resistance MR/W = 1/Bn + .04 + .5 s/sqrt(Bn),  D = GT - MR,  T = R GT. Driving only.";
    const RIVAL: bool = false;
    const REFERENCE: &'static str =
        "W. W. Brixius, ASAE paper 87-1622, 1987 (coefficients recalled)";

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        checks::contact(at)?;
        let values = Values {
            model: Self::NAME,
            params: Self::PARAMS,
            p,
        };
        let cone_index = values.get("cone_index", Must::BePositive)?;
        let deflection = values.get("deflection_ratio", Must::NotBeNegative)?;
        if at.slip.primal().any_lt(T::Primal::zero()) {
            return Err(ModelError::Contact {
                quantity: "slip",
                value: at.slip.primal().min_lane(),
                expected: "a driven wheel, slip in [0, 1]: the measurements hold no braking",
            });
        }
        let (load, diameter) = (at.normal_load, at.radius * 2.0);
        let mobility = cone_index * at.width * diameter / load * (deflection * 5.0 + 1.0)
            / (at.width / diameter * 3.0 + 1.0);
        let gross = (mobility * -0.1).exp_m1() * (at.slip * -7.5).exp_m1() * 0.88 + 0.04;
        let resistance = T::one() / mobility + 0.04 + at.slip * 0.5 / mobility.sqrt();
        Ok(WheelForces::from_thrust(
            gross * load,
            resistance * load,
            gross * load * at.radius,
        ))
    }

    fn typical() -> Vec<Vec<f64>> {
        vec![vec![3e5, 0.2], vec![7e5, 0.1], vec![1.5e6, 0.25]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ForceLaw;

    /// CI 700 kPa, b .4 m, d 1.5 m, W 14 kN, δ/h .2: Bn = 30 · 2/1.8 = 33.333; at slip .2:
    /// GT/W = .88 (1 - e^(-3.3333))(1 - e^(-1.5)) + .04 = .88 · .964326 · .776870 + .04 = .69926,
    /// MR/W = .03 + .04 + .1/5.7735 = .08732.
    #[test]
    fn a_tractor_tyre_by_hand() {
        let at = Contact::new(0.2, 14_000.0, 0.75, 0.4);
        let f = WesBrixius.forces(&[700e3, 0.2], &at).unwrap();
        assert!(
            (f.parts.thrust / 14_000.0 - 0.699_26).abs() < 1e-5,
            "{}",
            f.parts.thrust / 14_000.0
        );
        assert!((f.parts.compaction_resistance / 14_000.0 - 0.087_32).abs() < 1e-5);
        assert!((f.resistive_torque - 0.75 * f.parts.thrust).abs() < 1e-9);
    }

    /// At zero slip the pull is -W/Bn, whatever the .04; far up it is bounded by .88 W.
    #[test]
    fn limits_of_the_curves() {
        let at = |slip| Contact::new(slip, 5000.0, 0.75, 0.4);
        let f = WesBrixius.forces(&[300e3, 0.0], &at(0.0)).unwrap();
        let mobility = 300e3 * 0.4 * 1.5 / 5000.0 / (1.0 + 3.0 * 0.4 / 1.5);
        assert!((f.drawbar_pull + 5000.0 / mobility).abs() < 1e-9);
        let f = WesBrixius.forces(&[1e8, 0.0], &at(1.0)).unwrap();
        assert!((0.85..0.88).contains(&(f.drawbar_pull / 5000.0)));
        assert!(matches!(
            WesBrixius.forces(&[300e3, 0.0], &at(-0.1)),
            Err(ModelError::Contact {
                quantity: "slip",
                ..
            })
        ));
    }
}
