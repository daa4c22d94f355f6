//! What the data determine, by name: directions of the parameters that are known, and those that are not.
//!
//! # Equation
//! J (rows x dim): whitened Jacobian in the prior-standardised q, J = U diag(s) Vᵀ. Along column v of V the posterior
//! sd is 1/sqrt(1 + s²) of the prior's 1. The number vᵀq is Σ w_k ln p_k with w_k = v_k / (d ln p_k/dq_k).
//!
//! # Reference
//! G. H. Golub, C. F. Van Loan, *Matrix Computations*, section 2.4 (SVD); Laplace approximation around the fit.

use faer::Mat;
use nalgebra::DMatrix;

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;

/// Posterior over prior sd above which a direction counts as undetermined.
pub const WEAK: f64 = 0.8;
/// Share of a direction's length below which a parameter is not named in it.
const NAMED: f64 = 0.3;

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
    // Zero rows change no singular value and give V all n columns when there are fewer rows than parameters.
    let rows = jacobian.nrows().max(n);
    let matrix = Mat::from_fn(rows, n, |i, k| jacobian.get((i, k)).copied().unwrap_or(0.0));
    let svd = matrix
        .thin_svd()
        .map_err(|_| EstimatorError::Decomposition {
            what: "singular value decomposition",
        })?;
    let (v, s) = (svd.V(), svd.S().column_vector());
    let (names, slopes) = (space.names(), space.log_slope(q));
    for column in 0..n {
        let v: Vec<f64> = (0..n).map(|k| v[(k, column)]).collect();
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
    directions.sort_by(|a, b| a.sd_ln.total_cmp(&b.sd_ln));
    let rank = directions.len();
    Ok(Identifiability {
        undetermined,
        directions,
        rank,
    })
}

/// Coefficients of at least `share` of the length, largest first, the first of them positive.
fn named(names: &[&'static str], w: &[f64], length: f64, share: f64) -> Vec<(&'static str, f64)> {
    let scaled = names.iter().zip(w).map(|(name, w)| (*name, w / length));
    let mut kept: Vec<_> = scaled.filter(|(_, w)| w.abs() >= share).collect();
    kept.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
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
