//! A posterior always names a winner; this says whether the winner explains the forces at all.
//!
//! # Equation
//! Over the last K samples of the winner: NIS/d = Σ e_kᵀ e_k / Σ d_k and lag-1 = Σ e_kᵀ e_(k-1) / Σ e_kᵀ e_k of its
//! standardised residuals e; with a right hypothesis and a right covariance they are near 1 and 0.
//!
//! Systematic error (torque scale, pitch, ground-speed scale), not noise, breaks identification, and a wrong
//! neighbour absorbs it with full confidence: the alarm belongs to every posterior.

use std::collections::VecDeque;

use nalgebra::DVector;

use crate::error::EstimatorError;

/// When to raise the alarm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlarmRule {
    /// K, samples looked at.
    pub window: usize,
    /// NIS/d above which no hypothesis explains the forces.
    pub threshold: f64,
    /// Looks at every window of the log, not only at the last: a fault that has passed has still been weighed.
    pub whole_log: bool,
}

impl Default for AlarmRule {
    fn default() -> Self {
        AlarmRule {
            window: 50,
            threshold: 1.5,
            whole_log: false,
        }
    }
}

impl AlarmRule {
    /// For the innovations of a vehicle filter, which are white: 50 samples of 7 channels stay below 1.3 unless
    /// something is wrong.
    pub fn innovations() -> Self {
        AlarmRule {
            window: 50,
            threshold: 1.3,
            whole_log: true,
        }
    }

    /// A legal rule.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for an empty window or a threshold of 1 or less.
    pub fn checked(self) -> Result<Self, EstimatorError> {
        let fail = |what: &str, value, expected| {
            Err(EstimatorError::Value {
                what: what.to_owned(),
                value,
                expected,
            })
        };
        if self.window == 0 {
            return fail("alarm window", 0.0, "at least 1 sample");
        }
        if !(self.threshold.is_finite() && self.threshold > 1.0) {
            return fail("alarm threshold", self.threshold, "a finite NIS/d above 1");
        }
        Ok(self)
    }
}

/// How well the most probable hypothesis explains the last samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// NIS/d; none before the first sample that the winner could predict.
    pub nis_per_dof: Option<f64>,
    /// Correlation of neighbouring standardised residuals; none before the second sample.
    pub lag1: Option<f64>,
    /// Largest NIS/d of any full window so far.
    pub worst_nis_per_dof: Option<f64>,
    /// Samples in the window.
    pub samples: usize,
    /// True when the winner must not be trusted.
    pub alarm: bool,
    /// Why the alarm is raised.
    pub reason: Option<String>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    nis: f64,
    cross: Option<f64>,
    dof: usize,
}

/// The last samples of one hypothesis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Window {
    entries: VecDeque<Option<Entry>>,
    last: Option<DVector<f64>>,
    /// Sums over the entries, and the largest ratio they had while the window was full.
    nis: f64,
    dof: usize,
    worst: Option<f64>,
}

impl Window {
    /// Adds a standardised residual, or the fact that there was none. `follows`: the sample before belongs to the
    /// same group.
    pub(crate) fn push(
        &mut self,
        standardised: Option<DVector<f64>>,
        follows: bool,
        rule: AlarmRule,
    ) {
        if self.entries.len() >= rule.window
            && let Some(Some(gone)) = self.entries.pop_front()
        {
            self.nis -= gone.nis;
            self.dof -= gone.dof;
        }
        if let Some(e) = &standardised {
            self.nis += e.norm_squared();
            self.dof += e.len();
        }
        let last = self.last.take().filter(|_| follows);
        self.entries.push_back(standardised.as_ref().map(|e| Entry {
            nis: e.norm_squared(),
            cross: last.filter(|l| l.len() == e.len()).map(|l| l.dot(e)),
            dof: e.len(),
        }));
        self.last = standardised;
        if self.entries.len() >= rule.window && self.dof > 0 {
            let ratio = self.nis / self.dof as f64;
            if self.worst.is_none_or(|w| ratio > w) {
                self.worst = Some(ratio);
            }
        }
    }

    /// The verdict on these samples.
    pub(crate) fn verdict(&self, rule: AlarmRule) -> Consistency {
        let entries: Vec<Entry> = self.entries.iter().flatten().copied().collect();
        let dof: usize = entries.iter().map(|e| e.dof).sum();
        let infeasible = self.entries.len() - entries.len();
        let nis: f64 = entries.iter().map(|e| e.nis).sum();
        let nis_per_dof = (dof > 0).then(|| nis / dof as f64);
        let crossed: f64 = entries
            .iter()
            .filter(|e| e.cross.is_some())
            .map(|e| e.nis)
            .sum();
        let cross: f64 = entries.iter().filter_map(|e| e.cross).sum();
        let lag1 = (crossed > 0.0).then(|| cross / crossed);
        let limit = rule.threshold.max(chi2_per_dof_limit(dof));
        let reason = match nis_per_dof {
            _ if 2 * infeasible > self.entries.len() => Some(format!(
                "the winner cannot carry the load in {infeasible} of {} samples",
                self.entries.len()
            )),
            _ if rule.whole_log && self.worst.is_some_and(|w| w > limit) => {
                let worst = self.worst.unwrap_or(f64::NAN);
                Some(format!(
                    "NIS/d {worst:.2} over {} samples of the log exceeds {limit:.2}: no hypothesis explains them",
                    rule.window
                ))
            }
            Some(x) if x > limit => Some(format!(
                "NIS/d {x:.2} over the last {} samples exceeds {limit:.2}: no hypothesis explains these forces",
                entries.len()
            )),
            _ => None,
        };
        Consistency {
            nis_per_dof,
            lag1,
            worst_nis_per_dof: self.worst,
            samples: self.entries.len(),
            alarm: reason.is_some(),
            reason,
        }
    }
}

/// The 99.9 % point of chi²_d / d (Wilson-Hilferty): in a short window even a right hypothesis strays.
fn chi2_per_dof_limit(dof: usize) -> f64 {
    const Z: f64 = 3.090_232;
    let c = 2.0 / (9.0 * dof.max(1) as f64);
    (1.0 - c + Z * c.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_is_the_tabulated_quantile() {
        // chi² at .999 in standard tables; Wilson-Hilferty is good to 2 % this far out at 3 degrees of freedom.
        for (dof, chi2) in [(3, 16.266), (10, 29.588), (30, 59.703), (100, 149.449)] {
            let ratio = chi2_per_dof_limit(dof) * dof as f64 / chi2;
            assert!((ratio - 1.0).abs() < 0.02, "{dof} {ratio}");
        }
        assert!((chi2_per_dof_limit(100) - 1.49449).abs() < 0.002);
    }

    #[test]
    fn a_constant_offset_is_seen_in_both_figures_and_leaves_with_the_window() {
        let rule = AlarmRule {
            window: 10,
            threshold: 1.5,
            whole_log: false,
        };
        let mut window = Window::default();
        for _ in 0..20 {
            window.push(Some(DVector::from_element(3, 2.0)), true, rule);
        }
        let seen = window.verdict(rule);
        assert_eq!(
            (seen.nis_per_dof, seen.lag1, seen.samples),
            (Some(4.0), Some(1.0), 10)
        );
        assert!(seen.alarm);
        for k in 0..10 {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            window.push(Some(DVector::from_element(3, sign)), k > 0, rule);
        }
        let seen = window.verdict(rule);
        assert_eq!(seen.nis_per_dof, Some(1.0));
        assert_eq!((seen.alarm, seen.lag1), (false, Some(-1.0)));
        for _ in 0..6 {
            window.push(None, true, rule);
        }
        assert!(
            window
                .verdict(rule)
                .reason
                .unwrap()
                .contains("cannot carry")
        );
        assert!(
            AlarmRule {
                window: 0,
                threshold: 1.5,
                whole_log: false
            }
            .checked()
            .is_err()
        );
        assert!(
            AlarmRule {
                window: 5,
                threshold: 1.0,
                whole_log: false
            }
            .checked()
            .is_err()
        );
    }
}
