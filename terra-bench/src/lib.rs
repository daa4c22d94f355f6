//! Fixed inputs of the benches and instruction counts, each with the reference its answers are checked against.
//!
//! - `cargo bench -p terra-bench`: times, for people. They belong to the machine and its load, and gate nothing.
//! - `cargo xtask bench`: instructions per operation under callgrind, compared with `counts.toml`. That is the gate.
//!
//! Nothing here is for use outside this package. A figure without a right answer means nothing, so every kernel is
//! compared with a reference that does not come from the kernel, in the same run that times or counts it.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

pub mod caches;
pub mod drive;
mod error;
pub mod filter;
pub mod fused;
pub mod hand;
pub mod hypotheses;
pub mod many;
pub mod wheel;

pub use error::{BenchError, check};
