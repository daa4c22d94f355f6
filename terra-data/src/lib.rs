//! Logs and rover descriptions: what a user has on disk, checked and in SI units.
//!
//! [`read_rover`] reads the nominal simulator, [`read_drive_log`] and [`read_rig_log`] read measurements with the names
//! and units it declares, [`read_terrains`] a user's own soils. Nothing is repaired or guessed: a missing sample stays
//! missing and is counted, a mistake is a [`DataError`] with its file, line and column.
//!
//! ```
//! use terra_data::{parse_rover, read_rig_log_from};
//! let rig = parse_rover(
//!     r#"
//!     [wheel]
//!     radius_m = 0.058
//!     width_m = 0.05
//!     [terrain]
//!     model = "wong-reece"
//!     [columns]
//!     drawbar_pull_N = { from = "Fx", unit = "kN" }
//!     slip = { from = "slip_pct", convention = "percent" }
//!     "#,
//!     "rig.toml",
//! )?;
//! let log = read_rig_log_from("slip_pct,normal_load_N,Fx\n20,80,0.0145\n".as_bytes(), "log.csv", &rig)?;
//! assert_eq!(log.rows[0].slip.value, 0.2);
//! assert_eq!(log.rows[0].drawbar_pull.map(|m| m.value), Some(14.5));
//! # Ok::<(), terra_data::DataError>(())
//! ```
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod atomic;
mod columns;
mod compliance;
mod drive;
mod error;
mod import;
mod inspect;
mod kind;
mod lines;
mod names;
mod notes;
mod problem;
mod read_columns;
mod read_drive;
mod read_rig;
mod read_rover;
mod read_soil;
mod read_terrains;
mod rig;
mod rig_slip;
mod rover;
mod section;
mod series;
mod source;
mod table;
mod units;
mod write;

pub use atomic::{abandon_writes, atomic_write, atomic_write_new};
pub use columns::{ContractColumn, contract_columns};
pub use compliance::{SlipCompliance, slip_compliance, write_slip_compliance};
pub use drive::{DriveLog, Segment, WHEELS};
pub use error::{DataError, Place};
#[cfg(feature = "mcap")]
pub use import::import_mcap;
pub use import::{
    ImportKind, ImportedLog, import, parse_scm_json, read_scm_json, scm_json, write_terrains,
    write_terrains_to,
};
pub use inspect::{
    ChannelSummary, DriveInspector, Gap, Group, Inspection, Pace, Suspicion, inspect_drive,
    inspect_rig, slip_against_speeds,
};
pub use kind::{LogKind, log_kind, log_kind_from};
pub use notes::{MissingCells, ReadNotes};
pub use problem::Problem;
pub use read_drive::{DriveBlock, DriveReader, read_drive_log, read_drive_log_from};
pub use read_rig::{read_rig_log, read_rig_log_from};
pub use read_rover::{parse_rover, parse_rover_in, parse_rover_with, read_rover, read_rover_with};
pub use read_terrains::{hypothesis_terrains, names_a_file, read_terrains, read_terrains_from};
pub use rig::{Measured, RigLog, RigRow};
pub use rover::{
    ColumnMap, Condition, Drivetrain, FilterSettings, GapSettings, GroundSpeedSource, Noise, Rover,
    SoilSharing, Start, TerrainSettings, VehicleData, WheelData,
};
pub use series::{MissingCount, Series};
pub use units::{Dimension, Unit};
pub use write::{write_drive_log, write_drive_log_to, write_rig_log, write_rig_log_to};
