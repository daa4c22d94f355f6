//! Quadrature for stresses that grow like u^n from the ends of the contact.
//!
//! The only factor that is not smooth is u^n with n from .1 to 1.6. Gauss-Legendre nodes on \[0, 1\] (the same for
//! every soil, so that soils can be lanes) get weights that integrate u^n times a polynomial exactly:
//!
//! w^σ_q = w_q Σ_k (2k+1) P*_k(u_q) M_k(n),   M_k = Π_{j<k}(n - j) / Π_{j<=k}(n + 1 + j),   P*_k(u) = P_k(2u - 1).

use std::num::NonZeroUsize;
use std::sync::OnceLock;

use gauss_quad::GaussLegendre;

use crate::lanes::Vector;
use crate::real::{Real, Root, is_plain};

/// The orders there are: nodes a piece of a branch.
pub(crate) const ORDERS: [usize; 8] = [2, 3, 5, 7, 8, 12, 16, 24];
const MOST: usize = 24;

/// Nodes and weights on \[0, 1\], and the table that turns moments of u^n into weights.
pub(crate) struct Rule {
    pub(crate) nodes: [f64; MOST],
    /// 1/u.
    pub(crate) inverse: [f64; MOST],
    pub(crate) weights: [f64; MOST],
    /// `basis[k][q]` = w_q (2k+1) P*_k(u_q).
    pub(crate) basis: [[f64; MOST]; MOST],
}

impl Rule {
    fn new(order: usize) -> Rule {
        let gauss = GaussLegendre::new(NonZeroUsize::new(order).unwrap_or(NonZeroUsize::MIN));
        let mut rule = Rule {
            nodes: [0.0; MOST],
            inverse: [0.0; MOST],
            weights: [0.0; MOST],
            basis: [[0.0; MOST]; MOST],
        };
        for (q, (x, w)) in gauss.as_node_weight_pairs().iter().enumerate() {
            let node = 0.5 * (1.0 + x);
            rule.nodes[q] = node;
            rule.inverse[q] = 1.0 / node;
            rule.weights[q] = 0.5 * w;
            let (mut before, mut current) = (0.0, 1.0);
            for k in 0..order {
                rule.basis[k][q] = rule.weights[q] * (2 * k + 1) as f64 * current;
                let kf = k as f64;
                let next = ((2.0 * kf + 1.0) * x * current - kf * before) / (kf + 1.0);
                (before, current) = (current, next);
            }
        }
        rule
    }
}

/// The rule of an order in [`ORDERS`], made once.
#[inline]
pub(crate) fn rule<const ORDER: usize>() -> &'static Rule {
    static RULES: [OnceLock<Rule>; ORDERS.len()] = [const { OnceLock::new() }; ORDERS.len()];
    const { assert!(position(ORDER) < ORDERS.len(), "no such order") };
    RULES[position(ORDER)].get_or_init(|| Rule::new(ORDER))
}

const fn position(order: usize) -> usize {
    let mut at = 0;
    while at < ORDERS.len() && ORDERS[at] != order {
        at += 1;
    }
    at
}

/// The moments M_k of u^n and their slopes in n.
fn moments<P: Root, const ORDER: usize>(n: P, slopes: bool) -> [(P, P); ORDER] {
    let mut moments = [(P::zero(), P::zero()); ORDER];
    let mut moment = P::one() / (n + 1.0);
    let mut slope = -(moment * moment);
    for (k, m) in moments.iter_mut().enumerate() {
        *m = (moment, slope);
        let (above, below) = (n - k as f64, n + (k as f64 + 2.0));
        let ratio = above / below;
        if slopes {
            // d(above/below)/dn = (below - above)/below² = (2k + 2)/below²
            let ratio_slope = (P::one() - ratio) / below;
            slope = slope * ratio + moment * ratio_slope;
        }
        moment *= ratio;
    }
    moments
}

/// The moment M of u^n of one order.
#[inline]
pub(crate) fn moment<P: Root, const ORDER: usize>(n: P) -> P {
    let (mut above, mut below) = (P::one(), n + 1.0);
    for k in 0..ORDER {
        above *= n - k as f64;
        below *= n + (k as f64 + 2.0);
    }
    above / below
}

/// Weights for u^n at the nodes, as many at once as there are nodes side by side: the first `ORDER/NODES_AT_ONCE` count.
#[inline]
pub(crate) fn power_weights<P: Root, const ORDER: usize>(n: P) -> [P::Nodes; ORDER] {
    let rule = rule::<ORDER>();
    let moments = moments::<P, ORDER>(n, false);
    std::array::from_fn(|chunk| {
        let q = chunk * P::NODES_AT_ONCE;
        let mut sum = P::Nodes::zero();
        if q < ORDER {
            for ((m, _), basis) in moments.iter().zip(&rule.basis) {
                sum = P::table(&basis[q..]).mul_add(m.spread(), sum);
            }
        }
        sum
    })
}

/// The slopes in n of [`power_weights`].
pub(crate) fn power_weight_slopes<P: Root, const ORDER: usize>(n: P) -> [P::Nodes; ORDER] {
    let rule = rule::<ORDER>();
    let moments = moments::<P, ORDER>(n, true);
    std::array::from_fn(|chunk| {
        let q = chunk * P::NODES_AT_ONCE;
        let mut sum = P::Nodes::zero();
        if q < ORDER {
            for ((_, slope), basis) in moments.iter().zip(&rule.basis) {
                sum = P::table(&basis[q..]).mul_add(slope.spread(), sum);
            }
        }
        sum
    })
}

/// Weights for u^n one by one, in any scalar: value and slope in the primal, which is exact for first derivatives.
pub(crate) fn lifted_power_weights<T: Real, const ORDER: usize>(n: T) -> [T; ORDER] {
    let rule = rule::<ORDER>();
    let moments = moments::<T::Primal, ORDER>(n.primal(), true);
    let dn = n - T::from_primal(n.primal());
    std::array::from_fn(|q| {
        let (mut value, mut slope) = (T::Primal::zero(), T::Primal::zero());
        for ((m, dm), basis) in moments.iter().zip(&rule.basis) {
            value += *m * basis[q];
            slope += *dm * basis[q];
        }
        dn.scaled(slope) + T::from_primal(value)
    })
}

/// 1/((2k+2)(2k+3)), k from 10 down to 1: t - sin t; the first left out is below 1e-19 at π/2.
const T_MINUS_SIN: [f64; 10] = inverse_products(2.0);
/// 1/((2k)(2k+1)), k from 10 down to 1: sin x / x.
const SINC: [f64; 10] = inverse_products(0.0);

const fn inverse_products(shift: f64) -> [f64; 10] {
    let mut out = [0.0; 10];
    let mut q = 0;
    while q < 10 {
        let k = (10 - q) as f64;
        out[q] = 1.0 / ((2.0 * k + shift) * (2.0 * k + shift + 1.0));
        q += 1;
    }
    out
}

/// 1 - y c_1 (1 - y c_2 (1 - ...)) and its slope in y.
#[inline]
fn nested<P: Root>(y: P, inverse: &[f64; 10]) -> (P, P) {
    let (mut sum, mut slope) = (P::one(), P::zero());
    for &c in inverse {
        slope = -(sum + y * slope) * c;
        sum = P::one() - y * sum * c;
    }
    (sum, slope)
}

/// A function of one variable in any scalar from its value and slope in the primal: exact for first derivatives, and
/// many times cheaper than to carry eight derivatives through a series.
#[inline]
fn lifted<T: Real>(x: T, function: impl Fn(T::Primal) -> (T::Primal, T::Primal)) -> T {
    let (value, slope) = function(x.primal());
    if is_plain::<T>() {
        // No derivative to carry, and the slope is never computed.
        return T::from_primal(value);
    }
    (x - T::from_primal(x.primal())).scaled(slope) + T::from_primal(value)
}

/// t - sin t and its slope 1 - cos t for |t| <= π/2, without cancellation.
#[inline]
pub(crate) fn sine_defects<P: Root>(t: P) -> (P, P) {
    let y = t * t;
    let (sum, slope) = nested(y, &T_MINUS_SIN);
    (t * y * sum / 6.0, y * (sum * 3.0 + y * slope * 2.0) / 6.0)
}

/// t - sin t for |t| <= π/2, without cancellation.
#[inline]
pub(crate) fn t_minus_sin<T: Real>(t: T) -> T {
    lifted(t, sine_defects)
}

/// sin x / x for |x| <= π/2.
#[inline]
pub(crate) fn sinc<T: Real>(x: T) -> T {
    lifted(x, |x| {
        let (sum, slope) = nested(x * x, &SINC);
        (sum, slope * x * 2.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// ∫ u^n u^m du = 1/(n+m+1) on [0, 1], exactly, for every polynomial degree below the number of nodes.
    fn check<const ORDER: usize>() {
        for n in [0.11, 0.5, 1.1, 1.6] {
            let w: [f64; ORDER] = lifted_power_weights(n);
            let chunks = power_weights::<f64, ORDER>(n);
            let slopes = power_weight_slopes::<f64, ORDER>(n);
            for m in 0..ORDER {
                let power = |q: usize| rule::<ORDER>().nodes[q].powi(m as i32);
                let exact = 1.0 / (n + m as f64 + 1.0);
                let sum: f64 = (0..ORDER).map(|q| w[q] * power(q)).sum();
                assert_relative_eq!(sum, exact, epsilon = 1e-13);
                let sum: f64 = (0..ORDER)
                    .map(|q| chunks[q / 8].lane(q % 8) * power(q))
                    .sum();
                assert_relative_eq!(sum, exact, epsilon = 1e-13);
                let sum: f64 = (0..ORDER)
                    .map(|q| slopes[q / 8].lane(q % 8) * power(q))
                    .sum();
                assert_relative_eq!(sum, -exact * exact, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn weights_integrate_powers_times_polynomials() {
        check::<2>();
        check::<3>();
        check::<7>();
        check::<8>();
        check::<12>();
        check::<16>();
        check::<24>();
    }

    #[test]
    fn series_match_their_functions() {
        for i in 1..=157 {
            let t = 0.01 * i as f64;
            assert_relative_eq!(sinc(t), t.sin() / t, epsilon = 4e-16);
            if t > 0.5 {
                assert_relative_eq!(t_minus_sin(t), t - t.sin(), epsilon = 4e-16);
            }
        }
        assert_relative_eq!(
            t_minus_sin(1e-3),
            1.6666665833333356e-10,
            max_relative = 1e-15
        );
    }
}
