//! How much a score must be before it counts, whatever the length of the log.
//!
//! # Equation
//! Looks at one span are numbered n = 2, 3, ...; the n-th may raise a false alarm with probability
//! α_n = (α/3)/(S n ln² n), S = Σ_{n≥2} 1/(n ln² n) = 2.109743, and each of its m scores with α_n/m. So no log of any length,
//! looked at over three spans, raises one with more than α (Boole's inequality: how the scores depend on each other does not
//! matter). A score is a Student t with as many degrees of freedom as the baseline gives its scale.
//!
//! # Reference
//! D. P. Foster, R. A. Stine, Alpha-investing, J. Royal Statistical Society B 70(2):429-444, 2008 (spending α over a sequence
//! of tests).

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Σ 1/(n ln² n) from n = 2.
const SUM: f64 = 2.109_743;

/// Spends the false alarms of one log.
#[derive(Clone, Debug)]
pub(crate) struct Spending {
    /// False alarms per log.
    pub(crate) alpha: f64,
    /// Spans looked over.
    pub(crate) spans: usize,
    /// Scores of one look.
    pub(crate) scores: usize,
    /// Degrees of freedom of a score.
    pub(crate) freedom: f64,
}

impl Spending {
    /// Probability that one score of look `k` (from 0) of one span may have by chance.
    pub(crate) fn share(&self, k: usize) -> f64 {
        let n = k as f64 + 2.0;
        self.alpha / (self.spans * self.scores) as f64 / (SUM * n * n.ln().powi(2))
    }

    /// The |score| that belongs to it, of scores that go both ways.
    pub(crate) fn threshold(&self, k: usize) -> f64 {
        match StudentsT::new(0.0, 1.0, self.freedom) {
            Ok(t) => -t.inverse_cdf(0.5 * self.share(k)),
            Err(_) => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All shares of all scores and spans together are α; the series is summed to n = 10^6 and its tail is between the integrals
    /// 1/ln n.
    #[test]
    fn all_looks_together_spend_alpha() {
        let s = Spending {
            alpha: 0.05,
            spans: 3,
            scores: 40,
            freedom: 60.0,
        };
        let n = 1_000_000;
        let spent: f64 = (0..n).map(|k| s.share(k)).sum::<f64>() * 120.0;
        let tail = 0.05 / SUM / ((n + 2) as f64).ln();
        assert!((spent + tail - 0.05).abs() < 1e-6, "{spent} {tail}");
    }

    /// Against the normal quantile (Abramowitz and Stegun, 26.2: Q(4.7534) = 1e-6) at many degrees of freedom.
    #[test]
    fn the_threshold_is_the_quantile() {
        let s = Spending {
            alpha: 2e-6 * SUM * 2.0 * 2f64.ln().powi(2),
            spans: 1,
            scores: 1,
            freedom: 1e7,
        };
        assert!((s.threshold(0) - 4.7534).abs() < 1e-3, "{}", s.threshold(0));
        assert!(s.threshold(100) > s.threshold(10));
    }
}
