//! The linear update that all filters share: joint (Joseph) or one channel after the other.

use nalgebra::{DMatrix, DVector};

use crate::gaussian::symmetrise;

/// Innovation of the channels present, in a form that says how likely it is.
#[derive(Clone, Debug)]
pub(crate) struct Whitened {
    pub(crate) values: Vec<f64>,
    pub(crate) log_likelihood: f64,
}

/// L⁻¹ ν and ln N(ν; 0, S). `Err(row)` names the first row in which S has no inverse.
pub(crate) fn whiten(s: &DMatrix<f64>, residual: &DVector<f64>) -> Result<Whitened, usize> {
    let k = residual.len();
    let mut l = DMatrix::<f64>::zeros(k, k);
    let mut values = vec![0.0; k];
    let mut log_likelihood = -0.5 * k as f64 * std::f64::consts::TAU.ln();
    for i in 0..k {
        for j in 0..=i {
            let mut sum = s[(i, j)];
            for c in 0..j {
                sum -= l[(i, c)] * l[(j, c)];
            }
            if i == j {
                if !(sum > 1e-14 * s[(i, i)] && sum.is_finite()) {
                    return Err(i);
                }
                l[(i, i)] = sum.sqrt();
            } else {
                l[(i, j)] = sum / l[(j, j)];
            }
        }
        let mut rest = residual[i];
        for c in 0..i {
            rest -= l[(i, c)] * values[c];
        }
        values[i] = rest / l[(i, i)];
        log_likelihood -= l[(i, i)].ln() + 0.5 * values[i] * values[i];
    }
    Ok(Whitened {
        values,
        log_likelihood,
    })
}

/// Joint update. `Err(row)` as in [`whiten`].
///
/// # Equation
/// S = C P Cᵀ + R, K = P Cᵀ S⁻¹, x ← x + K ν, P ← (I - K C) P (I - K C)ᵀ + K R Kᵀ (Joseph: symmetric and positive
/// semi-definite whatever rounding does to K).
pub(crate) fn joseph(
    mean: &mut DVector<f64>,
    p: &mut DMatrix<f64>,
    c: &DMatrix<f64>,
    r: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Result<(), usize> {
    let n = mean.len();
    let pct = &*p * c.transpose();
    let mut s = c * &pct + r;
    symmetrise(&mut s);
    whiten(&s, residual)?;
    let Some(cholesky) = s.cholesky() else {
        return Err(0);
    };
    let gain = cholesky.solve(&pct.transpose()).transpose();
    *mean += &gain * residual;
    let keep = DMatrix::identity(n, n) - &gain * c;
    *p = &keep * &*p * keep.transpose() + &gain * r * gain.transpose();
    symmetrise(p);
    Ok(())
}

/// Scalar-sequential update with independent channels of variance `r`. `Err(row)` as in [`whiten`].
///
/// # Equation
/// For each channel: s = c P cᵀ + r, k = P cᵀ/s, x ← x + k (ν - c (x - x0)), P ← P - k kᵀ s, with x0 the mean at which
/// ν was computed.
pub(crate) fn sequential(
    mean: &mut DVector<f64>,
    p: &mut DMatrix<f64>,
    c: &DMatrix<f64>,
    r: &[f64],
    residual: &DVector<f64>,
) -> Result<(), usize> {
    let n = mean.len();
    let start = mean.clone();
    let mut pc = DVector::zeros(n);
    for i in 0..residual.len() {
        let row = c.row(i).transpose();
        p.mul_to(&row, &mut pc);
        let prior = row.dot(&pc);
        let s = prior + r[i];
        if !(s > 0.0 && s.is_finite()) {
            return Err(i);
        }
        let rest = residual[i] - row.dot(&(&*mean - &start));
        mean.axpy(rest / s, &pc, 1.0);
        for a in 0..n {
            for b in 0..=a {
                let value = p[(a, b)] - pc[a] * pc[b] / s;
                p[(a, b)] = value;
                p[(b, a)] = value;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One state of variance 4, one channel of variance 1: gain .8, new variance .8, by hand, in both forms.
    #[test]
    fn one_state_by_hand() {
        let c = DMatrix::from_element(1, 1, 1.0);
        let nu = DVector::from_element(1, 5.0);
        let (mut x, mut p) = (DVector::zeros(1), DMatrix::from_element(1, 1, 4.0));
        joseph(&mut x, &mut p, &c, &c, &nu).unwrap();
        assert!((x[0] - 4.0).abs() < 1e-15 && (p[(0, 0)] - 0.8).abs() < 1e-15);
        let (mut x, mut p) = (DVector::zeros(1), DMatrix::from_element(1, 1, 4.0));
        sequential(&mut x, &mut p, &c, &[1.0], &nu).unwrap();
        assert!((x[0] - 4.0).abs() < 1e-15 && (p[(0, 0)] - 0.8).abs() < 1e-15);
        let w = whiten(&DMatrix::from_element(1, 1, 5.0), &nu).unwrap();
        assert!((w.values[0] - 5f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn two_perfect_sensors_of_one_state_are_singular() {
        let c = DMatrix::from_element(2, 1, 1.0);
        let (mut x, mut p) = (DVector::zeros(1), DMatrix::from_element(1, 1, 4.0));
        let result = joseph(
            &mut x,
            &mut p,
            &c,
            &DMatrix::zeros(2, 2),
            &DVector::zeros(2),
        );
        assert_eq!(result, Err(1));
    }
}
