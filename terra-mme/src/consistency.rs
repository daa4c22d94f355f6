//! A posterior always names a winner; this says whether the winner explains the forces at all.
//!
//! # Equation
//! Over the last K samples of the winner: NIS/d = Σ e_kᵀ e_k / Σ d_k and lag-1 = Σ e_kᵀ e_(k-1) / Σ e_kᵀ e_k of its
//! standardised residuals e; with a right hypothesis and a right covariance they are near 1 and 0.
//!
//! A rule for white residuals rings on a stated share of sound logs, whatever their length: its limit is that of the
//! largest window of a log that long (see `scan`).
//!
//! Systematic error (torque scale, pitch, ground-speed scale), not noise, breaks identification, and a wrong
//! neighbour absorbs it with full confidence: the alarm belongs to every posterior.

use std::collections::VecDeque;

use nalgebra::DVector;

use crate::error::EstimatorError;
use crate::scan;

/// When to raise the alarm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlarmRule {
    /// K, samples looked at.
    pub window: usize,
    /// NIS/d above which no hypothesis explains the forces.
    pub threshold: f64,
    /// For white residuals: looks at every window of the log, as a fault that has passed has still been weighed, and rings
    /// on this share of sound logs of any length. `None` looks at the last window alone, against `threshold` and the
    /// 99.9 % point of χ².
    pub false_alarms: Option<f64>,
}

impl Default for AlarmRule {
    fn default() -> Self {
        AlarmRule {
            window: 50,
            threshold: 1.5,
            false_alarms: None,
        }
    }
}

impl AlarmRule {
    /// For the innovations of a vehicle filter, which are white: one sound log in a hundred rings.
    pub fn innovations() -> Self {
        AlarmRule {
            window: 50,
            threshold: 1.05,
            false_alarms: Some(0.01),
        }
    }

    /// A legal rule.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for an empty window, a threshold of 1 or less, or a share of false alarms that is none.
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
        if let Some(rate) = self.false_alarms
            && !(rate > 0.0 && rate < 1.0)
        {
            return fail("share of false alarms", rate, "a share in (0, 1)");
        }
        Ok(self)
    }
}

/// The 99.9 % point of the normal: in a short window even a right hypothesis strays.
const LAST_WINDOW: f64 = 3.090_232;

/// How well the most probable hypothesis explains the last samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// NIS/d; none before the first sample that the winner could predict.
    pub nis_per_dof: Option<f64>,
    /// Correlation of neighbouring standardised residuals; none before the second sample.
    pub lag1: Option<f64>,
    /// NIS/d of the full window that chance explains least, so far: the largest, where all had the same channels.
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
    /// Sums over the entries.
    nis: f64,
    dof: usize,
    /// Full windows so far.
    places: usize,
    /// The one that chance explains least: NIS/d and d.
    worst: Option<(f64, usize)>,
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
            self.places += 1;
            let (ratio, dof) = (self.nis / self.dof as f64, self.dof);
            let stranger = |(worst, d)| scan::z_of(ratio, dof) > scan::z_of(worst, d);
            if self.worst.is_none_or(stranger) {
                self.worst = Some((ratio, dof));
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
        let (places, window) = (self.places, rule.window);
        let quantile = |dof| match rule.false_alarms {
            Some(rate) => scan::ratio_of(scan::limit(rate, places, window), dof),
            None => scan::ratio_of(LAST_WINDOW, dof),
        };
        let limit = |dof| rule.threshold.max(quantile(dof));
        // Once a window has been full, all of them are judged; before that, what there is.
        let whole_log = self.worst.filter(|_| rule.false_alarms.is_some());
        let reason = match (whole_log, nis_per_dof) {
            _ if 2 * infeasible > self.entries.len() => Some(format!(
                "the winner cannot carry the load in {infeasible} of {} samples",
                self.entries.len()
            )),
            (Some((worst, dof)), _) => (worst > limit(dof)).then(|| {
                format!(
                    "NIS/d {worst:.2} over {} samples of the log exceeds {:.2}: no hypothesis explains them",
                    rule.window,
                    limit(dof)
                )
            }),
            (None, Some(x)) if x > limit(dof) => Some(format!(
                "NIS/d {x:.2} over the last {} samples exceeds {:.2}: no hypothesis explains these forces",
                entries.len(),
                limit(dof)
            )),
            _ => None,
        };
        Consistency {
            nis_per_dof,
            lag1,
            worst_nis_per_dof: self.worst.map(|w| w.0),
            samples: self.entries.len(),
            alarm: reason.is_some(),
            reason,
        }
    }
}

#[cfg(test)]
mod tests {
    use chacha20::ChaCha8Rng;
    use chacha20::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn a_constant_offset_is_seen_in_both_figures_and_leaves_with_the_window() {
        let rule = AlarmRule {
            window: 10,
            threshold: 1.5,
            false_alarms: None,
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
                false_alarms: None
            }
            .checked()
            .is_err()
        );
        assert!(
            AlarmRule {
                window: 5,
                threshold: 1.0,
                false_alarms: None
            }
            .checked()
            .is_err()
        );
    }

    /// White residuals of a right hypothesis: of 4 000 logs the stated share rings, for short and long ones, one channel
    /// and seven. At the default share of one in a hundred, too.
    #[test]
    fn the_share_of_false_alarms_is_the_stated_one() {
        const LOGS: u64 = 4000;
        for (rows, channels, rate) in [
            (60, 7, 0.05),
            (200, 7, 0.05),
            (1000, 7, 0.05),
            (200, 3, 0.05),
            (200, 7, 0.01),
        ] {
            let rule = AlarmRule {
                window: 50,
                threshold: 1.001,
                false_alarms: Some(rate),
            };
            let mut rung = 0;
            for log in 0..LOGS {
                let mut rng = ChaCha8Rng::seed_from_u64(rows as u64 + 10 * channels as u64);
                rng.set_stream(log);
                let mut window = Window::default();
                for k in 0..rows {
                    let e = DVector::from_fn(channels, |_, _| StandardNormal.sample(&mut rng));
                    window.push(Some(e), k > 0, rule);
                }
                rung += u64::from(window.verdict(rule).alarm);
            }
            let found = rung as f64 / LOGS as f64;
            // Three sigma of the count, and a tenth for the approximation of the limit.
            let bound = 3.0 * (rate * (1.0 - rate) / LOGS as f64).sqrt() + 0.1 * rate;
            assert!(
                (found - rate).abs() < bound,
                "{rows} rows of {channels}: {found}, stated {rate}"
            );
        }
    }

    /// A fault that has passed still rings at the end of the log.
    #[test]
    fn a_fault_that_has_passed_rings() {
        let rule = AlarmRule::innovations();
        let mut window = Window::default();
        for k in 0..400 {
            let size = if (100..150).contains(&k) { 1.3 } else { 0.9 };
            let sign = if k % 2 == 0 { size } else { -size };
            window.push(Some(DVector::from_element(7, sign)), k > 0, rule);
        }
        let seen = window.verdict(rule);
        assert!(seen.alarm && seen.nis_per_dof.unwrap() < 1.0, "{seen:?}");
        assert!((seen.worst_nis_per_dof.unwrap() - 1.69).abs() < 1e-9);
    }
}
