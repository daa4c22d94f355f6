//! Does a filter know how wrong it is?
//!
//! # Equation
//! Under a matched model the NIS of a step is chi-square with its dof, independent from step to step, so their sum is
//! chi-square too; and the whitened innovations are uncorrelated in time, so the lag-1 correlation of N of them has
//! standard deviation 1/√N.
//!
//! # Reference
//! Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation*, Wiley (2001),
//! section 5.4.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::channels::Channels;
use crate::measurement::Innovation;

/// What the numbers say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Errors are as large as claimed, and white.
    Consistent,
    /// Errors are larger than claimed: R or Q too small, or a wrong model.
    Overconfident,
    /// Errors are smaller than claimed: R or Q too large.
    Underconfident,
    /// Size as claimed, but correlated in time: the model lacks something.
    Coloured,
    /// Fewer than 30 values: nothing can be said.
    TooFew,
}

/// Sum of squares and lag-1 correlation of whitened values, over any number of runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Consistency {
    sum: f64,
    dof: usize,
    lag_sum: f64,
    lag_squares: f64,
    lag_count: usize,
    last: Channels,
}

impl Consistency {
    /// Nothing seen yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in the next update of a run.
    pub fn add(&mut self, innovation: &Innovation) {
        self.sum += innovation.nis;
        self.dof += innovation.dof;
        for (now, before) in innovation.whitened.iter().zip(self.last.iter()) {
            if let (Some(now), Some(before)) = (now, before) {
                self.lag_sum += now * before;
                self.lag_squares += 0.5 * (now * now + before * before);
                self.lag_count += 1;
            }
        }
        self.last.clone_from(&innovation.whitened);
    }

    /// Takes in one squared error eᵀ P⁻¹ e with its dof, independent of the others (NEES: one instant a run).
    pub fn add_square(&mut self, square: f64, dof: usize) {
        self.sum += square;
        self.dof += dof;
    }

    /// A new run begins: no correlation across the boundary.
    pub fn new_run(&mut self) {
        self.last = Channels::default();
    }

    /// Values taken in.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Mean square over dof: 1 when matched. `None` without values.
    pub fn mean(&self) -> Option<f64> {
        (self.dof > 0).then(|| self.sum / self.dof as f64)
    }

    /// Lag-1 correlation of the whitened innovations. `None` without pairs.
    pub fn lag1(&self) -> Option<f64> {
        (self.lag_squares > 0.0).then(|| self.lag_sum / self.lag_squares)
    }

    /// Two-sided chi-square band of [`mean`](Self::mean) for a probability in (0, 1), by the cube-root normal
    /// approximation of Wilson and Hilferty (relative error below 1e-3 from 30 degrees of freedom on).
    pub fn band(&self, probability: f64) -> Option<(f64, f64)> {
        if self.dof == 0 || !(probability > 0.0 && probability < 1.0) {
            return None;
        }
        let z = Normal::standard().inverse_cdf(0.5 * (1.0 + probability));
        let v = 2.0 / (9.0 * self.dof as f64);
        let at = |z: f64| (1.0 - v + z * v.sqrt()).max(0.0).powi(3);
        Some((at(-z), at(z)))
    }

    /// How many standard deviations the mean square is off: negative when errors are smaller than claimed.
    pub fn z(&self) -> Option<f64> {
        let v = 2.0 / (9.0 * self.dof as f64);
        self.mean().map(|m| (m.cbrt() - (1.0 - v)) / v.sqrt())
    }

    /// Lag-1 correlation in its standard deviations under the matched model.
    pub fn lag1_z(&self) -> Option<f64> {
        self.lag1().map(|r| r * (self.lag_count as f64).sqrt())
    }

    /// The verdict at `limit` standard deviations (3 is usual).
    pub fn verdict(&self, limit: f64) -> Verdict {
        let Some(z) = self.z() else {
            return Verdict::TooFew;
        };
        if self.dof < 30 {
            Verdict::TooFew
        } else if z > limit {
            Verdict::Overconfident
        } else if z < -limit {
            Verdict::Underconfident
        } else if self.lag1_z().is_some_and(|l| l.abs() > limit) {
            Verdict::Coloured
        } else {
            Verdict::Consistent
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chi-square quantiles of the tables: 95 % of 30 dof lie in 16.791..46.979, of 100 dof in 74.222..129.561.
    #[test]
    fn band_matches_the_tables() {
        for (dof, low, high) in [(30, 16.791, 46.979), (100, 74.222, 129.561)] {
            let mut c = Consistency::new();
            c.add_square(dof as f64, dof);
            let (l, h) = c.band(0.95).unwrap();
            assert!(
                (l * dof as f64 / low - 1.0).abs() < 2e-3
                    && (h * dof as f64 / high - 1.0).abs() < 2e-3
            );
        }
    }
}
