//! Granular resistive force theory: every piece of a rim feels dry sand as a small plate of its tilt and direction would.
//!
//! # Equation
//! A piece at the angle θ of the rim, z deep, has the tilt β = θ and moves in the direction γ below the horizontal, with
//! cos γ = (1 - i - cos θ)/N and sin γ = sin θ/N. It is pushed back by ζ z α_x dA and up by ζ z α_z dA:
//! α_z = A00 + A10 cos 2β + B11 sin(2β + γ) + B01 sin γ + B-11 sin(-2β + γ),
//! α_x = C11 cos(2β + γ) + C01 cos γ + C-11 cos(-2β + γ) + D10 sin 2β. Only pieces that move into the sand feel it, which
//! on a rolling wheel is its front, 0 <= θ <= θ1:
//! W = b R ζ ∫ z α_z dθ,  D = -b R ζ ∫ z α_x dθ,  T = b R² ζ ∫ z (α_z sin θ - α_x cos θ) dθ,  z = R (cos θ - cos θ1).
//!
//! # Units
//! ζ \[N/m³\] is the stress per depth on a level plate pushed straight down: the coefficients are those of the generic
//! medium, for which α_z(0, π/2) = 1.
//!
//! # Reference
//! C. Li, T. Zhang, D. I. Goldman, "A terradynamics of legged locomotion on granular media", Science 339:1408-1412, 2013,
//! supplement (generic coefficients; also in the open codes of Treers et al. 2021 and Agarwal et al. 2019). Slow motion in dry
//! grains; a wheel's own wake and the sand it carries along are left out.

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Flags, WheelForces};
use crate::model::TerrainModel;
use crate::models::slots::checks::{self, Must, Values};
use crate::param::{Param, Scale};
use crate::quadrature::rule;
use crate::real::{Real, Root};
use crate::root::{TOLERANCE, balanced};
use crate::stress::{StressField, StressPoint};

/// A wheel in dry grains.
#[derive(Clone, Copy, Debug, Default)]
pub struct GranularRft;

/// A00, A10, B11, B01, B-11 of α_z.
const UP: [f64; 5] = [0.206, 0.169, 0.212, 0.358, 0.055];
/// C11, C01, C-11, D10 of α_x.
const BACK: [f64; 4] = [-0.124, 0.253, 0.007, 0.088];
/// Nodes a piece.
const NODES: usize = 16;
/// Share of the entry angle below which the turn of the direction at the bottom is not resolved.
const SHARPEST: f64 = 1e-4;
/// Most that ln(θ/a + ...) changes over one piece.
const PER_PIECE: f64 = 2.0;

#[derive(Clone, Copy)]
struct Wheel<T> {
    /// ζ.
    stiffness: T,
    /// Travel and rim speed, the larger of them 1.
    travel: T,
    rim: T,
    radius: T,
    torque_arm: T,
    width: T,
}

struct Sums<T> {
    load: T,
    pull: T,
    torque: T,
}

impl<T: Real> Wheel<T> {
    fn read(p: &[T], at: &Contact<T>) -> Result<Self, ModelError> {
        checks::contact(at)?;
        let values = Values {
            model: GranularRft::NAME,
            params: GranularRft::PARAMS,
            p,
        };
        let (zero, one) = (T::zero(), T::one());
        Ok(Wheel {
            stiffness: values.get("intrusion_stiffness", Must::BePositive)? * at.hooks.stiffness,
            travel: at.slip.select_lt(zero, one, one - at.slip),
            rim: at.slip.select_lt(zero, one + at.slip, one),
            radius: at.radius * at.hooks.contact_radius,
            torque_arm: at.radius,
            width: at.width,
        })
    }

    fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            stiffness: f(self.stiffness),
            travel: f(self.travel),
            rim: f(self.rim),
            radius: f(self.radius),
            torque_arm: f(self.torque_arm),
            width: f(self.width),
        }
    }

    /// Stress back and up at an angle.
    fn stresses(&self, entry: T, angle: T) -> (T, T) {
        let (sin, cos) = angle.sin_cos();
        let (half, _) = (angle * 0.5).sin_cos();
        let off = self.travel - self.rim;
        let along = off + self.rim * half.squared() * 2.0;
        let down = self.rim * sin;
        let speed = (off.squared() + self.travel * self.rim * half.squared() * 4.0).sqrt();
        let (cos_dir, sin_dir) = (along / speed, down / speed);
        // sin 2β and cos 2β, β = θ.
        let (s2, c2) = (sin * cos * 2.0, cos.squared() - sin.squared());
        let [a00, a10, b11, b01, b_11] = UP;
        let [c11, c01, c_11, d10] = BACK;
        let up = c2 * a10
            + a00
            + (s2 * cos_dir + c2 * sin_dir) * b11
            + sin_dir * b01
            + (c2 * sin_dir - s2 * cos_dir) * b_11;
        let back = (c2 * cos_dir - s2 * sin_dir) * c11
            + cos_dir * c01
            + (c2 * cos_dir + s2 * sin_dir) * c_11
            + s2 * d10;
        // cos θ - cos θ1 = 2 sin((θ1 + θ)/2) sin((θ1 - θ)/2)
        let (sum, _) = ((entry + angle) * 0.5).sin_cos();
        let (difference, _) = ((entry - angle) * 0.5).sin_cos();
        let stress = self.stiffness * self.radius * sum * difference * 2.0;
        (stress * back, stress * up)
    }

    /// θ = a sinh t clusters the nodes where the direction of motion turns, over |i| from the bottom.
    fn sums(&self, entry: T) -> Sums<T> {
        let fast = (self.travel * self.rim)
            .primal()
            .max_of(T::Primal::from(1e-12))
            .sqrt();
        let turn = (self.travel - self.rim).abs().primal() / fast;
        // Where nodes stand carries no derivative, but they move with the entry angle.
        let share = (turn / entry.primal())
            .max_of(T::Primal::from(SHARPEST))
            .min_of(T::Primal::one());
        let scale = entry.scaled(share);
        let inverse = T::Primal::one() / share;
        let whole = (inverse + (inverse.squared() + 1.0).sqrt()).ln();
        let count = (whole.max_lane() / PER_PIECE).ceil().clamp(1.0, 16.0) as usize;
        let step = whole * (1.0 / count as f64);
        let rule = rule::<NODES>();
        let zero = T::zero();
        let (mut load, mut pull, mut torque) = (zero, zero, zero);
        for piece in 0..count {
            for (x, w) in rule.nodes.iter().zip(&rule.weights).take(NODES) {
                let grown = (step * (piece as f64 + x)).exp();
                let shrunk = T::Primal::one() / grown;
                let angle = scale.scaled((grown - shrunk) * 0.5);
                let weight = scale.scaled((grown + shrunk) * 0.5 * step * *w);
                let (back, up) = self.stresses(entry, angle);
                let (sin, cos) = angle.sin_cos();
                load += up * weight;
                pull -= back * weight;
                torque += (up * sin - back * cos) * weight;
            }
        }
        let area = self.radius * self.width;
        Sums {
            load: load * area,
            pull: pull * area,
            torque: torque * area * self.torque_arm,
        }
    }

    fn entry(&self, at: &Contact<T>) -> Result<T, ModelError> {
        type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
        let primal = self.map(T::primal);
        let load = at.normal_load.primal();
        // W = ζ α b R² θ1³/3 with α near .6
        let area = primal.width * primal.radius.squared() * primal.stiffness * 0.2;
        let guess = ((load / area).ln() * (1.0 / 3.0)).exp();
        let tangent: Wheel<Tangent<T>> = primal.map(Tangent::<T>::from_primal);
        // Sand that a slipping rim throws back may carry less at a larger angle, driven or braked.
        let rises_to = T::Primal::zero();
        balanced(
            at.normal_load,
            guess,
            at.slip.primal(),
            rises_to,
            TOLERANCE,
            |angle| tangent.sums(angle).load,
            |angle| self.sums(angle).load,
        )
    }
}

impl TerrainModel for GranularRft {
    const NAME: &'static str = "granular-rft";
    const SUMMARY: &'static str = "granular resistive force theory: each piece of the rim is a small plate that moves through dry sand";
    const PARAMS: &'static [Param] = &[Param {
        name: "intrusion_stiffness",
        symbol: "ζ",
        unit: "N/m^3",
        min: 1e3,
        max: 1e9,
        scale: Scale::Log,
        prior_sd: 0.5,
        doc: "stress per depth on a level plate pushed straight down",
    }];
    const EQUATION: &'static str = "\
A piece at the angle θ of the rim, z deep, has the tilt β = θ and moves in the direction γ below the horizontal, with
cos γ = (1 - i - cos θ)/N and sin γ = sin θ/N. It is pushed back by ζ z α_x dA and up by ζ z α_z dA:
α_z = A00 + A10 cos 2β + B11 sin(2β + γ) + B01 sin γ + B-11 sin(-2β + γ),
α_x = C11 cos(2β + γ) + C01 cos γ + C-11 cos(-2β + γ) + D10 sin 2β. Only pieces that move into the sand feel it, which
on a rolling wheel is its front, 0 <= θ <= θ1:
W = b R ζ ∫ z α_z dθ,  D = -b R ζ ∫ z α_x dθ,  T = b R² ζ ∫ z (α_z sin θ - α_x cos θ) dθ,  z = R (cos θ - cos θ1).";
    const RIVAL: bool = false;
    const REFERENCE: &'static str =
        "C. Li, T. Zhang, D. I. Goldman, Science 339:1408-1412, 2013 (generic coefficients)";
    const HOOKS: &'static [Hook] = &[Hook::Stiffness, Hook::ContactRadius];

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        let wheel = Wheel::read(p, at)?;
        let entry = wheel.entry(at)?;
        let sums = wheel.sums(entry);
        let mut forces = WheelForces::from_thrust(sums.pull, T::zero(), sums.torque);
        let (half, _) = (entry * 0.5).sin_cos();
        let sinkage = wheel.radius * half.squared() * 2.0;
        forces.sinkage = Some(sinkage);
        forces.angles = Some(Angles {
            entry,
            exit: T::zero(),
            max_stress: T::zero(),
        });
        forces.flags = Flags {
            braking: at.slip.primal().any_lt(T::Primal::zero()),
            apex_limited: false,
            deep_sinkage: (at.radius * 0.5).primal().any_lt(sinkage.primal()),
        };
        Ok(forces)
    }

    /// Loose poppy seeds of the paper (the sum of its own coefficients for them), and two sands.
    fn typical() -> Vec<Vec<f64>> {
        vec![vec![2.54e5], vec![1e6], vec![3e6]]
    }

    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        let wheel = Wheel::read(p, at)?;
        let entry = wheel.entry(at)?;
        let arm = at.radius;
        let point = move |angle: f64| {
            // At the very bottom of a wheel that rolls without slip the direction has no meaning; a hair ahead it has.
            let place = angle.max(1e-9 * entry);
            let (back, up) = wheel.stresses(entry, place);
            let (sin, cos) = angle.sin_cos();
            StressPoint {
                angle,
                normal_stress: back * sin + up * cos,
                shear_stress: up * sin - back * cos,
                shear_arm: arm,
            }
        };
        const SCAN: usize = 400;
        let apex = (0..=SCAN)
            .map(|k| entry * k as f64 / SCAN as f64)
            .max_by(|a, b| point(*a).normal_stress.total_cmp(&point(*b).normal_stress))
            .unwrap_or(0.0);
        Ok(Some(StressField::new(0.0, apex, entry, point)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ForceLaw;

    /// The published coefficients: a level plate pushed straight down has α_z = 1, and by symmetry α_x = 0.
    #[test]
    fn coefficients_are_normalised() {
        let sum: f64 = UP[0] + UP[1] + UP[2] + UP[3] + UP[4];
        assert!((sum - 1.0).abs() < 1e-12);
        // Spinning in place at the bottom: a level plate dragged backwards, γ = π.
        let wheel = Wheel {
            stiffness: 1.0,
            travel: 0.0,
            rim: 1.0,
            radius: 1.0,
            torque_arm: 1.0,
            width: 1.0,
        };
        let (back, up) = wheel.stresses(0.5, 1e-12);
        let depth = 1.0 - 0.5f64.cos();
        // α_x(0, π) = -(C11 + C01 + C-11), α_z(0, π) = A00 + A10
        assert!((back / depth + 0.136).abs() < 1e-9, "{back}");
        assert!((up / depth - 0.375).abs() < 1e-9, "{up}");
    }

    /// The composite midpoint rule on the same stresses, a second method: forces to 1e-7 of the load.
    #[test]
    fn a_second_quadrature_agrees() {
        for slip in [-0.6, -0.02, 0.0, 0.003, 0.1, 0.5, 1.0] {
            let at = Contact::new(slip, 120.0, 0.13, 0.16);
            let p = [2e6];
            let wheel = Wheel::read(&p, &at).unwrap();
            let entry = wheel.entry(&at).unwrap();
            let f = GranularRft.forces(&p, &at).unwrap();
            let n = 400_000;
            let (mut load, mut pull, mut torque) = (0.0, 0.0, 0.0);
            for k in 0..n {
                let angle = entry * (f64::from(k) + 0.5) / f64::from(n);
                let (back, up) = wheel.stresses(entry, angle);
                let area = 0.13 * 0.16 * entry / f64::from(n);
                load += up * area;
                pull -= back * area;
                torque += (up * angle.sin() - back * angle.cos()) * area * 0.13;
            }
            assert!((load - 120.0).abs() < 1e-5, "slip {slip}: {load}");
            assert!((pull - f.drawbar_pull).abs() < 1e-5, "slip {slip}");
            assert!((torque - f.resistive_torque).abs() < 1e-6, "slip {slip}");
        }
    }

    /// A wheel that rolls without slip is held back, one that spins pulls, a locked one is held back most.
    #[test]
    fn signs_along_slip() {
        let pull = |slip| {
            GranularRft
                .forces(&[2e6], &Contact::new(slip, 120.0, 0.13, 0.16))
                .unwrap()
                .drawbar_pull
        };
        assert!(pull(-0.9) < pull(0.0) && pull(0.0) < 0.0 && pull(0.6) > pull(0.1));
    }

    /// The wheel that comes out carries the load that went in.
    #[test]
    fn the_load_is_balanced() {
        for p in GranularRft::typical() {
            for slip in [-1.0, -0.3, 0.0, 0.05, 0.6, 1.0] {
                for load in [10.0, 60.0, 245.25] {
                    let at = Contact::new(slip, load, 0.254, 0.15);
                    let wheel = Wheel::read(&p, &at).unwrap();
                    let entry = wheel.entry(&at).unwrap();
                    let carried = wheel.sums(entry).load;
                    assert!((carried / load - 1.0).abs() < 1e-10, "{carried} {load}");
                }
            }
        }
    }
}
