#![doc = include_str!("intro.md")]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod channels;
mod config;
mod consistency;
mod derived;
mod discretise;
mod error;
mod filter;
mod filters;
mod gaussian;
mod log;
mod measurement;
mod registry;
mod robust;
mod smoother;
pub mod spaces;
mod state_space;
mod structure;
mod update;

pub use channels::Channels;
pub use config::{FilterConfig, Particles, Robust, RobustLaw, Unscented, UpdateForm};
pub use consistency::{Consistency, Verdict};
pub use derived::{
    Side, SideForces, SlipState, Value, WheelEstimate, side_forces, wheel_estimates,
};
pub use discretise::{Discrete, discretise};
pub use error::FilterError;
pub use filter::Filter;
pub use filters::{
    BlockFilter, DenseFilter, Extended, Factor, Factored, Iterated, LaneFilter, Linear, Particle,
    Score, SigmaPoint, SquareRoot, UnitDiagonal,
};
pub use gaussian::Gaussian;
pub use log::{
    Dropped, FirstPass, Flag, ForceConfig, ForceRun, INPUT_HOLD, InputState, Rejected, RobotLog,
    RobotRow, Step, Tally, TorqueTally, estimate_forces, rejected,
};
pub use measurement::{Innovation, Measurement};
pub use registry::{
    BuildFilter, BuildSpace, FILTERS, FilterEntry, Registry, STATE_SPACES, SpaceEntry,
};
pub use smoother::{Passage, smooth};
pub use state_space::{AnyStateSpace, Dims, StateSpace, StateSpaceAt};
pub use structure::{Blocks, Coupling};
