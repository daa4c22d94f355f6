//! The stress integrals in any scalar, node by node: for contacts with a sideways slip. All others take
//! [`super::kernel`], many times as fast.

use super::wheel::{Integrals, Wheel};
use crate::quadrature::{lifted_power_weights, rule};
use crate::real::Real;
use crate::real::Root;

/// Nodes a piece.
const ORDER: usize = 12;

/// One branch of the contact.
#[derive(Clone, Copy)]
struct Branch<T> {
    /// Angle at u = 0.
    start: T,
    /// Angle at u = 1 less that at u = 0.
    step: T,
    /// Its magnitude.
    length: T,
}

impl<T: Real> Wheel<T> {
    fn branches(&self, entry: T) -> [Branch<T>; 2] {
        let (exit, apex) = (self.exit(entry), self.apex(entry));
        let (front, rear) = (entry - apex, apex - exit);
        [
            Branch {
                start: entry,
                step: -front,
                length: front,
            },
            Branch {
                start: exit,
                step: rear,
                length: rear,
            },
        ]
    }

    pub(super) fn integrals(&self, entry: T) -> Integrals<T> {
        let weights: [T; ORDER] = lifted_power_weights(self.ground.exponent);
        let zero = T::zero();
        let mut sum = Integrals {
            load: zero,
            thrust: zero,
            compaction: zero,
            shear: zero,
            lateral: zero,
        };
        let branches = self.branches(entry);
        let pieces = self.map(T::primal).pieces(entry.primal());
        let one = T::Primal::one();
        let whole = pieces.iter().all(|p| !p.ends[0].any_lt(one));

        // One piece a branch: both branches have the same normal stress at equal u.
        let n = self.ground.exponent;
        let scale = self.ground.stiffness * self.radius.pow_pos(n);
        let half_d = (T::one() - self.ground.apex_ratio) * 0.5;
        let rule = rule::<ORDER>();
        if whole {
            for (q, &power) in weights.iter().enumerate() {
                let u = rule.nodes[q];
                let sigma = scale * self.depth_base(entry, half_d * u).pow_pos(n) * power;
                for branch in &branches {
                    let angle = branch.start + branch.step * u;
                    self.add(
                        &mut sum,
                        entry,
                        angle,
                        sigma * branch.length,
                        branch.length * rule.weights[q],
                    );
                }
            }
        } else {
            for (branch, pieces) in branches.iter().zip(&pieces) {
                let first = T::from_primal(pieces.ends[0]);
                let first_scale = scale * first.pow_pos(n) * first * branch.length;
                for (q, &power) in weights.iter().enumerate() {
                    let u = first * rule.nodes[q];
                    let sigma = self.depth_base(entry, half_d * u).pow_pos(n) * power;
                    let angle = branch.start + branch.step * u;
                    self.add(
                        &mut sum,
                        entry,
                        angle,
                        sigma * first_scale,
                        first * branch.length * rule.weights[q],
                    );
                }
                let [a, b, c] = pieces.ends;
                for (low, high) in [(a, b), (b, c), (c, one)] {
                    pieces.each_node::<ORDER>(low, high, |u, weight| {
                        let (u, weight) =
                            (T::from_primal(u), T::from_primal(weight) * branch.length);
                        let sigma = scale * (self.depth_base(entry, half_d * u) * u).pow_pos(n);
                        self.add(
                            &mut sum,
                            entry,
                            branch.start + branch.step * u,
                            sigma * weight,
                            weight,
                        );
                    });
                }
            }
        }
        if let Some((depth, stiffness)) = self.layer {
            let begins = self
                .map(T::primal)
                .layer_begins(entry.primal(), depth.primal());
            for (branch, pieces) in branches.iter().zip(&pieces) {
                let [a, b, c] = pieces.ends.map(|end| end.max_of(begins));
                for (low, high) in [(begins, a), (a, b), (b, c), (c, one)] {
                    pieces.each_node::<ORDER>(low, high, |u, weight| {
                        let (u, weight) =
                            (T::from_primal(u), T::from_primal(weight) * branch.length);
                        let z = self.radius * u * self.depth_base(entry, half_d * u);
                        let extra = stiffness * (z - depth) * weight;
                        // The cohesion is in the main integral already.
                        self.add(
                            &mut sum,
                            entry,
                            branch.start + branch.step * u,
                            extra,
                            T::zero(),
                        );
                    });
                }
            }
        }
        sum
    }

    /// Adds one node: its weight with and without the normal stress.
    #[inline]
    fn add(&self, sum: &mut Integrals<T>, entry: T, angle: T, normal: T, weight: T) {
        let (sin, cos) = angle.sin_cos();
        sum.load += normal * cos;
        sum.compaction += normal * sin;
        let (along, across) = self.mobilised(entry, angle);
        let strength = normal * self.ground.tan_friction + weight * self.ground.cohesion;
        let tau = strength * along;
        sum.load += tau * sin;
        sum.thrust += tau * cos;
        sum.shear += tau;
        if self.lateral.is_some() {
            sum.lateral += strength * across;
        }
    }
}
