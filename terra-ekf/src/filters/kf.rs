//! `kf`: the Kalman filter of a linear time-invariant state space.
//!
//! # Equation
//! x' = A x + g(u), discretised exactly: x ← a x + Γ g, P ← a P aᵀ + q; z = C x + d.
//!
//! # Reference
//! R. E. Kalman, "A new approach to linear filtering and prediction problems", J. Basic Engineering 82 (1960).

use nalgebra::{DMatrix, DVector};

use super::Model;
use super::dense::{Method, View};
use crate::error::FilterError;
use crate::gaussian::{Gaussian, symmetrise};

/// Method of `kf`.
#[derive(Clone)]
pub struct Linear {
    c: DMatrix<f64>,
    offset: DVector<f64>,
}

impl Linear {
    /// Takes C and the constant part of h from a linear state space.
    ///
    /// # Errors
    /// [`FilterError::NotLinear`].
    pub fn new(space: &dyn crate::AnyStateSpace) -> Result<Self, FilterError> {
        if !space.is_linear() {
            return Err(FilterError::NotLinear {
                filter: "kf",
                space: space.name(),
            });
        }
        let origin = vec![0.0; space.dims().state];
        let (offset, c) = space.measure_jacobian(&origin)?;
        Ok(Linear {
            c,
            offset: DVector::from_vec(offset),
        })
    }
}

impl Method for Linear {
    fn name(&self) -> &'static str {
        "kf"
    }

    fn predict(
        &mut self,
        model: &mut Model,
        belief: &Gaussian,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
        predict_linear(model, belief, u, dt)
    }

    fn observe(&self, _model: &Model, belief: &Gaussian) -> Result<View, FilterError> {
        let predicted = &self.c * &belief.mean + &self.offset;
        Ok(View {
            predicted,
            c: self.c.clone(),
            extra: None,
            root: None,
        })
    }
}

/// Exact prediction of a linear state space.
pub(crate) fn predict_linear(
    model: &mut Model,
    belief: &Gaussian,
    u: &[f64],
    dt: f64,
) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
    let drive = drive(model, u)?;
    let name = model.space.name();
    let Some(steps) = model.steps.as_mut() else {
        return Err(FilterError::NotLinear {
            filter: "kf",
            space: name,
        });
    };
    let step = steps.get(dt)?;
    let mean = &step.a * &belief.mean + &step.gamma * drive;
    let cross = &belief.covariance * step.a.transpose();
    let mut covariance = &step.a * &cross + &step.q;
    symmetrise(&mut covariance);
    Ok((Gaussian { mean, covariance }, cross))
}

/// g(u) = f(0, u) of a linear state space.
pub(crate) fn drive(model: &Model, u: &[f64]) -> Result<DVector<f64>, FilterError> {
    let origin = vec![0.0; model.space.dims().state];
    model.space.rate_value(&origin, u).map(DVector::from_vec)
}
