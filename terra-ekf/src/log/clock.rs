//! Where a row stands in time: after the last, at the same instant, late, or on a clock that jumped.

use crate::error::FilterError;

/// How a row's time follows the newest one before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arrival {
    /// The first row, or the clock jumped: the filter starts.
    Start {
        /// True for a jump.
        jumped: bool,
    },
    /// Later by so much \[s\].
    Next(f64),
    /// The same instant once more.
    Again,
    /// Earlier, by no more than the window.
    Late,
}

/// The clock of one segment.
pub(super) struct Clock {
    newest: Option<f64>,
    restart_gap: f64,
    late: f64,
    /// Usual step \[s\], the median; infinite for a segment too short to have one.
    usual: f64,
    /// True when some row of the segment is late, so that the past must be kept.
    pub(super) disordered: bool,
}

/// Steps of a segment from which its usual one is taken: the first so many, which bounds the memory.
const STEPS: usize = 1 << 20;

/// What a segment's times say before its first row is run.
#[derive(Default)]
pub(super) struct Pace {
    last: Option<f64>,
    steps: Vec<f64>,
    usual: Option<f64>,
    disordered: bool,
}

impl Pace {
    pub(super) fn see(&mut self, time: f64, late: f64) {
        let Some(last) = self.last.replace(time) else {
            return;
        };
        let dt = time - last;
        if dt > 0.0 && self.steps.len() < STEPS {
            self.steps.push(dt);
        }
        self.disordered |= time < last && last - time <= late;
    }

    /// Once all rows are seen: keeps the usual step alone.
    pub(super) fn close(&mut self) {
        let mut steps = std::mem::take(&mut self.steps);
        steps.sort_unstable_by(f64::total_cmp);
        self.usual = steps.get(steps.len() / 2).copied();
    }
}

impl Clock {
    /// The clock of a segment whose pace is closed.
    pub(super) fn new(pace: &Pace, restart_gap: f64, late: f64) -> Self {
        Clock {
            newest: None,
            restart_gap,
            late,
            usual: pace.usual.unwrap_or(f64::INFINITY),
            disordered: pace.disordered,
        }
    }

    /// Places the next row.
    ///
    /// # Errors
    /// [`FilterError::TimeStep`] for a time that is not finite: such a row has no place.
    pub(super) fn place(&mut self, time: f64) -> Result<Arrival, FilterError> {
        if !time.is_finite() {
            return Err(FilterError::TimeStep { dt: f64::NAN, time });
        }
        let Some(newest) = self.newest else {
            self.newest = Some(time);
            return Ok(Arrival::Start { jumped: false });
        };
        let dt = time - newest;
        if dt < 0.0 && -dt <= self.late {
            return Ok(Arrival::Late);
        }
        self.newest = Some(time);
        Ok(if dt == 0.0 {
            Arrival::Again
        } else if dt < 0.0 || dt > self.restart_gap {
            Arrival::Start { jumped: true }
        } else {
            Arrival::Next(dt)
        })
    }

    /// True for a step much longer than usual: rows are missing.
    pub(super) fn rows_missing(&self, dt: f64) -> bool {
        dt > 2.5 * self.usual
    }
}
