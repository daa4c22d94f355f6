//! Chebyshev series: nodes, coefficients, sums, and polynomials in vectors of eight.

use crate::lanes::{Lanes, Vector};
use crate::real::Real;

/// Nodes in load: three vectors of eight, of which the last may be padded.
pub(super) const LOADS: usize = 24;
pub(super) const CHUNKS: usize = LOADS / 8;
/// Node k of n on \[-1, 1\].
pub(super) fn chebyshev(k: usize, n: usize) -> f64 {
    -(std::f64::consts::PI * (k as f64 + 0.5) / n as f64).cos()
}

/// Coefficients of the series through values at the nodes.
pub(super) fn coefficients(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    (0..n)
        .map(|j| {
            let sum: f64 = values
                .iter()
                .enumerate()
                .map(|(k, v)| {
                    let angle = std::f64::consts::PI * (k as f64 + 0.5) / n as f64;
                    // Nodes run from -1 up.
                    let sign = if j % 2 == 1 { -1.0 } else { 1.0 };
                    v * sign * (j as f64 * angle).cos()
                })
                .sum();
            sum * if j == 0 { 1.0 } else { 2.0 } / n as f64
        })
        .collect()
}

/// A series and its slope.
pub(super) fn series(coefficients: &[f64], x: f64) -> (f64, f64) {
    let (mut sum, mut slope) = (0.0, 0.0);
    let (mut before, mut now) = ((x, 1.0), (1.0, 0.0));
    for &c in coefficients {
        sum += c * now.0;
        slope += c * now.1;
        let next = (
            2.0 * x * now.0 - before.0,
            2.0 * (now.0 + x * now.1) - before.1,
        );
        (before, now) = (now, next);
    }
    (sum, slope)
}

/// T_0(x), T_1(x), ... in vectors of eight.
#[inline]
pub(super) fn polynomials(x: f64) -> [Lanes; CHUNKS] {
    let mut values = [0.0; LOADS];
    let (mut before, mut now) = (x, 1.0);
    for value in &mut values {
        *value = now;
        (before, now) = (now, 2.0 * x * now - before);
    }
    pack(&values)
}

/// Their slopes.
#[inline]
pub(super) fn polynomial_slopes(x: f64) -> [Lanes; CHUNKS] {
    let mut slopes = [0.0; LOADS];
    let (mut before, mut now) = ((x, 1.0), (1.0, 0.0));
    for slope in &mut slopes {
        *slope = now.1;
        let next = (
            2.0 * x * now.0 - before.0,
            2.0 * (now.0 + x * now.1) - before.1,
        );
        (before, now) = (now, next);
    }
    pack(&slopes)
}

#[inline]
fn pack(values: &[f64; LOADS]) -> [Lanes; CHUNKS] {
    std::array::from_fn(|chunk| Lanes::gather(values.iter().skip(8 * chunk).take(8).copied()))
}

pub(super) fn dot(a: &[Lanes; CHUNKS], b: &[Lanes; CHUNKS]) -> f64 {
    let mut sum = Lanes::zero();
    for (a, b) in a.iter().zip(b) {
        sum = a.mul_add(*b, sum);
    }
    sum.0.reduce_add()
}
