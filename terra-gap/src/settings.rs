//! What is asked of a diagnosis.

use terra_data::{GapSettings, Rover, SoilSharing};

use crate::holdout::HoldOut;

/// Kind of log, which decides what can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogKind {
    /// A vehicle.
    Drive,
    /// A vehicle whose log tells of no forces: its motion alone.
    Kinematic,
    /// One wheel on a testbed.
    Rig,
}

/// Options of a diagnosis.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Candidate effects by name; `None` for all.
    pub effects: Option<Vec<String>>,
    /// Groups to hold out; `None` for the default of the log's kind.
    pub hold_out: Option<HoldOut>,
    /// Largest number of effects combined (1 or 2).
    pub combine: usize,
    /// Mock cases of the log's own design to calibrate with; 0 takes the frozen calibration.
    pub calibrate: usize,
    /// Seed of the mock cases.
    pub seed: u64,
    /// Whether several logs share one soil or have one each.
    pub soil: SoilSharing,
    /// Most windows of a drive that are used; where there are more, every kind of motion stays and frequent ones are
    /// thinned. The frozen calibrations were made on some two hundred.
    pub windows: usize,
    /// Whether a drive without torques is diagnosed by its motion alone even where its accelerations tell of forces: on ground that
    /// no terrain model describes.
    pub motion_only: bool,
    /// Window, slip range, priors.
    pub gap: GapSettings,
}

impl Settings {
    /// [`windows`](Self::windows) where nothing else is said.
    pub const WINDOWS: usize = 512;

    /// The settings of a rover file.
    pub fn of(rover: &Rover) -> Self {
        Settings {
            effects: None,
            hold_out: None,
            combine: 2,
            calibrate: 0,
            seed: 0,
            soil: SoilSharing::Shared,
            windows: Self::WINDOWS,
            motion_only: false,
            gap: rover.gap,
        }
    }
}
