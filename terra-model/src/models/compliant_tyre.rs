//! A pneumatic tyre on soft soil: round where the soil is softer than the tyre, flat where the tyre is.
//!
//! # Equation
//! σ = k z^n pushes on the round front, θf <= θ <= θ1, until it reaches the pressure p_t of inflation and carcass at the
//! depth z_0 = (p_t/k)^(1/n). From there the tyre lies flat at that depth, over l = 2 R sin θf with
//! cos θf = cos θ1 + z_0/R, and carries p_t; a wheel that sinks less stays round, θf = 0. With E(j) = sign(j)(1 - e^(-|j|/K)):
//! W = b R ∫ (σ cos θ + τ sin θ) dθ + b p_t l,  D = b R ∫ (τ cos θ - σ sin θ) dθ + b ∫ τ dx,
//! T = b R² ∫ τ dθ + b R cos θf ∫ τ dx;  τ = (c + σ tan φ) E(j), on the front j = R \[(θ1 - θ) - (1 - i)(sin θ1 - sin θ)\],
//! under the flat j = j(θf) + i x.
//!
//! # Units
//! SI. p_t \[Pa\] is one number, because inflation and carcass act only through their sum.
//!
//! # Reference
//! M. G. Bekker, *Introduction to Terrain-Vehicle Systems*, 1969; J. Y. Wong, *Theory of Ground Vehicles*, chapter 2 (the
//! critical pressure and the flat; the forms are recalled and not checked against the book). There the front is replaced by
//! the plate's work; here its stresses are integrated, and shear along it is kept.

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Flags, WheelForces};
use crate::model::{Soil, TerrainModel};
use crate::models::bekker::PARAMS as BEKKER;
use crate::models::displacement::{displacement, sign_changes};
use crate::models::slots::checks::{self, Must, Values, kinematic, quantity};
use crate::param::{Param, Scale};
use crate::quadrature::rule;
use crate::real::{Real, Root};
use crate::root::{FINE_TOLERANCE, MAX_ENTRY_ANGLE, balanced, rises_to};
use crate::stress::{StressField, StressPoint};

/// A tyre that flattens on firm ground.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompliantTyre;

/// Nodes of the front, clustered at its entry, and of the flat.
const NODES: usize = 24;
/// Change of j/K along the flat from which its integral is taken in closed form.
const STEEP: f64 = 0.5;
/// Depth \[m\] below which there is none: the stress there is zero to rounding, and so is its part of the load.
const SHALLOW: f64 = 1e-200;

/// p_t.
pub(in crate::models) const PRESSURE: Param = Param {
    name: "tyre_pressure",
    symbol: "p_t",
    unit: "Pa",
    min: 1e3,
    max: 1e7,
    scale: Scale::Log,
    prior_sd: 0.3,
    doc: "inflation pressure and what the carcass adds to it",
};

#[derive(Clone, Copy)]
struct Wheel<T> {
    stiffness: T,
    exponent: T,
    cohesion: T,
    tan_friction: T,
    modulus: T,
    pressure: T,
    slip: T,
    radius: T,
    /// Of the rim, for the torque.
    arm: T,
    width: T,
}

struct Sums<T> {
    load: T,
    thrust: T,
    compaction: T,
    torque: T,
}

/// 1 - cos t.
pub(in crate::models) fn versine<T: Real>(t: T) -> T {
    let (s, _) = (t * 0.5).sin_cos();
    s.squared() * 2.0
}

/// θf of a tyre that lies flat from a depth on, 0 while it stays round, and the angle θ1 - θf of the round front.
pub(in crate::models) fn flattened<T: Real>(entry: T, depth: T, radius: T) -> (T, T) {
    let over = versine(entry) - depth / radius;
    // The root of zero has no derivative: the tyre just touches.
    let (zero, one) = (T::zero(), T::one());
    let safe = zero.select_lt(over, over, one);
    let angle = (safe / (T::from(2.0) - safe)).sqrt().atan() * 2.0;
    // cos θf - cos θ1 = z_0/R = 2 sin((θ1 + θf)/2) sin((θ1 - θf)/2): a front far shorter than the flat keeps its digits.
    let (middle, _) = ((entry + angle) * 0.5).sin_cos();
    let half = (depth / (radius * middle * 2.0)).min_of(T::from(0.99));
    let span = (half / (one - half.squared()).sqrt()).atan() * 2.0;
    (
        zero.select_lt(over, angle, zero),
        zero.select_lt(over, span, entry),
    )
}

impl<T: Real> Wheel<T> {
    fn read(p: &[T], at: &Contact<T>) -> Result<Self, ModelError> {
        checks::contact(at)?;
        let model = CompliantTyre::NAME;
        let values = Values {
            model,
            params: CompliantTyre::PARAMS,
            p,
        };
        let hooks = &at.hooks;
        let k_c = values.get("k_c", Must::BeFinite)?;
        let k_phi = values.get("k_phi", Must::BeFinite)?;
        let n = values.get("sinkage_exponent", Must::BeFinite)? + hooks.sinkage_exponent;
        let stiffness = (k_c / at.width + k_phi) * hooks.stiffness;
        Ok(Wheel {
            stiffness: quantity(model, "k_c/b + k_phi", stiffness, Must::BePositive)?,
            exponent: quantity(model, "sinkage_exponent", n, Must::BePositive)?,
            cohesion: values.get("cohesion", Must::NotBeNegative)? * hooks.cohesion,
            tan_friction: values.get("friction_angle", Must::BeAcute)?.tan() * hooks.friction,
            modulus: values.get("shear_modulus", Must::BePositive)? * hooks.shear_modulus,
            pressure: values.get("tyre_pressure", Must::BePositive)?,
            slip: kinematic(at.slip),
            radius: at.radius * hooks.contact_radius,
            arm: at.radius,
            width: at.width,
        })
    }

    fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            stiffness: f(self.stiffness),
            exponent: f(self.exponent),
            cohesion: f(self.cohesion),
            tan_friction: f(self.tan_friction),
            modulus: f(self.modulus),
            pressure: f(self.pressure),
            slip: f(self.slip),
            radius: f(self.radius),
            arm: f(self.arm),
            width: f(self.width),
        }
    }

    /// θf, 0 while the wheel stays round, and the angle θ1 - θf of the round front.
    fn flat_from(&self, entry: T) -> (T, T) {
        let depth = ((self.pressure / self.stiffness).ln() / self.exponent).exp();
        flattened(entry, depth, self.radius)
    }

    fn displacement(&self, entry: T, angle: T) -> T {
        self.radius * displacement(self.slip, entry, angle)
    }

    fn mobilised(&self, j: T) -> T {
        let e = -(-(j.abs() / self.modulus)).exp_m1();
        j.select_lt(T::zero(), -e, e)
    }

    /// ∫ E dx over a flat of that length that begins at a displacement.
    fn flat_shear(&self, start: T, length: T) -> T {
        let zero = T::zero();
        let rule = rule::<NODES>();
        let mut mean = zero;
        for (x, w) in rule.nodes.iter().zip(&rule.weights).take(NODES) {
            mean += self.mobilised(start + self.slip * length * *x) * *w;
        }
        // An antiderivative of E is |j| + K e^(-|j|/K).
        let integral = |j: T| j.abs() + self.modulus * (-(j.abs() / self.modulus)).exp_m1();
        let change = self.slip * length;
        let steep = change.abs() / self.modulus;
        // A rule in one piece does not see the bend where j = 0.
        let bends = start * (start + change);
        let steep = bends.select_lt(zero, T::from(STEEP), steep);
        let divisor = steep.select_lt(T::from(STEEP), T::one(), self.slip);
        let closed = (integral(start + change) - integral(start)) / divisor;
        steep.select_lt(T::from(STEEP), mean * length, closed)
    }

    /// x of the front at which the shear of a braked wheel changes its sign, which bends E: 1 where it does not.
    fn bend(&self, entry: T, from: T, span: T) -> Option<T::Primal> {
        let (slip, one) = (self.slip.primal(), T::Primal::one());
        if !slip.any_lt(T::Primal::zero()) {
            return None;
        }
        let entry = entry.primal();
        let [ahead, _] = sign_changes(slip, entry, from.primal());
        let share = (entry - ahead) / span.primal();
        let tiny = T::Primal::from(f64::MIN_POSITIVE);
        let x = share.max_of(tiny).pow_pos(one / 3.0).min_of(one);
        Some(tiny.select_lt(share, x, one))
    }

    fn sums(&self, entry: T) -> Sums<T> {
        let (from, span) = self.flat_from(entry);
        let zero = T::zero();
        let (mut load, mut thrust, mut compaction, mut turning) = (zero, zero, zero, zero);
        // θ1 - θ = span x³: σ rises as a broken power of the way from the entry.
        let mut add = |x: T, w: T| {
            let below = span * (x * x * x);
            let angle = entry - below;
            let weight = span * (x * x * w * 3.0);
            let (sum, _) = (entry - below * 0.5).sin_cos();
            let (half, _) = (below * 0.5).sin_cos();
            let depth = (self.radius * sum * half * 2.0).max_of(T::from(SHALLOW));
            let normal = self.stiffness * depth.pow_pos(self.exponent);
            let shear = (self.cohesion + normal * self.tan_friction)
                * self.mobilised(self.displacement(entry, angle));
            let (sin, cos) = angle.sin_cos();
            load += (normal * cos + shear * sin) * weight;
            thrust += shear * cos * weight;
            compaction += normal * sin * weight;
            turning += shear * weight;
        };
        let rule = rule::<NODES>();
        let bend = self.bend(entry, from, span);
        let ahead = bend.map_or(T::one(), T::from_primal);
        for (x, w) in rule.nodes.iter().zip(&rule.weights).take(NODES) {
            add(ahead * *x, ahead * *w);
            if bend.is_some() {
                let behind = T::one() - ahead;
                add(ahead + behind * *x, behind * *w);
            }
        }
        let (sin, cos) = from.sin_cos();
        let length = self.radius * sin * 2.0;
        let strength = self.cohesion + self.pressure * self.tan_friction;
        let flat = strength * self.flat_shear(self.displacement(entry, from), length);
        let area = self.radius * self.width;
        Sums {
            load: load * area + self.pressure * length * self.width,
            thrust: thrust * area + flat * self.width,
            compaction: compaction * area,
            torque: (turning * area + flat * cos * self.width) * self.arm,
        }
    }

    fn entry(&self, at: &Contact<T>) -> Result<T, ModelError> {
        type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
        let primal = self.map(T::primal);
        let load = at.normal_load.primal();
        // A round wheel of this exponent near one: W = b k R^(n+1) θ1^(2n+1)/2.
        let n = primal.exponent;
        let area = primal.width * primal.radius * primal.stiffness;
        let depth = (load / area).ln() - n * primal.radius.ln();
        let guess = (depth / (n * 2.0 + 1.0)).exp();
        let tangent: Wheel<Tangent<T>> = primal.map(Tangent::<T>::from_primal);
        balanced(
            at.normal_load,
            guess,
            at.slip.primal(),
            rises_to(at.slip.primal(), MAX_ENTRY_ANGLE),
            FINE_TOLERANCE,
            |angle| tangent.sums(angle).load,
            |angle| self.sums(angle).load,
        )
    }
}

impl Wheel<f64> {
    fn stress_at(&self, entry: f64, from: f64, angle: f64) -> StressPoint {
        let (normal_stress, displacement) = if from > 0.0 && angle <= from {
            let behind = self.radius * from.cos() * (from.tan() - angle.tan());
            let start = self.displacement(entry, from);
            (self.pressure, start + self.slip * behind)
        } else {
            let half = (0.5 * (entry - angle)).sin();
            let depth = 2.0 * self.radius * (0.5 * (entry + angle)).sin() * half;
            let normal = self.stiffness * depth.max(0.0).powf(self.exponent);
            (normal, self.displacement(entry, angle))
        };
        let strength = self.cohesion + normal_stress * self.tan_friction;
        StressPoint {
            angle,
            normal_stress,
            shear_stress: strength * self.mobilised(displacement),
            shear_arm: if angle.abs() < from {
                self.arm * from.cos()
            } else {
                self.arm
            },
        }
    }
}

impl TerrainModel for CompliantTyre {
    const NAME: &'static str = "compliant-tyre";
    const SUMMARY: &'static str =
        "tyre that lies flat where the soil would push harder than inflation and carcass";
    const PARAMS: &'static [Param] = &[
        BEKKER[0], BEKKER[1], BEKKER[2], BEKKER[3], BEKKER[4], BEKKER[5], PRESSURE,
    ];
    const EQUATION: &'static str = "\
σ = k z^n pushes on the round front, θf <= θ <= θ1, until it reaches the pressure p_t of inflation and carcass at the
depth z_0 = (p_t/k)^(1/n). From there the tyre lies flat at that depth, over l = 2 R sin θf with
cos θf = cos θ1 + z_0/R, and carries p_t; a wheel that sinks less stays round, θf = 0. With E(j) = sign(j)(1 - e^(-|j|/K)):
W = b R ∫ (σ cos θ + τ sin θ) dθ + b p_t l,  D = b R ∫ (τ cos θ - σ sin θ) dθ + b ∫ τ dx,
T = b R² ∫ τ dθ + b R cos θf ∫ τ dx;  τ = (c + σ tan φ) E(j), on the front j = R [(θ1 - θ) - (1 - i)(sin θ1 - sin θ)],
under the flat j = j(θf) + i x.";
    const RIVAL: bool = false;
    const REFERENCE: &'static str =
        "M. G. Bekker, 1969; J. Y. Wong, Theory of Ground Vehicles (forms recalled)";
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
        let wheel = Wheel::read(p, at)?;
        let entry = wheel.entry(at)?;
        let sums = wheel.sums(entry);
        let (from, _) = wheel.flat_from(entry);
        let mut forces = WheelForces::from_thrust(sums.thrust, sums.compaction, sums.torque);
        let sinkage = wheel.radius * (versine(entry) - versine(from));
        forces.sinkage = Some(sinkage);
        forces.angles = Some(Angles {
            entry,
            exit: -from,
            max_stress: from,
        });
        forces.flags = Flags {
            braking: at.slip.primal().any_lt(T::Primal::zero()),
            apex_limited: false,
            deep_sinkage: (at.radius * 0.5).primal().any_lt(sinkage.primal()),
        };
        Ok(forces)
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        let mut soil = Soil::unknown();
        if let [k_c, k_phi, n, c, phi, k, ..] = p {
            soil.stiffness = Some(*k_c / at.width + *k_phi);
            soil.sinkage_exponent = Some(*n);
            soil.cohesion = Some(*c);
            soil.friction_angle = Some(*phi);
            soil.shear_modulus = Some(*k);
        }
        soil
    }

    /// Of the round front, and of the flat, where the pressure is p_t and points are named by their angle from the axle.
    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        let wheel = Wheel::read(p, at)?;
        let entry = wheel.entry(at)?;
        let (from, _) = wheel.flat_from(entry);
        let mut field = StressField::new(-from, from, entry, move |angle| {
            wheel.stress_at(entry, from, angle)
        });
        field.flat = (from > 0.0).then_some(from);
        Ok(Some(field))
    }

    /// Dry sand, upland sandy loam and lean clay of the catalogue, under tyres of 60, 150 and 100 kPa.
    fn typical() -> Vec<Vec<f64>> {
        [
            ("dry_sand", 6e4),
            ("upland_sandy_loam", 1.5e5),
            ("lean_clay_22", 1e5),
        ]
        .into_iter()
        .filter_map(|(id, pressure)| {
            let terrain = crate::catalogue::find(id).ok()?;
            let mut p: Vec<f64> = Self::PARAMS
                .iter()
                .take(6)
                .map(|p| terrain.value(p.name))
                .collect::<Option<_>>()?;
            p.push(pressure);
            Some(p)
        })
        .collect()
    }
}

#[cfg(test)]
mod tests;
