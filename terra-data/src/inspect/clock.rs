//! How evenly a log is sampled.

use super::{KEPT, Suspicion, quantile};

/// A step this many times the usual one is a gap.
const GAP: f64 = 2.5;
/// A step off by more than this share of the usual one is uneven.
const UNEVEN: f64 = 0.1;
/// More uneven steps than this are worth a word.
const TOLERATED: f64 = 0.05;

/// A hole in a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Last time before it \[s\].
    pub from: f64,
    /// Its length \[s\].
    pub length: f64,
}

/// Times against their usual step.
struct Judged {
    /// So far, without the share of uneven steps.
    pace: Pace,
    steps: usize,
    uneven: usize,
}

impl Judged {
    fn of(time: &[f64]) -> Option<Self> {
        let start = *time.first()?;
        let mut steps: Vec<f64> = time
            .iter()
            .zip(time.iter().skip(1))
            .map(|(a, b)| b - a)
            .collect();
        let mut judged = Judged {
            pace: Pace {
                start,
                end: start,
                step: quantile(&mut steps, 0.5)?,
                uneven: 0.0,
                gaps: Vec::new(),
            },
            steps: 0,
            uneven: 0,
        };
        time.iter().skip(1).for_each(|t| judged.see(*t));
        Some(judged)
    }

    fn see(&mut self, time: f64) {
        let (from, usual) = (self.pace.end, self.pace.step);
        let length = time - from;
        if length > GAP * usual {
            self.pace.gaps.push(Gap { from, length });
        } else if (length - usual).abs() > UNEVEN * usual {
            self.uneven += 1;
        }
        self.pace.end = time;
        self.steps += 1;
    }

    fn pace(self) -> Pace {
        Pace {
            uneven: self.uneven as f64 / self.steps as f64,
            ..self.pace
        }
    }
}

/// Times that come one by one. The usual step is the median of the first [`KEPT`] steps, so that no more times are held.
#[derive(Default)]
pub(super) struct Clock {
    first: Vec<f64>,
    judged: Option<Judged>,
}

impl Clock {
    pub(super) fn see(&mut self, time: f64) {
        if let Some(judged) = &mut self.judged {
            judged.see(time);
            return;
        }
        self.first.push(time);
        if self.first.len() > KEPT {
            self.judged = Judged::of(&self.first);
            self.first = Vec::new();
        }
    }

    /// As [`Pace::of`].
    pub(super) fn pace(self) -> Option<Pace> {
        let judged = self.judged.or_else(|| Judged::of(&self.first));
        judged.map(Judged::pace)
    }
}

/// The clock of one group of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// First time \[s\].
    pub start: f64,
    /// Last time \[s\].
    pub end: f64,
    /// Usual step between rows, the median \[s\]; in a segment of a drive, of its first 262 144 steps.
    pub step: f64,
    /// Share of steps off by more than a tenth of the usual one, gaps not counted.
    pub uneven: f64,
    /// Steps of more than 2.5 usual ones.
    pub gaps: Vec<Gap>,
}

impl Pace {
    /// The clock of increasing times; `None` for fewer than two.
    pub(crate) fn of(time: &[f64]) -> Option<Self> {
        Judged::of(time).map(Judged::pace)
    }

    pub(crate) fn suspicions(&self, group: &str) -> Vec<Suspicion> {
        let mut out = Vec::new();
        if self.uneven > TOLERATED {
            out.push(Suspicion {
                code: "uneven-clock",
                message: format!(
                    "time_s in '{group}': {:.0} % of the steps differ by more than 10 % from the usual {:.4} s: \
                     were samples stamped when they arrived, not when they were taken?",
                    100.0 * self.uneven,
                    self.step
                ),
            });
        }
        let longest = self
            .gaps
            .iter()
            .max_by(|a, b| a.length.total_cmp(&b.length));
        if let Some(gap) = longest {
            out.push(Suspicion {
                code: "gap",
                message: format!(
                    "time_s in '{group}': {} gap(s), the longest {:.3} s after {} s (usual step {:.4} s): \
                     samples were lost; a new segment there restarts the filter",
                    self.gaps.len(),
                    gap.length,
                    gap.from,
                    self.step
                ),
            });
        }
        out
    }
}
