//! A mean and its covariance.

use nalgebra::{DMatrix, DVector};

use crate::error::FilterError;

/// Belief about a state: mean (n) and covariance (n x n), units of the state and their products.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaussian {
    /// x (n).
    pub mean: DVector<f64>,
    /// P (n x n), symmetric positive semi-definite.
    pub covariance: DMatrix<f64>,
}

impl Gaussian {
    /// A belief that is checked once, here.
    ///
    /// # Errors
    /// [`FilterError::Size`], [`FilterError::NotFinite`], or [`FilterError::NotACovariance`] when the matrix is not
    /// symmetric positive semi-definite to rounding.
    pub fn new(mean: DVector<f64>, covariance: DMatrix<f64>) -> Result<Self, FilterError> {
        let n = mean.len();
        if covariance.shape() != (n, n) {
            return Err(FilterError::Size {
                what: "covariance",
                expected: n,
                found: covariance.nrows(),
            });
        }
        check_finite("mean", mean.as_slice())?;
        check_covariance("covariance", &covariance)?;
        Ok(Gaussian { mean, covariance })
    }

    /// Independent states with the given standard deviations.
    pub fn independent(mean: &[f64], sd: &[f64]) -> Self {
        let variance = DVector::from_iterator(sd.len(), sd.iter().map(|s| s * s));
        Gaussian {
            mean: DVector::from_column_slice(mean),
            covariance: DMatrix::from_diagonal(&variance),
        }
    }

    /// Number of states.
    pub fn dim(&self) -> usize {
        self.mean.len()
    }

    /// Standard deviation of one state; `None` beyond the last, or for a variance that is none.
    pub fn sd(&self, state: usize) -> Option<f64> {
        self.covariance
            .get((state, state))
            .filter(|v| **v >= 0.0)
            .map(|v| v.sqrt())
    }

    pub(crate) fn check_finite(&self) -> Result<(), FilterError> {
        check_finite("mean", self.mean.as_slice())?;
        check_finite("covariance", self.covariance.as_slice())
    }
}

/// Error at the first element that is not finite.
pub(crate) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), FilterError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(FilterError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Error unless `p` is finite, symmetric and positive semi-definite to rounding.
pub(crate) fn check_covariance(what: &'static str, p: &DMatrix<f64>) -> Result<(), FilterError> {
    check_finite(what, p.as_slice())?;
    for i in 0..p.nrows() {
        for j in 0..i {
            let scale = (p[(i, i)] * p[(j, j)]).abs().sqrt();
            let value = p[(i, j)] - p[(j, i)];
            // An overflow of the scale (entries near 1e308) is as useless as an asymmetric matrix.
            if !scale.is_finite() || value.abs() > 1e-9 * scale {
                return Err(FilterError::NotACovariance {
                    what,
                    reason: "not symmetric",
                    value,
                });
            }
        }
    }
    square_root(what, p).map(|_| ())
}

/// Mirrors the average of both triangles: rounding alone makes a covariance asymmetric.
pub(crate) fn symmetrise(p: &mut DMatrix<f64>) {
    for i in 0..p.nrows() {
        for j in 0..i {
            let mean = 0.5 * (p[(i, j)] + p[(j, i)]);
            p[(i, j)] = mean;
            p[(j, i)] = mean;
        }
    }
}

/// Lower triangular L with L Lᵀ = P for a positive **semi**-definite P: a pivot that is zero to rounding gives a zero
/// column, a negative one an error.
pub(crate) fn square_root(
    what: &'static str,
    p: &DMatrix<f64>,
) -> Result<DMatrix<f64>, FilterError> {
    let n = p.nrows();
    let mut l = DMatrix::zeros(n, n);
    for j in 0..n {
        let mut pivot = p[(j, j)];
        for k in 0..j {
            pivot -= l[(j, k)] * l[(j, k)];
        }
        // Rounding of the sum above is of the order of n eps P_jj.
        let zero = 1e-13 * n as f64 * p[(j, j)].abs();
        if pivot.is_nan() || p[(j, j)] < 0.0 || pivot < -zero {
            return Err(FilterError::NotACovariance {
                what,
                reason: "negative pivot",
                value: pivot,
            });
        }
        if pivot <= zero * 1e-3 {
            // The rest of the column must vanish with its pivot, or P has a negative eigenvalue.
            for i in j + 1..n {
                let mut rest = p[(i, j)];
                for k in 0..j {
                    rest -= l[(i, k)] * l[(j, k)];
                }
                if rest.abs() > 1e-6 * (p[(i, i)].abs() * p[(j, j)].abs()).sqrt() {
                    return Err(FilterError::NotACovariance {
                        what,
                        reason: "correlated with a state of no variance",
                        value: rest,
                    });
                }
            }
            continue;
        }
        let root = pivot.sqrt();
        l[(j, j)] = root;
        for i in j + 1..n {
            let mut sum = p[(i, j)];
            for k in 0..j {
                sum -= l[(i, k)] * l[(j, k)];
            }
            l[(i, j)] = sum / root;
        }
    }
    Ok(l)
}
