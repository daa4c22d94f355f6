//! What the data determine, by name: directions of the parameters that are known, and those that are not.
//!
//! # Equation
//! J (rows x dim): whitened Jacobian in the prior-standardised q, J = U diag(s) Vᵀ. Along column v of V the posterior
//! sd is 1/sqrt(1 + s²) of the prior's 1. The number vᵀq is Σ w_k ln p_k with w_k = v_k / (d ln p_k/dq_k).
//!
//! # Reference
//! G. H. Golub, C. F. Van Loan, *Matrix Computations*, section 2.4 (SVD); Laplace approximation around the fit.

use nalgebra::{DMatrix, DVector, SVD};
use terra_model::order::{ascending, descending};

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;

/// Posterior over prior sd above which a direction counts as undetermined.
pub const WEAK: f64 = 0.8;
/// Share of a direction's length below which a parameter is not named in it.
const NAMED: f64 = 0.3;
/// Most steps of the decomposition, which takes about two a parameter.
const STEPS: usize = 1000;

/// A combination of logarithms that the data determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// Parameter and coefficient w_k, scaled to length 1, small ones left out.
    pub combination: Vec<(&'static str, f64)>,
    /// Posterior sd of Σ w_k ln p_k \[1\].
    pub sd_ln: f64,
    /// Posterior over prior sd.
    pub sd_ratio: f64,
}

/// The verdict of an identifiability analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct Identifiability {
    /// What cannot be told from these data, in words, names first.
    pub undetermined: Vec<String>,
    /// What can, best known first.
    pub directions: Vec<Direction>,
    /// Number of directions with a ratio below [`WEAK`].
    pub rank: usize,
}

/// Analyses a whitened Jacobian (rows x dim) at q.
///
/// # Errors
/// [`EstimatorError::Decomposition`]; [`EstimatorError::Size`].
pub fn identifiability(
    space: &FitSpace,
    q: &[f64],
    jacobian: &DMatrix<f64>,
) -> Result<Identifiability, EstimatorError> {
    let n = space.dim();
    if jacobian.ncols() != n {
        return Err(EstimatorError::Size {
            what: "columns of the Jacobian",
            found: jacobian.ncols(),
            expected: n,
        });
    }
    let mut undetermined = Vec::new();
    if space.merges_stiffness() {
        undetermined.push("k_c, k_phi only through k_c/b + k_phi".to_owned());
    }
    let mut directions = Vec::new();
    if n == 0 {
        return Ok(Identifiability {
            undetermined,
            directions,
            rank: 0,
        });
    }
    let (s, v) = right_singular(jacobian, n)?;
    let (names, slopes) = (space.names(), space.log_slope(q));
    for column in 0..n {
        let v: Vec<f64> = v.row(column).iter().copied().collect();
        let sd_ratio = 1.0 / (1.0 + s[column] * s[column]).sqrt();
        if sd_ratio > WEAK {
            undetermined.push(weak(&names, &v, sd_ratio));
            continue;
        }
        let w: Vec<f64> = v.iter().zip(&slopes).map(|(v, d)| v / d).collect();
        let length = w.iter().map(|w| w * w).sum::<f64>().sqrt();
        directions.push(Direction {
            combination: named(&names, &w, length, 0.1),
            sd_ln: sd_ratio / length,
            sd_ratio,
        });
    }
    ascending(&mut directions, |d| d.sd_ln);
    let rank = directions.len();
    Ok(Identifiability {
        undetermined,
        directions,
        rank,
    })
}

/// Singular values, largest first, and Vᵀ.
fn right_singular(
    jacobian: &DMatrix<f64>,
    n: usize,
) -> Result<(DVector<f64>, DMatrix<f64>), EstimatorError> {
    // Zero rows change no singular value and give V all n columns when there are fewer rows than parameters.
    let rows = jacobian.nrows().max(n);
    let matrix = jacobian.clone().resize(rows, n, 0.0);
    // J = Q R: R has J's singular values and its V, and is n x n however long the log is.
    let svd = SVD::try_new(matrix.qr().unpack_r(), false, true, f64::EPSILON, STEPS);
    svd.and_then(|svd| Some((svd.singular_values, svd.v_t?)))
        .filter(|(s, _)| s.iter().all(|s| s.is_finite()))
        .ok_or(EstimatorError::Decomposition {
            what: "singular value decomposition",
        })
}

/// Coefficients of at least `share` of the length, largest first, the first of them positive.
fn named(names: &[&'static str], w: &[f64], length: f64, share: f64) -> Vec<(&'static str, f64)> {
    let scaled = names.iter().zip(w).map(|(name, w)| (*name, w / length));
    let mut kept: Vec<_> = scaled.filter(|(_, w)| w.abs() >= share).collect();
    descending(&mut kept, |k| k.1.abs());
    if kept.first().is_some_and(|(_, w)| *w < 0.0) {
        kept.iter_mut().for_each(|(_, w)| *w = -*w);
    }
    kept
}

fn weak(names: &[&'static str], v: &[f64], ratio: f64) -> String {
    let parts = named(names, v, 1.0, NAMED);
    let list: Vec<&str> = parts.iter().map(|(name, _)| *name).collect();
    let what = if list.len() > 1 {
        format!("{} trade off", list.join(", "))
    } else {
        list.join("")
    };
    format!("{what} (posterior sd {ratio:.2} of the prior's)")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J = Q D H with an orthogonal H and columns of Q orthonormal: D and H come back, over eight decades of D.
    #[test]
    fn a_decomposition_that_is_known() {
        let n = 7;
        let u = DVector::from_fn(n, |k, _| 1.0 + 0.3 * k as f64);
        let h = DMatrix::identity(n, n) - &u * u.transpose() * (2.0 / u.norm_squared());
        let d = DVector::from_fn(n, |k, _| 1e4 * 0.05_f64.powi(k as i32));
        // Each row of D H in three parts whose squares add up to 1.
        let block = DMatrix::from_diagonal(&d) * &h;
        let parts = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
        let jacobian = DMatrix::from_fn(3 * n, n, |i, k| parts[i / n] * block[(i % n, k)]);
        let (s, v) = right_singular(&jacobian, n).unwrap();
        for k in 0..n {
            assert!((s[k] - d[k]).abs() < 1e-11 * d[0], "{k}: {} {}", s[k], d[k]);
            let cosine = v.row(k).dot(&h.row(k)).abs();
            assert!((cosine - 1.0).abs() < 1e-6, "{k}: {cosine}");
        }
    }

    /// Another library's decomposition of matrices without any structure.
    #[test]
    fn as_faer_decomposes_it() {
        for (rows, n, seed) in [(4, 8, 1.0_f64), (9, 9, 2.0), (300, 10, 3.0)] {
            let entry = |i: usize, k: usize| (seed + 12.9898 * i as f64 + 78.233 * k as f64).sin();
            let jacobian = DMatrix::from_fn(rows, n, |i, k| {
                entry(i * k + i, k) * 10_f64.powi(-(k as i32))
            });
            let (s, v) = right_singular(&jacobian, n).unwrap();
            let padded = faer::Mat::from_fn(rows.max(n), n, |i, k| {
                jacobian.get((i, k)).copied().unwrap_or(0.0)
            });
            let svd = padded.thin_svd().unwrap();
            let (s2, v2) = (svd.S().column_vector(), svd.V());
            for j in 0..rows.min(n) {
                assert!(
                    (s[j] - s2[j]).abs() < 1e-13 * s[0],
                    "{j}: {} {}",
                    s[j],
                    s2[j]
                );
                if s[j] > 1e-7 * s[0] {
                    let cosine: f64 = (0..n).map(|k| v[(j, k)] * v2[(k, j)]).sum();
                    assert!((cosine.abs() - 1.0).abs() < 1e-6, "{j}: {cosine}");
                }
            }
        }
    }

    /// Fewer rows than parameters leave as many directions without any information.
    #[test]
    fn what_no_row_sees() {
        let jacobian = DMatrix::from_row_slice(1, 3, &[3.0, 0.0, 4.0]);
        let (s, v) = right_singular(&jacobian, 3).unwrap();
        assert!((s[0] - 5.0).abs() < 1e-14 && s[1].abs() < 1e-14 && s[2].abs() < 1e-14);
        assert!(
            (v.row(0)
                .dot(&DMatrix::from_row_slice(1, 3, &[0.6, 0.0, 0.8])))
            .abs()
                > 1.0 - 1e-14
        );
    }

    #[test]
    fn what_is_no_number_has_no_decomposition() {
        let jacobian = DMatrix::from_element(4, 4, f64::NAN);
        assert!(right_singular(&jacobian, 4).is_err());
    }
}
