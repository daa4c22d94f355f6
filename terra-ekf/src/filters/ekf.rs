//! `ekf`: the extended Kalman filter, continuous in the dynamics and discrete in the measurements.
//!
//! # Equation
//! Mean by Runge-Kutta of x' = f(x, u), covariance by Van Loan on ∂f/∂x; C = ∂h/∂x at the predicted mean. Jacobians are
//! exact. A linear state space is discretised exactly, as in `kf`.
//!
//! # Reference
//! A. H. Jazwinski, *Stochastic Processes and Filtering Theory*, Academic Press (1970), section 8.3.

use nalgebra::{DMatrix, DVector};

use super::Model;
use super::dense::{Method, View};
use super::kf::predict_linear;
use crate::discretise::propagate;
use crate::error::FilterError;
use crate::gaussian::{Gaussian, symmetrise};

/// Method of `ekf`.
#[derive(Clone)]
pub struct Extended;

impl Method for Extended {
    fn name(&self) -> &'static str {
        "ekf"
    }

    fn predict(
        &mut self,
        model: &mut Model,
        belief: &Gaussian,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
        predict_extended(model, belief, u, dt)
    }

    fn observe(&self, model: &Model, belief: &Gaussian) -> Result<View, FilterError> {
        let (predicted, c) = model.space.measure_jacobian(belief.mean.as_slice())?;
        Ok(View {
            predicted: DVector::from_vec(predicted),
            c,
            extra: None,
            root: None,
        })
    }
}

/// Prediction by linearisation along the mean.
pub(crate) fn predict_extended(
    model: &mut Model,
    belief: &Gaussian,
    u: &[f64],
    dt: f64,
) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
    if model.steps.is_some() {
        return predict_linear(model, belief, u, dt);
    }
    let (mean, a, q) = propagate(
        &*model.space,
        &model.q,
        &belief.mean,
        u,
        dt,
        model.config.max_step,
    )?;
    let cross = &belief.covariance * a.transpose();
    let mut covariance = &a * &cross + q;
    symmetrise(&mut covariance);
    Ok((Gaussian { mean, covariance }, cross))
}
