//! One row of a log.

use super::RobotLog;

/// One row of a log in SI units; `None` where a sample is missing, or where the log has no such channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RobotRow {
    /// Its number in the log.
    pub row: usize,
    /// t \[s\].
    pub time: f64,
    /// Torque applied at each wheel \[N m\], fl fr rl rr.
    pub torque: [Option<f64>; 4],
    /// a_x, w fl fr rl rr, v, r, as in [`RobotLog::channels`].
    pub channels: [Option<f64>; 7],
    /// Pitch \[rad\], nose-up positive.
    pub pitch: Option<f64>,
    /// Known extra mass at the centre of mass \[kg\].
    pub payload: Option<f64>,
}

impl RobotLog<'_> {
    pub(super) fn row(&self, row: usize) -> RobotRow {
        let at = |column: &[Option<f64>]| column.get(row).copied().flatten();
        RobotRow {
            row,
            time: self.time.get(row).copied().unwrap_or(f64::NAN),
            torque: self.torque.map(at),
            channels: self.channels.map(at),
            pitch: at(self.pitch),
            payload: at(self.payload),
        }
    }
}
