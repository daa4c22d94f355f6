//! Quadrature along one branch of a contact for any pressure law.
//!
//! # Equation
//! ∫ f(u) du over \[0, 1\], u = 0 where the contact ends. The first piece, up to the first break, has weights for u^m times
//! a polynomial, where σ ~ u^m; the others are Gauss-Legendre pieces whose lengths grow by a factor of four, so that u^m,
//! the layer of the shear law at the entry and that of the pressure law are resolved together. Breaks lie where the
//! integrand has a bend: a change of sign of the shear displacement, a layer of soil, the floor of a rut.
//!
//! Where a piece ends carries no derivative, because the integrand is continuous there.

use super::{NODES, QUICK_NODES};
use crate::quadrature::{Rule, lifted_power_weights, rule};
use crate::real::{Real, Root};

/// A break nearer to the end than this share of a branch holds less than rounding.
pub(super) const NEGLIGIBLE: f64 = 1e-9;
/// Steepness above which the layer at the entry gets its own pieces.
const STEEP: f64 = 6.0;
/// What the steep quantity reaches at the end of the first of those.
const FIRST_PIECE: f64 = 4.0;
/// What it may change by within a piece around a bend.
const PER_PIECE: f64 = 8.0;

/// Steepness above which a rear branch, whose nodes are close together at the apex, does not resolve a layer there.
const STEEP_BEHIND: f64 = 20.0;
/// j/K at the apex from which nothing of the layer is left behind it.
const SATURATED: f64 = 25.0;

/// Most breaks of one branch.
const BREAKS: usize = 11;

/// The breaks of a branch in rising order, 1 where there are no more.
#[derive(Clone, Copy)]
pub(super) struct Pieces<P> {
    ends: [P; BREAKS],
    found: usize,
    /// How much the steepest dimensionless quantity changes along the branch.
    steepness: P,
    dense: bool,
}

/// One node: its place, its weight for σ/u^m where the piece has one, else for σ, and its weight for all else.
#[derive(Clone, Copy)]
pub(super) struct Node<T> {
    pub(super) u: T,
    pub(super) normal: T,
    pub(super) plain: T,
    /// σ is wanted over u^m.
    pub(super) over_power: bool,
}

/// The nodes of every piece, and the weights for u^m on the first.
#[derive(Clone, Copy)]
pub(super) struct PowerRule<T> {
    rule: &'static Rule,
    order: usize,
    /// As many as the order.
    power: [T; NODES],
}

impl<T: Real> PowerRule<T> {
    /// `quick`: the short rule.
    pub(super) fn new(exponent: T, quick: bool) -> Self {
        if !quick {
            return PowerRule {
                rule: rule::<NODES>(),
                order: NODES,
                power: lifted_power_weights(exponent),
            };
        }
        let few: [T; QUICK_NODES] = lifted_power_weights(exponent);
        let mut power = [T::zero(); NODES];
        power[..QUICK_NODES].copy_from_slice(&few);
        PowerRule {
            rule: rule::<QUICK_NODES>(),
            order: QUICK_NODES,
            power,
        }
    }

    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S) -> PowerRule<S> {
        PowerRule {
            rule: self.rule,
            order: self.order,
            power: self.power.map(f),
        }
    }

    /// Places, plain weights and weights for u^m.
    fn nodes(&self) -> impl Iterator<Item = ((f64, f64), T)> {
        self.plain().zip(self.power)
    }

    /// Places and plain weights.
    fn plain(&self) -> impl Iterator<Item = (f64, f64)> + use<T> {
        let pairs = self.rule.nodes.iter().zip(&self.rule.weights);
        pairs.map(|(x, w)| (*x, *w)).take(self.order)
    }
}

impl<P: Root> Pieces<P> {
    /// A branch along which dimensionless quantities (shear displacement over K, depth over a length of the pressure
    /// law) change by at most `steepness`.
    pub(super) fn new(steepness: P) -> Self {
        let one = P::one();
        let mut pieces = Pieces {
            ends: [one; BREAKS],
            found: 0,
            steepness,
            dense: false,
        };
        pieces.at(P::from(STEEP).select_lt(steepness, P::from(FIRST_PIECE) / steepness, one));
        pieces
    }

    /// Adds a break; one outside (0, 1) is none.
    pub(super) fn at(&mut self, u: P) {
        let one = P::one();
        let small = u.select_lt(P::from(NEGLIGIBLE), one, u);
        let mut next = one.select_lt(small, one, small);
        for end in &mut self.ends {
            let (low, high) = (end.min_of(next), end.max_of(next));
            (*end, next) = (low, high);
        }
        self.found += 1;
        debug_assert!(self.found <= BREAKS);
    }

    /// Adds a break with steep changes on both its sides.
    pub(super) fn bend_at(&mut self, u: P) {
        self.at(u);
        self.dense = self.dense || (P::from(NEGLIGIBLE).any_lt(u) && u.any_lt(P::one()));
    }

    /// The layer of shear at the entry reaches past the apex, where j/K is `there`, onto this branch.
    pub(super) fn layered_behind(&mut self, there: P) {
        self.dense = self.dense
            || (P::from(STEEP_BEHIND).any_lt(self.steepness) && there.any_lt(P::from(SATURATED)));
    }

    /// Adds pieces that shrink towards u = 1, where the steep quantity has a layer too.
    pub(super) fn steep_end(&mut self, steepness: P) {
        let one = P::one();
        for reach in [FIRST_PIECE, 4.0 * FIRST_PIECE, 16.0 * FIRST_PIECE] {
            let u = one - P::from(reach) / steepness;
            self.at(P::from(STEEP).select_lt(steepness, u, one));
        }
    }

    /// All nodes of the branch in u, those of the first piece for u^m.
    pub(super) fn each_node<T: Real<Primal = P>>(
        &self,
        exponent: T,
        rule: &PowerRule<T>,
        mut visit: impl FnMut(Node<T>),
    ) {
        let one = P::one();
        let first = self.ends[0];
        let whole = !first.any_lt(one);
        let first_t = T::from_primal(first);
        let scale = if whole {
            T::one()
        } else {
            first_t.pow_pos(exponent) * first_t
        };
        for ((x, w), power) in rule.nodes() {
            visit(Node {
                u: first_t * x,
                // σ/u^m at u = first x, times first^(m + 1) x^m
                normal: scale * power,
                plain: first_t * w,
                over_power: true,
            });
        }
        if whole {
            return;
        }
        for pair in self.ends.windows(2) {
            if let &[low, high] = pair {
                self.plain_nodes(low, high, rule, &mut visit);
            }
        }
        self.plain_nodes(self.ends[BREAKS - 1], one, rule, &mut visit);
    }

    fn plain_nodes<T: Real<Primal = P>>(
        &self,
        low: P,
        high: P,
        rule: &PowerRule<T>,
        visit: &mut impl FnMut(Node<T>),
    ) {
        if !low.any_lt(high) {
            return;
        }
        let ratio = high / low;
        let growing = ratio.max_lane().ln() / 4.0_f64.ln();
        let dense = if self.dense {
            ((high - low) * self.steepness / PER_PIECE)
                .max_lane()
                .min(32.0)
        } else {
            0.0
        };
        let count = growing.max(dense).ceil().clamp(1.0, 64.0) as usize;
        let factor = (ratio.ln() / count as f64).exp();
        let mut start = low;
        for k in 1..=count {
            let end = if k == count { high } else { start * factor };
            for (x, w) in rule.plain() {
                let weight = T::from_primal((end - start) * w);
                visit(Node {
                    u: T::from_primal(start + (end - start) * x),
                    normal: weight,
                    plain: weight,
                    over_power: false,
                });
            }
            start = end;
        }
    }
}
