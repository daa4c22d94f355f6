//! How far soil is sheared under a rigid rim, and where that changes its sign.

use crate::quadrature::{sine_defects, t_minus_sin};
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
    let past = P::one() - i;
    // tan²(θc/2) = (1 - cos θc)/(1 + cos θc) = -i/(2 - i)
    let turn = (-i / (past + 1.0)).sqrt().atan() * 2.0;
    let (upper, lower) = (turn.min_of(entry), (-turn).max_of(exit));
    let (entry_defect, _) = sine_defects(entry);
    let j = |angle: P| {
        let (defect, versine) = sine_defects(angle);
        let j = i * (entry - angle) + past * (entry_defect - defect);
        (j, -(i + past * versine))
    };
    // j = 0 where (sin θ1 - sin θ)/(θ1 - θ) = 1/(1 - i), that is θ1² + θ1 θ + θ² = -6 i/(1 - i) for small angles.
    let apart = (entry * entry * -0.75 - i / past * 6.0).max_of(zero).sqrt();
    let search = |start: P, mut negative: P, mut positive: P| {
        // Newton inside the bracket; where the slope vanishes with j, halving is exact enough: E is flat there.
        let (low, high) = (negative.min_of(positive), negative.max_of(positive));
        let mut angle = start.max_of(low).min_of(high);
        for _ in 0..10 {
            let (j, slope) = j(angle);
            negative = j.select_lt(zero, angle, negative);
            positive = j.select_lt(zero, positive, angle);
            let middle = (negative + positive) * 0.5;
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
    let (lowest, _) = j(lower);
    // Up to θc it is negative from the entry on.
    let within = turn.select_lt(entry, lowest, zero);
    let ahead = if within.any_lt(zero) {
        let found = search(entry * -0.5 + apart, lower, upper);
        within.select_lt(zero, found, entry)
    } else {
        entry
    };
    let back = if exit.any_lt(-turn) {
        let opens = zero.select_lt(j(exit).0, lowest, zero);
        let found = search(entry * -0.5 - apart, lower, exit);
        opens.select_lt(zero, found, exit)
    } else {
        exit
    };
    [ahead, back]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against halving, for every slip, entry angle and exit: both places to the stated share of θ1, and j is negative between
    /// them alone.
    #[test]
    fn changes_of_sign_lie_where_halving_finds_them() {
        for k in 1..40 {
            let slip = -0.025 * f64::from(k) * 1.3;
            for n in 1..32 {
                let entry = 0.05 * f64::from(n);
                for exit in [0.0, -0.3 * entry, -0.9 * entry] {
                    let j = |angle: f64| displacement(slip, entry, angle);
                    let [ahead, back] = sign_changes(slip, entry, exit);
                    let (mut first, mut last) = (entry, exit);
                    // The first angle below the entry at which j turns negative, by a dense scan, then by halving.
                    let steps = 4000;
                    let at = |q: i32| entry + (exit - entry) * f64::from(q) / f64::from(steps);
                    let negative: Vec<i32> = (1..=steps).filter(|q| j(at(*q)) < 0.0).collect();
                    let halve = |mut yes: f64, mut no: f64| {
                        for _ in 0..60 {
                            let middle = 0.5 * (yes + no);
                            if j(middle) < 0.0 {
                                yes = middle;
                            } else {
                                no = middle;
                            }
                        }
                        yes
                    };
                    let (Some(&from), Some(&to)) = (negative.first(), negative.last()) else {
                        assert!((ahead - entry).abs() < 1e-3 * entry || ahead <= back + 1e-3);
                        continue;
                    };
                    if from > 1 {
                        first = halve(at(from), at(from - 1));
                    }
                    if to < steps {
                        last = halve(at(to), at(to + 1));
                    }
                    // Where both lie close, j is flat and the place of no weight.
                    let close = if to - from < 40 { 1e-2 } else { 2e-5 };
                    assert!(
                        (ahead - first).abs() < close * entry,
                        "{slip} {entry} {exit}: {ahead} {first}"
                    );
                    assert!(
                        (back - last).abs() < close * entry,
                        "{slip} {entry} {exit}: {back} {last}"
                    );
                }
            }
        }
    }
}
