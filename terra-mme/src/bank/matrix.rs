//! Small matrices of the vehicle filter: products, A P Aᵀ, and the matrix functions of an exponential step.
//!
//! # Reference
//! M. Hochbruck, A. Ostermann, *Exponential integrators*, Acta Numerica 19 (2010), section 2.1 (φ1).

use super::vehicle_filter::{Matrix, STATES, Vector};

pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; STATES]; STATES];
    for i in 0..STATES {
        for k in 0..STATES {
            let x = a[i][k];
            for j in 0..STATES {
                c[i][j] += x * b[k][j];
            }
        }
    }
    c
}

pub(super) fn apply(a: &Matrix, x: &Vector) -> Vector {
    std::array::from_fn(|i| (0..STATES).map(|k| a[i][k] * x[k]).sum())
}

/// e^(hA) and φ1(hA) = Σ (hA)^k/(k+1)!, by series after halving, then doubling: φ1(2z) = φ1(z)(e^z + 1)/2.
pub(super) fn exponentials(a: &Matrix, h: f64) -> (Matrix, Matrix) {
    let size = a
        .iter()
        .map(|r| r.iter().map(|v| v.abs()).sum::<f64>())
        .fold(0.0, f64::max)
        * h;
    let halvings = if size > 0.25 {
        ((size / 0.25).log2().ceil() as u32).min(40)
    } else {
        0
    };
    let small = h / 2.0_f64.powi(halvings as i32);
    let z: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] * small));
    let identity: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    // φ1 by Horner to z^7, then e^z = 1 + z φ1.
    let mut phi = identity;
    for k in (2..=8).rev() {
        let step = product(&z, &phi);
        for i in 0..STATES {
            for j in 0..STATES {
                phi[i][j] = identity[i][j] + step[i][j] / f64::from(k);
            }
        }
    }
    let mut exp = product(&z, &phi);
    for (i, row) in exp.iter_mut().enumerate() {
        row[i] += 1.0;
    }
    for _ in 0..halvings {
        let mut plus = exp;
        for (i, row) in plus.iter_mut().enumerate() {
            row[i] += 1.0;
        }
        let doubled = product(&phi, &plus);
        phi = doubled.map(|r| r.map(|v| 0.5 * v));
        exp = product(&exp, &exp);
    }
    (exp, phi)
}

/// A P Aᵀ, symmetric to the last bit.
pub(super) fn sandwich(a: &Matrix, p: &Matrix) -> Matrix {
    let left = product(a, p);
    let mut out = [[0.0; STATES]; STATES];
    for i in 0..STATES {
        for j in 0..=i {
            let v: f64 = (0..STATES).map(|k| left[i][k] * a[j][k]).sum();
            out[i][j] = v;
            out[j][i] = v;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// e^A of a rotation and a decay in closed form, and φ1 A = e^A - 1.
    #[test]
    fn exponentials_in_closed_form() {
        let mut a = [[0.0; STATES]; STATES];
        (a[0][1], a[1][0]) = (-7.0, 7.0);
        a[2][2] = -300.0;
        let (exp, phi) = exponentials(&a, 0.1);
        assert!((exp[0][0] - 0.7_f64.cos()).abs() < 1e-10);
        assert!((exp[1][0] - 0.7_f64.sin()).abs() < 1e-10);
        assert!((exp[2][2] - (-30.0_f64).exp()).abs() < 1e-12);
        let back = product(&phi, &a.map(|r| r.map(|v| 0.1 * v)));
        for i in 0..STATES {
            for j in 0..STATES {
                let one = if i == j { 1.0 } else { 0.0 };
                assert!((back[i][j] - (exp[i][j] - one)).abs() < 1e-10);
            }
        }
    }
}
