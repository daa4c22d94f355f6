//! The covariance that all hypotheses share, in fixed sizes: a sample of a small set costs little else.
//!
//! # Equation
//! S = H C Hᵀ, H = [-I, G], G = A dF/d(slip, load); S (1 - ρ²) = L Lᵀ.

use wide::f64x8;

use super::kernel::{ROWS, WHEELS};
use crate::observation::ForceObservation;

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;
/// Slips and loads at most.
const INPUTS: usize = 2 * WHEELS;

/// Rows side by side.
const LANES: usize = 8;

/// A matrix of at most [`ROWS`] columns, or rows.
pub(super) type Columns = [[f64; LANES]; ROWS];

/// G of one observation, by columns.
pub(super) struct Shared<'a> {
    obs: &'a ForceObservation,
    g: [[f64; LANES]; INPUTS],
}

impl<'a> Shared<'a> {
    /// No slopes yet. The observation has been checked and has at most [`ROWS`] rows and [`WHEELS`] wheels.
    pub(super) fn new(obs: &'a ForceObservation) -> Self {
        Shared {
            obs,
            g: [[0.0; LANES]; INPUTS],
        }
    }

    /// Adds the slopes in slip and load of a force, given its column of the map.
    pub(super) fn slope(&mut self, wheel: usize, column: &[f64], in_slip: f64, in_load: f64) {
        let column = f64x8::from(rows(column));
        for (g, slope) in self.g.iter_mut().skip(2 * wheel).zip([in_slip, in_load]) {
            *g = column
                .mul_add(f64x8::splat(slope), f64x8::from(*g))
                .to_array();
        }
    }

    /// S, by columns: what each column of C gives to it.
    pub(super) fn covariance(&self) -> Columns {
        let (m, wheels) = (self.obs.forces.len(), self.obs.contacts.len());
        let mut s = [[0.0; LANES]; ROWS];
        let columns = self.obs.covariance.as_slice().chunks_exact(m + 2 * wheels);
        for (k, column) in columns.enumerate() {
            // H times the column.
            let (above, below) = column.split_at(m);
            let mut left = -f64x8::from(rows(above));
            for (g, c) in self.g.iter().zip(below) {
                left = f64x8::from(*g).mul_add(f64x8::splat(*c), left);
            }
            match k.checked_sub(m).and_then(|k| self.g.get(k)) {
                Some(g) => {
                    for (s, g) in s.iter_mut().zip(g).take(m) {
                        *s = left.mul_add(f64x8::splat(*g), f64x8::from(*s)).to_array();
                    }
                }
                None => {
                    if let Some(s) = s.get_mut(k) {
                        *s = (f64x8::from(*s) - left).to_array();
                    }
                }
            }
        }
        s
    }
}

/// One number a row: at most [`ROWS`].
#[inline]
fn rows(column: &[f64]) -> [f64; LANES] {
    // Not a copy of so many bytes: a call for a few numbers costs more than they.
    let mut out = [0.0; LANES];
    for (k, out) in out.iter_mut().enumerate().take(ROWS) {
        *out = column.get(k).copied().unwrap_or(0.0);
    }
    out
}

/// Makes L⁻¹ of the first m columns of `scale` S, row by row, and returns ln N(0; 0, scale S); `None` when it is not positive
/// definite.
pub(super) fn factor(mut s: Columns, m: usize, scale: f64, inverse: &mut Columns) -> Option<f64> {
    let mut constant = -0.5 * m as f64 * LN_TAU;
    // One logarithm of a product costs less than one a row.
    let mut product = 1.0;
    let scale = f64x8::splat(scale);
    for column in s.iter_mut().take(m) {
        *column = (f64x8::from(*column) * scale).to_array();
    }
    for k in 0..m {
        let pivot = s[k][k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        product *= pivot;
        if !(1e-100..1e100).contains(&product) {
            constant -= 0.5 * product.ln();
            product = 1.0;
        }
        let inverse_root = 1.0 / pivot.sqrt();
        let (done, rest) = s.split_at_mut(k + 1);
        // Column k of L.
        let l = f64x8::from(done[k]) * f64x8::splat(inverse_root);
        done[k] = l.to_array();
        for (column, l_j) in rest
            .iter_mut()
            .zip(done[k].iter().skip(k + 1))
            .take(m - k - 1)
        {
            *column = l
                .mul_neg_add(f64x8::splat(*l_j), f64x8::from(*column))
                .to_array();
        }
        // Row k of the inverse from those above.
        let mut row = f64x8::ZERO;
        for (above, l) in inverse.iter().zip(&*done).take(k) {
            row = f64x8::from(*above).mul_neg_add(f64x8::splat(l[k]), row);
        }
        inverse[k] = (row * f64x8::splat(inverse_root)).to_array();
        inverse[k][k] = inverse_root;
    }
    Some(constant - 0.5 * product.ln())
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use terra_model::Contact;

    use super::*;
    use crate::residual::{covariance, score};

    /// Against the matrices of any size: H C Hᵀ, its inverse and its density, one to four wheels.
    #[test]
    fn fixed_sizes_give_the_same_covariance() {
        for w in 1..=4 {
            let m = (1 + w).min(ROWS);
            let n = m + 2 * w;
            let number =
                |i: usize, j: usize| ((7 * i + 3 * j + 1) as f64 * 0.618_034).fract() - 0.5;
            let root = DMatrix::from_fn(n, n, |i, j| number(i, j) + f64::from(u8::from(i == j)));
            let obs = ForceObservation {
                time: 0.0,
                group: 0,
                forces: DVector::zeros(m),
                map: ForceObservation::side_map(w),
                contacts: vec![Contact::new(0.2, 200.0, 0.25, 0.15); w],
                covariance: &root * root.transpose(),
            };
            let mut shared = Shared::new(&obs);
            let mut slopes = DMatrix::zeros(3 * w, 2 * w);
            for k in 0..w {
                for output in 0..2 {
                    let (a, b) = (3.0 * number(k, output), number(output, k));
                    let column = obs.map.column(3 * k + output);
                    shared.slope(k, column.as_slice(), a, b);
                    (
                        slopes[(3 * k + output, 2 * k)],
                        slopes[(3 * k + output, 2 * k + 1)],
                    ) = (a, b);
                }
            }
            let expected = covariance(&obs, &(&obs.map * slopes)) * 0.36;
            let s = shared.covariance();
            let mut inverse = [[0.0; LANES]; ROWS];
            let constant = factor(s, m, 0.36, &mut inverse).unwrap();
            let density = score(&DVector::zeros(m), &expected).unwrap().log_density;
            assert!((constant - density).abs() < 1e-12, "{constant} {density}");
            let l = DMatrix::from_fn(m, m, |i, j| inverse[i][j]);
            let identity = &l * &expected * l.transpose();
            assert!((identity - DMatrix::identity(m, m)).amax() < 1e-10);
        }
        let none = [[0.0; LANES]; ROWS];
        assert!(factor(none, 1, 1.0, &mut none.clone()).is_none());
    }
}
