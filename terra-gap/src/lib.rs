//! Where does my simulator differ from reality, which unmodelled effect causes it, and how far does the gap shrink once
//! it is added?
//!
//! The soil of the nominal model is always re-fitted, with priors, because it imitates almost everything: what a re-fit
//! absorbs is no evidence for an effect. Every known effect then competes, with other terrain models, with pairs, with
//! "nothing is missing" and with "something unknown". This crate knows nothing of the simulator that makes test logs.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod abreast;
mod apart;
mod beside;
mod calibrate;
mod calibration;
mod candidates;
mod cause;
mod centring;
mod closing;
mod confirm;
mod contenders;
mod contrast;
mod dataset;
mod decide;
mod descent;
mod diagnose;
mod drive;
mod error;
mod evidence;
mod fit;
mod form_error;
mod forms;
mod holdout;
mod hypothesis;
mod kinematic;
mod latent;
mod loads;
mod locate;
mod logs;
mod memory;
mod mock;
mod next;
mod noise;
mod null;
mod other_soil;
mod pairs;
mod parallel;
mod predictor;
mod renewal;
mod rig;
mod rivals;
mod roomier;
mod roughness;
mod round;
mod run;
mod scout;
mod screen;
mod sensor;
mod settings;
mod setup;
mod shared;
mod signatures;
mod soil;
mod soil_space;
mod stand_in;
mod starts;
mod structures;
mod thin;
mod uneven;
mod unknown;
mod verdict;
mod watch;
mod ways;
mod weigh;
mod wheel_size;

pub use calibration::{Calibration, Case, Evidence};
pub use candidates::is_instrument;
pub use cause::{Cause, CauseKind};
pub use closing::{closing_drive, closing_rig};
pub use contrast::{Baseline, Shown};
pub use dataset::{ChannelInfo, DataSet, Factors, Observation};
pub use diagnose::{Diagnosis, Waterfall};
pub use drive::DriveWindows;
pub use error::GapError;
pub use form_error::is_form_error;
pub use holdout::{HeldOut, HoldOut, Interval};
pub use hypothesis::Hypothesis;
pub use kinematic::{
    KinematicPredictor, SkidSteerCentres, SkidSteerDrag, UniformSlip, diagnose_kinematic,
};
pub use locate::Place;
pub use logs::{JoinedLogs, Named};
pub use next::Experiment;
pub use rig::RigPredictor;
pub use roomier::by_roomier_windows;
pub use run::{
    diagnose_drive, diagnose_drive_against, diagnose_drives, diagnose_drives_against, diagnose_rig,
    diagnose_rig_against, diagnose_rigs, diagnose_rigs_against, diagnose_windows,
};
pub use settings::{LogKind, Settings};
pub use setup::{ADEQUATE, LOOK_ALIKE, OTHER_SOIL, Screened};
pub use soil_space::SoilSpace;
pub use verdict::{Provenance, to_json};
pub use watch::{
    BaselineSpan, ExpectedDelay, Hint, Instant, Look, SoilValue, Watch, WatchBaseline, WatchEvent,
    WatchSettings, WatchStep, watch_json,
};
