//! One pass over a tile of hypotheses: look-up, residual, whitening, quadratic form, log-weight.

use wide::f32x8;

use super::grid::{LANES, STENCIL};

/// Rows of an observation at most.
pub(super) const ROWS: usize = 6;
/// Forces that an observation looks at, at most: D, T, z of four wheels.
pub(super) const FORCES: usize = 12;

/// Everything that all hypotheses share at one sample. Fixed sizes: nothing is allocated in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Places of the nodes of each force looked at (hypothesis 0).
    pub(super) at: [[usize; STENCIL]; FORCES],
    pub(super) weight: [[f32; STENCIL]; FORCES],
    pub(super) forces: usize,
    /// A with the force's scale: row of the observation by force.
    pub(super) map: [[f32; FORCES]; ROWS],
    pub(super) observed: [f32; ROWS],
    pub(super) rows: usize,
    /// L⁻¹ of S (1 - ρ²) = L Lᵀ, lower triangle.
    pub(super) whiten: [[f32; ROWS]; ROWS],
    pub(super) rho: f32,
}

#[inline]
fn load(x: &[f32], at: usize) -> f32x8 {
    match x
        .get(at..at + LANES)
        .and_then(|x| <[f32; LANES]>::try_from(x).ok())
    {
        Some(x) => f32x8::from(x),
        None => f32x8::ZERO,
    }
}

/// Residuals (rows) of the eight hypotheses from `h` on.
#[inline]
fn residual(sample: &Sample, values: &[f32], h: usize) -> [f32x8; ROWS] {
    let mut forces = [f32x8::ZERO; FORCES];
    for ((force, at), weight) in forces
        .iter_mut()
        .zip(&sample.at)
        .zip(&sample.weight)
        .take(sample.forces)
    {
        for (at, w) in at.iter().zip(weight) {
            *force = load(values, at + h).mul_add(f32x8::splat(*w), *force);
        }
    }
    let mut out = [f32x8::ZERO; ROWS];
    for ((r, map), y) in out
        .iter_mut()
        .zip(&sample.map)
        .zip(&sample.observed)
        .take(sample.rows)
    {
        let mut sum = f32x8::splat(-*y);
        for (a, f) in map.iter().zip(&forces).take(sample.forces) {
            sum = f.mul_add(f32x8::splat(*a), sum);
        }
        *r = sum;
    }
    out
}

/// rᵀ S⁻¹ r of eight hypotheses, and their residuals for the next sample.
#[inline]
pub(super) fn quadratic(
    sample: &Sample,
    values: &[f32],
    previous: &[f32],
    padded: usize,
    h: usize,
) -> (f32x8, [f32x8; ROWS]) {
    let now = residual(sample, values, h);
    let mut d = now;
    if sample.rho > 0.0 {
        let rho = f32x8::splat(-sample.rho);
        for (row, d) in d.iter_mut().enumerate().take(sample.rows) {
            *d = load(previous, row * padded + h).mul_add(rho, *d);
        }
    }
    let mut sum = f32x8::ZERO;
    for (row, l) in sample.whiten.iter().enumerate().take(sample.rows) {
        let mut e = f32x8::ZERO;
        for (l, d) in l.iter().zip(&d).take(row + 1) {
            e = d.mul_add(f32x8::splat(*l), e);
        }
        sum = e.mul_add(e, sum);
    }
    (sum, now)
}

/// Stores eight numbers.
#[inline]
pub(super) fn store(x: f32x8, out: &mut [f32], at: usize) {
    if let Some(out) = out.get_mut(at..at + LANES) {
        out.copy_from_slice(&x.to_array());
    }
}

/// Loads eight numbers; zeros beyond the end.
#[inline]
pub(super) fn read(x: &[f32], at: usize) -> f32x8 {
    load(x, at)
}
