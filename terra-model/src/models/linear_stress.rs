//! Stresses that rise and fall linearly: the closed form for fast on-line use.
//!
//! # Equation
//! σ and τ are linear from θ1 (zero) to the apex θm = (c1 + c2 i) θ1 (σm, τm) and on to θ = 0 (σ = 0, τ0):
//! σm = k (R (cos θm - cos θ1))^n, τm = (c + σm tan φ) E(j(θm)), τ0 = c, and with
//! A = (cos θm - cos θ1)/(θ1-θm) - (1 - cos θm)/θm, B = (θ1 sin θm - θm sin θ1)/(θm (θ1-θm)), C = 1 - sin θm/θm:
//! W = R b (σm A + τm B + τ0 C),  D = R b (τm A - σm B + τ0 (1 - cos θm)/θm),  T = R² b (τm θ1 + τ0 θm)/2.
//! c1 = .5, c2 = 0 is the symmetric published form.
//!
//! # Reference
//! K. Iagnemma, S. Kang, H. Shibly, S. Dubowsky, "Online terrain parameter estimation for wheeled mobile robots with
//! application to planetary rovers", IEEE Trans. Robotics 20(5):921-927, 2004; H. Shibly, K. Iagnemma, S. Dubowsky,
//! J. Terramechanics 42(1):1-13, 2005.

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Flags, WheelForces};
use crate::model::{Soil, TerrainModel};
use crate::models::bekker::{self, Ground};
use crate::param::Param;
use crate::quadrature::{sinc, t_minus_sin};
use crate::real::{Real, Root};
use crate::root::{LINEAR_RISES_TO, TOLERANCE, balanced, rises_to};
use crate::stress::{StressField, StressPoint};

/// The linearised-stress wheel.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinearStress;

#[derive(Clone, Copy)]
struct Wheel<T> {
    ground: Ground<T>,
    radius: T,
    width: T,
}

/// Apex stresses and the integrals of the two linear branches, per R b.
struct Forces<T> {
    sigma: T,
    tau: T,
    load: T,
    thrust: T,
    compaction: T,
    shear: T,
}

/// 1 - cos t, without cancellation.
fn versine<T: Real>(t: T) -> T {
    let (s, _) = (t * 0.5).sin_cos();
    s.squared() * 2.0
}

impl<T: Real> Wheel<T> {
    fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            ground: self.ground.map(f),
            radius: f(self.radius),
            width: f(self.width),
        }
    }

    fn forces(&self, entry: T) -> Forces<T> {
        let g = &self.ground;
        let apex = g.apex_ratio * entry;
        let ahead = entry - apex;
        // cos θm - cos θ1 = 2 sin((θ1+θm)/2) sin((θ1-θm)/2)
        let drop = ((entry + apex) * 0.5) * sinc((entry + apex) * 0.5) * ahead * sinc(ahead * 0.5);
        let sigma = g.stiffness * (self.radius * drop).pow_pos(g.exponent);
        let j = self.radius
            * (g.slip * ahead + (T::one() - g.slip) * (t_minus_sin(entry) - t_minus_sin(apex)));
        let y = j.abs() / g.shear_modulus;
        let mobilised = -(-y).exp_m1();
        let e = j.select_lt(T::zero(), -mobilised, mobilised);
        let tau = (g.cohesion + sigma * g.tan_friction) * e;
        // A, B, C with the linear terms of the sines cancelled by hand.
        let rise = versine(apex) / apex;
        let a = drop / ahead - rise;
        let b = (apex * t_minus_sin(entry) - entry * t_minus_sin(apex)) / (apex * ahead);
        let c = t_minus_sin(apex) / apex;
        let tau0 = g.cohesion;
        Forces {
            sigma,
            tau,
            load: sigma * a + tau * b + tau0 * c,
            thrust: tau * a + tau0 * rise,
            compaction: sigma * b,
            shear: (tau * entry + tau0 * apex) * 0.5,
        }
    }

    fn load(&self, entry: T) -> T {
        self.forces(entry).load * self.radius * self.width
    }
}

impl LinearStress {
    fn wheel<T: Real>(p: &[T], at: &Contact<T>) -> Result<Wheel<T>, ModelError> {
        let ground = Ground::read(Self::NAME, p, at)?;
        Ok(Wheel {
            ground,
            radius: at.radius * at.hooks.contact_radius,
            width: at.width,
        })
    }

    fn entry<T: Real>(wheel: &Wheel<T>, at: &Contact<T>) -> Result<T, ModelError> {
        let primal = wheel.map(T::primal);
        let load = at.normal_load.primal();
        let guess = primal
            .ground
            .compaction_guess(load, primal.radius, primal.width);
        type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
        let tangent: Wheel<Tangent<T>> = primal.map(Tangent::<T>::from_primal);
        balanced(
            at.normal_load,
            guess,
            at.slip.primal(),
            rises_to(at.slip.primal(), LINEAR_RISES_TO),
            TOLERANCE,
            |angle| tangent.load(angle),
            |angle| wheel.load(angle),
        )
    }
}

impl TerrainModel for LinearStress {
    const NAME: &'static str = "linear-stress";
    const SUMMARY: &'static str =
        "rigid wheel whose stresses are linear between entry, apex and bottom: a closed form";
    const PARAMS: &'static [Param] = bekker::PARAMS;
    const EQUATION: &'static str = "\
σ and τ are linear from θ1 (zero) to the apex θm = (c1 + c2 i) θ1 (σm, τm) and on to θ = 0 (σ = 0, τ0):
σm = k (R (cos θm - cos θ1))^n, τm = (c + σm tan φ) E(j(θm)), τ0 = c, and with
A = (cos θm - cos θ1)/(θ1-θm) - (1 - cos θm)/θm, B = (θ1 sin θm - θm sin θ1)/(θm (θ1-θm)), C = 1 - sin θm/θm:
W = R b (σm A + τm B + τ0 C),  D = R b (τm A - σm B + τ0 (1 - cos θm)/θm),  T = R² b (τm θ1 + τ0 θm)/2.
c1 = .5, c2 = 0 is the symmetric published form.";
    const REFERENCE: &'static str = "K. Iagnemma et al., IEEE Trans. Robotics 20(5):921-927, 2004; H. Shibly et al., J. Terramechanics 42(1):1-13, 2005";
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
        let wheel = Self::wheel(p, at)?;
        let entry = Self::entry(&wheel, at)?;
        let f = wheel.forces(entry);
        let area = wheel.radius * wheel.width;
        let mut forces = WheelForces::from_thrust(
            f.thrust * area,
            f.compaction * area,
            f.shear * area * at.radius,
        );
        let sinkage = wheel.radius * versine(entry);
        forces.sinkage = Some(sinkage);
        forces.angles = Some(Angles {
            entry,
            exit: T::zero(),
            max_stress: wheel.ground.apex_ratio * entry,
        });
        forces.flags = Flags {
            braking: at.slip.primal().any_lt(T::Primal::zero()),
            apex_limited: wheel.ground.apex_limited,
            deep_sinkage: (at.radius * 0.5).primal().any_lt(sinkage.primal()),
        };
        Ok(forces)
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        bekker::soil(p, at)
    }

    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        let wheel = Self::wheel(p, at)?;
        let entry = Self::entry(&wheel, at)?;
        let f = wheel.forces(entry);
        let (apex, bottom) = (wheel.ground.apex_ratio * entry, wheel.ground.cohesion);
        let arm = at.radius;
        Ok(Some(StressField::new(0.0, apex, entry, move |angle| {
            let (normal_stress, shear_stress) = if angle >= apex {
                let share = (entry - angle) / (entry - apex);
                (f.sigma * share, f.tau * share)
            } else {
                let share = angle / apex;
                (f.sigma * share, bottom + (f.tau - bottom) * share)
            };
            StressPoint {
                angle,
                normal_stress,
                shear_stress,
                shear_arm: arm,
            }
        })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue;

    /// The wheel that comes out carries the load that went in, on every soil of the catalogue.
    #[test]
    fn the_load_is_balanced() {
        let mut compared = 0;
        for soil in catalogue::terrains() {
            let Ok(p) = soil.parameters(&LinearStress) else {
                continue;
            };
            for slip in [-1.0, -0.3, 0.0, 0.05, 0.6, 1.0] {
                for load in [40.0, 245.25, 2452.5] {
                    let at = Contact::new(slip, load, 0.254, 0.15);
                    let wheel = LinearStress::wheel(&p, &at).unwrap();
                    let Ok(entry) = LinearStress::entry(&wheel, &at) else {
                        continue;
                    };
                    let carried = wheel.load(entry);
                    assert!(
                        (carried / load - 1.0).abs() < 1e-10,
                        "{} {carried} {load}",
                        soil.id
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared > 400, "{compared}");
    }
}
