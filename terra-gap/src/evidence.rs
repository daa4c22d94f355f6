//! Evidence: how well a hypothesis predicted the data, its freedom paid for.
//!
//! # Equation
//! Laplace: ln Z = -|r|²/2 - |x|²/2 + b'H^-1 b/2 - ln det(H)/2 - ln det(C)/2 + Σ one-sided,
//! H = I + J'J, b = J'r - x (zero inside the bounds), one-sided = ln 2 + ln Φ(mu/sd) of that component.
//!
//! # Reference
//! D. J. C. MacKay, Neural Computation 4(3):415-447, 1992.

use nalgebra::{DMatrix, DVector};
use statrs::function::erf::erfc;

use crate::fit::Fit;
use crate::hypothesis::Hypothesis;

/// ln Φ(x), accurate far into the lower tail.
pub(crate) fn ln_normal_cdf(x: f64) -> f64 {
    if x > -30.0 {
        (0.5 * erfc(-x / std::f64::consts::SQRT_2)).ln()
    } else {
        // Mills ratio, first terms.
        -0.5 * x * x - (-x).ln() - 0.5 * (2.0 * std::f64::consts::PI).ln() - 1.0 / (x * x)
    }
}

/// Gaussian posterior of a fit: mean and covariance of x, and its log evidence.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Mean of the unconstrained Gaussian.
    pub mean: DVector<f64>,
    /// Its covariance H^-1.
    pub covariance: DMatrix<f64>,
    /// ln Z up to a constant shared by all hypotheses on the same data.
    pub log_evidence: f64,
}

/// Laplace evidence of a fit.
pub(crate) fn posterior(hypothesis: &Hypothesis, fit: &Fit) -> Posterior {
    let d = fit.x.len();
    let h = fit.jacobian.tr_mul(&fit.jacobian) + DMatrix::identity(d, d);
    let b = fit.jacobian.tr_mul(&fit.residual) - &fit.x;
    // I + J'J is positive definite by construction; a failure can only be rounding far beyond any real data.
    let (covariance, log_det) = match h.clone().cholesky() {
        Some(c) => {
            let log_det = 2.0 * c.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>();
            (c.inverse(), log_det)
        }
        None => (DMatrix::identity(d, d), f64::INFINITY),
    };
    let shift = &covariance * &b;
    let mean = &fit.x + &shift;
    // On the way a fit's slopes promise what its curvature does not keep.
    let promised = 0.5 * b.dot(&shift);
    let gain = if fit.given_up {
        promised.min(1.0)
    } else {
        promised
    };
    let mut log_evidence =
        -0.5 * (fit.chi2() + fit.x.norm_squared()) + gain - 0.5 * log_det - 0.5 * fit.log_det;
    for (k, one_sided) in hypothesis.one_sided().iter().enumerate() {
        if *one_sided {
            log_evidence +=
                std::f64::consts::LN_2 + ln_normal_cdf(mean[k] / covariance[(k, k)].sqrt());
        }
    }
    Posterior {
        mean,
        covariance,
        log_evidence,
    }
}

/// ln Σ exp.
pub(crate) fn log_sum_exp(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return most;
    }
    most + values.iter().map(|v| (v - most).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tabulated: Φ(-1) = .158655, Φ(-10) = 7.619853e-24; the far tail joins the near one.
    #[test]
    fn normal_tail_is_right_near_and_far() {
        assert!((ln_normal_cdf(-1.0).exp() - 0.158_655_25).abs() < 1e-8);
        assert!((ln_normal_cdf(-10.0) - 7.619_853e-24f64.ln()).abs() < 1e-6);
        let slope = ln_normal_cdf(-30.001) - ln_normal_cdf(-29.999);
        assert!((slope + 0.002 * 30.033).abs() < 1e-4, "{slope}");
    }

    #[test]
    fn log_sum_exp_survives_large_numbers() {
        assert!((log_sum_exp([-1e5, -1e5]) + 1e5 - 2f64.ln()).abs() < 1e-9);
        assert_eq!(log_sum_exp([]), f64::NEG_INFINITY);
    }
}
