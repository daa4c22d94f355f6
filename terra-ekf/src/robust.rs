//! Per-channel weights, rejection clocks and covariance resets.

use nalgebra::DMatrix;

use crate::config::FilterConfig;
use crate::measurement::Innovation;

/// Rejection clock and reset count of each channel.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// Time of unbroken rejection \[s\]; `None` while the channel is accepted.
    rejected_for: Vec<Option<f64>>,
    /// Time since the filter began \[s\].
    age: f64,
    pub(crate) resets: Vec<usize>,
}

impl Watch {
    pub(crate) fn new(channels: usize) -> Self {
        Watch {
            rejected_for: vec![None; channels],
            age: 0.0,
            resets: vec![0; channels],
        }
    }

    /// Forgets the clocks, keeps the counts.
    pub(crate) fn restart(&mut self) {
        self.rejected_for.fill(None);
        self.age = 0.0;
    }

    pub(crate) fn elapse(&mut self, dt: f64) {
        self.age += dt;
        for clock in self.rejected_for.iter_mut().flatten() {
            *clock += dt;
        }
    }

    /// True while a channel is being rejected.
    pub(crate) fn rejects(&self, channel: usize) -> bool {
        self.rejected_for[channel].is_some()
    }

    /// True when it has been for so long that it has lost its say. The prediction it is compared with grows vaguer all
    /// the while, and would sooner or later take a faulty reading for a possible one: then the filter follows the fault,
    /// and the sensor's return looks like the next fault.
    pub(crate) fn distrusts(&self, channel: usize) -> bool {
        self.age >= SETTLED && self.rejected_for[channel].is_some_and(|time| time >= DISTRUST_AFTER)
    }

    /// A channel inside its gate.
    pub(crate) fn accept(&mut self, channel: usize) {
        self.rejected_for[channel] = None;
    }

    /// Records |e| of a channel; true when its timeout has come: the clock then starts afresh.
    pub(crate) fn timed_out(&mut self, channel: usize, e: f64, config: &FilterConfig) -> bool {
        let Some(robust) = config.robust else {
            return false;
        };
        let gate = if self.distrusts(channel) {
            TRUST_AGAIN * config.gate
        } else {
            config.gate
        };
        if e.abs() <= gate {
            self.rejected_for[channel] = None;
            return false;
        }
        match self.rejected_for[channel] {
            Some(time) if time >= robust.reject_timeout => {
                self.rejected_for[channel] = None;
                self.resets[channel] += 1;
                true
            }
            Some(_) => false,
            None => {
                self.rejected_for[channel] = Some(0.0);
                false
            }
        }
    }
}

/// Time of unbroken rejection after which a channel has no say \[s\].
const DISTRUST_AFTER: f64 = 0.1;
/// Time before which a filter knows too little to take a channel's say away \[s\]: a hard start from rest is rejected for a
/// while too.
const SETTLED: f64 = 0.5;
/// Share of the gate inside which it gets it back.
const TRUST_AGAIN: f64 = 0.6;
/// Inflation of a channel without say.
pub(crate) const NO_SAY: f64 = 1e9;

/// |e| beyond which a robust update drops a channel: its weight would be lost in rounding.
const DROPPED: f64 = 1e8;
/// |e| beyond which a plain filter cannot go on: NIS and mean would overflow.
const OVERFLOW: f64 = 1e100;

/// Takes the channels with an absurd reading out of `rows`, with their ratio; `Ok(true)` when there were any.
/// `Err((row, e))` for a filter without robust update.
pub(crate) fn drop_absurd(
    innovation: &mut Innovation,
    rows: &mut Vec<usize>,
    residual: &[f64],
    s_diagonal: &[f64],
    config: &FilterConfig,
) -> Result<bool, (usize, f64)> {
    let limit = if config.robust.is_some() {
        DROPPED
    } else {
        OVERFLOW
    };
    let mut keep = Vec::with_capacity(rows.len());
    for (k, &row) in rows.iter().enumerate() {
        let sd = s_diagonal[k].max(0.0).sqrt();
        // A ratio is a finite number, even where the residual overflows.
        let e = (residual[k].abs() / sd).min(f64::MAX);
        if !(sd > 0.0 && e > limit) {
            keep.push(row);
        } else if config.robust.is_none() {
            return Err((row, e));
        } else {
            innovation.ratio[row] = Some(e / config.gate);
            innovation.dropped.push(row);
        }
    }
    let any = keep.len() < rows.len();
    *rows = keep;
    Ok(any)
}

/// Fills residual, sd and ratio of the channels in `rows`; returns e = ν/sd of each.
pub(crate) fn describe(
    innovation: &mut Innovation,
    rows: &[usize],
    residual: &[f64],
    s_diagonal: &[f64],
    gate: f64,
) -> Vec<f64> {
    let mut normal = Vec::with_capacity(rows.len());
    for (k, &row) in rows.iter().enumerate() {
        let sd = s_diagonal[k].max(0.0).sqrt();
        let e = if sd > 0.0 { residual[k] / sd } else { 0.0 };
        innovation.residual[row] = Some(residual[k]);
        innovation.sd[row] = Some(sd);
        innovation.ratio[row] = Some(e.abs() / gate);
        innovation.inflation[row] = Some(1.0);
        normal.push(e);
    }
    normal
}

/// Puts the prior covariance of the states in `group` back into `p`, without correlation to the others.
pub(crate) fn reset_group(p: &mut DMatrix<f64>, prior: &DMatrix<f64>, group: &[usize]) {
    for &i in group {
        p.row_mut(i).fill(0.0);
        p.column_mut(i).fill(0.0);
    }
    for &i in group {
        for &j in group {
            p[(i, j)] = prior[(i, j)];
        }
    }
}
