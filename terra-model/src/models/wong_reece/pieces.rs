//! Where a branch of the contact is integrated in more than one piece:
//!
//! - where the shear displacement changes its sign (braking): E has a kink in its second derivative there;
//! - where the shear stress saturates within a small part of the branch (small K, or a nearly locked wheel): pieces
//!   that grow by a factor of four resolve the layer at the entry;
//! - where that layer reaches past an apex close to the entry, behind it;
//! - where a stiffer layer of soil begins: its extra stress is integrated from there on, beside the rest.
//!
//! Where a piece ends carries no derivative, because the integrand is continuous there: all of this is in the primal.

use super::wheel::Wheel;
use crate::models::displacement::{displacement, sign_changes};
use crate::quadrature::rule;
use crate::real::{Real, Root};

/// Where the pieces of a branch end, and how steep the shear displacement (over K) is along it at most.
pub(super) struct Pieces<P> {
    pub(super) ends: [P; 3],
    steepness: P,
    /// A sign change lies inside, which has a layer on both its sides.
    dense: bool,
}

/// d(j/K)/du above which the layer at the entry gets its own pieces.
const STEEP: f64 = 6.0;
/// The same on the rear branch, whose nodes are close together at the apex, where its layer would be.
const STEEP_BEHIND: f64 = 20.0;
/// j/K at the apex from which nothing of the layer is left behind it.
const SATURATED: f64 = 25.0;
/// j/K at the end of the first of those pieces.
const FIRST_PIECE: f64 = 4.0;
/// A piece shorter than this share of a branch holds less than rounding.
const NEGLIGIBLE: f64 = 1e-9;

impl<P: Root> Wheel<P> {
    /// Where the pieces of the front and the rear branch end.
    pub(super) fn pieces(&self, entry: P) -> [Pieces<P>; 2] {
        let one = P::one();
        let (exit, apex) = (self.exit(entry), self.apex(entry));
        let i = self.ground.slip;
        // |dj/dθ|/K is largest at an end of the front branch.
        let slope = |angle: P| {
            let (sin_half, _) = (angle * 0.5).sin_cos();
            ((i + (one - i) * sin_half.squared() * 2.0) * self.shear_radius
                / self.ground.shear_modulus)
                .abs()
        };
        let steep = slope(entry).max_of(slope(apex)).max_of(slope(P::zero()));
        let (front_steep, rear_steep) = (steep * (entry - apex), steep * (apex - exit));

        let usable = |u: P| {
            let small = u.select_lt(P::from(NEGLIGIBLE), one, u);
            one.select_lt(small, one, small)
        };
        let first = |steepness: P| {
            usable(P::from(STEEP).select_lt(steepness, P::from(FIRST_PIECE) / steepness, one))
        };
        let in_front = |angle: P| usable((entry - angle) / (entry - apex));
        let behind = |angle: P| usable((angle - exit) / (apex - exit));
        let [ahead, back] = if self.braking {
            sign_changes(self.ground.slip, entry, exit)
        } else {
            [entry, exit]
        };
        let front = [in_front(ahead), in_front(back)];
        let rear = [behind(ahead), behind(back)];
        let dense = |breaks: [P; 2]| breaks.iter().any(|u| u.any_lt(one));
        let at_apex = displacement(i, entry, apex) * self.shear_radius / self.ground.shear_modulus;
        let left = rear_steep.select_lt(P::from(STEEP_BEHIND), P::from(SATURATED), at_apex.abs());
        let layered = left.any_lt(P::from(SATURATED));
        let rear_first = if dense(rear) {
            first(rear_steep)
        } else {
            left.select_lt(P::from(SATURATED), first(rear_steep), one)
        };
        [
            Pieces {
                ends: sorted(front[0], front[1], first(front_steep)),
                steepness: front_steep,
                dense: dense(front),
            },
            Pieces {
                ends: sorted(rear[0], rear[1], rear_first),
                steepness: rear_steep,
                dense: dense(rear) || layered,
            },
        ]
    }

    /// u at which the depth reaches `depth`; 1 where the contact stays above it.
    pub(super) fn layer_begins(&self, entry: P, depth: P) -> P {
        let (sin_half, _) = (entry * 0.5).sin_cos();
        // sin²(θ/2) = sin²(θ1/2) - z/2R, and θ by its tangent.
        let squared = sin_half.squared() - depth / (self.radius * 2.0);
        let held = squared.max_of(P::zero());
        let angle = (held / (P::one() - held)).sqrt().atan() * 2.0;
        let u = (entry - angle) / (entry - self.apex(entry));
        squared.select_lt(
            P::zero(),
            P::one(),
            u.min_of(P::one()).max_of(P::from(NEGLIGIBLE)),
        )
    }
}

impl<P: Root> Pieces<P> {
    /// The pieces of both branches at once: each ends where either of them does.
    pub(super) fn united(branches: [Pieces<P>; 2]) -> ([P; 6], Pieces<P>) {
        let [front, rear] = branches;
        let ([a, b, c], [d, e, f]) = (front.ends, rear.ends);
        let mut ends = [a, b, c, d, e, f];
        for last in (1..ends.len()).rev() {
            for k in 0..last {
                let (low, high) = (ends[k].min_of(ends[k + 1]), ends[k].max_of(ends[k + 1]));
                (ends[k], ends[k + 1]) = (low, high);
            }
        }
        let both = Pieces {
            ends: front.ends,
            steepness: front.steepness.max_of(rear.steepness),
            dense: front.dense || rear.dense,
        };
        (ends, both)
    }

    /// Starts and lengths of the pieces of [low, high], low > 0, short enough for u^n and for the layers of E.
    pub(super) fn each_part(&self, low: P, high: P, mut visit: impl FnMut(P, P)) {
        if !low.any_lt(high) {
            return;
        }
        // In another lane there may be nothing left.
        let high = high.max_of(low);
        let ratio = high / low;
        let growing = ratio.max_lane().ln() / 4.0_f64.ln();
        let dense = if self.dense {
            ((high - low) * self.steepness / 8.0).max_lane().min(32.0)
        } else {
            0.0
        };
        let count = growing.max(dense).ceil().clamp(1.0, 64.0) as usize;
        if count == 1 {
            visit(low, high - low);
            return;
        }
        let factor = (ratio.ln() / count as f64).exp();
        let mut start = low;
        for k in 1..=count {
            let end = if k == count { high } else { start * factor };
            visit(start, end - start);
            start = end;
        }
    }

    /// Nodes and weights on the pieces of [low, high].
    pub(super) fn each_node<const ORDER: usize>(
        &self,
        low: P,
        high: P,
        mut visit: impl FnMut(P, P),
    ) {
        let rule = rule::<ORDER>();
        self.each_part(low, high, |start, length| {
            for q in 0..ORDER {
                visit(start + length * rule.nodes[q], length * rule.weights[q]);
            }
        });
    }
}

/// Three numbers in rising order.
fn sorted<P: Real>(a: P, b: P, c: P) -> [P; 3] {
    let (low, high) = (a.min_of(b), a.max_of(b));
    let middle = high.min_of(c);
    [low.min_of(middle), low.max_of(middle), high.max_of(c)]
}
