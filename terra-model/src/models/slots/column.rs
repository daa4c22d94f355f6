//! Columns of soil that are pressed straight down and sheared along the ground: the closed form of a grid simulator with
//! Bekker pressure on a virgin flat surface.
//!
//! # Equation
//! p(z) acts vertically on the footprint, largest at the bottom, and the shear stress horizontally:
//! W = b R ∫ p cos θ dθ,  D = b R ∫ τ cos θ dθ,  T = b R² ∫ (τ cos θ + p sin θ) cos θ dθ over 0..θ1,
//! j(θ) = R ∫_θ^θ1 |r| cos θ' dθ', r = cos θ/(1 - i) - 1, the way of the rim over a column that stays where it is.
//!
//! τ points against the motion of the rim, which turns where r = 0: with r/sqrt(r² + δ²), δ = .005, in place of its sign,
//! so that forces have a slope at zero slip (δ is chosen; it moves the pull by less than .1 % of the load for slips above
//! .1).
//!
//! # Reference
//! A. Tasora, D. Mangoni, D. Negrut, R. Serban, P. Jayakumar, "Deformable soil with adaptive level of detail for tracked
//! and wheeled vehicles", Int. J. Vehicle Performance 5(1):60-76, 2019.

use super::contact_state::{Soil, Sums, angle_at_depth, depth_base};
use super::pieces::Pieces;
use crate::quadrature::t_minus_sin;
use crate::real::{Real, Root};
use crate::stress::StressPoint;

/// The equations, for whoever looks them up by name.
pub(super) const EQUATION: &str = "\
p(z) acts vertically on the footprint, largest at the bottom, and the shear stress horizontally:
W = b R ∫ p cos θ dθ,  D = b R ∫ τ cos θ dθ,  T = b R² ∫ (τ cos θ + p sin θ) cos θ dθ over 0..θ1,
j(θ) = R ∫_θ^θ1 |r| cos θ' dθ', r = cos θ/(1 - i) - 1, the way of the rim over a column that stays where it is.

τ points against the motion of the rim, which turns where r = 0: with r/sqrt(r² + δ²), δ = .005, in place of its sign,
so that forces have a slope at zero slip (δ is chosen; it moves the pull by less than .1 % of the load for slips above
.1).";

/// δ.
const TURN: f64 = 0.005;

/// Everything but the entry angle.
#[derive(Clone, Copy)]
pub(super) struct Column<T> {
    pub(super) soil: Soil<T>,
    /// g - 1 = R ω/v - 1.
    pub(super) excess: T,
    pub(super) radius: T,
    pub(super) shear_radius: T,
    pub(super) torque_arm: T,
    pub(super) width: T,
}

/// An angle of the contact, all from half of it: 1 - cos θ without cancellation.
struct Place<T> {
    angle: T,
    sin: T,
    versine: T,
}

impl<T: Real> Place<T> {
    fn at(angle: T) -> Self {
        let (sin, cos) = (angle * 0.5).sin_cos();
        Place {
            angle,
            sin: sin * cos * 2.0,
            versine: sin.squared() * 2.0,
        }
    }
}

/// Where the way turns, and the way at the entry and there.
struct Ways<T> {
    turn: T,
    at_entry: T,
    at_turn: T,
}

impl<T: Real> Column<T> {
    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Column<S> {
        Column {
            soil: self.soil.map(f),
            excess: f(self.excess),
            radius: f(self.radius),
            shear_radius: f(self.shear_radius),
            torque_arm: f(self.torque_arm),
            width: f(self.width),
        }
    }

    /// ∫ r cos θ from 0: (g - 1) θ + x(θ) - g (x(θ) + sin θ (1 - cos θ))/2 with x(θ) = θ - sin θ.
    fn way(&self, at: &Place<T>) -> T {
        let g = self.excess + 1.0;
        let x = t_minus_sin(at.angle);
        self.excess * at.angle + x - g * (x + at.sin * at.versine) * 0.5
    }

    /// r = g cos θ - 1.
    fn slip_at(&self, at: &Place<T>) -> T {
        self.excess - (self.excess + 1.0) * at.versine
    }

    /// Where r = 0: tan²(θ/2) = (g - 1)/(g + 1); 0 where the rim is nowhere faster than the ground.
    fn turn(&self) -> T::Primal {
        let excess = self.excess.primal().max_of(T::Primal::zero());
        (excess / (excess + 2.0)).sqrt().atan() * 2.0
    }

    /// What E needs of the whole contact.
    fn ways(&self, entry: T) -> Ways<T> {
        // No derivative in the turn: the way has none there.
        let free = T::from_primal(self.turn());
        let turn = free.select_lt(entry, free, entry);
        Ways {
            turn,
            at_entry: self.way(&Place::at(entry)),
            at_turn: self.way(&Place::at(turn)),
        }
    }

    /// E with its sign.
    fn mobilised(&self, ways: &Ways<T>, at: &Place<T>) -> T {
        let (here, entry) = (self.way(at), ways.at_entry);
        let back = ways.at_turn * 2.0 - here - entry;
        let j = at.angle.select_lt(ways.turn, back, here - entry);
        let y = self.shear_radius / self.soil.strength.modulus * j.max_of(T::zero());
        let r = self.slip_at(at);
        self.soil.strength.mobilised(y) * r / (r.squared() + TURN * TURN).sqrt()
    }

    /// What carries: the normal stress alone, and that depends on nothing but the depth, so few nodes do.
    pub(super) fn load(&self, entry: T) -> T {
        let (sin_entry, _) = entry.sin_cos();
        let soil = self.soil.under(self.radius * sin_entry);
        let pieces = self.map(T::primal).pieces_of_pressure(entry.primal());
        let mut load = T::zero();
        let base = |u: T| self.radius * depth_base(entry, T::one(), u * 0.5);
        soil.each_node(&pieces, entry, base, |u, normal, _| {
            let (_, cos) = (entry * (T::one() - u)).sin_cos();
            load += normal * cos;
        });
        load * self.radius * self.width
    }

    pub(super) fn sums(&self, entry: T) -> Sums<T> {
        let (sin_entry, _) = entry.sin_cos();
        let soil = self.soil.under(self.radius * sin_entry);
        let pieces = self.map(T::primal).pieces(entry.primal());
        let ways = self.ways(entry);
        let zero = T::zero();
        let (mut load, mut thrust, mut torque) = (zero, zero, zero);
        let base = |u: T| self.radius * depth_base(entry, T::one(), u * 0.5);
        soil.each_node(&pieces, entry, base, |u, normal, plain| {
            let at = Place::at(entry * (T::one() - u));
            let (sin, cos) = (at.sin, T::one() - at.versine);
            let strength = normal * soil.strength.tan_friction + plain * soil.strength.cohesion;
            let tau = strength * self.mobilised(&ways, &at);
            load += normal * cos;
            thrust += tau * cos;
            torque += (tau * cos + normal * sin) * cos;
        });
        let area = self.radius * self.width;
        Sums {
            load: load * area,
            thrust: thrust * area,
            lug_thrust: zero,
            // The normal stress is vertical: what compaction costs shows in the torque alone.
            compaction: zero,
            bulldozing: zero,
            torque: torque * area * self.torque_arm,
            lateral: zero,
        }
    }
}

impl<P: Root> Column<P> {
    fn pieces(&self, entry: P) -> Pieces<P> {
        let one = P::one();
        let per_modulus = self.shear_radius / self.soil.strength.modulus;
        let steep = self
            .slip_at(&Place::at(entry))
            .abs()
            .max_of(self.excess.abs())
            .max_of(P::from(TURN))
            * per_modulus
            * entry;
        let mut pieces = Pieces::new(steep.max_of(self.soil.steepness(self.deepest(entry))));
        // The direction of τ turns over |r| of a few δ: pieces that grow from r = 0 by a factor of five in r.
        let per_excess = one / ((self.excess + 1.0) * 2.0);
        for level in [-25.0, -5.0, -1.0, 0.0, 1.0, 5.0, 25.0] {
            // 1 - cos θ = (g - 1 - r)/g
            let squared = ((self.excess - level * TURN) * per_excess).max_of(P::zero());
            let angle = (squared / (one - squared)).sqrt().atan() * 2.0;
            pieces.at((entry - angle) / entry);
        }
        self.break_at_bends(&mut pieces, entry);
        pieces
    }

    fn pieces_of_pressure(&self, entry: P) -> Pieces<P> {
        let mut pieces = Pieces::new(self.soil.steepness(self.deepest(entry)));
        self.break_at_bends(&mut pieces, entry);
        pieces
    }

    fn deepest(&self, entry: P) -> P {
        let (sin_half, _) = (entry * 0.5).sin_cos();
        self.radius * sin_half.squared() * 2.0
    }

    fn break_at_bends(&self, pieces: &mut Pieces<P>, entry: P) {
        for bend in self.soil.bends().into_iter().flatten() {
            let (reached, angle) = angle_at_depth(entry, bend / self.radius);
            pieces.at(reached.select_lt(P::zero(), P::one(), (entry - angle) / entry));
        }
    }
}

impl Column<f64> {
    /// Normal and shear stress on the rim that have the same resultant as the vertical and horizontal ones on the ground.
    pub(super) fn stress_at(&self, entry: f64, angle: f64) -> StressPoint {
        let soil = self.soil.under(self.radius * entry.sin());
        let place = Place::at(angle);
        let (sin, cos) = (place.sin, 1.0 - place.versine);
        let half = 0.5 * (1.0 - angle / entry).clamp(0.0, 1.0);
        let depth = self.radius * 2.0 * half * depth_base(entry, 1.0, half);
        let p = soil.normal_stress(depth);
        let strength = soil.strength.cohesion + p * soil.strength.tan_friction;
        let tau = strength * self.mobilised(&self.ways(entry), &place);
        StressPoint {
            angle,
            normal_stress: (p * cos - tau * sin) * cos,
            shear_stress: (p * sin + tau * cos) * cos,
            shear_arm: self.torque_arm,
        }
    }
}
