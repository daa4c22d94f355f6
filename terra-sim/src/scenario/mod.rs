//! What is simulated: the scenario file in memory, SI units.

mod parse;
mod parse_world;
mod toml_table;
mod world;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use terra_data::Start;

use crate::error::SimError;
pub use world::{Motor, Patch, SensorSettings, SideSlip, World};

/// Largest file in bytes; a real one has a few kilobytes.
const LARGEST: u64 = 1 << 20;

/// A scenario of `terra simulate`: a drive (segments) or a rig (trials).
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Seed of every random number.
    pub seed: u64,
    /// Run of a campaign: each run has its own random streams under one seed. 0 for a file.
    pub run: u64,
    /// Path of the rover file, as written.
    pub rover: String,
    /// Sampling rate of a drive \[Hz\].
    pub rate: f64,
    /// Soil under the left wheels.
    pub left: Start,
    /// Soil under the right wheels; a rig uses `left`.
    pub right: Start,
    /// Terrain model.
    pub model: String,
    /// Factor on the rover's `[noise]`.
    pub noise_scale: f64,
    /// Manoeuvres of a drive, in order.
    pub segments: Vec<DriveSegment>,
    /// Trials of a rig, in order.
    pub trials: Vec<Trial>,
    /// What the truth has and the nominal simulator lacks.
    pub effects: Vec<EffectSetting>,
    /// Side slip, changes of soil, ruts, motors and sensors of a drive.
    pub world: World,
}

/// One number, linear in time over a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// At the segment's start.
    pub from: f64,
    /// At its end.
    pub to: f64,
}

impl Profile {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Profile {
            from: value,
            to: value,
        }
    }

    /// The value at a share of the segment, 0 to 1.
    pub fn at(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }
}

/// What drives the wheels fl, fr, rl, rr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Torque the motors deliver at the wheels \[N m\].
    Torque([Profile; 4]),
    /// Wheel speeds that a PI controller tracks \[rad/s\].
    WheelSpeed([Profile; 4]),
}

/// The motion a segment begins with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StartMotion {
    /// v \[m/s\].
    pub ground_speed: f64,
    /// ω of fl, fr, rl, rr \[rad/s\].
    pub wheel_speed: [f64; 4],
}

/// One manoeuvre.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveSegment {
    /// Its name in the log.
    pub name: String,
    /// Length \[s\].
    pub duration: f64,
    /// What drives it.
    pub command: Command,
    /// Motion at its start; only for the first segment or with `reset`. At rest when absent.
    pub start: Option<StartMotion>,
    /// Begin anew: motion, path and soil history do not carry on.
    pub reset: bool,
    /// Inclination of the ground \[rad\], nose-up positive, known to the log.
    pub pitch: Option<f64>,
    /// Side slope of the ground \[rad\], left side up positive, known to the log.
    pub roll: Option<f64>,
    /// Extra mass \[kg\], known to the log.
    pub payload: Option<f64>,
    /// Where it lies, forward, left and up of the centre of mass \[m\]; at the centre of mass, as the log says, when
    /// absent.
    pub payload_at: Option<[f64; 3]>,
    /// Towing force \[N\].
    pub tow_load: f64,
    /// Pass over the track, 1 on virgin soil; carries on from the segment before when absent.
    pub pass: Option<u32>,
}

impl DriveSegment {
    /// A manoeuvre on level virgin ground.
    pub fn new(name: impl Into<String>, duration: f64, command: Command) -> Self {
        DriveSegment {
            name: name.into(),
            duration,
            command,
            start: None,
            reset: false,
            pitch: None,
            roll: None,
            payload: None,
            payload_at: None,
            tow_load: 0.0,
            pass: None,
        }
    }
}

/// Trials of a rig: the grid slip x load x repeat, in that order (repeats innermost).
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Library slips \[1\].
    pub slip: Vec<f64>,
    /// W \[N\].
    pub normal_load: Vec<f64>,
    /// Repeats of each point.
    pub repeats: u32,
    /// v \[m/s\].
    pub travel_speed: f64,
    /// Wheel or soil variant (empty when there is none).
    pub condition: String,
    /// Pass in the same rut, 1 on virgin soil.
    pub pass: u32,
    /// The slips are run through in this time \[s\], evenly, one trial a load and repeat; each slip is a steady trial
    /// of its own when absent.
    pub ramp: Option<f64>,
}

/// One `[[effect]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectSetting {
    /// Registered name.
    pub name: String,
    /// Its numbers, *the* magnitude first; most effects have one.
    pub magnitude: Vec<f64>,
    /// Which formula of that name; the default one when absent.
    pub form: Option<String>,
}

impl EffectSetting {
    /// An effect's default form.
    pub fn new(name: impl Into<String>, magnitude: f64) -> Self {
        EffectSetting {
            name: name.into(),
            magnitude: vec![magnitude],
            form: None,
        }
    }
}

impl Scenario {
    /// Reads the text of a scenario file; `file` is its name in messages.
    ///
    /// # Errors
    /// [`ScenarioError`](crate::ScenarioError) with line and column: a syntax error, an unknown key with the nearest known one, a
    /// missing key, a wrong type, a number out of range, trials that multiply to more than a log can hold.
    pub fn parse(text: &str, file: &str) -> Result<Self, SimError> {
        Ok(parse::scenario(text, file)?)
    }

    /// Reads a scenario file.
    ///
    /// # Errors
    /// [`SimError::Unreadable`], also for a file of more than 1 MiB, or as [`Scenario::parse`].
    pub fn read(path: &Path) -> Result<Self, SimError> {
        let file = path.display().to_string();
        let unreadable = |reason: String| SimError::Unreadable {
            file: file.clone(),
            reason,
        };
        // A device may never end, so no more is taken than a scenario can have.
        let mut text = String::new();
        File::open(path)
            .and_then(|f| f.take(LARGEST + 1).read_to_string(&mut text))
            .map_err(|e| unreadable(e.to_string()))?;
        if text.len() as u64 > LARGEST {
            return Err(unreadable(format!("longer than {LARGEST} bytes")));
        }
        Scenario::parse(&text, &file)
    }

    /// The rover file of a scenario that lies at `scenario`.
    pub fn rover_path(&self, scenario: &Path) -> PathBuf {
        scenario.parent().unwrap_or(Path::new("")).join(&self.rover)
    }
}
