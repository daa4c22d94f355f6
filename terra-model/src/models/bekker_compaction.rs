//! Bekker's wheel: sinkage and compaction resistance of a smooth cylinder, thrust of a track of the same contact.
//!
//! # Equation
//! z = \[3 W/(b (3 - n) k sqrt(2R))\]^(2/(2n + 1)),  Rc = b k z^(n + 1)/(n + 1),  l = sqrt(z (2R - z)),
//! H = (b l c + W tan φ) M(i l/K),  M(y) = 1 - (1 - e^(-y))/y,  odd in y for braking,
//! D = H - Rc,  T = R H.
//!
//! For n < 1.3 and wheels above half a metre; the sinkage does not depend on slip.
//!
//! # Reference
//! M. G. Bekker, *Introduction to Terrain-Vehicle Systems* (1969), as in J. Y. Wong, *Theory of Ground Vehicles*
//! (thrust recalled); z and Rc as in Z. Q. Li, L. K. Bingham, *Terramechanics for LTV Modeling and Simulation*, NASA white
//! paper, after an open code of it.

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Flags, WheelForces};
use crate::model::{Soil, TerrainModel};
use crate::models::bekker;
use crate::models::slots::checks::{self, Must, Values, quantity};
use crate::param::Param;
use crate::real::{Real, Root};

/// Bekker's wheel of compaction resistance and track thrust.
#[derive(Clone, Copy, Debug, Default)]
pub struct BekkerCompaction;

/// The binomial of the derivation, 3 - n in place of a series, is poor beyond this exponent.
const LARGEST_EXPONENT: f64 = 1.3;

/// 1 - (1 - e^(-y))/y for y >= 0.
fn mean_mobilised<T: Real>(y: T) -> T {
    const SMALL: f64 = 1e-2;
    let safe = y.max_of(T::from(SMALL));
    let exact = T::one() + (-safe).exp_m1() / safe;
    let series =
        y * (T::from(0.5) - y * (T::from(1.0 / 6.0) - y * (T::from(1.0 / 24.0) - y / 120.0)));
    y.select_lt(T::from(SMALL), series, exact)
}

impl TerrainModel for BekkerCompaction {
    const NAME: &'static str = "bekker-compaction";
    const SUMMARY: &'static str = "smooth wheel that compacts Bekker soil, with the thrust of a track of the same contact: a closed form";
    const PARAMS: &'static [Param] = &[
        bekker::PARAMS[0],
        bekker::PARAMS[1],
        bekker::PARAMS[2],
        bekker::PARAMS[3],
        bekker::PARAMS[4],
        bekker::PARAMS[5],
    ];
    const EQUATION: &'static str = "\
z = [3 W/(b (3 - n) k sqrt(2R))]^(2/(2n + 1)),  Rc = b k z^(n + 1)/(n + 1),  l = sqrt(z (2R - z)),
H = (b l c + W tan φ) M(i l/K),  M(y) = 1 - (1 - e^(-y))/y,  odd in y for braking,
D = H - Rc,  T = R H.

For n < 1.3 and wheels above half a metre; the sinkage does not depend on slip.";
    const REFERENCE: &'static str = "M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969; z and Rc as in Z. Q. Li, L. K. Bingham, NASA white paper (thrust recalled)";
    const HOOKS: &'static [Hook] = &[
        Hook::Stiffness,
        Hook::Cohesion,
        Hook::Friction,
        Hook::ShearModulus,
        Hook::SinkageExponent,
        Hook::ContactRadius,
    ];

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
        let get = |name, must| values.get(name, must);
        let hooks = &at.hooks;
        let k = (get("k_c", Must::BeFinite)? / at.width + get("k_phi", Must::BeFinite)?)
            * hooks.stiffness;
        let k = quantity(Self::NAME, "k_c/b + k_phi", k, Must::BePositive)?;
        let n = get("sinkage_exponent", Must::BeFinite)? + hooks.sinkage_exponent;
        let n = quantity(Self::NAME, "sinkage_exponent", n, Must::BePositive)?;
        if n.primal().max_lane() >= LARGEST_EXPONENT {
            return Err(ModelError::Parameter {
                model: Self::NAME,
                parameter: "sinkage_exponent",
                value: n.primal().max_lane(),
                expected: "a value below 1.3",
            });
        }
        let cohesion = get("cohesion", Must::NotBeNegative)? * hooks.cohesion;
        let tan = get("friction_angle", Must::BeAcute)?.tan() * hooks.friction;
        let shear = get("shear_modulus", Must::BePositive)? * hooks.shear_modulus;

        let (radius, width, load) = (at.radius * hooks.contact_radius, at.width, at.normal_load);
        let per_load = width * k * (radius * 2.0).sqrt() * (T::from(3.0) - n) / 3.0;
        let z = (load / per_load).pow_pos(T::one() / (n + 0.5));
        if radius.primal().any_lt(z.primal()) {
            let most = per_load * radius.pow_pos(n + 0.5);
            return Err(ModelError::NoEquilibrium {
                load: load.primal().max_lane(),
                max_load: most.primal().min_lane(),
            });
        }
        let resistance = width * k * z.pow_pos(n + 1.0) / (n + 1.0);
        let length = (z * (radius * 2.0 - z)).sqrt();
        let y = checks::kinematic(at.slip) * length / shear;
        let mean = mean_mobilised(y.abs());
        let mobilised = y.select_lt(T::zero(), -mean, mean);
        let thrust = (width * length * cohesion + load * tan) * mobilised;
        let mut forces = WheelForces::from_thrust(thrust, resistance, thrust * at.radius);
        forces.sinkage = Some(z);
        forces.angles = Some(Angles {
            entry: (z / (radius * 2.0 - z)).sqrt().atan() * 2.0,
            exit: T::zero(),
            max_stress: T::zero(),
        });
        forces.flags = Flags {
            braking: at.slip.primal().any_lt(T::Primal::zero()),
            apex_limited: false,
            deep_sinkage: (at.radius * 0.5).primal().any_lt(z.primal()),
        };
        Ok(forces)
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        bekker::soil(p, at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ForceLaw, Registry};

    fn at(slip: f64, load: f64) -> Contact<f64> {
        Contact::new(slip, load, 0.3, 0.2)
    }

    /// k = 1 MN/m³, n = 1, 1 kN on a wheel of .6 m by .2 m: z^1.5 = 3000/(.2 · 2 · 1e6 · sqrt(.6)) = 9.68246e-3,
    /// z = 45.43 mm, Rc = .2 · 1e6 · z²/2 = 206.4 N.
    #[test]
    fn sinkage_and_resistance_by_hand() {
        let p = [0.0, 1e6, 1.0, 0.0, 0.0, 0.02];
        let f = BekkerCompaction.forces(&p, &at(0.3, 1000.0)).unwrap();
        assert!(
            (f.sinkage.unwrap() - 0.045_428).abs() < 1e-6,
            "{:?}",
            f.sinkage
        );
        assert!((f.parts.compaction_resistance - 206.37).abs() < 0.02);
        assert_eq!((f.parts.thrust, f.resistive_torque), (0.0, 0.0));
    }

    /// The load formula is the column integral for shallow sinkage with ∫ (1 - x²)^n dx over [0, 1] cut after two terms,
    /// 1 - n/3.
    #[test]
    fn sinkage_is_that_of_columns_but_for_the_binomial() {
        let columns = Registry::builtin().law("scm-column").unwrap();
        for n in [0.5, 0.8, 1.0, 1.2_f64] {
            let p = [0.0, 2e6, n, 1000.0, 0.5, 0.02];
            let (f, g) = (
                BekkerCompaction.forces(&p, &at(0.2, 6.0)).unwrap(),
                columns.forces(&p, &at(0.2, 6.0)).unwrap(),
            );
            let steps = 20_000;
            let whole: f64 = (0..steps)
                .map(|q| (f64::from(q) + 0.5) / f64::from(steps))
                .map(|x| (1.0 - x * x).powf(n) / f64::from(steps))
                .sum();
            let expected = (whole / (1.0 - n / 3.0)).powf(1.0 / (n + 0.5));
            let ratio = f.sinkage.unwrap() / g.sinkage.unwrap();
            assert!(
                (ratio / expected - 1.0).abs() < 0.01,
                "{n}: {ratio} {expected}"
            );
        }
    }

    /// H = ∫ b (c + p tan φ)(1 - e^(-i x/K)) dx with the mean pressure, by Simpson's rule.
    #[test]
    fn thrust_is_the_integral_along_the_contact() {
        let p = [0.0, 1e6, 0.9, 3000.0, 0.5, 0.02];
        for slip in [1e-3, 0.05, 0.4, 1.0] {
            let f = BekkerCompaction.forces(&p, &at(slip, 800.0)).unwrap();
            let z = f.sinkage.unwrap();
            let length = (z * (0.6 - z)).sqrt();
            let strength = 0.2 * 3000.0 + 800.0 / length * 0.5_f64.tan();
            let n = 400;
            let sum: f64 = (0..=n)
                .map(|q| {
                    let weight = if q == 0 || q == n {
                        1.0
                    } else if q % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    };
                    let x = length * f64::from(q) / f64::from(n);
                    weight * strength * (1.0 - (-slip * x / 0.02).exp())
                })
                .sum();
            let thrust = sum * length / f64::from(n) / 3.0;
            assert!((f.parts.thrust / thrust - 1.0).abs() < 1e-7, "{slip}");
        }
    }

    #[test]
    fn snow_is_outside_its_range() {
        let p = [4370.0, 196_720.0, 1.6, 1030.0, 0.34, 0.05];
        assert!(matches!(
            BekkerCompaction.forces(&p, &at(0.2, 100.0)),
            Err(ModelError::Parameter {
                parameter: "sinkage_exponent",
                ..
            })
        ));
    }
}
