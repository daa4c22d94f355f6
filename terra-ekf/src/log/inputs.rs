//! What is known of the inputs at each row: torques with their gaps held, then given up; pitch and payload.

use std::ops::Range;

use super::RobotLog;

/// Samples over which a missing input is held at its last value.
pub const INPUT_HOLD: usize = 5;

/// Torques beyond this are no reading \[N m\].
const MOST_TORQUE: f64 = 1e6;

const TORQUE_NAMES: [&str; 4] = ["torque_fl", "torque_fr", "torque_rl", "torque_rr"];

/// The name of a wheel's torque in flags.
pub(super) fn torque_name(wheel: usize) -> &'static str {
    TORQUE_NAMES.get(wheel).copied().unwrap_or("torque")
}

/// What is known of an input at a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputState {
    /// It was logged.
    #[default]
    Given,
    /// It is missing, and held at the last value: for up to [`INPUT_HOLD`] samples.
    Held,
    /// It has been missing for longer: the wheel speed says nothing of the resistance, whose spread grows.
    Unknown,
    /// It is back after having been unknown: the resistance starts afresh, from the spread of the prior.
    Returned,
}

/// An input column over a segment.
pub(super) struct Column {
    values: Vec<(f64, InputState)>,
    /// True when no row has a value.
    pub(super) absent: bool,
}

impl Column {
    /// Holds gaps for up to [`INPUT_HOLD`] samples; a gap at the head is filled with the first value after it.
    pub(super) fn new(column: &[Option<f64>], rows: Range<usize>, most: f64) -> Self {
        let at = |row: usize| {
            let value = column.get(row).copied().flatten();
            value.filter(|v| v.is_finite() && v.abs() < most)
        };
        let first = rows.clone().find_map(at);
        let mut last = first.unwrap_or(0.0);
        // Before the first value there is nothing to hold but that value itself.
        let mut gap = rows
            .clone()
            .position(|row| at(row).is_some())
            .map_or(
                INPUT_HOLD,
                |head| if head <= INPUT_HOLD { 0 } else { INPUT_HOLD },
            );
        let values = rows
            .map(|row| match at(row) {
                Some(value) => {
                    let state = if gap > INPUT_HOLD {
                        InputState::Returned
                    } else {
                        InputState::Given
                    };
                    (last, gap) = (value, 0);
                    (value, state)
                }
                None => {
                    gap += 1;
                    let state = if gap > INPUT_HOLD {
                        InputState::Unknown
                    } else {
                        InputState::Held
                    };
                    (last, state)
                }
            })
            .collect();
        Column {
            values,
            absent: first.is_none(),
        }
    }

    pub(super) fn at(&self, k: usize) -> (f64, InputState) {
        self.values
            .get(k)
            .copied()
            .unwrap_or((0.0, InputState::Unknown))
    }
}

/// The inputs of a segment.
pub(super) struct Inputs {
    first: usize,
    torque: [Column; 4],
    pitch: Option<Column>,
    payload: Option<Column>,
}

/// The inputs at one row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Input {
    pub(super) torque: [f64; 4],
    pub(super) state: [InputState; 4],
    /// Pitch \[rad\] and whether it is anything but logged; `None` for a log without.
    pub(super) pitch: Option<(f64, bool)>,
    /// Known extra mass \[kg\].
    pub(super) payload: f64,
}

impl Inputs {
    pub(super) fn new(log: &RobotLog<'_>, rows: Range<usize>) -> Self {
        // A column without any value is a column the log does not have.
        let column = |values: &[Option<f64>], most: f64| {
            Some(Column::new(values, rows.clone(), most)).filter(|c| !c.absent)
        };
        Inputs {
            first: rows.start,
            torque: log
                .torque
                .map(|t| Column::new(t, rows.clone(), MOST_TORQUE)),
            pitch: column(log.pitch, std::f64::consts::FRAC_PI_2),
            payload: column(log.payload, f64::MAX),
        }
    }

    /// Torques that no row of the segment has.
    pub(super) fn absent(&self) -> impl Iterator<Item = &'static str> {
        (0..4).filter(|&q| self.torque[q].absent).map(torque_name)
    }

    pub(super) fn at(&self, row: usize) -> Input {
        let k = row - self.first;
        Input {
            torque: std::array::from_fn(|q| self.torque[q].at(k).0),
            state: std::array::from_fn(|q| self.torque[q].at(k).1),
            pitch: self.pitch.as_ref().map(|p| {
                let (value, state) = p.at(k);
                // A pitch is a slow thing: however long it is missing, the last one is the best guess.
                let logged = matches!(state, InputState::Given | InputState::Returned);
                (value, !logged)
            }),
            payload: self.payload.as_ref().map_or(0.0, |p| p.at(k).0),
        }
    }
}

impl Input {
    /// The vector the state space takes: the mean over a step from `before` to `self`, or `self` alone.
    pub(super) fn vector(&self, before: &Input) -> Vec<f64> {
        let mut u: Vec<f64> = (0..4)
            .map(|q| 0.5 * (before.torque[q] + self.torque[q]))
            .collect();
        if let Some((pitch, _)) = self.pitch {
            u.push(0.5 * (pitch + before.pitch.map_or(pitch, |p| p.0)));
        }
        u
    }
}
