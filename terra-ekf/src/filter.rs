//! What every filter does.

use nalgebra::DMatrix;

use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::measurement::{Innovation, Measurement};
use crate::state_space::AnyStateSpace;
use crate::structure::Coupling;

/// A Gaussian filter over any state space.
///
/// `predict` and `update` alternate; an update with all channels missing changes nothing, so one call of each a row of
/// a log is always right. A call that fails leaves the belief as it was.
pub trait Filter: Send {
    /// Name in the registry.
    fn name(&self) -> &'static str;

    /// The state space.
    fn space(&self) -> &dyn AnyStateSpace;

    /// Moves the belief `dt` \[s\] ahead under the input `u`, held over the step.
    ///
    /// # Errors
    /// [`FilterError::TimeStep`] unless `dt` is positive and finite, [`FilterError::NotFinite`] for such an input or
    /// when the belief overflows, or whatever the state space raises.
    fn predict(&mut self, u: &[f64], dt: f64) -> Result<(), FilterError>;

    /// Takes one sample in; missing channels are dropped rows.
    ///
    /// # Errors
    /// [`FilterError::Size`], [`FilterError::SingularInnovation`], or whatever the state space raises.
    fn update(&mut self, z: &Measurement) -> Result<Innovation, FilterError>;

    /// Adds independent process noise of these variances (n, unit of x²) to the belief just predicted: an input that is
    /// not known, a state that has become doubtful.
    ///
    /// # Errors
    /// [`FilterError::Size`], or [`FilterError::NotACovariance`] for a variance that is none.
    fn widen(&mut self, variance: &[f64]) -> Result<(), FilterError>;

    /// A copy of the filter as it stands, for going back to when late data arrive.
    fn boxed_clone(&self) -> Box<dyn Filter>;

    /// Mean and covariance now.
    fn belief(&self) -> &Gaussian;

    /// Mean and covariance before the last update, for the smoother. A covariance reset counts as part of it.
    fn predicted(&self) -> &Gaussian;

    /// cov(x_(k-1), x_k) over the last prediction (n x n), given the samples before it, for the smoother.
    fn cross_covariance(&self) -> &DMatrix<f64>;

    /// Starts again from another belief, as at a new segment. Rejection clocks restart too.
    ///
    /// # Errors
    /// [`FilterError::Size`] or a belief that is none.
    fn restart(&mut self, belief: Gaussian) -> Result<(), FilterError>;

    /// Covariance resets so far, by channel.
    fn resets(&self) -> &[usize];

    /// Why a filter that lives on block structure could not use all of what was declared; empty when it could.
    fn couplings(&self) -> &[Coupling] {
        &[]
    }
}
