//! What is in a drive log.

use std::collections::BTreeMap;

use super::clock::Clock;
use super::motion::Motion;
use super::wheel_size::wheel_size;
use super::zeros::Zeros;
use super::{ChannelSummary, Count, Group, Inspection, Suspicion, angle, largest};
use crate::drive::{DriveLog, WHEELS};
use crate::kind::LogKind;
use crate::notes::ReadNotes;
use crate::read_drive::DriveBlock;
use crate::rover::Rover;

/// Fewest equal samples in a row that can be called stuck.
const STUCK_ROWS: usize = 25;
/// Rows over which a slower sensor's value is held at least, how often, and the share of its values that are held as long.
const HELD: (usize, usize, f64) = (3, 20, 0.8);
/// Rows up to which a hold is counted by its length.
const LONGEST_HOLD: usize = 256;
/// An accelerometer along x that reads more than this on average carries gravity \[m/s²\].
const GRAVITY_ON_X: f64 = 5.0;
/// Channels that may stand still.
const STEADY: [&str; 5] = ["payload_kg", "pass", "pitch_rad", "roll_rad", "distance_m"];

/// Counts the channels of a drive log and says what looks wrong in it. With a rover the checks of units know the wheel's
/// radius and the track.
pub fn inspect_drive(log: &DriveLog, rover: Option<&Rover>) -> Inspection {
    let mut inspector = DriveInspector::new(rover);
    inspector.look(log, false);
    inspector.finish()
}

/// [`inspect_drive`] of a log that comes block by block.
///
/// Memory: the segments, their gaps, and the samples that a usual value is found among. A segment's usual step is the
/// median of its first 262 144 steps; of a log with more rows than that, ground speed is held against wheel speed in
/// every second row, every fourth, and so on, so that no more than 262 144 are held. All else counts every row.
pub struct DriveInspector<'r> {
    rover: Option<&'r Rover>,
    rows: usize,
    channels: Vec<Channel>,
    groups: Vec<Group>,
    /// Of the last group.
    clock: Clock,
    motion: Motion,
    loads: bool,
    notes: ReadNotes,
    warnings: Vec<String>,
}

/// One channel on its way over a log.
struct Channel {
    name: String,
    count: Count,
    still: Still,
    zeros: Zeros,
}

impl<'r> DriveInspector<'r> {
    /// Before the first block. With a rover the checks of units know the wheel's radius and the track.
    pub fn new(rover: Option<&'r Rover>) -> Self {
        DriveInspector {
            rover,
            rows: 0,
            channels: Vec::new(),
            groups: Vec::new(),
            clock: Clock::default(),
            motion: Motion::default(),
            loads: false,
            notes: ReadNotes::default(),
            warnings: Vec::new(),
        }
    }

    /// Takes the next block in.
    pub fn block(&mut self, block: &DriveBlock) {
        self.look(&block.log, block.continues);
    }

    fn look(&mut self, log: &DriveLog, continues: bool) {
        let series = log.channels();
        if self.channels.is_empty() {
            let new = |(name, _): &(String, _)| Channel {
                name: name.clone(),
                count: Count::default(),
                still: Still::default(),
                zeros: Zeros::default(),
            };
            self.channels = series.iter().map(new).collect();
        }
        for (channel, (_, one)) in self.channels.iter_mut().zip(&series) {
            one.iter().for_each(|v| channel.count.see(v));
            if STEADY.contains(&channel.name.as_str()) {
                continue;
            }
            for (i, segment) in log.segments.iter().enumerate() {
                if i > 0 || !continues {
                    channel.still.begin();
                    channel.zeros.begin();
                }
                for k in segment.rows.clone() {
                    channel.still.see(one.get(k), k, log);
                    channel.zeros.see(one.get(k));
                }
            }
        }
        for (i, segment) in log.segments.iter().enumerate() {
            if i > 0 || !continues {
                self.close();
                self.motion.begin();
                self.groups.push(Group {
                    name: segment.name.clone(),
                    rows: 0,
                    pace: None,
                });
            }
            if let Some(group) = self.groups.last_mut() {
                group.rows += segment.rows.len();
            }
            let time = log.time.get(segment.rows.clone()).unwrap_or_default();
            time.iter().for_each(|t| self.clock.see(*t));
            for k in segment.rows.clone() {
                self.motion.see(log, k);
            }
        }
        self.loads |= log.normal_load.is_some();
        self.rows += log.len();
        self.notes.add(&log.notes);
        self.warnings.extend_from_slice(&log.warnings);
    }

    /// Ends the last group.
    fn close(&mut self) {
        let clock = std::mem::take(&mut self.clock);
        if let Some(group) = self.groups.last_mut() {
            group.pace = clock.pace();
        }
    }

    /// What is in the log, and what looks wrong in it.
    pub fn finish(mut self) -> Inspection {
        self.close();
        let channels: Vec<ChannelSummary> = self
            .channels
            .iter()
            .map(|c| c.count.summary(&c.name, &self.notes))
            .collect();
        let mut suspicions: Vec<Suspicion> = self
            .groups
            .iter()
            .filter_map(|g| g.pace.as_ref().map(|p| p.suspicions(&g.name)))
            .flatten()
            .collect();
        suspicions.extend(slow_clock(&self.groups));
        for channel in &channels {
            suspicions.extend(plausible(channel));
            suspicions.extend(self.rover.and_then(|r| payload(channel, r)));
        }
        suspicions.extend(self.motion.suspicions(self.rover));
        suspicions.extend(self.rover.and_then(wheel_size));
        for channel in &self.channels {
            suspicions.extend(channel.still.suspicion(&channel.name, self.rows));
            suspicions.extend(channel.still.held(&channel.name));
            suspicions.extend(channel.zeros.suspicion(&channel.name, self.rows));
        }
        if !self.loads && self.rover.is_none_or(|r| r.vehicle.is_none()) {
            suspicions.push(Suspicion {
                code: "load-missing",
                message: "no normal_load_{fl,fr,rl,rr}_N and no [vehicle]: give --rover, whose mass and geometry set the wheel loads"
                    .to_owned(),
            });
        }
        Inspection {
            kind: LogKind::Drive,
            rows: self.rows,
            channels,
            groups: self.groups,
            suspicions,
            dropped: Vec::new(),
            notes: self.notes,
            warnings: self.warnings,
        }
    }
}

/// Rows of a drive that are farther apart than this \[s\] are hardly seconds, and where they are as far as this, milliseconds no more.
const SLOW_ROWS: f64 = 0.8;
const MICROSECONDS: f64 = 800.0;

/// A clock that ticks in a smaller unit.
fn slow_clock(groups: &[Group]) -> Option<Suspicion> {
    let steps = groups
        .iter()
        .filter_map(|g| g.pace.as_ref())
        .map(|p| p.step);
    let step = steps.fold(f64::INFINITY, f64::min);
    let unit = match step {
        s if !(SLOW_ROWS..f64::INFINITY).contains(&s) => return None,
        s if s < MICROSECONDS => "ms",
        _ => "us",
    };
    Some(Suspicion {
        code: "time-unit",
        message: format!(
            "rows are {step} s apart: time_s in {unit}? In [columns]: unit = \"{unit}\"; a drive needs several rows a second"
        ),
    })
}

/// What one channel's range says on its own.
fn plausible(channel: &ChannelSummary) -> Option<Suspicion> {
    let name = channel.name.as_str();
    if channel.present == 0 {
        return Some(Suspicion {
            code: "empty-channel",
            message: format!("{name} has no value in any row: remove the column or record it"),
        });
    }
    if name == "pitch_rad" || name == "roll_rad" {
        return angle(channel);
    }
    let mean = channel.range.map_or(0.0, |[_, mean, _]| mean);
    if name == "accel_x_m_s2" && mean.abs() > GRAVITY_ON_X {
        return Some(Suspicion {
            code: "gravity-on-x",
            message: format!(
                "{name} averages {mean:.2} m/s2: gravity lies on it, so this is not the axis that points forward"
            ),
        });
    }
    if name.starts_with("sinkage") && largest(channel) > 0.5 {
        return Some(Suspicion {
            code: "millimetres",
            message: format!(
                "{name} reaches {:.1} m: millimetres logged as metres? In [columns]: unit = \"mm\"",
                largest(channel)
            ),
        });
    }
    let low = channel.range.map_or(1.0, |[low, ..]| low);
    (name.starts_with("normal_load") && low <= 0.0).then(|| Suspicion {
        code: "load-sign",
        message: format!("{name} falls to {low:.1} N: a load presses down and is positive"),
    })
}

/// Vehicle masses beyond which no vehicle carries a payload.
const MUCH: f64 = 5.0;

/// A payload in another unit: with it every wheel sinks out of sight, and its windows are left out.
fn payload(channel: &ChannelSummary, rover: &Rover) -> Option<Suspicion> {
    let mass = rover.vehicle.as_ref()?.mass;
    let most = largest(channel);
    (channel.name == "payload_kg" && most > MUCH * mass).then(|| Suspicion {
        code: "payload-unit",
        message: format!(
            "payload_kg reaches {most} kg on a vehicle of {mass} kg: in grams? In [columns]: unit = \"g\""
        ),
    })
}

/// Rows in which a channel has one and the same value.
#[derive(Clone, Copy)]
struct Stretch {
    value: Option<f64>,
    from: f64,
    rows: usize,
    /// Lowest and highest speed of each wheel in them.
    speeds: [(f64, f64); 4],
}

impl Stretch {
    const NONE: Stretch = Stretch {
        value: None,
        from: 0.0,
        rows: 0,
        speeds: [(f64::INFINITY, f64::NEG_INFINITY); 4],
    };
}

/// The longest stretch of a channel, and how many there are of each length.
struct Still {
    now: Stretch,
    longest: Stretch,
    lengths: BTreeMap<usize, usize>,
}

impl Default for Still {
    fn default() -> Self {
        Still {
            now: Stretch::NONE,
            longest: Stretch::NONE,
            lengths: BTreeMap::new(),
        }
    }
}

impl Still {
    /// A segment begins.
    fn begin(&mut self) {
        self.now = Stretch::NONE;
    }

    /// Takes the sample of a row in.
    fn see(&mut self, value: Option<f64>, row: usize, log: &DriveLog) {
        if value.is_none() || value != self.now.value {
            if self.now.value.is_some() {
                let length = self.now.rows.min(LONGEST_HOLD);
                *self.lengths.entry(length).or_default() += 1;
            }
            self.now = Stretch {
                value,
                from: log.time.get(row).copied().unwrap_or(f64::NAN),
                ..Stretch::NONE
            };
        }
        self.now.rows += 1;
        for ((low, high), speed) in self.now.speeds.iter_mut().zip(&log.wheel_speed) {
            if let Some(v) = speed.get(row) {
                *low = low.min(v);
                *high = high.max(v);
            }
        }
        if self.now.rows > self.longest.rows {
            self.longest = self.now;
        }
    }

    /// Values that change every so many rows only, and then every time: a sensor of a slower rate, held in between.
    fn held(&self, name: &str) -> Option<Suspicion> {
        let (least, often, share) = HELD;
        let (&rows, &times) = self.lengths.iter().max_by_key(|(_, times)| **times)?;
        let all: usize = self.lengths.values().sum();
        let held = (least..LONGEST_HOLD).contains(&rows) && times >= often;
        // A diagnosis reads a ground speed that is held where it changes.
        let but = if name == "ground_speed_m_s" {
            " by all but `terra gap`"
        } else {
            ""
        };
        (held && times as f64 >= share * all as f64).then(|| Suspicion {
            code: "held",
            message: format!(
                "{name} changes every {rows} rows only, {times} times: a slower sensor whose value is held in between? Its noise is then the same {rows} times over, and counted as if it were not{but}: leave the cells in between empty"
            ),
        })
    }

    /// A value that stands still while the wheels change their speed.
    fn suspicion(&self, name: &str, rows: usize) -> Option<Suspicion> {
        let longest = &self.longest;
        if longest.rows < STUCK_ROWS.max(rows / 20) {
            return None;
        }
        // Speeds of the other wheels in these rows: if they move, this value should.
        let moves = WHEELS
            .iter()
            .zip(longest.speeds)
            .filter(|(wheel, _)| !name.contains(&format!("_{wheel}_")))
            .any(|(_, (low, high))| high - low > 0.05 * high.abs().max(low.abs()));
        let value = longest.value?;
        moves.then(|| Suspicion {
            code: "stuck",
            message: format!(
                "{name} is exactly {value} for {} rows from {} s while wheels change speed: a stuck or unplugged sensor?",
                longest.rows, longest.from
            ),
        })
    }
}
