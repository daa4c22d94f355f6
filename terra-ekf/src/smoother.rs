//! Rauch-Tung-Striebel: what the whole log says about each of its instants.
//!
//! # Equation
//! Backwards over the log: G = C P⁻_(k+1)⁻¹, x_s = x_k + G (x_s,(k+1) - x⁻_(k+1)), P_s = P_k + G (P_s,(k+1) - P⁻_(k+1)) Gᵀ,
//! with C = cov(x_k, x_(k+1)) of the prediction. It needs only moments, so it serves every Gaussian filter.
//!
//! # Reference
//! H. E. Rauch, F. Tung, C. T. Striebel, AIAA Journal 3 (1965); S. Särkkä, "Unscented Rauch-Tung-Striebel smoother",
//! IEEE Trans. Automatic Control 53 (2008).

use nalgebra::DMatrix;

use crate::error::FilterError;
use crate::filter::Filter;
use crate::gaussian::{Gaussian, symmetrise};

/// What the smoother needs of one instant.
#[derive(Clone, Debug)]
pub struct Passage {
    /// Belief before the sample.
    pub predicted: Gaussian,
    /// Belief after it.
    pub filtered: Gaussian,
    /// cov of the state an instant earlier with that of this one, before the sample.
    pub cross: DMatrix<f64>,
}

impl Passage {
    /// Records a filter after its update (or after its prediction, when there was no sample).
    pub fn of(filter: &dyn Filter) -> Self {
        Passage {
            predicted: filter.predicted().clone(),
            filtered: filter.belief().clone(),
            cross: filter.cross_covariance().clone(),
        }
    }
}

/// Smoothed beliefs of consecutive instants of one segment, in their order.
///
/// # Errors
/// [`FilterError::NotACovariance`] when a predicted covariance has no inverse.
pub fn smooth(passages: &[Passage]) -> Result<Vec<Gaussian>, FilterError> {
    let Some(last) = passages.last() else {
        return Ok(Vec::new());
    };
    let mut smoothed = vec![last.filtered.clone()];
    let mut later = last.filtered.clone();
    for pair in passages.windows(2).rev() {
        let (here, next) = (&pair[0], &pair[1]);
        let Some(cholesky) = next.predicted.covariance.clone().cholesky() else {
            return Err(FilterError::NotACovariance {
                what: "predicted covariance",
                reason: "singular, so the smoother has no gain",
                value: next.predicted.covariance.diagonal().min(),
            });
        };
        let gain = cholesky.solve(&next.cross.transpose()).transpose();
        let mean = &here.filtered.mean + &gain * (&later.mean - &next.predicted.mean);
        let change = &later.covariance - &next.predicted.covariance;
        let mut covariance = &here.filtered.covariance + &gain * change * gain.transpose();
        symmetrise(&mut covariance);
        later = Gaussian { mean, covariance };
        later.check_finite()?;
        smoothed.push(later.clone());
    }
    smoothed.reverse();
    Ok(smoothed)
}
