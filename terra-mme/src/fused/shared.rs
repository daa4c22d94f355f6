//! The covariance that all hypotheses share, in fixed sizes: a sample of a small set costs little else.
//!
//! # Equation
//! S = H C Hᵀ, H = [-I, G], G = A dF/d(slip, load); S (1 - ρ²) = L Lᵀ.

use super::kernel::{ROWS, WHEELS};
use crate::observation::ForceObservation;

/// Slips and loads at most.
const INPUTS: usize = 2 * WHEELS;

/// G of one observation.
pub(super) struct Shared<'a> {
    obs: &'a ForceObservation,
    g: [[f64; INPUTS]; ROWS],
}

impl<'a> Shared<'a> {
    /// No slopes yet. The observation has been checked and has at most [`ROWS`] rows and [`WHEELS`] wheels.
    pub(super) fn new(obs: &'a ForceObservation) -> Self {
        Shared {
            obs,
            g: [[0.0; INPUTS]; ROWS],
        }
    }

    /// Adds the slopes in slip and load of the force in a column of the map.
    pub(super) fn slope(&mut self, wheel: usize, column: usize, in_slip: f64, in_load: f64) {
        for (g, a) in self.g.iter_mut().zip(self.obs.map.column(column).iter()) {
            g[2 * wheel] += a * in_slip;
            g[2 * wheel + 1] += a * in_load;
        }
    }

    /// S, lower triangle.
    pub(super) fn covariance(&self) -> [[f64; ROWS]; ROWS] {
        let (m, wheels) = (self.obs.forces.len(), self.obs.contacts.len());
        let columns = self.obs.covariance.as_slice().chunks_exact(m + 2 * wheels);
        // H C, a row of the observation after the other.
        let mut left = [[0.0; ROWS + INPUTS]; ROWS];
        for (k, column) in columns.enumerate() {
            let (above, below) = column.split_at(m);
            let mut inputs = [0.0; INPUTS];
            for (input, c) in inputs.iter_mut().zip(below) {
                *input = *c;
            }
            for ((left, g), c) in left.iter_mut().zip(&self.g).zip(above) {
                left[k] = dot(g, &inputs) - c;
            }
        }
        let mut s = [[0.0; ROWS]; ROWS];
        for (i, (left, s)) in left.iter().zip(&mut s).enumerate().take(m) {
            let mut inputs = [0.0; INPUTS];
            for (input, l) in inputs.iter_mut().zip(&left[m..]).take(2 * wheels) {
                *input = *l;
            }
            for (j, (s, g)) in s.iter_mut().zip(&self.g).enumerate().take(i + 1) {
                *s = dot(g, &inputs) - left[j];
            }
        }
        s
    }
}

fn dot(a: &[f64; INPUTS], b: &[f64; INPUTS]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// L⁻¹ of the first m rows of `scale` S, lower triangle, and ln N(0; 0, scale S); `None` when it is not positive definite.
pub(super) fn factor(
    s: [[f64; ROWS]; ROWS],
    m: usize,
    scale: f64,
) -> Option<([[f64; ROWS]; ROWS], f64)> {
    let mut l = [[0.0; ROWS]; ROWS];
    let mut inverse = [[0.0; ROWS]; ROWS];
    let mut constant = -0.5 * m as f64 * std::f64::consts::TAU.ln();
    for i in 0..m {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = scale * s[i][j] - known;
            if j < i {
                l[i][j] = rest * inverse[j][j];
                continue;
            }
            if !(rest > 0.0 && rest.is_finite()) {
                return None;
            }
            l[i][i] = rest.sqrt();
            inverse[i][i] = 1.0 / l[i][i];
            constant -= 0.5 * rest.ln();
        }
        for j in 0..i {
            let sum: f64 = (j..i).map(|k| l[i][k] * inverse[k][j]).sum();
            inverse[i][j] = -sum * inverse[i][i];
        }
    }
    Some((inverse, constant))
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
                    shared.slope(k, 3 * k + output, a, b);
                    (
                        slopes[(3 * k + output, 2 * k)],
                        slopes[(3 * k + output, 2 * k + 1)],
                    ) = (a, b);
                }
            }
            let expected = covariance(&obs, &(&obs.map * slopes)) * 0.36;
            let s = shared.covariance();
            let (inverse, constant) = factor(s, m, 0.36).unwrap();
            let density = score(&DVector::zeros(m), &expected).unwrap().log_density;
            assert!((constant - density).abs() < 1e-12, "{constant} {density}");
            let l = DMatrix::from_fn(m, m, |i, j| inverse[i][j]);
            let identity = &l * &expected * l.transpose();
            assert!((identity - DMatrix::identity(m, m)).amax() < 1e-10);
        }
        assert!(factor([[0.0; ROWS]; ROWS], 1, 1.0).is_none());
    }
}
