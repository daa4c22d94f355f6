//! Many hypotheses in one pass: forces tabulated node by node, all hypotheses of a node side by side, in single precision.
//!
//! Slip and load are the same for all hypotheses of a wheel, so the weights of an interpolation are scalars and a look-up
//! is a sum of contiguous streams. Look-up, whitening, quadratic form, log-weight, exponential and evidence are one pass
//! over the set; several samples can share it.

mod estimator;
mod grid;
mod held;
mod held_pair;
mod kernel;
mod mean;
mod pair;
mod shared;
mod slice;

pub use estimator::FusedModel;
pub use grid::GridTable;
pub use held::HeldCovariance;
