//! terra: what forces does the ground give each wheel, what soil is it, and which unmodelled effect makes the simulator
//! differ from reality?
//!
//! This package re-exports the crates of the workspace and holds the binary `terra`.

pub use terra_data as data;
pub use terra_ekf as ekf;
pub use terra_gap as gap;
pub use terra_mme as mme;
pub use terra_model as model;
pub use terra_sim as sim;
