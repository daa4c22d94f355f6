//! Quadrature for stresses that grow like u^n from the ends of the contact.
//!
//! The only factor that is not smooth is u^n with n from .1 to 1.6. Gauss-Legendre nodes on \[0, 1\] (the same for
//! every soil, so that soils can be lanes) get weights that integrate u^n times a polynomial exactly:
//!
//! w^σ_q = w_q Σ_k (2k+1) P*_k(u_q) M_k(n),   M_k = Π_{j<k}(n - j) / Π_{j<=k}(n + 1 + j),   P*_k(u) = P_k(2u - 1).

use std::num::NonZeroUsize;
use std::sync::OnceLock;

use gauss_quad::GaussLegendre;

use crate::real::{Real, Root, is_plain};

/// Nodes a piece. Against the reference wheel 12 give 1e-11 or better on every row.
pub(crate) const NODES: usize = 12;

/// Nodes and weights on \[0, 1\], and the table that turns moments of u^n into weights.
pub(crate) struct Rule {
    pub(crate) nodes: [f64; NODES],
    pub(crate) weights: [f64; NODES],
    /// `basis[q][k]` = w_q (2k+1) P*_k(u_q).
    basis: [[f64; NODES]; NODES],
}

/// The rule, made once.
pub(crate) fn rule() -> &'static Rule {
    static RULE: OnceLock<Rule> = OnceLock::new();
    RULE.get_or_init(|| {
        let degree = NonZeroUsize::new(NODES).unwrap_or(NonZeroUsize::MIN);
        let gauss = GaussLegendre::new(degree);
        let mut rule = Rule {
            nodes: [0.0; NODES],
            weights: [0.0; NODES],
            basis: [[0.0; NODES]; NODES],
        };
        for (q, (x, w)) in gauss.as_node_weight_pairs().iter().enumerate() {
            rule.nodes[q] = 0.5 * (1.0 + x);
            rule.weights[q] = 0.5 * w;
            let (mut before, mut current) = (0.0, 1.0);
            for k in 0..NODES {
                rule.basis[q][k] = rule.weights[q] * (2 * k + 1) as f64 * current;
                let kf = k as f64;
                let next = ((2.0 * kf + 1.0) * x * current - kf * before) / (kf + 1.0);
                (before, current) = (current, next);
            }
        }
        rule
    })
}

/// Weights for u^n, in any scalar: computed once in the primal with the slope in n, then carried along linearly,
/// which is exact for first derivatives.
pub(crate) fn power_weights<T: Real>(n: T) -> [T; NODES] {
    let rule = rule();
    let seed = n.primal().seed();
    type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
    let mut moments = [Tangent::<T>::zero(); NODES];
    let mut moment = Tangent::<T>::one() / (seed + 1.0);
    for (k, m) in moments.iter_mut().enumerate() {
        *m = moment;
        let kf = k as f64;
        moment = moment * (seed - kf) / (seed + (kf + 2.0));
    }
    let dn = n - T::from_primal(n.primal());
    let mut weights = [T::zero(); NODES];
    for (weight, basis) in weights.iter_mut().zip(&rule.basis) {
        let mut sum = Tangent::<T>::zero();
        for (m, b) in moments.iter().zip(basis) {
            sum += *m * *b;
        }
        let (value, slope) = T::Primal::parts(sum);
        *weight = T::from_primal(value) + T::from_primal(slope) * dn;
    }
    weights
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
    T::from_primal(value) + T::from_primal(slope) * (x - T::from_primal(x.primal()))
}

/// t - sin t for |t| <= π/2, without cancellation.
#[inline]
pub(crate) fn t_minus_sin<T: Real>(t: T) -> T {
    lifted(t, |t| {
        let y = t * t;
        let (sum, slope) = nested(y, &T_MINUS_SIN);
        (t * y * sum / 6.0, y * (sum * 3.0 + y * slope * 2.0) / 6.0)
    })
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
    #[test]
    fn weights_integrate_powers_times_polynomials() {
        for n in [0.11, 0.5, 1.1, 1.6] {
            let w = power_weights(n);
            for m in 0..NODES {
                let sum: f64 = w
                    .iter()
                    .zip(&rule().nodes)
                    .map(|(w, u)| w * u.powi(m as i32))
                    .sum();
                assert_relative_eq!(sum, 1.0 / (n + m as f64 + 1.0), epsilon = 1e-13);
            }
        }
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
