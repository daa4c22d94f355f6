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
fn vector(x: &[f32; LANES]) -> f32x8 {
    f32x8::from(*x)
}

/// The forces of a tile of hypotheses from `h` on, one row of `out` a force: sums of contiguous streams, four nodes at a
/// time so that a sum is fetched and put back once for four.
pub(super) fn forces(sample: &Sample, values: &[f32], h: usize, out: &mut [[f32; LANES]]) {
    let vectors = out.len() / FORCES;
    let stream = |at: usize| -> &[[f32; LANES]] {
        let streams = values.get(at + h..at + h + vectors * LANES);
        streams.unwrap_or_default().as_chunks::<LANES>().0
    };
    let rows = out.chunks_exact_mut(vectors.max(1));
    for ((row, at), weight) in rows.zip(&sample.at).zip(&sample.weight).take(sample.forces) {
        row.fill([0.0; LANES]);
        for (at, w) in at.as_chunks::<4>().0.iter().zip(weight.as_chunks::<4>().0) {
            let [a, b, c, d] = at.map(stream);
            let [wa, wb, wc, wd] = w.map(f32x8::splat);
            for ((((sum, a), b), c), d) in row.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                let left = vector(b).mul_add(wb, vector(a).mul_add(wa, vector(sum)));
                *sum = vector(d)
                    .mul_add(wd, vector(c).mul_add(wc, left))
                    .to_array();
            }
        }
    }
}

/// rᵀ S⁻¹ r of the eight hypotheses at place `k` of a tile; their residuals become `previous`, one row of vectors a row of
/// the observation.
#[inline]
pub(super) fn quadratic(
    sample: &Sample,
    forces: &[[f32; LANES]],
    previous: &mut [[f32; LANES]],
    k: usize,
) -> f32x8 {
    let (vectors, kept) = (forces.len() / FORCES, previous.len() / ROWS);
    let mut d = [f32x8::ZERO; ROWS];
    let rho = f32x8::splat(-sample.rho);
    for (row, d) in d.iter_mut().enumerate().take(sample.rows) {
        let mut now = f32x8::splat(-sample.observed[row]);
        for (f, a) in sample.map[row].iter().enumerate().take(sample.forces) {
            // A side's map is mostly zeros.
            if *a != 0.0
                && let Some(force) = forces.get(f * vectors + k)
            {
                now = vector(force).mul_add(f32x8::splat(*a), now);
            }
        }
        if let Some(last) = previous.get_mut(row * kept + k) {
            *d = vector(last).mul_add(rho, now);
            *last = now.to_array();
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
    sum
}
