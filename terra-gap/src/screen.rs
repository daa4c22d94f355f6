//! The screen: one extra column per effect, the soil's tangent projected out.
//!
//! # Equation
//! j_k = -dr/ds_k, C0^-1 = I - J H^-1 J', H = I + J'J, y0 = r + J x0, g = j'C0^-1 y0, h = j'C0^-1 j:
//! ln B = g²/(2(1+h)) - ln(1+h)/2 \[+ ln 2 + ln Φ(mu/sd), one-sided\], mu = g/(1+h), sd = (1+h)^(-1/2).
//! The soil imitates nearly everything; without the projection an effect is credited with what a re-fit absorbs.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use terra_model::AnyEffect;

use crate::evidence::ln_normal_cdf;
use crate::fit::{Fit, Known};

/// How many times what the tangent promises near the data, and how much more, a fit is trusted to gain at most.
const TRUST: (f64, f64) = (1.3, 10.0);

/// ln B that a fit can be trusted to stay below where the tangent, at a fit near the data, promises so much.
pub(crate) fn within_reach(promised: f64) -> f64 {
    TRUST.0 * promised.max(0.0) + TRUST.1
}

/// The tangent space of a fit, to be projected out.
pub(crate) struct Tangent {
    jacobian: Arc<DMatrix<f64>>,
    information: Option<Cholesky<f64, Dyn>>,
    /// Whitened data around the prior centre, linearised at the fit.
    data: DVector<f64>,
}

/// What one column says.
#[derive(Clone, Debug)]
pub struct Score {
    /// ln B against the model alone.
    pub log_bayes_factor: f64,
    /// Best magnitude in prior sd.
    pub magnitude: f64,
    /// Its sd in prior sd.
    pub sd: f64,
    /// h: information about the magnitude that the soil leaves over.
    pub information: f64,
    /// Share of the signature that a re-fit of the soil absorbs.
    pub absorbed: f64,
    /// g: what the data say along this signature.
    along: f64,
    one_sided: bool,
    /// C0^-1 j, for cosines.
    projected: DVector<f64>,
    column: DVector<f64>,
}

impl Tangent {
    /// The tangent space of a fit.
    pub(crate) fn of(fit: &Fit) -> Self {
        let d = fit.x.len();
        let h = fit.jacobian.tr_mul(&fit.jacobian) + DMatrix::identity(d, d);
        Tangent {
            data: &fit.residual + &*fit.jacobian * &fit.x,
            information: Cholesky::new(h),
            jacobian: fit.jacobian.clone(),
        }
    }

    fn project(&self, v: &DVector<f64>) -> DVector<f64> {
        match &self.information {
            Some(h) => v - &*self.jacobian * h.solve(&self.jacobian.tr_mul(v)),
            None => v.clone(),
        }
    }

    /// The score of a whitened column.
    pub(crate) fn score(&self, column: DVector<f64>, one_sided: bool) -> Score {
        let projected = self.project(&column);
        let h = projected.dot(&column).max(0.0);
        let g = projected.dot(&self.data);
        let (mu, sd) = (g / (1.0 + h), (1.0 + h).powf(-0.5));
        let mut log_bayes_factor = 0.5 * g * g / (1.0 + h) - 0.5 * (1.0 + h).ln();
        if one_sided {
            log_bayes_factor += std::f64::consts::LN_2 + ln_normal_cdf(mu / sd);
        }
        let raw = column.norm_squared();
        Score {
            log_bayes_factor,
            magnitude: if one_sided { mu.max(0.0) } else { mu },
            sd,
            information: h,
            absorbed: if raw > 0.0 {
                (1.0 - h / raw).clamp(0.0, 1.0)
            } else {
                1.0
            },
            along: g,
            one_sided,
            projected,
            column,
        }
    }
}

impl Score {
    /// A fit's Jacobian with this signature as one more column.
    pub(crate) fn beside(&self, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        let d = jacobian.ncols();
        let mut out = jacobian.clone().insert_column(d, 0.0);
        out.set_column(d, &self.column);
        out
    }

    /// What a fit knows for one that begins at its end with this effect as one more, still at zero. The signature of a flat one is no
    /// slope there.
    pub(crate) fn beyond(&self, fit: &Fit, effect: &dyn AnyEffect) -> Known {
        let known = fit.known(self.beside(&fit.jacobian));
        Known {
            exact: known.exact && !effect.is_flat(),
            ..known
        }
    }

    /// ln B of this effect and another together, and their best magnitudes; none where one of them would have to be
    /// negative and cannot.
    pub(crate) fn with(&self, other: &Score) -> Option<(f64, [f64; 2])> {
        let common = self.projected.dot(&other.column);
        let (a, d) = (1.0 + self.information, 1.0 + other.information);
        let det = a * d - common * common;
        if det.is_nan() || det <= 0.0 {
            return None;
        }
        let magnitudes = [
            (d * self.along - common * other.along) / det,
            (a * other.along - common * self.along) / det,
        ];
        if (self.one_sided && magnitudes[0] < 0.0) || (other.one_sided && magnitudes[1] < 0.0) {
            return None;
        }
        let gain = 0.5 * (self.along * magnitudes[0] + other.along * magnitudes[1]);
        Some((gain - 0.5 * det.ln(), magnitudes))
    }

    /// Cosine of two signatures after the soil is re-fitted.
    pub fn cosine(&self, other: &Score) -> f64 {
        let norm = (self.information * other.information).sqrt();
        if norm > 0.0 {
            (self.projected.dot(&other.column) / norm).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }
}
