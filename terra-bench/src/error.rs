//! A wrong answer, or a kernel that gave none.

use terra_ekf::FilterError;
use terra_mme::EstimatorError;
use terra_model::ModelError;
use terra_sim::SimError;

/// Why a bench has no figure.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The kernel disagrees with its reference.
    #[error(
        "{what} is {found}, reference {reference}, off by {off:e} where {allowed:e} is allowed"
    )]
    Wrong {
        /// The quantity and the case.
        what: String,
        /// Of the kernel.
        found: f64,
        /// Of the reference.
        reference: f64,
        /// Error, in the measure of the kernel.
        off: f64,
        /// Largest error allowed.
        allowed: f64,
    },
    /// A terrain model failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A filter failed.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// An estimator failed.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// A simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The reference filter met a matrix that has no inverse.
    #[error("the innovation covariance of the reference filter is singular at step {step}")]
    Singular {
        /// Sample, from 0.
        step: usize,
    },
}

/// Compares a number with its reference: |found - reference| <= allowed * scale.
///
/// # Errors
/// [`BenchError::Wrong`], also where either is NaN.
pub fn check(
    what: &str,
    found: f64,
    reference: f64,
    scale: f64,
    allowed: f64,
) -> Result<(), BenchError> {
    let off = (found - reference).abs() / scale;
    if off <= allowed {
        Ok(())
    } else {
        Err(BenchError::Wrong {
            what: what.to_owned(),
            found,
            reference,
            off,
            allowed,
        })
    }
}
