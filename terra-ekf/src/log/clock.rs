//! Where a row stands in time: after the last, at the same instant, late, or on a clock that jumped.

use std::ops::Range;

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
    /// Usual step \[s\]; infinite for a segment too short to have one.
    usual: f64,
    /// True when some row of the segment is late, so that the past must be kept.
    pub(super) disordered: bool,
}

impl Clock {
    pub(super) fn new(time: &[f64], rows: Range<usize>, restart_gap: f64, late: f64) -> Self {
        let time = time.get(rows).unwrap_or_default();
        let mut steps: Vec<f64> = time
            .windows(2)
            .map(|t| t[1] - t[0])
            .filter(|dt| *dt > 0.0)
            .collect();
        steps.sort_unstable_by(f64::total_cmp);
        let disordered = time.windows(2).any(|t| t[1] < t[0] && t[0] - t[1] <= late);
        Clock {
            newest: None,
            restart_gap,
            late,
            usual: steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY),
            disordered,
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
