//! What would really happen? Truth simulation of vehicles and wheel rigs, with effects, sensors and noise.
//!
//! A [`Scenario`] says what is driven where and what the world has that the nominal simulator lacks. [`simulate_drive`]
//! integrates a four-wheeled vehicle forward in time, [`simulate_rig`] runs steady trials of one wheel; both return
//! the log a user would have and the truth behind it. Same seed, same bytes.
//!
//! ```
//! use terra_model::Registry;
//! use terra_sim::{EffectSetting, paper, simulate_drive};
//! let mut scenario = paper::torque_ramp("dry_sand", 1)?;
//! scenario.segments[0].duration = 0.1;
//! scenario.effects.push(EffectSetting::new("slip-sinkage", 0.3));
//! let run = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin())?;
//! assert_eq!(run.log.len(), 10);
//! # Ok::<(), terra_sim::SimError>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod control;
mod drive;
mod effects;
mod error;
mod filter;
mod force_table;
mod forms;
mod grid;
mod ground;
mod history;
mod instant;
pub mod integrate;
mod loads;
mod noise;
mod off_library;
pub mod paper;
mod programme;
mod record;
mod rig;
mod robot;
mod scenario;
mod sensors;
mod soil;
mod truth;
mod wheel;

pub use drive::{DriveRun, simulate_drive, simulate_drive_with};
pub use error::{ScenarioError, SimError};
pub use forms::form_variants;
pub use integrate::Integrator;
pub use off_library::{TruthOnly, off_library};
pub use rig::{RigRun, simulate_rig};
pub use robot::GRAVITY;
pub use scenario::{
    Command, DriveSegment, EffectSetting, Motor, Patch, Profile, Scenario, SensorSettings,
    SideSlip, StartMotion, Trial, World,
};
pub use truth::{DriveTruth, RigTruth, TruthColumn};
