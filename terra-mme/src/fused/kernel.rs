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

/// Blocks that a pass reads: the table, and one slice a load that stays. A power of two, so that a number is held within it by
/// its low bits.
pub(super) const SOURCES: usize = 8;

/// Log-weight below which a weight is nothing in single precision.
const LEAST: f32 = -87.0;

/// Neighbouring nodes, along the load in the table or along the slip in a slice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// The table, or 1 + the number of a slice.
    pub(super) source: usize,
    /// Block of the first node.
    pub(super) block: usize,
    /// What the row takes of each node.
    pub(super) weight: [f32; ALONG],
}

/// One row of an observation.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    pub(super) groups: Vec<Group>,
    pub(super) observed: f32,
    /// Its row of L⁻¹/√2, S (1 - ρ²) = L Lᵀ.
    pub(super) whiten: [f32; LANES],
}

/// Everything that all hypotheses share at one sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    pub(super) row: [Row; ROWS],
    pub(super) rows: usize,
    pub(super) rho: f32,
}

/// Forces of some tiles, tile by tile, `blocks` blocks of vectors a tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Source<'a> {
    pub(super) values: &'a [[f32; LANES]],
    pub(super) blocks: usize,
}

/// What a pass does to tiles of equal length.
pub(super) struct Tiles<'a> {
    pub(super) sources: [Source<'a>; SOURCES],
    /// Residuals of the last sample, [`ROWS`] rows of vectors a tile; empty where nothing is whitened in time.
    pub(super) previous: &'a mut [[f32; LANES]],
    /// Room for the residuals of this sample of one tile, [`TILE`] vectors a row.
    pub(super) residuals: &'a mut [[f32; LANES]],
    /// Log-weights.
    pub(super) weights: &'a mut [[f32; LANES]],
}

/// Blocks of V vectors, and blocks a tile.
type Blocks<'a, const V: usize> = (&'a [[[f32; LANES]; V]], usize);

/// V vectors a row.
type Rows<const V: usize> = [[[f32; LANES]; V]; ROWS];

/// Takes rᵀ S⁻¹ r / 2 out of the log-weights of V vectors of hypotheses; their residuals become `previous`.
///
/// M is the number of rows, or [`ROWS`] for any. What is summed over nodes stays in registers, with room for one number
/// more; all else is a memory operand.
#[inline]
fn fall<const V: usize, const M: usize>(
    sample: &Sample,
    sources: &[Blocks<'_, V>; SOURCES],
    tile: usize,
    mut previous: Option<&mut Rows<V>>,
    residuals: &mut Rows<V>,
    weights: &mut [[f32; LANES]; V],
) {
    for k in 0..M {
        if M == ROWS && k >= sample.rows {
            break;
        }
        let row = &sample.row[k];
        let mut sum = [f32x8::splat(-row.observed); V];
        for group in &row.groups {
            let (blocks, each) = sources[group.source % SOURCES];
            let first = tile * each + group.block;
            let nodes = blocks.get(first..first + ALONG);
            for (node, weight) in nodes.unwrap_or_default().iter().zip(&group.weight) {
                let weight = f32x8::splat(*weight);
                for (sum, x) in sum.iter_mut().zip(node) {
                    *sum = f32x8::from(*x).mul_add(weight, *sum);
                }
            }
        }
        if let Some(previous) = &mut previous {
            let rho = f32x8::splat(-sample.rho);
            for (sum, last) in sum.iter_mut().zip(&mut previous[k]) {
                let now = *sum;
                *sum = f32x8::from(*last).mul_add(rho, now);
                *last = now.to_array();
            }
        }
        if k + 1 < M {
            residuals[k] = sum.map(f32x8::to_array);
        }
        let own = f32x8::splat(row.whiten[k]);
        let mut e = sum.map(|d| d * own);
        for (d, l) in residuals.iter().zip(&row.whiten).take(k) {
            let l = f32x8::splat(*l);
            for (e, d) in e.iter_mut().zip(d) {
                *e = f32x8::from(*d).mul_add(l, *e);
            }
        }
        for (lw, e) in weights.iter_mut().zip(e) {
            *lw = e.mul_neg_add(e, f32x8::from(*lw)).to_array();
        }
    }
}

/// e^x to 4e-7 of it, 1e-38 at [`LEAST`] and below. Without the special cases of the library's.
///
/// # Equation
/// e^x = 2^k e^r, k = round(x / ln 2), |r| <= ln 2/2, e^r by the polynomial of degree 5 that is nowhere off by more than
/// 1.5e-7 of it. ln 2 of one number is off by 3e-9 of it: 2.4e-7 where a weight is 1e-38.
#[inline]
fn exp(x: f32x8) -> f32x8 {
    /// 1.5 2^23: adding it rounds to a whole number, which then sits in the low bits.
    const ROUND: f32 = 12_582_912.0;
    const SERIES: [f32; 6] = [
        0.008_297_648,
        0.041_915_43,
        0.166_675_75,
        0.499_988_94,
        0.999_999_7,
        1.0,
    ];
    let all = f32x8::splat;
    let held = x.fast_max(all(LEAST));
    let shifted = held.mul_add(all(std::f32::consts::LOG2_E), all(ROUND));
    let k = shifted - all(ROUND);
    let r = k.mul_neg_add(all(std::f32::consts::LN_2), held);
    let [first, rest @ ..] = SERIES;
    let mut series = all(first);
    for c in rest {
        series = series.mul_add(r, all(c));
    }
    // The series is near 1 and 2^k no smaller than 2^-126, so its exponent can be added to.
    let (series, shifted): (u32x8, u32x8) = (cast(series), cast(shifted));
    cast(series + (shifted << 23_u32))
}

/// Adds the same to all log-weights. Returns the sum of weights and the largest log-weights, lane by lane.
///
/// Its constants take all registers, so it is a function of its own.
#[inline(never)]
pub(super) fn lift(weights: &mut [[f32; LANES]], by: f32) -> (f32, f32x8) {
    let (mut sum, mut top) = (f32x8::ZERO, f32x8::splat(f32::MIN));
    let by = f32x8::splat(by);
    for kept in weights {
        let lw = f32x8::from(*kept) + by;
        *kept = lw.to_array();
        sum += exp(lw);
        top = lw.fast_max(top);
    }
    (sum.reduce_add(), top)
}

/// Tiles of V vectors under all samples of a pass: log-weights fall by q/2.
fn weigh_rows<const V: usize, const M: usize>(samples: &[Sample], tiles: Tiles<'_>) {
    let sources = tiles.sources.map(|s| (s.values.as_chunks().0, s.blocks));
    let (previous, _) = tiles.previous.as_chunks_mut::<V>();
    let mut previous = previous.as_chunks_mut::<ROWS>().0.iter_mut();
    let (residuals, _) = tiles.residuals.as_chunks_mut::<V>();
    let Some(residuals) = residuals.first_chunk_mut() else {
        return;
    };
    let (weights, _) = tiles.weights.as_chunks_mut::<V>();
    for (tile, weights) in weights.iter_mut().enumerate() {
        let mut previous = previous.next();
        for sample in samples {
            let previous = previous.as_deref_mut();
            fall::<V, M>(sample, &sources, tile, previous, residuals, weights);
        }
    }
}

/// As [`weigh_rows`], whatever the rows.
fn weigh<const V: usize>(samples: &[Sample], tiles: Tiles<'_>) {
    let rows = samples.first().map_or(0, |s| s.rows);
    let rows = if samples.iter().all(|s| s.rows == rows) {
        rows
    } else {
        ROWS
    };
    match rows {
        1 => weigh_rows::<V, 1>(samples, tiles),
        2 => weigh_rows::<V, 2>(samples, tiles),
        3 => weigh_rows::<V, 3>(samples, tiles),
        _ => weigh_rows::<V, ROWS>(samples, tiles),
    }
}

/// As [`weigh`], for tiles of `length` vectors.
pub(super) fn weigh_tiles(samples: &[Sample], length: usize, tiles: Tiles<'_>) {
    match length {
        1 => weigh::<1>(samples, tiles),
        2 => weigh::<2>(samples, tiles),
        4 => weigh::<4>(samples, tiles),
        _ => weigh::<TILE>(samples, tiles),
    }
}

/// Vectors that hold n hypotheses: whole tiles, and 1, 2 or 4 vectors more.
pub(super) fn padded(n: usize) -> usize {
    let vectors = n.div_ceil(LANES);
    let whole = vectors / TILE * TILE;
    match vectors - whole {
        0 => whole,
        rest => whole + rest.next_power_of_two(),
    }
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
        assert!(worst < 4e-7, "{worst:e}");
        for x in [LEAST, -1e4, -1e30, f32::NEG_INFINITY] {
            let [e, ..] = exp(f32x8::splat(x)).to_array();
            assert!((0.0..2e-38).contains(&e), "{e:e}");
        }
        assert_eq!(exp(f32x8::ZERO).to_array(), [1.0; LANES]);
    }
}
