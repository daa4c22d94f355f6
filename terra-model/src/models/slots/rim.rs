//! Normal and shear stress on the rim, with an apex that moves with slip (Wong and Reece), for any pressure and shear law.
//!
//! # Equation
//! As the plain Wong-Reece wheel: both branches have the same σ at equal u, θF = θ1 - u (θ1 - θm), θB = θ2 + u (θm - θ2),
//! j(θ) = R \[(θ1 - θ) - (1 - i)(sin θ1 - sin θ)\], W = R b ∫(σ cos θ + τ sin θ) dθ, D = R b ∫(τ cos θ - σ sin θ) dθ,
//! T = R² b ∫ τ dθ.

use super::contact_state::{Soil, Sums, angle_at_depth, depth_base};
use super::pieces::Pieces;
use super::pushed::{Lugs, Side};
use crate::lugs::LugPhase;
use crate::models::displacement::{displacement, sign_changes};
use crate::real::{Real, Root};
use crate::stress::StressPoint;

/// The equations, for whoever looks them up by name.
pub(super) const EQUATION: &str = "\
As the plain Wong-Reece wheel: both branches have the same σ at equal u, θF = θ1 - u (θ1 - θm), θB = θ2 + u (θm - θ2),
j(θ) = R [(θ1 - θ) - (1 - i)(sin θ1 - sin θ)], W = R b ∫(σ cos θ + τ sin θ) dθ, D = R b ∫(τ cos θ - σ sin θ) dθ,
T = R² b ∫ τ dθ.";

/// Everything but the entry angle.
#[derive(Clone, Copy)]
pub(super) struct Rim<T> {
    pub(super) soil: Soil<T>,
    /// Kinematic slip.
    pub(super) slip: T,
    pub(super) apex_ratio: T,
    pub(super) exit_ratio: T,
    /// Radius that meets the soil, that shears it, and arm of the torque.
    pub(super) radius: T,
    pub(super) shear_radius: T,
    pub(super) torque_arm: T,
    pub(super) width: T,
    /// tan β of a sideways slip that the shear stress follows.
    pub(super) turned: Option<T>,
    pub(super) lugs: Option<Lugs<T>>,
    pub(super) side: Option<Side<T>>,
}

impl<T: Real> Rim<T> {
    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Rim<S> {
        Rim {
            soil: self.soil.map(f),
            slip: f(self.slip),
            apex_ratio: f(self.apex_ratio),
            exit_ratio: f(self.exit_ratio),
            radius: f(self.radius),
            shear_radius: f(self.shear_radius),
            torque_arm: f(self.torque_arm),
            width: f(self.width),
            turned: self.turned.map(f),
            lugs: self.lugs.map(|l| l.map(f)),
            side: self.side.map(|s| s.map(f)),
        }
    }

    pub(super) fn apex(&self, entry: T) -> T {
        self.apex_ratio * entry
    }

    pub(super) fn exit(&self, entry: T) -> T {
        -(self.exit_ratio * entry)
    }

    /// E along the wheel and across it.
    fn mobilised(&self, entry: T, angle: T) -> (T, T) {
        let strength = &self.soil.strength;
        let per_modulus = self.shear_radius / strength.modulus;
        let y = per_modulus * displacement(self.slip, entry, angle);
        match self.turned {
            None => {
                let e = strength.mobilised(y.abs());
                (y.select_lt(T::zero(), -e, e), T::zero())
            }
            Some(tan) => {
                let across = per_modulus * (T::one() - self.slip) * (entry - angle) * tan;
                let both = (y.squared() + across.squared() + f64::MIN_POSITIVE).sqrt();
                let e = strength.mobilised(both);
                (e * (y / both), e * (across / both))
            }
        }
    }

    fn contact_length(&self, entry: T) -> T {
        let (front, _) = entry.sin_cos();
        let (rear, _) = self.exit(entry).sin_cos();
        self.radius * (front - rear)
    }

    pub(super) fn sums(&self, entry: T) -> Sums<T> {
        let soil = self.soil.under(self.contact_length(entry));
        let (exit, apex) = (self.exit(entry), self.apex(entry));
        let pieces = self.map(T::primal).pieces(entry.primal());
        let d = T::one() - self.apex_ratio;
        let half_d = d * 0.5;
        let zero = T::zero();
        let (mut load, mut thrust, mut compaction, mut shear, mut lateral) =
            (zero, zero, zero, zero, zero);
        // Lugs and flank, beside what acts on the rim.
        let (mut lug_load, mut lug_thrust, mut lug_moment, mut flank) = (zero, zero, zero, zero);
        let branches = [(entry, apex - entry), (exit, apex - exit)];
        for ((start, step), pieces) in branches.into_iter().zip(&pieces) {
            let base = |u: T| self.radius * depth_base(entry, d, half_d * u);
            soil.each_node(pieces, step.abs(), base, |u, normal, plain| {
                let angle = start + step * u;
                let (sin, cos) = angle.sin_cos();
                load += normal * cos;
                compaction += normal * sin;
                let (along, across) = self.mobilised(entry, angle);
                let strength = normal * soil.strength.tan_friction + plain * soil.strength.cohesion;
                let tau = strength * along;
                load += tau * sin;
                thrust += tau * cos;
                shear += tau;
                lateral += strength * across;
                if let Some(lugs) = &self.lugs {
                    let (force, moment) = lugs.push(normal, plain);
                    lug_load += force * along * sin;
                    lug_thrust += force * along * cos;
                    lug_moment += (force * self.torque_arm + moment) * along;
                }
                if let Some(side) = &self.side {
                    let way = self.shear_radius * (T::one() - self.slip) * (entry - angle);
                    lateral += strength * side.mobilised(&soil.strength, way);
                    let depth = base(u) * u;
                    flank += side.push(depth) * (self.radius - depth * cos) * plain;
                }
            });
        }
        let area = self.radius * self.width;
        Sums {
            load: load * area + lug_load * self.width,
            thrust: thrust * area,
            lug_thrust: lug_thrust * self.width,
            compaction: compaction * area,
            bulldozing: zero,
            torque: shear * area * self.torque_arm + lug_moment * self.width,
            // A wheel that slides to the left is pushed to the right.
            lateral: -(lateral * area + flank),
        }
    }
}

impl<P: Root> Rim<P> {
    fn pieces(&self, entry: P) -> [Pieces<P>; 2] {
        let one = P::one();
        let (exit, apex) = (self.exit(entry), self.apex(entry));
        let i = self.slip;
        let per_modulus = self.shear_radius / self.soil.strength.modulus;
        // |dj/dθ|/K is largest at an end of a branch or at the bottom.
        let slope = |angle: P| {
            let (sin_half, _) = (angle * 0.5).sin_cos();
            ((i + (one - i) * sin_half.squared() * 2.0) * per_modulus).abs()
        };
        let steep = slope(entry).max_of(slope(apex)).max_of(slope(P::zero()));
        let (sin_half, _) = (entry * 0.5).sin_cos();
        let deepest = self.radius * sin_half.squared() * 2.0;
        let pressure = self.soil.steepness(deepest);
        let [ahead, back] = if i.any_lt(P::zero()) {
            sign_changes(self.slip, entry, exit)
        } else {
            [entry, exit]
        };
        let in_front = |angle: P| (entry - angle) / (entry - apex);
        let behind = |angle: P| (angle - exit) / (apex - exit);
        let mut front = Pieces::new((steep * (entry - apex)).max_of(pressure));
        let mut rear = Pieces::new((steep * (apex - exit)).max_of(pressure));
        let at_apex = displacement(i, entry, apex) * per_modulus;
        rear.layered_behind(at_apex.abs());
        for angle in [ahead, back] {
            front.bend_at(in_front(angle));
            rear.bend_at(behind(angle));
        }
        for bend in self.soil.bends().into_iter().flatten() {
            let (reached, angle) = angle_at_depth(entry, bend / self.radius);
            // Equal σ at equal u: the same place on both branches.
            let u = reached.select_lt(P::zero(), one, in_front(angle));
            front.at(u);
            rear.at(u);
        }
        [front, rear]
    }
}

impl Rim<f64> {
    /// What the lugs push during the passage of one; none without lugs, or with none of them.
    pub(super) fn lug_cycle(&self, entry: f64, moments: usize) -> Option<Vec<LugPhase>> {
        let lugs = self.lugs.filter(|l| l.count > 0.0)?;
        let exit = self.exit(entry);
        let apart = std::f64::consts::TAU / lugs.count;
        let cycle = (0..moments).map(|k| {
            let phase = apart * (k as f64 + 0.5) / moments as f64;
            let mut now = LugPhase {
                phase,
                pull: 0.0,
                torque: 0.0,
                load: 0.0,
            };
            // The lug that left last is past the exit by the phase; the next one is that much short of one spacing from it.
            let mut angle = exit + apart - phase;
            while angle < entry {
                let normal = self.stress_at(entry, angle).normal_stress;
                let (along, _) = self.mobilised(entry, angle);
                // Of one lug: what the mean spreads over its spacing.
                let (force, moment) = lugs.push(normal, 1.0);
                let share = apart * self.width * along;
                let (sin, cos) = angle.sin_cos();
                now.pull += force * share * cos;
                now.load += force * share * sin;
                now.torque += (force * self.torque_arm + moment) * share;
                angle += apart;
            }
            now
        });
        Some(cycle.collect())
    }

    /// Stresses at one angle of the contact.
    pub(super) fn stress_at(&self, entry: f64, angle: f64) -> StressPoint {
        let soil = self.soil.under(self.contact_length(entry));
        let (exit, apex) = (self.exit(entry), self.apex(entry));
        let u = if angle >= apex {
            (entry - angle) / (entry - apex)
        } else {
            (angle - exit) / (apex - exit)
        };
        let u = u.clamp(0.0, 1.0);
        let d = 1.0 - self.apex_ratio;
        let depth = self.radius * u * depth_base(entry, d, 0.5 * d * u);
        let normal_stress = soil.normal_stress(depth);
        let (along, _) = self.mobilised(entry, angle);
        let strength = soil.strength.cohesion + normal_stress * soil.strength.tan_friction;
        // Per angle and width: what the rim shears, and what the lugs push in the mean over their places.
        let rim = strength * self.radius;
        let (push, moment) = self
            .lugs
            .map_or((0.0, 0.0), |lugs| lugs.push(normal_stress, 1.0));
        let both = rim + push;
        StressPoint {
            angle,
            normal_stress,
            shear_stress: both / self.radius * along,
            shear_arm: if both > 0.0 {
                self.torque_arm + moment / both
            } else {
                self.torque_arm
            },
        }
    }
}
