//! The force law of a wheel on soil as a C interface: what a simulator (Gazebo, MuJoCo, Chrono, a game engine) calls at
//! every step for every wheel.
//!
//! `include/terra.h` is the interface, `examples/wheel.c` shows it. Handles are opaque, every failure is a status with a
//! message, and no panic crosses the boundary.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod law;
mod pointer;
mod status;

pub use law::{TerraContact, TerraForces, TerraLaw};
pub use pointer::*;
pub use status::TerraStatus;
