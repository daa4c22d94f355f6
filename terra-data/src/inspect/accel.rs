//! The accelerometer against the change of the ground speed: units and signs of both, and the slope between them.
//!
//! # Equation
//! a = dv/dt + g sin(pitch): mean of the accelerometer over a piece of the log, difference of the ground speed over it.

use super::Suspicion;
use super::relation::{FEW, Three};
use crate::drive::DriveLog;

/// g \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Length of a piece \[s\]: the noise of two readings of the ground speed is then small against what a drive changes.
const PIECE: f64 = 1.0;
/// A piece that is this much longer has a hole.
const HOLE: f64 = 2.0;
/// dv/dt by the accelerometer is at most 1 in m/s² and 9.8 in g.
const IN_G: f64 = 5.0;
/// Tilt of the ground that is worth a word \[m/s²\]: a degree.
const TILT: f64 = 0.17;
/// Places in [`Three`].
const ACCEL: usize = 0;
const CHANGE: usize = 1;
const SLOPE: usize = 2;

/// What is needed of the rows, one after the other.
#[derive(Default)]
pub(super) struct Accelerations {
    piece: Option<Piece>,
    seen: Three,
    /// Accelerometer less dv/dt in a piece, in the one before, and nothing.
    left: Three,
    before: Option<f64>,
    squares: f64,
    with_pitch: bool,
}

/// From one reading of the ground speed on.
struct Piece {
    time: f64,
    speed: f64,
    rows: usize,
    accel: f64,
    slope: f64,
    /// Each row has what is asked for.
    whole: bool,
}

impl Accelerations {
    /// A segment begins.
    pub(super) fn begin(&mut self) {
        (self.piece, self.before) = (None, None);
    }

    /// Takes a row in.
    pub(super) fn see(&mut self, log: &DriveLog, row: usize) {
        let (Some(accel), Some(speed)) = (&log.accel_x, &log.ground_speed) else {
            return;
        };
        self.with_pitch |= log.pitch.is_some();
        let pitch = match &log.pitch {
            Some(pitch) => pitch.get(row),
            None => Some(0.0),
        };
        if let Some(piece) = &mut self.piece {
            match (accel.get(row), pitch) {
                (Some(a), Some(p)) => {
                    piece.rows += 1;
                    piece.accel += a;
                    piece.slope += GRAVITY * p.sin();
                }
                _ => piece.whole = false,
            }
        }
        let (Some(time), Some(speed)) = (log.time.get(row).copied(), speed.get(row)) else {
            return;
        };
        let over = self
            .piece
            .as_ref()
            .map_or(f64::INFINITY, |piece| time - piece.time);
        if over < PIECE {
            return;
        }
        let done = self.piece.replace(Piece {
            time,
            speed,
            rows: 0,
            accel: 0.0,
            slope: 0.0,
            whole: true,
        });
        let done = done.filter(|p| p.whole && p.rows > 0 && over < HOLE * PIECE);
        let Some(done) = done else {
            self.before = None;
            return;
        };
        let n = done.rows as f64;
        let (accel, change) = (done.accel / n, (speed - done.speed) / over);
        self.seen.see([accel, change, done.slope / n]);
        let left = accel - change;
        if let Some(before) = self.before.replace(left) {
            self.left.see([before, left, 0.0]);
            self.squares += left * left;
        }
    }

    pub(super) fn suspicion(&self) -> Option<Suspicion> {
        let one = |code, message| Some(Suspicion { code, message });
        let by_change = self.seen.partial(ACCEL, CHANGE)?;
        if by_change.against() {
            return one(
                "accel-sign",
                format!(
                    "accel_x_m_s2 falls where the vehicle speeds up (correlation {:.2} with the change of ground_speed_m_s): it is \
                     positive forward; sign flipped, in one of the two?",
                    by_change.correlation
                ),
            );
        }
        if by_change.together() && by_change.slope > IN_G {
            return one(
                "accel-unit",
                format!(
                    "ground_speed_m_s changes {:.1} times as fast as accel_x_m_s2 says: accelerometer in g? In [columns]: unit = \
                     \"g\"",
                    by_change.slope
                ),
            );
        }
        if self.with_pitch {
            let by_slope = self.seen.partial(SLOPE, ACCEL)?;
            return by_slope
                .against()
                .then(|| Suspicion {
                    code: "pitch-sign",
                    message: format!(
                        "what gravity leaves in accel_x_m_s2 falls as pitch_rad rises (correlation {:.2}): pitch_rad is positive \
                         nose-up; sign flipped?",
                        by_slope.correlation
                    ),
                });
        }
        // Noise of a reading of the ground speed has the other sign in the next piece; ground goes on.
        let goes_on = self.left.partial(0, 1)?;
        let tilt = (self.squares / self.left.rows() as f64).sqrt();
        (goes_on.together() && tilt > TILT && self.left.rows() >= FEW).then(|| {
            Suspicion {
                code: "pitch-missing",
                message: format!(
                    "accel_x_m_s2 differs from the change of ground_speed_m_s by {tilt:.2} m/s2, for seconds at a time: ground that \
                     rises and falls by {:.0} deg? Log pitch_rad",
                    (tilt / GRAVITY).asin().to_degrees()
                ),
            }
        })
    }
}
