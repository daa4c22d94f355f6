//! One pass over a few vectors of hypotheses: look-up, residual, whitening, quadratic form, log-weight, exponential, sums.

use wide::bytemuck::cast;
use wide::{f32x8, u32x8};

use super::grid::{ALONG, LANES};

/// Rows of an observation at most.
pub(super) const ROWS: usize = 6;
/// Forces that an observation looks at, at most: D, T, z of four wheels.
pub(super) const FORCES: usize = 12;
/// Wheels at most.
pub(super) const WHEELS: usize = FORCES / 3;
/// Vectors of hypotheses that are worked on together: their sums stay in registers while the nodes pass.
pub(super) const TILE: usize = 8;

/// Log-weight below which a weight is nothing in single precision.
const LEAST: f32 = -87.0;

/// Neighbouring nodes along the load: the block of the first, and what a row takes of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) block: usize,
    pub(super) weight: [f32; ALONG],
}

/// One row of an observation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    pub(super) observed: f32,
    /// End of the row's groups; they begin where those of the row above end.
    pub(super) end: usize,
    /// Its row of L⁻¹, S (1 - ρ²) = L Lᵀ.
    pub(super) whiten: [f32; LANES],
}

/// Everything that all hypotheses share at one sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    /// Row after row.
    pub(super) groups: Vec<Group>,
    pub(super) row: [Row; ROWS],
    pub(super) rows: usize,
    pub(super) rho: f32,
}

/// What a pass does to a tile of V vectors.
pub(super) struct Tile<'a> {
    /// Forces, V vectors a block.
    pub(super) values: &'a [[f32; LANES]],
    /// Residuals of the last sample, V vectors a row; empty where nothing is whitened in time.
    pub(super) previous: &'a mut [[f32; LANES]],
    /// Room for the residuals of this sample, [`TILE`] vectors a row.
    pub(super) residuals: &'a mut [[f32; LANES]],
    /// Log-weights.
    pub(super) weights: &'a mut [[f32; LANES]],
}

/// rᵀ S⁻¹ r of V vectors of hypotheses; their residuals become `previous`.
#[inline]
fn distances<const V: usize>(
    sample: &Sample,
    blocks: &[[[f32; LANES]; V]],
    previous: &mut [[[f32; LANES]; V]],
    residuals: &mut [[[f32; LANES]; V]],
) -> [f32x8; V] {
    let mut q = [f32x8::ZERO; V];
    let mut from = 0;
    for (k, row) in sample.row.iter().enumerate().take(sample.rows) {
        let mut sum = [f32x8::splat(-row.observed); V];
        for group in sample.groups.get(from..row.end).unwrap_or_default() {
            let nodes = blocks.get(group.block..).and_then(|b| b.first_chunk());
            let Some::<&[_; ALONG]>(nodes) = nodes else {
                continue;
            };
            for (node, weight) in nodes.iter().zip(&group.weight) {
                let weight = f32x8::splat(*weight);
                for (sum, x) in sum.iter_mut().zip(node) {
                    *sum = f32x8::from(*x).mul_add(weight, *sum);
                }
            }
        }
        from = row.end;
        if let Some(last) = previous.get_mut(k) {
            let rho = f32x8::splat(-sample.rho);
            for (sum, last) in sum.iter_mut().zip(last) {
                let now = *sum;
                *sum = f32x8::from(*last).mul_add(rho, now);
                *last = now.to_array();
            }
        }
        let own = f32x8::splat(row.whiten[k]);
        let mut e = sum.map(|d| d * own);
        for (d, l) in residuals.iter().zip(&row.whiten).take(k) {
            let l = f32x8::splat(*l);
            for (e, d) in e.iter_mut().zip(d) {
                *e = f32x8::from(*d).mul_add(l, *e);
            }
        }
        for (q, e) in q.iter_mut().zip(e) {
            *q = e.mul_add(e, *q);
        }
        if let Some(kept) = residuals.get_mut(k) {
            *kept = sum.map(f32x8::to_array);
        }
    }
    q
}

/// e^x to single precision, 0 at [`LEAST`] and below. Without the special cases of the library's.
///
/// # Equation
/// e^x = 2^k e^r, k = round(x / ln 2), |r| <= ln 2/2, e^r by its series to r^7.
#[inline]
fn exp(x: f32x8) -> f32x8 {
    /// 1.5 2^23: adding it rounds to a whole number, which then sits in the low bits.
    const ROUND: f32 = 12_582_912.0;
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    const SERIES: [f32; 8] = [
        1.0 / 5040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    let all = f32x8::splat;
    let shifted = x
        .fast_max(all(LEAST))
        .mul_add(all(std::f32::consts::LOG2_E), all(ROUND));
    let k = shifted - all(ROUND);
    let held = x.fast_max(all(LEAST));
    let r = k.mul_add(all(-LN2_LOW), k.mul_add(all(-LN2_HIGH), held));
    let [first, rest @ ..] = SERIES;
    let mut series = all(first);
    for c in rest {
        series = series.mul_add(r, all(c));
    }
    // The series is near 1 and 2^k no smaller than 2^-126, so its exponent can be added to.
    let (series, shifted): (u32x8, u32x8) = (cast(series), cast(shifted));
    let power: f32x8 = cast(series + (shifted << 23_u32));
    power & x.simd_gt(all(LEAST))
}

/// A tile under all samples of a pass: log-weights fall by (q - centre)/2. Returns the sum of weights and the largest
/// log-weights.
///
/// With the place of the winner in this tile, the centres are its q, and are put into `centres`.
fn weigh<const V: usize>(
    samples: &[Sample],
    winner: Option<usize>,
    centres: &mut Vec<f32>,
    tile: Tile<'_>,
) -> (f32, f32x8) {
    let (blocks, _) = tile.values.as_chunks::<V>();
    let (previous, _) = tile.previous.as_chunks_mut::<V>();
    let (residuals, _) = tile.residuals.as_chunks_mut::<V>();
    let (mut sum, mut top) = (f32x8::ZERO, f32x8::splat(f32::MIN));
    let Some(weights) = tile.weights.first_chunk_mut::<V>() else {
        return (0.0, top);
    };
    let half = f32x8::splat(-0.5);
    let mut lw = weights.map(f32x8::from);
    for (k, sample) in samples.iter().enumerate() {
        let q = distances(sample, blocks, previous, residuals);
        let centre = match winner {
            None => centres.get(k).copied().unwrap_or(0.0),
            Some(place) => {
                let own = q.get(place / LANES).map(|q| q.to_array()[place % LANES]);
                let own = own.unwrap_or(0.0);
                centres.push(own);
                own
            }
        };
        let centre = f32x8::splat(centre);
        for (lw, q) in lw.iter_mut().zip(q) {
            *lw = (q - centre).mul_add(half, *lw);
        }
    }
    for (kept, lw) in weights.iter_mut().zip(lw) {
        *kept = lw.to_array();
        sum += exp(lw);
        top = lw.fast_max(top);
    }
    (sum.reduce_add(), top)
}

/// As [`weigh`], for a tile of any length up to [`TILE`].
pub(super) fn weigh_tile(
    samples: &[Sample],
    winner: Option<usize>,
    centres: &mut Vec<f32>,
    tile: Tile<'_>,
) -> (f32, f32x8) {
    let weigh = match tile.weights.len() {
        1 => weigh::<1>,
        2 => weigh::<2>,
        3 => weigh::<3>,
        4 => weigh::<4>,
        5 => weigh::<5>,
        6 => weigh::<6>,
        7 => weigh::<7>,
        _ => weigh::<TILE>,
    };
    weigh(samples, winner, centres, tile)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_agrees_with_the_library() {
        let mut worst: f32 = 0.0;
        for k in 0..107_000 {
            let x = 20.0 - 1e-3 * k as f32;
            if x > LEAST {
                let [e, ..] = exp(f32x8::splat(x)).to_array();
                worst = worst.max((f64::from(e) / f64::from(x).exp() - 1.0).abs() as f32);
            }
        }
        assert!(worst < 3e-7, "{worst:e}");
        for x in [LEAST, -1e4, -1e30, f32::NEG_INFINITY] {
            assert_eq!(exp(f32x8::splat(x)).to_array(), [0.0; LANES]);
        }
        assert_eq!(exp(f32x8::ZERO).to_array(), [1.0; LANES]);
    }
}
