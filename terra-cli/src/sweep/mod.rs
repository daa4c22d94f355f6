//! Campaigns: a grid of runs with known truth, in shards, resumed where they stopped.
//!
//! Run r of a plan is point r / runs of the grid with noise draw r mod runs; its seed is drawn from the plan's seed and
//! r alone, so neither threads nor shards nor interruptions change a byte.

mod execute;
mod file;
mod merge;
mod plan;

pub(crate) use execute::execute;
pub(crate) use merge::merge;
pub(crate) use plan::{Plan, Shard};
