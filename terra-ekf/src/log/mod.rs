//! Forces from a whole log: the robot's state space, any filter, any mixture of missing samples.

mod clock;
mod driver;
mod facts;
mod inputs;
mod row;
mod run;
mod sides;
mod start;
mod stuck;

pub use driver::estimate_forces;
pub use inputs::{INPUT_HOLD, InputState};
pub use row::RobotRow;
pub use run::{FirstPass, ForceRun};

use std::ops::Range;

use crate::config::{FilterConfig, Robust};
use crate::gaussian::Gaussian;
use crate::measurement::Innovation;
use crate::registry::Registry;
use crate::spaces::LongitudinalRobot;
use crate::spaces::longitudinal_robot::{CHANNEL_NAMES, CHANNELS};

use terra_model::Vehicle;

/// A log as the filter needs it: plain slices in SI units, one sample a row, `None` where a sample is missing.
#[derive(Clone, Copy, Debug)]
pub struct RobotLog<'a> {
    /// t \[s\], increasing inside a segment; rows late by up to [`ForceConfig::late`] are put in their place by replay.
    pub time: &'a [f64],
    /// Rows of each segment: the filter restarts at each. Rows outside every segment are not estimated.
    pub segments: &'a [Range<usize>],
    /// Torque applied at each wheel \[N m\], fl fr rl rr.
    pub torque: [&'a [Option<f64>]; 4],
    /// a_x, w fl fr rl rr, v, r, in the order of [`CHANNEL_NAMES`](crate::spaces::longitudinal_robot::CHANNEL_NAMES);
    /// an empty slice is a channel the log does not have.
    pub channels: [&'a [Option<f64>]; 7],
    /// Pitch \[rad\], nose-up positive; empty when the log has none: the vehicle's own then holds.
    pub pitch: &'a [Option<f64>],
    /// Known extra mass at the centre of mass \[kg\], held from row to row; empty when the log has none.
    pub payload: &'a [Option<f64>],
}

/// How a log is run.
#[derive(Clone, Debug)]
pub struct ForceConfig {
    /// The robot with its noise.
    pub space: LongitudinalRobot,
    /// Filter by name (default `block`).
    pub filter: String,
    /// Smoothed beliefs instead of filtered ones.
    pub smooth: bool,
    /// Filter settings (default: robust updates on).
    pub settings: FilterConfig,
    /// Ground speed is not measured: the channel is ignored, and every step says that v is not observable.
    pub no_ground_speed: bool,
    /// Samples marked `starting` at the head of a segment (default 20).
    pub start_wait: usize,
    /// Gap after which the filter starts anew \[s\] (default 1): the torque in between is not known.
    pub restart_gap: f64,
    /// How late a row may be \[s\] (default .2): the filter goes back to its time and comes forward again over the rows
    /// since. A clock that steps back further has jumped, and the filter starts anew.
    pub late: f64,
    /// Where filters are looked up.
    pub registry: Registry,
}

impl ForceConfig {
    /// The defaults for a robot.
    pub fn new(space: LongitudinalRobot) -> Self {
        ForceConfig {
            space,
            filter: "block".to_owned(),
            smooth: false,
            settings: FilterConfig {
                robust: Some(Robust::default()),
                ..FilterConfig::default()
            },
            no_ground_speed: false,
            start_wait: 20,
            restart_gap: 1.0,
            late: 0.2,
            registry: Registry::builtin(),
        }
    }
}

/// How far to trust a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flag {
    /// All channels in, all inside their gate.
    Ok,
    /// The filter has just started.
    Starting,
    /// A covariance was reset after a timeout of rejections (the channels), or the filter restarted after a gap (none).
    Reset(Vec<&'static str>),
    /// Channels without which some states cannot be known are absent from the whole segment.
    NotObservable(Vec<&'static str>),
    /// What is doubtful at this row: channels missing, stuck or outside their gate; torques held or unknown; `pitch`
    /// held; `time` for a row that is late, a repeated instant, or behind missing rows; `sides` where yaw rate and wheel
    /// speeds say that left and right are swapped.
    Degraded(Vec<&'static str>),
}

impl std::fmt::Display for Flag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (word, names) = match self {
            Flag::Ok => return write!(f, "ok"),
            Flag::Starting => return write!(f, "starting"),
            Flag::Reset(names) => ("reset", names),
            Flag::NotObservable(names) => ("not_observable", names),
            Flag::Degraded(names) => ("degraded", names),
        };
        if names.is_empty() {
            write!(f, "{word}")
        } else {
            write!(f, "{word}:{}", names.join("+"))
        }
    }
}

/// Why a reading was not shown to the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dropped {
    /// The sensor repeats one reading to the last digit although it is a noisy one.
    Stuck,
    /// No robot moves like that.
    Implausible,
    /// The row repeats the one before, time and all.
    Duplicate,
    /// It came too late for an instant before the filter's start.
    TooLate,
}

/// The estimate at one row of the log.
#[derive(Clone, Debug)]
pub struct Step {
    /// Row in the log.
    pub row: usize,
    /// Number of the segment.
    pub segment: usize,
    /// t \[s\].
    pub time: f64,
    /// How far to trust it.
    pub flag: Flag,
    /// Rows since the filter last started, 0 at the first.
    pub since_start: usize,
    /// νᵀ S⁻¹ ν of the filter, with nominal noise.
    pub nis: f64,
    /// Channels used.
    pub dof: usize,
    /// The 18 states of [`longitudinal_robot`](crate::spaces::longitudinal_robot): filtered, or smoothed when asked for.
    pub belief: Gaussian,
    /// All that the update said.
    pub innovation: Innovation,
    /// Channels whose sample became the mean of a start, and was not used a second time.
    pub taken: Vec<usize>,
    /// Readings that the filter was not shown: channel and why.
    pub dropped: Vec<(usize, Dropped)>,
    /// Torque used at this row \[N m\], held where it was missing.
    pub torque: [f64; 4],
    /// What is known of it.
    pub torque_state: [InputState; 4],
    /// The vehicle at this row: with its payload, on this slope.
    pub vehicle: Vehicle<f64>,
}

/// Where the samples went: in = used + rejected + missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples inside their gate.
    pub used: usize,
    /// Samples outside their gate, down-weighted when the update is robust, and those that were dropped.
    pub rejected: usize,
    /// Of these, samples dropped because the sensor was stuck.
    pub stuck: usize,
    /// Samples that are not there.
    pub missing: usize,
    /// Covariance resets.
    pub resets: usize,
}

impl Tally {
    /// Counts each of the seven channels over steps.
    pub fn of(steps: &[Step]) -> [Tally; 7] {
        let mut tally = [Tally::default(); 7];
        for step in steps {
            for (i, t) in tally.iter_mut().enumerate() {
                let dropped = step.dropped.iter().find(|d| d.0 == i);
                t.stuck += usize::from(dropped.is_some_and(|d| d.1 == Dropped::Stuck));
                match step.innovation.ratio.get(i) {
                    _ if dropped.is_some() => t.rejected += 1,
                    Some(ratio) if ratio > 1.0 => t.rejected += 1,
                    Some(_) => t.used += 1,
                    None if step.taken.contains(&i) => t.used += 1,
                    None => t.missing += 1,
                }
                t.resets += usize::from(step.innovation.resets.contains(&i));
            }
        }
        tally
    }
}

/// Where the torque samples of one wheel went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TorqueTally {
    /// Samples used.
    pub used: usize,
    /// Samples missing and held.
    pub held: usize,
    /// Samples missing for longer.
    pub unknown: usize,
    /// Times that a torque came back and its resistance started afresh.
    pub resets: usize,
}

impl TorqueTally {
    /// Counts the torque of each wheel over steps.
    pub fn of(steps: &[Step]) -> [TorqueTally; 4] {
        let mut tally = [TorqueTally::default(); 4];
        for step in steps {
            for (t, state) in tally.iter_mut().zip(step.torque_state) {
                match state {
                    InputState::Given => t.used += 1,
                    InputState::Held => t.held += 1,
                    InputState::Unknown => t.unknown += 1,
                    InputState::Returned => {
                        t.used += 1;
                        t.resets += 1;
                    }
                }
            }
        }
        tally
    }
}

/// A reading that did not count in full, as [`rejected`] lists them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejected {
    /// Row in the log.
    pub row: usize,
    /// Channel by name.
    pub channel: &'static str,
    /// |ν| over its standard deviation, where the filter saw the reading.
    pub deviations: Option<f64>,
    /// Why the filter was not shown it; `None` for a reading outside its gate.
    pub dropped: Option<Dropped>,
}

/// Every reading that did not count in full, in order. `gate` is that of the filter's settings.
pub fn rejected(steps: &[Step], gate: f64) -> Vec<Rejected> {
    let mut list = Vec::new();
    for step in steps {
        for (i, &channel) in CHANNEL_NAMES.iter().enumerate().take(CHANNELS) {
            let ratio = step.innovation.ratio.get(i);
            let dropped = step.dropped.iter().find(|d| d.0 == i).map(|d| d.1);
            if dropped.is_some() || ratio.is_some_and(|r| r > 1.0) {
                list.push(Rejected {
                    row: step.row,
                    channel,
                    deviations: ratio.map(|r| r * gate),
                    dropped,
                });
            }
        }
    }
    list
}
