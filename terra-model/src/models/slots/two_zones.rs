//! A braked wheel with two zones of shear, for any pressure and shear law of the soil.
//!
//! # Equation
//! As the plain one: σ of both branches is that of the rim with its apex at θm, which moves to θ0 where the zones meet,
//! cos θ0 - (1 + s) = tan(45° - φ/2) sin θ0, and the shear displacement begins anew there. σ is the pressure law's at its
//! depth, E the shear law's. Driven it is the rim itself, [`Rim`](super::rim::Rim).
//!
//! θ0 is where the rim moves along a slip line of the soil, which takes the angle of friction of the soil itself.

use super::contact_state::{Soil, Sums, angle_at_depth, depth_base};
use super::pieces::Pieces;
use crate::models::braked_two_zone::zones::{Places, SMALLEST, Zones};
use crate::real::{Real, Root};
use crate::stress::StressPoint;

/// Everything but the entry angle.
#[derive(Clone, Copy)]
pub(super) struct TwoZones<T> {
    pub(super) soil: Soil<T>,
    pub(super) zones: Zones<T>,
    pub(super) radius: T,
    pub(super) torque_arm: T,
    pub(super) width: T,
}

impl<T: Real> TwoZones<T> {
    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> TwoZones<S> {
        TwoZones {
            soil: self.soil.map(f),
            zones: self.zones.map(f),
            radius: f(self.radius),
            torque_arm: f(self.torque_arm),
            width: f(self.width),
        }
    }

    pub(super) fn apex(&self, entry: T) -> T {
        self.zones.places(entry).apex
    }

    /// The soil under a contact that ends at the bottom.
    fn soil_under(&self, entry: T) -> Soil<T> {
        let (sin, _) = entry.sin_cos();
        self.soil.under(self.radius * sin)
    }

    /// E with its sign.
    fn mobilised(&self, at: &Places<T>, angle: T) -> T {
        let per_modulus = self.radius / self.soil.strength.modulus;
        let j = self.zones.displacement(at, angle);
        self.soil.strength.signed(per_modulus * j)
    }

    pub(super) fn sums(&self, entry: T) -> Sums<T> {
        let soil = self.soil_under(entry);
        let at = self.zones.places(entry);
        let turn = self.zones.turn(&at);
        let pieces = self.map(T::primal).pieces(&at.map(T::primal), turn);
        let d = (entry - at.apex) / entry;
        let half_d = d * 0.5;
        let zero = T::zero();
        let (mut load, mut thrust, mut compaction, mut shear) = (zero, zero, zero, zero);
        let branches = [(entry, at.apex - entry), (zero, at.apex)];
        for ((start, step), pieces) in branches.into_iter().zip(&pieces) {
            let base = |u: T| self.radius * depth_base(entry, d, half_d * u);
            soil.each_node(pieces, step.abs(), base, |u, normal, plain| {
                let angle = start + step * u;
                let (sin, cos) = angle.sin_cos();
                let strength = normal * soil.strength.tan_friction + plain * soil.strength.cohesion;
                let tau = strength * self.mobilised(&at, angle);
                load += normal * cos + tau * sin;
                thrust += tau * cos;
                compaction += normal * sin;
                shear += tau;
            });
        }
        let area = self.radius * self.width;
        Sums {
            load: load * area,
            thrust: thrust * area,
            compaction: compaction * area,
            torque: shear * area * self.torque_arm,
            ..Sums::zero()
        }
    }
}

impl<P: Root> TwoZones<P> {
    fn pieces(&self, at: &Places<P>, turn: Option<P>) -> [Pieces<P>; 2] {
        let (zero, one) = (P::zero(), P::one());
        let Places {
            entry,
            meeting,
            apex,
            ..
        } = *at;
        let per_modulus = self.radius / self.soil.strength.modulus;
        // |dj/dθ|/K is largest at an end of a zone.
        let slopes = |angle: P| {
            self.zones
                .growths(at, angle)
                .map(|x| (x * per_modulus).abs())
        };
        let [ahead, _] = slopes(entry);
        let [above, below] = slopes(meeting);
        let [_, behind] = slopes(zero);
        // Within the join θm lies apart from θ0, and a branch has some of the other zone.
        let other_ahead = apex.select_lt(meeting, below, zero);
        let other_behind = meeting.select_lt(apex, above, zero);
        let in_front_steep = ahead.max_of(above).max_of(other_ahead);
        let behind_steep = behind.max_of(below).max_of(other_behind);
        let (sin_half, _) = (entry * 0.5).sin_cos();
        let pressure = self.soil.steepness(self.radius * sin_half.squared() * 2.0);
        let in_front = |angle: P| (entry - angle) / (entry - apex);
        let branch = |along: P| {
            let mut pieces = Pieces::new(along.max_of(pressure));
            // Nearly locked, a zone begins with a layer, and θm is where it does.
            pieces.steep_end(along);
            pieces
        };
        let (mut front, mut rear) = (
            branch(in_front_steep * (entry - apex)),
            branch(behind_steep * apex),
        );
        for angle in [Some(meeting), turn].into_iter().flatten() {
            // Without a zone behind there is no bend.
            let none = angle.select_lt(entry * SMALLEST, apex, angle);
            front.bend_at(in_front(none));
            rear.bend_at(none / apex);
        }
        for bend in self.soil.bends().into_iter().flatten() {
            let (reached, angle) = angle_at_depth(entry, bend / self.radius);
            // Equal σ at equal u: the same place on both branches.
            let u = reached.select_lt(zero, one, in_front(angle));
            front.at(u);
            rear.at(u);
        }
        [front, rear]
    }
}

impl TwoZones<f64> {
    /// Stresses at one angle of the contact.
    pub(super) fn stress_at(&self, entry: f64, angle: f64) -> StressPoint {
        let soil = self.soil_under(entry);
        let at = self.zones.places(entry);
        let u = if angle >= at.apex {
            (entry - angle) / (entry - at.apex)
        } else {
            angle / at.apex
        };
        let u = u.clamp(0.0, 1.0);
        let d = (entry - at.apex) / entry;
        let depth = self.radius * u * depth_base(entry, d, 0.5 * d * u);
        let normal_stress = soil.normal_stress(depth);
        let strength = soil.strength.cohesion + normal_stress * soil.strength.tan_friction;
        StressPoint {
            angle,
            normal_stress,
            shear_stress: strength * self.mobilised(&at, angle),
            shear_arm: self.torque_arm,
        }
    }
}
