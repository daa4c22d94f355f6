//! The noise of the data: sensors, propagated input noise, and a smooth discrepancy of the model's form.
//!
//! # Equation
//! Per observation C = D S D' with D the derivative of the residual in all raw measurements (values and inputs, slip
//! included) and S their variances; block diagonal over observations. A discrepancy adds
//! a² diag(s) K diag(s), K = exp(-(Δ slip)²/(2 ℓ²)) inside each channel, ℓ = .25.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use terra_model::{Dual8, jacobian};

use crate::dataset::{DataSet, Predictor};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;

/// Length of the discrepancy in slip.
pub(crate) const DISCREPANCY_LENGTH: f64 = 0.25;

/// Covariance of the stacked values, block diagonal by observation, with extra variance per channel.
#[derive(Clone, Debug)]
pub(crate) struct NoiseModel {
    /// Blocks in the order of the observations.
    pub blocks: Vec<DMatrix<f64>>,
}

impl NoiseModel {
    /// Propagates sensor and input noise at a fit vector.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub(crate) fn propagate<P: Predictor>(
        data: &DataSet,
        predictor: &P,
        hypothesis: &Hypothesis,
        x: &[f64],
    ) -> Result<Self, GapError> {
        let p: Vec<Dual8> = hypothesis
            .parameters(x)
            .into_iter()
            .map(Dual8::from)
            .collect();
        let blocks = (0..data.observations.len())
            .into_par_iter()
            .map(|i| {
                let o = &data.observations[i];
                let raw = predictor.raw(o.index);
                let (_, d) = jacobian(&raw, |raw| {
                    predictor.residual(&hypothesis.law, &p, o.index, raw)
                })?;
                let variances =
                    DVector::from_iterator(raw.len(), o.raw_sd.iter().map(|sd| sd * sd));
                Ok(&d * DMatrix::from_diagonal(&variances) * d.transpose())
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        Ok(NoiseModel { blocks })
    }

    /// Adds variance to every value of a channel.
    pub(crate) fn add_channel_variance(&mut self, data: &DataSet, channel: usize, variance: f64) {
        for (block, o) in self.blocks.iter_mut().zip(&data.observations) {
            for (k, &c) in o.channels.iter().enumerate() {
                if c == channel {
                    block[(k, k)] += variance;
                }
            }
        }
    }

    /// The whitener of the noise alone.
    ///
    /// # Errors
    /// [`GapError::NotPositiveDefinite`].
    pub(crate) fn whitener(&self, data: &DataSet) -> Result<Whitener, GapError> {
        let mut log_det = 0.0;
        let blocks = self
            .blocks
            .iter()
            .zip(&data.observations)
            .map(|(b, o)| {
                let c = Cholesky::new(b.clone()).ok_or_else(|| GapError::NotPositiveDefinite {
                    what: o.place.clone(),
                })?;
                log_det += log_determinant(&c);
                Ok(c)
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        Ok(Whitener {
            kind: Kind::Blocks(blocks),
            log_det,
        })
    }

    /// The whitener of noise plus a discrepancy of relative amplitude `a` (dense: for rig logs).
    ///
    /// # Errors
    /// [`GapError::NotPositiveDefinite`].
    pub(crate) fn whitener_with_discrepancy(
        &self,
        data: &DataSet,
        a: f64,
    ) -> Result<Whitener, GapError> {
        if a == 0.0 {
            return self.whitener(data);
        }
        let places: Vec<(usize, usize)> = data.stacked().collect();
        let n = places.len();
        let slip = |i: usize| {
            data.observations[i]
                .factors
                .get("slip")
                .copied()
                .unwrap_or(0.0)
        };
        let mut full = DMatrix::from_fn(n, n, |r, c| {
            let ((i, ci), (j, cj)) = (places[r], places[c]);
            if ci != cj {
                return 0.0;
            }
            let d = (slip(i) - slip(j)) / DISCREPANCY_LENGTH;
            let s = a * data.channels[ci].scale;
            s * s * (-0.5 * d * d).exp()
        });
        let mut at = 0;
        for b in &self.blocks {
            let m = b.nrows();
            let mut view = full.view_mut((at, at), (m, m));
            view += b;
            at += m;
        }
        let c = Cholesky::new(full).ok_or_else(|| GapError::NotPositiveDefinite {
            what: "noise with discrepancy".to_owned(),
        })?;
        let log_det = log_determinant(&c);
        Ok(Whitener {
            kind: Kind::Dense(Box::new(c)),
            log_det,
        })
    }

    /// Noise so many times larger.
    pub(crate) fn times(&self, factor: f64) -> Self {
        NoiseModel {
            blocks: self.blocks.iter().map(|b| b * (factor * factor)).collect(),
        }
    }

    /// Only the blocks of some observations.
    pub(crate) fn subset(&self, keep: &[usize]) -> Self {
        NoiseModel {
            blocks: keep.iter().map(|&i| self.blocks[i].clone()).collect(),
        }
    }
}

fn log_determinant(c: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * c.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
}

/// L^-1 with L L' = covariance.
#[derive(Clone, Debug)]
pub(crate) struct Whitener {
    kind: Kind,
    /// ln det of the covariance.
    pub log_det: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    Blocks(Vec<Cholesky<f64, Dyn>>),
    Dense(Box<Cholesky<f64, Dyn>>),
}

impl Whitener {
    /// L^-1 m for stacked rows.
    pub(crate) fn apply(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = m.clone();
        match &self.kind {
            Kind::Dense(c) => {
                c.l_dirty().solve_lower_triangular_mut(&mut out);
            }
            Kind::Blocks(blocks) => {
                let mut at = 0;
                for c in blocks {
                    let k = c.l_dirty().nrows();
                    let mut rows = out.rows_mut(at, k);
                    c.l_dirty().solve_lower_triangular_mut(&mut rows);
                    at += k;
                }
            }
        }
        out
    }

    /// L^-1 v.
    pub(crate) fn apply_vector(&self, v: &DVector<f64>) -> DVector<f64> {
        let m = self.apply(&DMatrix::from_column_slice(v.len(), 1, v.as_slice()));
        DVector::from_column_slice(m.as_slice())
    }
}
