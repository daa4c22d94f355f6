//! What is in a log, and what in it looks wrong, before any model is asked.
//!
//! Counting needs no vehicle; some suspicions are sharper with the rover file's wheel radius and track.

mod accel;
mod clock;
mod drive;
mod motion;
mod relation;
mod rig;
mod rig_forces;
mod rig_speeds;
mod thinned;
mod torque;
mod wheel_size;
mod wheels;
mod zeros;

use crate::kind::LogKind;
use crate::notes::{MissingCells, ReadNotes};

pub use clock::{Gap, Pace};
pub use drive::{DriveInspector, inspect_drive};
pub use rig::inspect_rig;
pub use rig_speeds::slip_against_speeds;

/// One channel of a log, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelSummary {
    /// Contract column.
    pub name: String,
    /// Samples with a value.
    pub present: usize,
    /// Samples without: blank, and not finite.
    pub missing: MissingCells,
    /// Smallest, mean and largest value; `None` when all are missing.
    pub range: Option<[f64; 3]>,
}

/// One group of rows: a segment of a drive, a trial of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Its name in the log.
    pub name: String,
    /// Number of rows.
    pub rows: usize,
    /// Its clock; `None` without time or with one row.
    pub pace: Option<Pace>,
}

/// Something that is probably a mistake in the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspicion {
    /// A short name that stays the same: `sides-swapped`, `rpm`, ...
    pub code: &'static str,
    /// What was seen, with its numbers, and what it would mean.
    pub message: String,
}

/// What is in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Drive or rig.
    pub kind: LogKind,
    /// Rows that were read.
    pub rows: usize,
    /// Its channels, in the contract's order.
    pub channels: Vec<ChannelSummary>,
    /// Segments or trials, in order.
    pub groups: Vec<Group>,
    /// What looks wrong.
    pub suspicions: Vec<Suspicion>,
    /// Rows that cannot be used, with line and reason.
    pub dropped: Vec<(u64, String)>,
    /// Columns that no command reads, and missing cells.
    pub notes: ReadNotes,
    /// What the reader had to say.
    pub warnings: Vec<String>,
}

/// Samples held to find a median or a quantile of; of a longer log, some stand for all.
const KEPT: usize = 1 << 18;

/// The samples of a channel, counted one by one.
struct Count {
    present: usize,
    absent: usize,
    sum: f64,
    low: f64,
    high: f64,
}

impl Default for Count {
    fn default() -> Self {
        Count {
            present: 0,
            absent: 0,
            sum: 0.0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        }
    }
}

impl Count {
    fn see(&mut self, value: Option<f64>) {
        match value {
            Some(x) => {
                self.present += 1;
                self.sum += x;
                self.low = self.low.min(x);
                self.high = self.high.max(x);
            }
            None => self.absent += 1,
        }
    }

    fn summary(&self, name: &str, notes: &ReadNotes) -> ChannelSummary {
        let not_finite = notes.missing.get(name).map_or(0, |m| m.not_finite);
        let mean = self.sum / self.present as f64;
        ChannelSummary {
            name: name.to_owned(),
            present: self.present,
            missing: MissingCells {
                blank: self.absent.saturating_sub(not_finite),
                not_finite: not_finite.min(self.absent),
            },
            range: (self.present > 0).then_some([self.low, mean, self.high]),
        }
    }
}

/// Largest absolute value.
fn largest(channel: &ChannelSummary) -> f64 {
    channel
        .range
        .map_or(0.0, |[low, _, high]| low.abs().max(high.abs()))
}

/// An angle of ground or wheel that is larger than a vehicle survives.
fn angle(channel: &ChannelSummary) -> Option<Suspicion> {
    let found = largest(channel);
    (found > std::f64::consts::FRAC_PI_2).then(|| Suspicion {
        code: "degrees",
        message: format!(
            "{} reaches {found:.1} rad = {:.0} deg: degrees logged as radians? In [columns]: unit = \"deg\"",
            channel.name,
            found.to_degrees()
        ),
    })
}

/// A positive number in two or three digits, as it is read best.
fn digits(x: f64) -> String {
    match x {
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 0.1 => format!("{x:.2}"),
        x => format!("{x:.1e}"),
    }
}

/// The value below which a share of the values lies.
fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let k = (share * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(k).copied()
}
