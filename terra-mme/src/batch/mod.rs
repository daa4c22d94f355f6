//! Estimators that need the whole log: they answer as multiple models while it comes in, and better once it has ended.

mod ensemble;
mod estimator;
mod least_squares;

pub use ensemble::{Ensemble, EnsembleOptions, ensemble};
pub use estimator::{Batch, BatchMethod};
pub use least_squares::{LeastSquaresOptions, LocalFit, least_squares};
