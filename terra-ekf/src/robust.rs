//! Per-channel weights, rejection clocks and covariance resets.

use nalgebra::DMatrix;

use crate::config::FilterConfig;
use crate::measurement::Innovation;

/// Rejection clock and reset count of each channel.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// Time of unbroken rejection \[s\]; `None` while the channel is accepted.
    rejected_for: Vec<Option<f64>>,
    /// The same as it stood before the sample that is being taken in.
    before: Vec<Option<f64>>,
    /// e of the last sample, and of the one before the sample that is being taken in.
    heard: Vec<f64>,
    heard_before: Vec<f64>,
    /// Time since a channel that had been rejected for long was taken again \[s\].
    trusted_for: Vec<f64>,
    /// Time since the filter began \[s\].
    age: f64,
    pub(crate) resets: Vec<usize>,
}

impl Watch {
    pub(crate) fn new(channels: usize) -> Self {
        Watch {
            rejected_for: vec![None; channels],
            before: vec![None; channels],
            heard: vec![0.0; channels],
            heard_before: vec![0.0; channels],
            trusted_for: vec![f64::INFINITY; channels],
            age: 0.0,
            resets: vec![0; channels],
        }
    }

    /// Forgets the clocks, keeps the counts.
    pub(crate) fn restart(&mut self) {
        self.rejected_for.fill(None);
        self.before.fill(None);
        self.heard.fill(0.0);
        self.heard_before.fill(0.0);
        self.trusted_for.fill(f64::INFINITY);
        self.age = 0.0;
    }

    pub(crate) fn elapse(&mut self, dt: f64) {
        self.age += dt;
        for clock in self.rejected_for.iter_mut().flatten() {
            *clock += dt;
        }
        for clock in &mut self.trusted_for {
            *clock += dt;
        }
        self.before.copy_from_slice(&self.rejected_for);
        self.heard_before.copy_from_slice(&self.heard);
    }

    /// True when a channel has been rejected for a few samples and another says the same, which no fault of one sensor can
    /// bring about: then a force has changed at once, as it does where one soil ends and another begins.
    ///
    /// Another channel of the same states says the same when it strays for two samples as S correlates the two innovations. A
    /// faulty reading would drag the states towards itself and the other's prediction away from its reading. A channel of
    /// other states must have been rejected since about the same time.
    pub(crate) fn changed(
        &self,
        channel: usize,
        others: &[Other],
        e: f64,
        config: &FilterConfig,
    ) -> bool {
        let since = |c: usize| {
            let clock = self.before.get(c).copied().flatten();
            clock.filter(|t| *t >= CHANGED_AFTER)
        };
        let Some(mine) = since(channel).filter(|_| config.robust.is_some()) else {
            return false;
        };
        let strays = |o: &Other| {
            let last = self.heard_before.get(o.channel).copied().unwrap_or(0.0);
            let twice = o.e.abs() > STRAYS && last.abs() > STRAYS && last * o.e > 0.0;
            twice && e * o.e * o.correlation > 0.0
        };
        let shared = |o: &&Other| o.correlation.abs() > UNRELATED;
        let with = |c: usize| {
            let near = since(c).is_some_and(|t| (t - mine).abs() <= CHANGED_WITHIN);
            c != channel && near && !others.iter().filter(shared).any(|o| o.channel == c)
        };
        self.age >= CHANGED_FROM
            && e.abs() > config.gate
            && (others.iter().filter(shared).any(strays) || (0..self.before.len()).any(with))
    }

    /// Counts a reset of a channel that has changed together with another.
    pub(crate) fn reset(&mut self, channel: usize, e: f64) {
        self.heard[channel] = e;
        self.rejected_for[channel] = None;
        self.resets[channel] += 1;
    }

    /// True while any channel is being rejected.
    pub(crate) fn rejects_any(&self) -> bool {
        self.rejected_for.iter().any(Option::is_some)
    }

    /// True when it has been for so long that it has lost its say. The prediction it is compared with grows vaguer all
    /// the while, and would sooner or later take a faulty reading for a possible one: then the filter follows the fault,
    /// and the sensor's return looks like the next fault.
    pub(crate) fn distrusts(&self, channel: usize) -> bool {
        self.age >= SETTLED && self.rejected_for[channel].is_some_and(|time| time >= DISTRUST_AFTER)
    }

    /// A channel inside its gate.
    pub(crate) fn accept(&mut self, channel: usize, e: f64) {
        self.heard[channel] = e;
        self.rejected_for[channel] = None;
    }

    /// Records |e| of a channel; true when its timeout has come: the clock then starts afresh.
    pub(crate) fn timed_out(&mut self, channel: usize, e: f64, config: &FilterConfig) -> bool {
        self.heard[channel] = e;
        let Some(robust) = config.robust else {
            return false;
        };
        let gate = if self.distrusts(channel) {
            TRUST_AGAIN * config.gate
        } else {
            config.gate
        };
        if e.abs() <= gate {
            let long = self.rejected_for[channel].is_some_and(|time| time >= SUSPECT_AFTER);
            if long && self.age >= SETTLED {
                self.trusted_for[channel] = 0.0;
            }
            self.rejected_for[channel] = None;
            return false;
        }
        // A reading that comes within the gate of a vague prediction may still be a faulty one, and has then led the filter
        // astray: what is rejected soon after may be the end of the fault.
        let timeout = if self.trusted_for[channel] < PROBATION {
            robust.reject_timeout.min(PROBATION_TIMEOUT)
        } else {
            robust.reject_timeout
        };
        match self.rejected_for[channel] {
            Some(time) if time >= timeout => {
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
/// Time of rejection after which a channel is taken again on probation \[s\].
const SUSPECT_AFTER: f64 = 0.05;
/// Time on probation, in which a new rejection lasts no longer than [`PROBATION_TIMEOUT`] \[s\].
const PROBATION: f64 = 1.0;
/// Timeout on probation \[s\].
const PROBATION_TIMEOUT: f64 = 0.2;
/// Time of rejection after which the states behind a channel may have changed \[s\]: three samples at 100 Hz.
const CHANGED_AFTER: f64 = 0.015;
/// Largest difference of the times at which two rejections began \[s\].
const CHANGED_WITHIN: f64 = 0.1;
/// Time before which a filter knows too little to say so \[s\].
const CHANGED_FROM: f64 = 0.2;
/// |e| of two samples in a row at which another channel is heard as a witness; by chance one pair in some 10⁵.
const STRAYS: f64 = 3.0;
/// Correlation of two innovations that share no states.
const UNRELATED: f64 = 1e-6;
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
            innovation.ratio.set(row, e / config.gate);
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
        innovation.residual.set(row, residual[k]);
        innovation.sd.set(row, sd);
        innovation.ratio.set(row, e.abs() / gate);
        innovation.inflation.set(row, 1.0);
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

/// Another channel of an update: its e, and its correlation by S with the channel asked about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Other {
    channel: usize,
    e: f64,
    correlation: f64,
}

/// All but the k-th channel of an update.
pub(crate) fn others(rows: &[usize], k: usize, normal: &[f64], s: &DMatrix<f64>) -> Vec<Other> {
    let one = |(j, (&channel, &e)): (usize, (&usize, &f64))| Other {
        channel,
        e,
        correlation: s[(k, j)] / (s[(k, k)] * s[(j, j)]).sqrt(),
    };
    let all = rows.iter().zip(normal).enumerate();
    all.filter(|(j, _)| *j != k).map(one).collect()
}
