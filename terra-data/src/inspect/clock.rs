//! How evenly a log is sampled.

use super::{Suspicion, quantile};

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

/// The clock of one group of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// First time \[s\].
    pub start: f64,
    /// Last time \[s\].
    pub end: f64,
    /// Usual step between rows, the median \[s\].
    pub step: f64,
    /// Share of steps off by more than a tenth of the usual one, gaps not counted.
    pub uneven: f64,
    /// Steps of more than 2.5 usual ones.
    pub gaps: Vec<Gap>,
}

impl Pace {
    /// The clock of increasing times; `None` for fewer than two.
    pub(crate) fn of(time: &[f64]) -> Option<Self> {
        let (start, end) = (*time.first()?, *time.last()?);
        let steps: Vec<f64> = time
            .iter()
            .zip(time.iter().skip(1))
            .map(|(a, b)| b - a)
            .collect();
        let step = quantile(&mut steps.clone(), 0.5)?;
        let gaps: Vec<Gap> = time
            .iter()
            .zip(&steps)
            .filter(|(_, s)| **s > GAP * step)
            .map(|(from, length)| Gap {
                from: *from,
                length: *length,
            })
            .collect();
        let uneven = steps
            .iter()
            .filter(|s| **s <= GAP * step && (**s - step).abs() > UNEVEN * step)
            .count();
        Some(Pace {
            start,
            end,
            step,
            uneven: uneven as f64 / steps.len() as f64,
            gaps,
        })
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
