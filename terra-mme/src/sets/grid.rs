//! A full grid: every value of each axis with every value of the others.

use std::sync::Arc;

use terra_model::Law;

use super::Axis;
use super::axis::{countable, placed};
use crate::error::EstimatorError;
use crate::hypothesis::HypothesisSet;

impl HypothesisSet {
    /// A full grid around a parameter vector: `points` values along each axis, both ends among them (one point: the
    /// middle), evenly spaced in the logarithm where the parameter is fitted so. The last axis varies fastest; names
    /// are `prefix-1`, `prefix-2`, ...
    ///
    /// # Errors
    /// [`EstimatorError::Name`] for an unknown parameter; [`EstimatorError::Value`] for a range that is empty or
    /// illegal; [`EstimatorError::Size`] for a centre that does not fit the law or more than
    /// [`MOST_HYPOTHESES`](crate::MOST_HYPOTHESES); [`EstimatorError::EmptySet`] for an axis without points.
    pub fn grid(
        law: &Arc<Law>,
        prefix: &str,
        centre: &[f64],
        axes: &[(Axis, usize)],
    ) -> Result<Self, EstimatorError> {
        let found = placed(law, centre, axes.iter().map(|(axis, _)| axis))?;
        let total = axes
            .iter()
            .try_fold(1usize, |n, (_, points)| n.checked_mul(*points));
        let total = countable(total)?;
        let vectors = (0..total).map(|mut rest| {
            let mut p = centre.to_vec();
            for (axis, (_, points)) in found.iter().zip(axes).rev() {
                let step = rest % points;
                rest /= points;
                let share = if *points == 1 {
                    0.5
                } else {
                    step as f64 / (points - 1) as f64
                };
                if let Some(value) = p.get_mut(axis.index) {
                    *value = axis.at(share);
                }
            }
            p
        });
        Self::from_vectors(law, prefix, vectors)
    }
}
