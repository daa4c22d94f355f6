//! Ground that does not give way: friction that builds up with slip. What a soft-soil hypothesis must beat.
//!
//! # Equation
//! F = μ W sin(C atan(B s - E (B s - atan(B s)))),  D = F - f W,  T = R F, s the library slip. C = 1, E = 0 and a large B
//! is Coulomb's law.
//!
//! # Reference
//! H. B. Pacejka, *Tire and Vehicle Dynamics* (magic formula, recalled).

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Flags, WheelForces};
use crate::model::TerrainModel;
use crate::models::slots::checks::{self, Must, Values};
use crate::param::{Param, Scale};
use crate::real::{Real, Root};

/// A wheel on hard ground.
#[derive(Clone, Copy, Debug, Default)]
pub struct HardGround;

impl TerrainModel for HardGround {
    const NAME: &'static str = "hard-ground";
    const SUMMARY: &'static str =
        "ground that does not give way: the magic formula of friction against slip";
    const PARAMS: &'static [Param] = &[
        Param {
            name: "friction_coefficient",
            symbol: "μ",
            unit: "1",
            min: 0.0,
            max: 3.0,
            scale: Scale::Log,
            prior_sd: 0.3,
            doc: "largest longitudinal force over load",
        },
        Param {
            name: "stiffness_factor",
            symbol: "B",
            unit: "1",
            min: 0.1,
            max: 1e4,
            scale: Scale::Log,
            prior_sd: 0.5,
            doc: "B C μ is the slope at zero slip",
        },
        Param {
            name: "shape_factor",
            symbol: "C",
            unit: "1",
            min: 1.0,
            max: 2.0,
            scale: Scale::Log,
            prior_sd: 0.1,
            doc: "1 rises to the limit, above 1 peaks before it",
        },
        Param {
            name: "curvature_factor",
            symbol: "E",
            unit: "1",
            min: -10.0,
            max: 1.0,
            scale: Scale::Linear,
            prior_sd: 0.3,
            doc: "where the peak lies",
        },
        Param {
            name: "rolling_resistance",
            symbol: "f",
            unit: "1",
            min: 0.0,
            max: 1.0,
            scale: Scale::Log,
            prior_sd: 0.5,
            doc: "rolling resistance over load",
        },
    ];
    const EQUATION: &'static str = "\
F = μ W sin(C atan(B s - E (B s - atan(B s)))),  D = F - f W,  T = R F, s the library slip. C = 1, E = 0 and a large B
is Coulomb's law.";
    const RIVAL: bool = false;
    const REFERENCE: &'static str =
        "H. B. Pacejka, Tire and Vehicle Dynamics (magic formula, recalled)";
    const HOOKS: &'static [Hook] = &[Hook::Friction];

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
        let friction = values.get("friction_coefficient", Must::NotBeNegative)? * at.hooks.friction;
        let stiffness = values.get("stiffness_factor", Must::BePositive)?;
        let shape = values.get("shape_factor", Must::BePositive)?;
        let curvature = values.get("curvature_factor", Must::BeFinite)?;
        let rolling = values.get("rolling_resistance", Must::NotBeNegative)?;
        let y = stiffness * at.slip;
        let (sin, _) = (shape * (y - curvature * (y - y.atan())).atan()).sin_cos();
        let force = friction * at.normal_load * sin;
        let resistance = rolling * at.normal_load;
        let mut forces = WheelForces::from_thrust(force, T::zero(), force * at.radius);
        forces.drawbar_pull -= resistance;
        forces.parts.other -= resistance;
        forces.flags = Flags {
            braking: at.slip.primal().any_lt(T::Primal::zero()),
            ..Flags::default()
        };
        Ok(forces)
    }

    fn typical() -> Vec<Vec<f64>> {
        vec![
            vec![0.8, 8.0, 1.5, 0.3, 0.02],
            vec![0.6, 12.0, 1.3, 0.0, 0.01],
            vec![1.0, 20.0, 1.9, 0.97, 0.03],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ForceLaw;

    fn pull(p: &[f64], slip: f64) -> f64 {
        let f = HardGround
            .forces(p, &Contact::new(slip, 1000.0, 0.3, 0.2))
            .unwrap();
        assert!((f.resistive_torque - 0.3 * f.parts.thrust).abs() < 1e-9);
        f.drawbar_pull
    }

    /// Slope B C μ W at zero slip, peak μ W where the argument of the sine is π/2, odd about zero but for rolling.
    #[test]
    fn slope_peak_and_symmetry() {
        let p = [0.8, 10.0, 1.6, 0.0, 0.0];
        assert!((pull(&p, 1e-6) / 1e-6 - 10.0 * 1.6 * 800.0).abs() < 1e-3 * 12_800.0);
        // C atan(B s) = π/2
        let peak = (std::f64::consts::FRAC_PI_2 / 1.6).tan() / 10.0;
        assert!((pull(&p, peak) - 800.0).abs() < 1e-9);
        assert!(pull(&p, 1.0) < 700.0);
        assert!((pull(&p, 0.3) + pull(&p, -0.3)).abs() < 1e-9);
        let rolling = [0.8, 10.0, 1.6, 0.0, 0.03];
        assert!((pull(&p, 0.3) - pull(&rolling, 0.3) - 30.0).abs() < 1e-9);
    }

    /// sin(atan x) -> 1: Coulomb's law to μ W/(2 (B s)²).
    #[test]
    fn a_stiff_wheel_slides_by_coulomb() {
        let p = [0.7, 1e4, 1.0, 0.0, 0.0];
        for slip in [-1.0, -0.1, 0.1, 1.0_f64] {
            assert!((pull(&p, slip) - 700.0 * slip.signum()).abs() < 1e-3);
        }
    }
}
