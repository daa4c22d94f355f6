//! Forces from a whole log: the robot's state space, any filter, any mixture of missing samples.

mod driver;
mod start;

pub use driver::estimate_forces;

use std::ops::Range;

use crate::config::{FilterConfig, Robust};
use crate::gaussian::Gaussian;
use crate::measurement::Innovation;
use crate::registry::Registry;
use crate::spaces::LongitudinalRobot;

/// Samples over which a missing torque is held at its last value.
pub const INPUT_HOLD: usize = 5;

/// A log as the filter needs it: plain slices in SI units, one sample a row, `None` where a sample is missing.
#[derive(Clone, Copy, Debug)]
pub struct RobotLog<'a> {
    /// t \[s\], strictly increasing inside a segment.
    pub time: &'a [f64],
    /// Rows of each segment: the filter restarts at each. Rows outside every segment are not estimated.
    pub segments: &'a [Range<usize>],
    /// Torque applied at each wheel \[N m\], fl fr rl rr.
    pub torque: [&'a [Option<f64>]; 4],
    /// a_x, w fl fr rl rr, v, r, in the order of [`CHANNEL_NAMES`](crate::spaces::longitudinal_robot::CHANNEL_NAMES);
    /// an empty slice is a channel the log does not have.
    pub channels: [&'a [Option<f64>]; 7],
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
    /// Channels missing or outside their gate at this row, torques held.
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
    /// Torque used at this row \[N m\], held where it was missing.
    pub torque: [f64; 4],
}

/// Where the samples went: in = used + rejected + missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples inside their gate.
    pub used: usize,
    /// Samples outside their gate, down-weighted when the update is robust.
    pub rejected: usize,
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
                match step.innovation.ratio.get(i).copied().flatten() {
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
