//! Banks of vehicle filters, one a hypothesis: their innovations are white, so Bayes' rule needs no repair.
//!
//! The two-step way (forces first, soils second) must wait until the forces have settled and compares residuals that
//! repeat themselves. A bank weighs from the first sample, needs no ground speed, and says by its innovations when no
//! soil explains the log.

mod core;
mod matrix;
mod motion;
mod parts;
mod points;
mod rates;
mod soil_map;
mod systematic;
mod vehicle_filter;
mod weigher;

pub use self::core::SoilMaps;
pub use motion::{
    AT_ACCEL, AT_SPEED, AT_WHEELS, AT_YAW, MOTION_CHANNELS, MotionNoise, MotionSample, Plant,
};
pub use systematic::{OFFERED_GAIN, SYSTEMATIC, SystematicCandidate, systematic};
pub use weigher::{InnovationBank, Marginal, SideBank};
