//! What every wheel of the slots shares: the soil under it and the forces that come out.

use super::pieces::PowerRule;
use super::pieces::{Node, Pieces};
use super::pressure::{Layer, Pressure};
use super::shear::Strength;
use crate::real::{Real, Root};

/// Forces of the ground for one entry angle: N, N m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums<T> {
    pub(super) load: T,
    pub(super) thrust: T,
    /// Of lugs that push.
    pub(super) lug_thrust: T,
    pub(super) compaction: T,
    pub(super) bulldozing: T,
    pub(super) torque: T,
    /// To the left.
    pub(super) lateral: T,
}

impl<T: Real> Sums<T> {
    pub(super) fn zero() -> Self {
        let zero = T::zero();
        Sums {
            load: zero,
            thrust: zero,
            lug_thrust: zero,
            compaction: zero,
            bulldozing: zero,
            torque: zero,
            lateral: zero,
        }
    }
}

/// Pressure and shear laws with the layers below, ready for integration.
#[derive(Clone, Copy)]
pub(super) struct Soil<T> {
    pub(super) pressure: Pressure<T>,
    pub(super) layers: [Option<Layer<T>>; 2],
    pub(super) strength: Strength<T>,
    rule: PowerRule<T>,
}

impl<T: Real> Soil<T> {
    pub(super) fn new(
        pressure: Pressure<T>,
        layers: [Option<Layer<T>>; 2],
        strength: Strength<T>,
        quick: bool,
    ) -> Self {
        Soil {
            rule: PowerRule::new(pressure.exponent(), quick),
            pressure,
            layers,
            strength,
        }
    }

    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Soil<S> {
        Soil {
            pressure: self.pressure.map(f),
            layers: self.layers.map(|l| l.map(|l| l.map(f))),
            strength: self.strength.map(f),
            rule: self.rule.map(f),
        }
    }

    /// The soil under a contact of this length.
    pub(super) fn under(&self, length: T) -> Self {
        Soil {
            pressure: self.pressure.under(length),
            ..*self
        }
    }

    /// Normal stress at a depth below the surface that the wheel meets.
    pub(super) fn normal_stress(&self, depth: T) -> T {
        let zero = T::zero();
        // 0^n is not for logarithms.
        let tiny = T::from(f64::MIN_POSITIVE);
        let stress = tiny.select_lt(depth, self.pressure.at(depth.max_of(tiny)), zero);
        self.extra(stress, depth)
    }

    fn extra(&self, stress: T, depth: T) -> T {
        let floor = self.pressure.floor();
        self.layers
            .iter()
            .flatten()
            .fold(stress, |sum, layer| sum + layer.extra(depth + floor))
    }

    /// Depths below the surface that the wheel meets at which the pressure has a bend.
    pub(super) fn bends(&self) -> [Option<T>; 3] {
        let floor = self.pressure.floor();
        let [a, b] = self.layers.map(|l| l.map(|l| l.depth - floor));
        [self.pressure.bend(), a, b]
    }

    /// σ dθ and dθ of every node of a branch of this length, with its u.
    pub(super) fn each_node(
        &self,
        pieces: &Pieces<T::Primal>,
        length: T,
        depth_base: impl Fn(T) -> T,
        mut visit: impl FnMut(T, T, T),
    ) where
        T: Real,
    {
        let m = self.pressure.exponent();
        pieces.each_node(m, &self.rule, |node: Node<T>| {
            let base = depth_base(node.u);
            let (u, depth) = (node.u, base * node.u);
            let stress = if node.over_power {
                self.pressure.over_power(base, u)
            } else {
                self.pressure.at(depth)
            };
            let extra = self.extra(T::zero(), depth);
            let normal = stress * node.normal + extra * node.plain;
            visit(u, normal * length, node.plain * length);
        });
    }

    /// How steep the pressure law is at most along a branch that ends at this depth.
    pub(super) fn steepness(&self, depth: T) -> T {
        self.pressure
            .length()
            .map_or_else(T::zero, |length| depth / length)
    }
}

/// (cos θ - cos θ1)/u at θ = θ1 (1 - 2 half), u = 2 half/d: depth over R without its factor u.
pub(super) fn depth_base<T: Real>(entry: T, d: T, half: T) -> T {
    use crate::quadrature::sinc;
    (T::one() - half) * sinc(entry * (T::one() - half)) * sinc(entry * half) * d * entry.squared()
}

/// Angle at which a contact of this entry angle reaches a depth (over R); none where it stays above.
pub(super) fn angle_at_depth<P: Root>(entry: P, depth: P) -> (P, P) {
    let (sin_half, _) = (entry * 0.5).sin_cos();
    // sin²(θ/2) = sin²(θ1/2) - z/2R, and θ by its tangent.
    let squared = sin_half.squared() - depth * 0.5;
    let held = squared.max_of(P::zero());
    let angle = (held / (P::one() - held)).sqrt().atan() * 2.0;
    (squared, angle)
}
