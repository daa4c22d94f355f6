//! `ukf` and `ckf`: filters that carry a belief through f and h by a few points instead of derivatives.
//!
//! # Equation
//! x_i = x ± s L e_i with P = L Lᵀ, s² = n + λ (unscented) or n (cubature), one weight 1/(2 s²) for all, the rest of the
//! weight at the centre. The update is linear regression of z on ξ = L⁻¹(x - mean): C = E\[z ξᵀ\], and what the regression
//! leaves over joins R.
//!
//! # Reference
//! S. J. Julier and J. K. Uhlmann, "Unscented filtering and nonlinear estimation", Proc. IEEE 92 (2004); I. Arasaratnam
//! and S. Haykin, "Cubature Kalman filters", IEEE Trans. Automatic Control 54 (2009).

use nalgebra::{DMatrix, DVector};

use super::Model;
use super::dense::{Method, View};
use super::kf::drive;
use crate::config::Unscented;
use crate::discretise::{propagate, runge_kutta, substeps};
use crate::error::FilterError;
use crate::gaussian::{Gaussian, square_root, symmetrise};

/// Mean, covariance and slope of a function of a belief.
type Moments = (DVector<f64>, DMatrix<f64>, DMatrix<f64>);

/// Method of `ukf` and `ckf`.
#[derive(Clone)]
pub struct SigmaPoint {
    name: &'static str,
    /// s: distance of the points in standard deviations.
    spread: f64,
    /// Weights of the centre in mean and covariance.
    centre: (f64, f64),
}

impl SigmaPoint {
    /// 2n + 1 points, n states.
    ///
    /// # Errors
    /// [`FilterError::Config`] unless α² (n + κ) > 0.
    pub fn unscented(states: usize, u: Unscented) -> Result<Self, FilterError> {
        let n = states as f64;
        let spread2 = u.alpha * u.alpha * (n + u.kappa);
        if !(spread2.is_finite() && spread2 > 0.0) {
            return Err(FilterError::Config {
                key: "alpha^2 (n + kappa)",
                value: spread2,
                expected: "a positive number",
            });
        }
        let mean = 1.0 - n / spread2;
        let centre = (mean, mean + 1.0 - u.alpha * u.alpha + u.beta);
        Ok(SigmaPoint {
            name: "ukf",
            spread: spread2.sqrt(),
            centre,
        })
    }

    /// 2n points, n states.
    pub fn cubature(states: usize) -> Self {
        SigmaPoint {
            name: "ckf",
            spread: (states as f64).sqrt(),
            centre: (0.0, 0.0),
        }
    }

    /// Mean and covariance of f over the points, and E\[(f - mean) ξᵀ\].
    fn moments(
        &self,
        belief: &Gaussian,
        root: &DMatrix<f64>,
        mut f: impl FnMut(&DVector<f64>) -> Result<DVector<f64>, FilterError>,
    ) -> Result<Moments, FilterError> {
        let n = belief.dim();
        let weight = 0.5 / (self.spread * self.spread);
        let mut images = Vec::with_capacity(2 * n);
        for i in 0..n {
            let step = root.column(i) * self.spread;
            images.push((f(&(&belief.mean + &step))?, f(&(&belief.mean - &step))?));
        }
        let centre = f(&belief.mean)?;
        // Deviations from the centre's image, not from zero: the sums then lose no digits.
        let mut shift = DVector::zeros(centre.len());
        for (plus, minus) in &images {
            shift += ((plus - &centre) + (minus - &centre)) * weight;
        }
        let mean = &centre + &shift;
        let mut covariance = &shift * shift.transpose() * self.centre.1;
        let mut slope = DMatrix::zeros(centre.len(), n);
        for (i, (plus, minus)) in images.iter().enumerate() {
            let (up, down) = (plus - &mean, minus - &mean);
            covariance += (&up * up.transpose() + &down * down.transpose()) * weight;
            slope.set_column(i, &((plus - minus) * (weight * self.spread)));
        }
        symmetrise(&mut covariance);
        Ok((mean, covariance, slope))
    }
}

impl Method for SigmaPoint {
    fn name(&self) -> &'static str {
        self.name
    }

    fn predict(
        &mut self,
        model: &mut Model,
        belief: &Gaussian,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
        let root = square_root("covariance", &belief.covariance)?;
        let (mean, mut covariance, slope, q);
        if model.steps.is_some() {
            let drive = drive(model, u)?;
            let Some(steps) = model.steps.as_mut() else {
                return Err(FilterError::NotLinear {
                    filter: self.name,
                    space: model.space.name(),
                });
            };
            let step = steps.get(dt)?;
            let push = &step.gamma * drive;
            (mean, covariance, slope) = self.moments(belief, &root, |x| Ok(&step.a * x + &push))?;
            q = step.q.clone();
        } else {
            let space = &*model.space;
            let count = substeps(dt, model.config.max_step)?;
            let h = dt / count as f64;
            (mean, covariance, slope) = self.moments(belief, &root, |x| {
                let mut x = x.clone();
                for _ in 0..count {
                    x = runge_kutta(space, &x, u, h)?;
                }
                Ok(x)
            })?;
            q = propagate(space, &model.q, &belief.mean, u, dt, model.config.max_step)?.2;
        }
        covariance += q;
        Ok((Gaussian { mean, covariance }, root * slope.transpose()))
    }

    fn observe(&self, model: &Model, belief: &Gaussian) -> Result<View, FilterError> {
        let root = square_root("covariance", &belief.covariance)?;
        let (predicted, spread, c) = self.moments(belief, &root, |x| {
            model
                .space
                .measure_value(x.as_slice())
                .map(DVector::from_vec)
        })?;
        let extra = spread - &c * c.transpose();
        Ok(View {
            predicted,
            c,
            extra: Some(extra),
            root: Some(root),
        })
    }
}
