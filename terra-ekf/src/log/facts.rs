//! What is decided once for a segment, gathered in a first pass over its rows in memory that does not grow with them.

use super::clock::Pace;
use super::inputs::Heads;
use super::row::RobotRow;
use super::sides::Turning;
use super::start::{AHEAD, plausible, sample};
use crate::spaces::longitudinal_robot::CHANNELS;
use terra_model::Vehicle;

/// The first reading after a stretch without, which is longer than the rows a run sees ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Row within the segment.
    row: usize,
    value: f64,
}

/// One segment.
pub(super) struct SegmentFacts {
    /// Number of rows.
    pub(super) rows: usize,
    /// Where each input begins.
    pub(super) inputs: Heads,
    /// Channels with a finite reading.
    pub(super) present: [bool; CHANNELS],
    /// Left and right against the yaw rate.
    pub(super) turning: Turning,
    /// The clock's usual step, and whether rows are late.
    pub(super) pace: Pace,
    /// By channel; at most one in [`AHEAD`] rows.
    found: [Vec<Found>; CHANNELS],
    /// The last row of each channel that has a reading a robot can have.
    last: [usize; CHANNELS],
}

impl SegmentFacts {
    pub(super) fn new(vehicle: &Vehicle<f64>) -> Self {
        SegmentFacts {
            rows: 0,
            inputs: Heads::default(),
            present: [false; CHANNELS],
            turning: Turning::new(vehicle),
            pace: Pace::default(),
            found: Default::default(),
            last: [0; CHANNELS],
        }
    }

    pub(super) fn see(&mut self, row: &RobotRow, no_ground_speed: bool, late: f64) {
        self.inputs.see(row);
        for (seen, value) in self.present.iter_mut().zip(sample(row, no_ground_speed)) {
            *seen |= value.is_some();
        }
        self.turning.see(row);
        self.pace.see(row.time, late);
        for (i, reading) in row.channels.iter().enumerate() {
            let Some(value) = reading.filter(|v| plausible(i, *v)) else {
                continue;
            };
            if self.rows - self.last[i] > AHEAD {
                self.found[i].push(Found {
                    row: self.rows,
                    value,
                });
            }
            self.last[i] = self.rows;
        }
        self.rows += 1;
    }

    /// The next reading of a channel, more than [`AHEAD`] rows after `row`, when none of those rows has one.
    pub(super) fn beyond(&self, channel: usize, row: usize) -> Option<f64> {
        let found = self.found.get(channel)?;
        let next = found.partition_point(|f| f.row <= row);
        found.get(next).map(|f| f.value)
    }
}
