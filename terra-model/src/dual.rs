//! Exact Jacobians of run-time sized functions, eight derivatives at a time.

use nalgebra::{Const, DMatrix, U1};
use num_dual::DualSVec64;

/// A number with eight derivatives.
pub type Dual8 = DualSVec64<8>;

/// Value (m) and exact Jacobian (m x n) of `f` at `x`, by forward differentiation in chunks of eight variables.
///
/// # Errors
/// Whatever `f` returns.
pub fn jacobian<E>(
    x: &[f64],
    mut f: impl FnMut(&[Dual8]) -> Result<Vec<Dual8>, E>,
) -> Result<(Vec<f64>, DMatrix<f64>), E> {
    const N: usize = 8;
    let n = x.len();
    let mut seeds: Vec<Dual8> = x.iter().map(|&v| Dual8::from_re(v)).collect();
    let mut value = Vec::new();
    let mut jac = DMatrix::zeros(0, n);
    let mut start = 0;
    loop {
        let end = (start + N).min(n);
        for (k, seed) in seeds[start..end].iter_mut().enumerate() {
            *seed = Dual8::from_re(seed.re).derivative(k);
        }
        let y = f(&seeds)?;
        if start == 0 {
            value = y.iter().map(|d| d.re).collect();
            jac = DMatrix::zeros(y.len(), n);
        }
        for (row, d) in y.iter().enumerate() {
            let eps = d.eps.unwrap_generic(Const::<N>, U1);
            for column in start..end {
                jac[(row, column)] = eps[column - start];
            }
        }
        for seed in &mut seeds[start..end] {
            *seed = Dual8::from_re(seed.re);
        }
        start = end;
        if start >= n {
            return Ok((value, jac));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::Real;

    /// d tanh(x)/dx = 1 - tanh²(x), also where sinh and cosh² overflow.
    #[test]
    fn tanh_has_its_slope_everywhere() {
        for x in [-800.0, -1.0, 0.0, 0.3, 40.0, 400.0] {
            let (_, slope) = jacobian(&[x], |x| Ok::<_, ()>(vec![Real::tanh(x[0])])).unwrap();
            assert_eq!(slope[(0, 0)], 1.0 - f64::tanh(x).powi(2));
        }
    }
}
