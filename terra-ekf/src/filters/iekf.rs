//! `iekf`: the extended Kalman filter whose update is iterated to the mode of the posterior.
//!
//! # Equation
//! Gauss-Newton: x_(i+1) = x⁻ + K_i [z - h(x_i) - C_i (x⁻ - x_i)], C_i = ∂h/∂x at x_i, until no state moves by more than
//! 1e-9 of its prior standard deviation. The innovation reported is that of the first pass, the predictive one.
//!
//! # Reference
//! B. M. Bell and F. W. Cathey, "The iterated Kalman filter update as a Gauss-Newton method", IEEE Trans. Automatic
//! Control 38 (1993).

use nalgebra::{DMatrix, DVector};

use super::Model;
use super::dense::{Method, Refined, View};
use super::ekf::{Extended, predict_extended};
use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::update::joseph;

/// Method of `iekf`.
#[derive(Clone)]
pub struct Iterated;

impl Method for Iterated {
    fn name(&self) -> &'static str {
        "iekf"
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
        Extended.observe(model, belief)
    }

    fn refine(
        &self,
        model: &Model,
        belief: &Gaussian,
        rows: &[usize],
        z: &DVector<f64>,
        r: &DMatrix<f64>,
    ) -> Result<Option<Refined>, FilterError> {
        let mut at = belief.mean.clone();
        let mut moved = f64::INFINITY;
        for _ in 0..model.config.max_iterations {
            let (h, c) = model.space.measure_jacobian(at.as_slice())?;
            let c = c.select_rows(rows);
            let h = DVector::from_vec(h).select_rows(rows);
            let residual = z - h - &c * (&belief.mean - &at);
            // A move below rounding: this linearisation is the one at the mode.
            if moved <= 1e-9 {
                return Ok(Some((c, residual)));
            }
            let (mut next, mut p) = (belief.mean.clone(), belief.covariance.clone());
            joseph(&mut next, &mut p, &c, r, &residual).map_err(|row| {
                FilterError::SingularInnovation {
                    channel: model.channel(rows.get(row).copied().unwrap_or(row)),
                }
            })?;
            moved = 0.0;
            for i in 0..next.len() {
                let sd = belief.covariance[(i, i)].sqrt();
                if sd > 0.0 {
                    moved = moved.max((next[i] - at[i]).abs() / sd);
                }
            }
            at = next;
        }
        Err(FilterError::NotConverged {
            what: "iterated update",
            iterations: model.config.max_iterations,
            step: moved,
        })
    }
}
