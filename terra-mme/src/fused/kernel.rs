//! One pass over a few vectors of hypotheses: look-up, residual, whitening, quadratic form.

use wide::f32x8;

use super::grid::{LANES, STENCIL};

/// Rows of an observation at most.
pub(super) const ROWS: usize = 6;
/// Forces that an observation looks at, at most: D, T, z of four wheels.
pub(super) const FORCES: usize = 12;
/// Wheels at most.
pub(super) const WHEELS: usize = FORCES / 3;
/// Vectors of hypotheses that are worked on together: their sums stay in registers while the nodes pass.
pub(super) const TILE: usize = 8;

/// Nodes of one wheel's interpolation (output 0, hypothesis 0) and their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Nodes {
    pub(super) at: [usize; STENCIL],
    pub(super) weight: [f32; STENCIL],
}

/// A force that the observation looks at: its wheel, its place behind the wheel's nodes, and what each row takes of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Looked {
    pub(super) wheel: usize,
    pub(super) offset: usize,
    /// The column of A with the force's scale.
    pub(super) share: [f32; ROWS],
}

/// Everything that all hypotheses share at one sample. Fixed sizes: nothing is allocated in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    pub(super) nodes: [Nodes; WHEELS],
    pub(super) looked: [Looked; FORCES],
    pub(super) forces: usize,
    pub(super) observed: [f32; ROWS],
    pub(super) rows: usize,
    /// L⁻¹ of S (1 - ρ²) = L Lᵀ, lower triangle.
    pub(super) whiten: [[f32; ROWS]; ROWS],
    pub(super) rho: f32,
}

/// rᵀ S⁻¹ r of V vectors of hypotheses from place `h` on; their residuals become `previous`, V vectors a row.
#[inline]
fn distances<const V: usize>(
    sample: &Sample,
    values: &[f32],
    h: usize,
    previous: &mut [[f32; LANES]],
) -> [f32x8; V] {
    let mut d = [[f32x8::ZERO; V]; ROWS];
    for (d, y) in d.iter_mut().zip(&sample.observed).take(sample.rows) {
        *d = [f32x8::splat(-y); V];
    }
    for looked in sample.looked.iter().take(sample.forces) {
        let Some(nodes) = sample.nodes.get(looked.wheel) else {
            continue;
        };
        let mut force = [f32x8::ZERO; V];
        for (at, weight) in nodes.at.iter().zip(&nodes.weight) {
            let from = at + looked.offset + h;
            let stream = values.get(from..from + V * LANES).unwrap_or_default();
            let weight = f32x8::splat(*weight);
            for (sum, x) in force.iter_mut().zip(stream.as_chunks::<LANES>().0) {
                *sum = f32x8::from(*x).mul_add(weight, *sum);
            }
        }
        // A side's map is mostly zeros.
        for (d, share) in d.iter_mut().zip(&looked.share).take(sample.rows) {
            if *share != 0.0 {
                let share = f32x8::splat(*share);
                for (d, force) in d.iter_mut().zip(&force) {
                    *d = force.mul_add(share, *d);
                }
            }
        }
    }
    let rho = f32x8::splat(-sample.rho);
    let rows = d.iter_mut().zip(previous.as_chunks_mut::<V>().0);
    for (d, last) in rows.take(sample.rows) {
        for (d, last) in d.iter_mut().zip(last) {
            let now = *d;
            *d = f32x8::from(*last).mul_add(rho, now);
            *last = now.to_array();
        }
    }
    let mut q = [f32x8::ZERO; V];
    for (row, l) in sample.whiten.iter().enumerate().take(sample.rows) {
        let mut e = [f32x8::ZERO; V];
        for (l, d) in l.iter().zip(&d).take(row + 1) {
            let l = f32x8::splat(*l);
            for (e, d) in e.iter_mut().zip(d) {
                *e = d.mul_add(l, *e);
            }
        }
        for (q, e) in q.iter_mut().zip(e) {
            *q = e.mul_add(e, *q);
        }
    }
    q
}

/// One tile under all samples of a pass: log-weights fall by (q - centre)/2. Without a centre it is that of the one sample's
/// winner, which lies in this tile at `best`; it is returned.
fn weigh<const V: usize>(
    samples: &[Sample],
    centres: &[f32],
    best: usize,
    values: &[f32],
    h: usize,
    previous: &mut [[f32; LANES]],
    weights: &mut [[f32; LANES]],
) -> f32 {
    let half = f32x8::splat(-0.5);
    let mut centre = 0.0;
    for (k, sample) in samples.iter().enumerate() {
        let q = distances::<V>(sample, values, h, previous);
        let own = || {
            let vector = q.get(best / LANES).map(|q| q.to_array());
            vector.and_then(|v| v.get(best % LANES).copied())
        };
        centre = centres.get(k).copied().or_else(own).unwrap_or(0.0);
        let all = f32x8::splat(centre);
        for (lw, q) in weights.iter_mut().zip(q) {
            *lw = (f32x8::from(*lw) + (q - all) * half).to_array();
        }
    }
    centre
}

/// As [`weigh`], for a tile of any length up to [`TILE`].
pub(super) fn weigh_tile(
    samples: &[Sample],
    centres: &[f32],
    best: usize,
    values: &[f32],
    h: usize,
    previous: &mut [[f32; LANES]],
    weights: &mut [[f32; LANES]],
) -> f32 {
    let weigh = match weights.len() {
        1 => weigh::<1>,
        2 => weigh::<2>,
        3 => weigh::<3>,
        4 => weigh::<4>,
        5 => weigh::<5>,
        6 => weigh::<6>,
        7 => weigh::<7>,
        _ => weigh::<TILE>,
    };
    weigh(samples, centres, best, values, h, previous, weights)
}

/// q of one hypothesis at each sample, from the eight around it and a copy of their residuals.
pub(super) fn one(
    samples: &[Sample],
    values: &[f32],
    h: usize,
    lane: usize,
    mut previous: [[f32; LANES]; ROWS],
    out: &mut Vec<f32>,
) {
    for sample in samples {
        let [q] = distances::<1>(sample, values, h, &mut previous);
        out.push(q.to_array().get(lane).copied().unwrap_or(0.0));
    }
}
