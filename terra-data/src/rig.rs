//! The log of a single-wheel testbed: one contact a row.

use crate::notes::ReadNotes;

/// A measured value and its 1-sigma, where the log gives one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The value, SI.
    pub value: f64,
    /// Its standard deviation from the row's own `_sd_` column.
    pub sd: Option<f64>,
}

/// One steady trial, or one sample when the log has `time_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct RigRow {
    /// Line in the file.
    pub line: u64,
    /// Repeats and windows are grouped by trial.
    pub trial: String,
    /// Wheel or soil variant (empty when there is none).
    pub condition: String,
    /// Pass in the same rut; 1 is virgin soil.
    pub pass: u32,
    /// t \[s\].
    pub time: Option<f64>,
    /// Library slip \[1\].
    pub slip: Measured,
    /// W \[N\].
    pub normal_load: Measured,
    /// D \[N\].
    pub drawbar_pull: Option<Measured>,
    /// T at the axle \[N m\].
    pub torque: Option<Measured>,
    /// z \[m\].
    pub sinkage: Option<Measured>,
    /// F_y \[N\].
    pub side_force: Option<Measured>,
    /// β \[rad\].
    pub slip_angle: Option<f64>,
    /// v \[m/s\].
    pub travel_speed: Option<f64>,
    /// ω \[rad/s\].
    pub wheel_speed: Option<f64>,
}

/// A testbed's log.
#[derive(Clone, Debug, Default)]
pub struct RigLog {
    /// Rows with slip, load and at least one force or sinkage.
    pub rows: Vec<RigRow>,
    /// Rows left out, with their line and the reason.
    pub dropped: Vec<(u64, String)>,
    /// What a reader of the result should know (slip and speeds disagree, ...).
    pub warnings: Vec<String>,
    /// What the reader saw beside the numbers: unused columns, missing cells.
    pub notes: ReadNotes,
}
