//! A tyre that lies flat where the soil would push harder than inflation and carcass, for any pressure and shear law.
//!
//! # Equation
//! As the plain tyre. σ of the pressure law and its layers pushes on the round front, θf <= θ <= θ1, until it reaches the
//! pressure p_t of inflation and carcass at the depth z_0; from there the tyre lies flat over l = 2 R sin θf with
//! cos θf = cos θ1 + z_0/R, and carries p_t. A wheel that sinks less stays round, θf = 0, as does one on a soil that never
//! pushes so hard: snow whose strength is below p_t. With the sign of j, E(j) of the shear law:
//! W = b R ∫ (σ cos θ + τ sin θ) dθ + b p_t l,  D = b R ∫ (τ cos θ - σ sin θ) dθ + b ∫ τ dx,
//! T = b R² ∫ τ dθ + b R cos θf ∫ τ dx;  on the front j = R \[(θ1 - θ) - (1 - i)(sin θ1 - sin θ)\], under the flat
//! j = j(θf) + i x.
//!
//! Peat feels the length of the contact, which is that of all the soil it lies on, front and flat: L = R (sin θ1 + sin θf).
//! The plate of the law is what presses the soil, and that is both; L of a round wheel is the same with θf = 0, so that
//! nothing jumps as the flat begins. z_0 and L then depend on each other: one root, because a deeper z_0 means a shorter flat
//! and a stiffer peat.

use super::NODES;
use super::contact_state::{Soil, Sums, angle_at_depth, depth_base};
use super::pieces::Pieces;
use super::shear::Strength;
use crate::models::compliant_tyre::{flattened, versine};
use crate::models::displacement::{displacement, sign_changes};
use crate::quadrature::rule;
use crate::real::{Real, Root};
use crate::stress::StressPoint;

/// Changes of j/K up to which E has a panel of its own: it settles by e^(-j/K), and is settled beyond.
const REACHES: [f64; 4] = [4.0, 16.0, 64.0, f64::INFINITY];
/// Relative change of z_0 at which its search stops; one implicit step follows.
const TOLERANCE: f64 = 1e-13;
/// Steps of that search: halvings alone find any depth by then.
const STEPS: usize = 100;

/// Everything but the entry angle.
#[derive(Clone, Copy)]
pub(super) struct Tyre<T> {
    soil: Soil<T>,
    /// Kinematic slip.
    slip: T,
    /// p_t.
    pressure: T,
    radius: T,
    /// Of the rim.
    torque_arm: T,
    width: T,
    /// z_0; none where it takes the length of the contact.
    depth: Option<T>,
}

/// A tyre at one entry angle.
struct Lying<T> {
    /// Of the lowest point below the surface that the wheel meets.
    depth: T,
    /// θf, and θ1 - θf.
    from: T,
    span: T,
    soil: Soil<T>,
}

impl<T: Real> Tyre<T> {
    pub(super) fn new(
        soil: Soil<T>,
        slip: T,
        pressure: T,
        [radius, torque_arm, width]: [T; 3],
    ) -> Self {
        let mut tyre = Tyre {
            soil,
            slip,
            pressure,
            radius,
            torque_arm,
            width,
            depth: None,
        };
        if !soil.pressure.feels_length() {
            tyre.depth = Some(tyre.reached(T::zero()));
        }
        tyre
    }

    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Tyre<S> {
        Tyre {
            soil: self.soil.map(f),
            slip: f(self.slip),
            pressure: f(self.pressure),
            radius: f(self.radius),
            torque_arm: f(self.torque_arm),
            width: f(self.width),
            depth: self.depth.map(f),
        }
    }

    pub(super) fn soil(&self) -> &Soil<T> {
        &self.soil
    }

    pub(super) fn radius(&self) -> T {
        self.radius
    }

    fn soil_under(&self, entry: T, from: T) -> Soil<T> {
        if !self.soil.pressure.feels_length() {
            return self.soil;
        }
        let ((front, _), (rear, _)) = (entry.sin_cos(), from.sin_cos());
        self.soil.under(self.radius * (front + rear))
    }

    /// σ at a depth less p_t, if the tyre lay flat from there.
    fn excess(&self, entry: T, depth: T) -> T {
        let from = if self.soil.pressure.feels_length() {
            flattened(entry, depth, self.radius).0
        } else {
            T::zero()
        };
        self.soil_under(entry, from).normal_stress(depth) - self.pressure
    }

    /// z_0: found in the primal between the surface and where the law alone, under the longest contact there can be, pushes so
    /// hard, because layers and a shorter contact only add to that. Its derivatives follow from one implicit step.
    fn reached(&self, entry: T) -> T {
        type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
        let zero = T::Primal::zero();
        let alone = self
            .soil_under(entry, entry)
            .pressure
            .depth_at(self.pressure);
        let tangent = self.map(|x| Tangent::<T>::from_primal(x.primal()));
        let at = Tangent::<T>::from_primal(entry.primal());
        let excess = |depth: T::Primal| T::Primal::parts(tangent.excess(at, depth.seed()));
        let (mut low, mut high, mut depth) = (zero, alone.primal(), alone.primal());
        let (most, mut steepest) = excess(depth);
        let (mut over, mut slope) = (most, steepest);
        for _ in 0..STEPS {
            low = over.select_lt(zero, depth, low);
            high = over.select_lt(zero, high, depth);
            steepest = zero.select_lt(slope, slope, T::Primal::one());
            let (middle, newton) = ((low + high) * 0.5, depth - over / steepest);
            let inside = newton.select_lt(low, middle, high.select_lt(newton, middle, newton));
            let next = zero.select_lt(slope, inside, middle);
            let change = (next - depth).abs();
            depth = next;
            if !(depth * TOLERANCE).any_lt(change) {
                break;
            }
            (over, slope) = excess(depth);
        }
        let root = T::from_primal(depth);
        let stepped = root - self.excess(entry, root) / T::from_primal(steepest);
        // A soil that never pushes so hard, or does where the law says to the last digit.
        T::from_primal(most).select_lt(T::zero(), alone, stepped)
    }

    fn lying(&self, entry: T) -> Lying<T> {
        let zero = T::zero();
        let depth = self.depth.unwrap_or_else(|| self.reached(entry));
        let (from, span) = flattened(entry, depth, self.radius);
        let round = self.radius * versine(entry);
        Lying {
            depth: zero.select_lt(from, depth, round),
            from,
            span,
            soil: self.soil_under(entry, from),
        }
    }

    /// θf.
    pub(super) fn flat_from(&self, entry: T) -> T {
        self.lying(entry).from
    }

    pub(super) fn sinkage(&self, entry: T) -> T {
        self.lying(entry).depth
    }

    /// j/K on the front.
    fn sheared(&self, entry: T, angle: T) -> T {
        self.radius / self.soil.strength.modulus * displacement(self.slip, entry, angle)
    }

    /// Length of the flat.
    fn length(&self, from: T) -> T {
        let (sin, _) = from.sin_cos();
        self.radius * sin * 2.0
    }

    /// Forces on the front, and the load on the flat.
    fn front(&self, entry: T, lying: &Lying<T>) -> Sums<T> {
        let Lying {
            from,
            span,
            soil,
            depth,
        } = lying;
        let pieces = self.map(T::primal).pieces(
            entry.primal(),
            from.primal(),
            span.primal(),
            depth.primal(),
        );
        let d = *span / entry;
        let half_d = d * 0.5;
        let zero = T::zero();
        let (mut load, mut thrust, mut compaction, mut shear) = (zero, zero, zero, zero);
        let base = |u: T| self.radius * depth_base(entry, d, half_d * u);
        soil.each_node(&pieces, *span, base, |u, normal, plain| {
            let angle = entry - *span * u;
            let (sin, cos) = angle.sin_cos();
            let strength = normal * soil.strength.tan_friction + plain * soil.strength.cohesion;
            let tau = strength * soil.strength.signed(self.sheared(entry, angle));
            load += normal * cos + tau * sin;
            thrust += tau * cos;
            compaction += normal * sin;
            shear += tau;
        });
        let area = self.radius * self.width;
        Sums {
            load: load * area + self.pressure * self.length(*from) * self.width,
            thrust: thrust * area,
            compaction: compaction * area,
            torque: shear * area * self.torque_arm,
            ..Sums::zero()
        }
    }

    /// What is carried at an entry angle: the shear stress under the flat has no part in it.
    pub(super) fn load(&self, entry: T) -> T {
        self.front(entry, &self.lying(entry)).load
    }

    pub(super) fn sums(&self, entry: T) -> Sums<T> {
        let lying = self.lying(entry);
        let front = self.front(entry, &lying);
        let strength = &self.soil.strength;
        let (length, (_, cos)) = (self.length(lying.from), lying.from.sin_cos());
        let change = self.slip * length / strength.modulus;
        let mean = mean_mobilised(strength, self.sheared(entry, lying.from), change);
        let most = strength.cohesion + self.pressure * strength.tan_friction;
        let flat = most * mean * length * self.width;
        Sums {
            thrust: front.thrust + flat,
            torque: front.torque + flat * cos * self.torque_arm,
            ..front
        }
    }
}

/// Mean of E, with its sign, where j/K changes along a straight line.
///
/// E has a bend where j = 0, and settles away from it: panels grow from where |j| is least.
pub(super) fn mean_mobilised<T: Real>(strength: &Strength<T>, start: T, change: T) -> T {
    let (zero, one) = (T::Primal::zero(), T::Primal::one());
    let way = change.primal();
    let size = way.abs().max_of(T::Primal::from(f64::MIN_POSITIVE));
    let signed = way.select_lt(zero, -size, size);
    let least = (-(start.primal() / signed)).max_of(zero).min_of(one);
    let rule = rule::<NODES>();
    let mut mean = T::zero();
    for (side, towards) in [(least, -1.0), (one - least, 1.0)] {
        let mut low = zero;
        for reach in REACHES {
            let high = side.min_of(T::Primal::from(reach) / size);
            if !low.any_lt(high) {
                break;
            }
            for (x, w) in rule.nodes.iter().zip(&rule.weights).take(NODES) {
                let share = least + (low + (high - low) * *x) * towards;
                let e = strength.signed(start + change.scaled(share));
                mean += e.scaled((high - low) * *w);
            }
            low = high;
        }
    }
    mean
}

impl<P: Root> Tyre<P> {
    fn pieces(&self, entry: P, from: P, span: P, depth: P) -> Pieces<P> {
        let one = P::one();
        let i = self.slip;
        let per_modulus = self.radius / self.soil.strength.modulus;
        // |dj/dθ|/K is largest at an end of the front.
        let slope = |angle: P| ((i + (one - i) * versine(angle)) * per_modulus).abs();
        let steep = slope(entry).max_of(slope(from)) * span;
        let mut pieces = Pieces::new(steep.max_of(self.soil.steepness(depth)));
        if i.any_lt(P::zero()) {
            let [ahead, _] = sign_changes(i, entry, from);
            pieces.bend_at((entry - ahead) / span);
        }
        for bend in self.soil.bends().into_iter().flatten() {
            let (reached, angle) = angle_at_depth(entry, bend / self.radius);
            pieces.at(reached.select_lt(P::zero(), one, (entry - angle) / span));
        }
        pieces
    }
}

impl Tyre<f64> {
    /// Stresses at one angle of the contact: on the flat the angle names the point from the axle.
    pub(super) fn stress_at(&self, entry: f64, angle: f64) -> StressPoint {
        let Lying {
            from, span, soil, ..
        } = self.lying(entry);
        let flat = from > 0.0 && angle <= from;
        let (normal_stress, sheared) = if flat {
            let behind = self.radius * from.cos() * (from.tan() - angle.tan());
            let start = self.sheared(entry, from);
            let more = self.slip * behind / soil.strength.modulus;
            (self.pressure, start + more)
        } else {
            let u = ((entry - angle) / span).clamp(0.0, 1.0);
            let d = span / entry;
            let depth = self.radius * u * depth_base(entry, d, 0.5 * d * u);
            (soil.normal_stress(depth), self.sheared(entry, angle))
        };
        let strength = soil.strength.cohesion + normal_stress * soil.strength.tan_friction;
        StressPoint {
            angle,
            normal_stress,
            shear_stress: strength * soil.strength.signed(sheared),
            shear_arm: if angle.abs() < from {
                self.torque_arm * from.cos()
            } else {
                self.torque_arm
            },
        }
    }
}
