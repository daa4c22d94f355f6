//! What is known of the inputs at each row: torques with their gaps held, then given up; pitch and payload.

use super::row::RobotRow;

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

/// Where an input begins in a segment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Head {
    /// Rows before its first value.
    rows: usize,
    /// `None` when no row has a value.
    first: Option<f64>,
}

impl Head {
    fn see(&mut self, value: Option<f64>) {
        if self.first.is_none() {
            self.first = value;
            self.rows += usize::from(value.is_none());
        }
    }

    /// True when some row has a value.
    fn there(self) -> bool {
        self.first.is_some()
    }
}

/// Where each input begins.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Heads {
    torque: [Head; 4],
    pitch: Head,
    payload: Head,
}

impl Heads {
    pub(super) fn see(&mut self, row: &RobotRow) {
        let usable = Usable::of(row);
        for (head, value) in self.torque.iter_mut().zip(usable.torque) {
            head.see(value);
        }
        self.pitch.see(usable.pitch);
        self.payload.see(usable.payload);
    }

    /// True when some row has a pitch.
    pub(super) fn with_pitch(&self) -> bool {
        self.pitch.there()
    }

    /// Torques that no row of the segment has.
    pub(super) fn absent(&self) -> impl Iterator<Item = &'static str> {
        (0..4).filter(|&q| !self.torque[q].there()).map(torque_name)
    }
}

/// The inputs of a row that can be used.
struct Usable {
    torque: [Option<f64>; 4],
    pitch: Option<f64>,
    payload: Option<f64>,
}

impl Usable {
    fn of(row: &RobotRow) -> Self {
        let below =
            |value: Option<f64>, most: f64| value.filter(|v| v.is_finite() && v.abs() < most);
        Usable {
            torque: row.torque.map(|t| below(t, MOST_TORQUE)),
            pitch: below(row.pitch, std::f64::consts::FRAC_PI_2),
            payload: below(row.payload, f64::MAX),
        }
    }
}

/// An input column on its way over a segment.
#[derive(Clone, Copy, Debug)]
struct Column {
    last: f64,
    gap: usize,
}

impl Column {
    /// A gap at the head is filled with the first value after it.
    fn new(head: Head) -> Self {
        Column {
            last: head.first.unwrap_or(0.0),
            // Before the first value there is nothing to hold but that value itself.
            gap: if head.there() && head.rows <= INPUT_HOLD {
                0
            } else {
                INPUT_HOLD
            },
        }
    }

    /// Holds gaps for up to [`INPUT_HOLD`] samples.
    fn next(&mut self, value: Option<f64>) -> (f64, InputState) {
        let state = match value {
            Some(value) => {
                let back = self.gap > INPUT_HOLD;
                (self.last, self.gap) = (value, 0);
                if back {
                    InputState::Returned
                } else {
                    InputState::Given
                }
            }
            None => {
                self.gap += 1;
                if self.gap > INPUT_HOLD {
                    InputState::Unknown
                } else {
                    InputState::Held
                }
            }
        };
        (self.last, state)
    }
}

/// The inputs of a segment, row by row.
pub(super) struct Inputs {
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
    pub(super) fn new(heads: &Heads) -> Self {
        // A column without any value is a column the log does not have.
        let column = |head: Head| head.there().then(|| Column::new(head));
        Inputs {
            torque: heads.torque.map(Column::new),
            pitch: column(heads.pitch),
            payload: column(heads.payload),
        }
    }

    /// The inputs at the next row.
    pub(super) fn next(&mut self, row: &RobotRow) -> Input {
        let usable = Usable::of(row);
        let mut input = Input {
            torque: [0.0; 4],
            state: [InputState::Unknown; 4],
            pitch: self.pitch.as_mut().map(|p| {
                let (value, state) = p.next(usable.pitch);
                // A pitch is a slow thing: however long it is missing, the last one is the best guess.
                let logged = matches!(state, InputState::Given | InputState::Returned);
                (value, !logged)
            }),
            payload: self
                .payload
                .as_mut()
                .map_or(0.0, |p| p.next(usable.payload).0),
        };
        for (q, column) in self.torque.iter_mut().enumerate() {
            (input.torque[q], input.state[q]) = column.next(usable.torque[q]);
        }
        input
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
