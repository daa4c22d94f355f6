//! How far soil is sheared under a rigid rim, and where that changes its sign.

use crate::quadrature::t_minus_sin;
use crate::real::{Real, Root};

/// How exactly a change of sign is placed, as a share of θ1: E's second derivative jumps there, which leaves the cube of
/// that, and the step that ends the search is squared once more.
const PLACED: f64 = 1e-5;

/// j/R at θ, without cancellation: i (θ1 - θ) + (1 - i)\[(θ1 - sin θ1) - (θ - sin θ)\], of the kinematic slip i.
#[inline]
pub(crate) fn displacement<T: Real>(slip: T, entry: T, angle: T) -> T {
    slip * (entry - angle) + (T::one() - slip) * (t_minus_sin(entry) - t_minus_sin(angle))
}

/// Braking: the angles between which the shear displacement is negative, entry and exit where there is no change.
///
/// j/R = f(θ1) - f(θ) with the odd f(θ) = θ - (1 - i) sin θ, which falls between ∓θc, cos θc = 1/(1 - i), and rises
/// outside: at most one zero inside and one below -θc.
pub(crate) fn sign_changes<P: Root>(slip: P, entry: P, exit: P) -> [P; 2] {
    let zero = P::zero();
    let i = slip.min_of(zero);
    // tan²(θc/2) = (1 - cos θc)/(1 + cos θc) = -i/(2 - i)
    let turn = (-i / (P::from(2.0) - i)).sqrt().atan() * 2.0;
    let (upper, lower) = (turn.min_of(entry), (-turn).max_of(exit));
    let search = |mut negative: P, mut positive: P| {
        // Newton inside the bracket; where the slope vanishes with j, halving is exact enough: E is flat there.
        let mut angle = (negative + positive) * 0.5;
        for _ in 0..10 {
            let j = displacement(slip, entry, angle);
            negative = j.select_lt(zero, angle, negative);
            positive = j.select_lt(zero, positive, angle);
            let middle = (negative + positive) * 0.5;
            let (sin_half, _) = (angle * 0.5).sin_cos();
            let slope = -(i + (P::one() - i) * sin_half.squared() * 2.0);
            let newton = angle - j / slope;
            let (low, high) = (negative.min_of(positive), negative.max_of(positive));
            // At the root itself the step ends on the bracket.
            let above = newton.select_lt(low, middle, newton);
            let next = high.select_lt(newton, middle, above);
            let step = (next - angle).abs();
            angle = next;
            if !(entry * PLACED).any_lt(step) {
                break;
            }
        }
        angle
    };
    let lowest = displacement(slip, entry, lower);
    let ahead = lowest.select_lt(zero, search(lower, upper), entry);
    let back = if exit.any_lt(-turn) {
        let opens = zero.select_lt(displacement(slip, entry, exit), lowest, zero);
        opens.select_lt(zero, search(lower, exit), exit)
    } else {
        exit
    };
    [ahead, back]
}
