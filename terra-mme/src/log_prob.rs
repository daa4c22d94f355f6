//! Probabilities by their logarithm: products of thousands of small numbers that never reach zero by rounding.

use std::ops::{Div, Mul};

/// ln(p) of a probability or a probability density. The product of two is `a * b`.
///
/// # Reference
/// Ray 2008, eqs 22-23, multiplies likelihoods; the literal product ends in 0/0 on real residuals.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct LogProb(f64);

impl LogProb {
    /// p = 0.
    pub const ZERO: LogProb = LogProb(f64::NEG_INFINITY);
    /// p = 1.
    pub const ONE: LogProb = LogProb(0.0);

    /// From ln(p).
    pub fn from_ln(ln: f64) -> Self {
        LogProb(ln)
    }

    /// From p >= 0; a negative or missing number becomes NaN, which every estimator refuses.
    pub fn from_probability(p: f64) -> Self {
        LogProb(p.ln())
    }

    /// ln(p).
    pub fn ln(self) -> f64 {
        self.0
    }

    /// p.
    pub fn probability(self) -> f64 {
        self.0.exp()
    }

    /// ln(p + q).
    #[must_use]
    pub fn or(self, q: LogProb) -> LogProb {
        LogProb(log_sum_exp(&[self.0, q.0]))
    }
}

impl Mul for LogProb {
    type Output = LogProb;
    #[allow(clippy::suspicious_arithmetic_impl)] // the logarithm of a product
    fn mul(self, b: LogProb) -> LogProb {
        LogProb(self.0 + b.0)
    }
}

impl Div for LogProb {
    type Output = LogProb;
    #[allow(clippy::suspicious_arithmetic_impl)] // the logarithm of a quotient
    fn div(self, b: LogProb) -> LogProb {
        LogProb(self.0 - b.0)
    }
}

/// ln Σ e^(x_i), without overflow or underflow; -∞ for no terms.
///
/// # Equation
/// m + ln Σ e^(x_i - m), m = max x_i.
pub fn log_sum_exp(x: &[f64]) -> f64 {
    let max = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !max.is_finite() {
        return if x.iter().any(|v| v.is_nan()) {
            f64::NAN
        } else {
            max
        };
    }
    max + x.iter().map(|v| (v - max).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_what_the_linear_domain_cannot() {
        assert_eq!((-1000.0_f64).exp(), 0.0);
        assert!((log_sum_exp(&[-1000.0, -1000.0]) - (-1000.0 + 2.0_f64.ln())).abs() < 1e-12);
        assert!((log_sum_exp(&[800.0, 0.0]) - 800.0).abs() < 1e-12);
        assert_eq!(log_sum_exp(&[]), f64::NEG_INFINITY);
        assert!(log_sum_exp(&[f64::NAN, 0.0]).is_nan());
    }

    #[test]
    fn products_and_quotients_are_those_of_the_probabilities() {
        let (a, b) = (
            LogProb::from_probability(0.25),
            LogProb::from_probability(0.5),
        );
        assert!(((a * b).probability() - 0.125).abs() < 1e-15);
        assert!(((a / b).probability() - 0.5).abs() < 1e-15);
        assert!((a.or(b).probability() - 0.75).abs() < 1e-15);
        assert_eq!(LogProb::ZERO.or(LogProb::ONE), LogProb::ONE);
    }
}
