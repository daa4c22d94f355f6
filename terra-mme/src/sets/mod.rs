//! Hypothesis sets that are made rather than read: grids, Latin hypercubes, perturbed copies.
//!
//! A set is a design of experiments in the space of a law's parameters. A grid covers few axes evenly, a Latin
//! hypercube covers many with few members, perturbed copies say how well a soil is told from its like.

mod axis;
mod grid;
mod hypercube;
mod perturbed;

pub use axis::Axis;

/// Largest number of hypotheses a maker builds: a slip of the pen in a grid must not exhaust the memory.
pub const MOST_HYPOTHESES: usize = 1_000_000;
