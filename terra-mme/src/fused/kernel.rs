//! One pass over a few vectors of hypotheses: look-up, residual, whitening, quadratic form, log-weight, exponential, sums.

use wide::bytemuck::cast;
use wide::{f32x4, f32x8, i32x8};

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

/// Log-weight (to base 2) below which a weight is nothing in single precision.
const LEAST: f32 = -126.0;

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

impl Group {
    /// Of a slice whose nodes begin at `block`: four along slip, taken `share` times.
    #[inline]
    pub(super) fn sliced(slice: usize, block: usize, along: &[f64; ALONG], share: f64) -> Self {
        Group {
            source: 1 + slice,
            block,
            weight: along.map(|slip| (slip * share) as f32),
        }
    }
}

/// One row of an observation.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    /// With [`scale`](Self::scale) already in the weights where nothing is whitened in time.
    pub(super) groups: Vec<Group>,
    /// As the groups.
    pub(super) observed: f32,
    /// What a residual that is whitened in time is taken times afterwards.
    pub(super) scale: f32,
    /// What is added of the rows above it, each taken times its own scale.
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

/// Takes rᵀ S⁻¹ r log2(e)/2 out of the log-weights of V vectors of hypotheses; `previous` becomes their residuals.
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
            let (rho, scale) = (f32x8::splat(-sample.rho), f32x8::splat(row.scale));
            for (sum, last) in sum.iter_mut().zip(&mut previous[k]) {
                let now = *sum;
                *sum = f32x8::from(*last).mul_add(rho, now) * scale;
                *last = now.to_array();
            }
        }
        if k + 1 < M {
            residuals[k] = sum.map(f32x8::to_array);
        }
        for (d, l) in residuals.iter().zip(&row.whiten).take(k) {
            let l = f32x8::splat(*l);
            for (e, d) in sum.iter_mut().zip(d) {
                *e = f32x8::from(*d).mul_add(l, *e);
            }
        }
        for (lw, e) in weights.iter_mut().zip(sum) {
            *lw = e.mul_neg_add(e, f32x8::from(*lw)).to_array();
        }
    }
}

/// 2^x to 4e-7 of it, 1e-38 at [`LEAST`] and below. Without the special cases of the library's.
///
/// # Equation
/// 2^x = 2^k 2^f, k = round(x), |f| <= 1/2, 2^f by the polynomial of degree 5 that is nowhere off by more than 1.5e-7 of it.
#[inline]
pub(super) fn power_of_two(x: f32x8) -> f32x8 {
    const SERIES: [f32; 6] = [
        0.001_327_655_4,
        0.009_675_627,
        0.055_507_433,
        0.240_221_28,
        0.693_146_9,
        1.0,
    ];
    let all = f32x8::splat;
    // In this order one that is not a number stays so, and what is read from memory needs no step of its own.
    let held = all(LEAST).fast_max(x);
    let f = held - held.round_ties_even();
    let [first, rest @ ..] = SERIES;
    let mut series = all(first);
    for c in rest {
        series = series.mul_add(f, all(c));
    }
    // The series is near 1 and 2^k no smaller than 2^-126, so its exponent can be added to.
    let series: i32x8 = cast(series);
    cast(series + (held.fast_round_int() << 23_i32))
}

/// The sum of weights and the largest log-weight so far, lane by lane.
struct Lifted {
    sum: f32x8,
    top: f32x8,
}

impl Lifted {
    const NONE: Lifted = Lifted {
        sum: f32x8::ZERO,
        top: f32x8::splat(f32::MIN),
    };

    /// Adds to the log-weights of one vector.
    #[inline(always)]
    fn lift(&mut self, kept: &mut [f32; LANES], by: f32x8) {
        let lw = f32x8::from(*kept) + by;
        *kept = lw.to_array();
        self.top = lw.fast_max(self.top);
        self.sum += power_of_two(lw);
    }

    /// Over all lanes.
    #[inline(always)]
    fn all(self) -> (f32, f32) {
        let [a, b]: [f32x4; 2] = cast(self.top);
        let [a, b, c, d] = a.fast_max(b).to_array();
        let more = |a: f32, b: f32| if a > b { a } else { b };
        (self.sum.reduce_add(), more(more(a, b), more(c, d)))
    }
}

/// Adds the same to all log-weights. Returns the sum of weights and the largest log-weight.
///
/// Its constants take all registers, so it is a function of its own.
#[inline(never)]
pub(super) fn lift(weights: &mut [[f32; LANES]], by: f32) -> (f32, f32) {
    let (mut lifted, by) = (Lifted::NONE, f32x8::splat(by));
    // Four by four: the loop itself then costs a quarter.
    let (fours, last) = weights.as_chunks_mut::<4>();
    for lws in fours {
        lws.iter_mut().for_each(|lw| lifted.lift(lw, by));
    }
    last.iter_mut().for_each(|lw| lifted.lift(lw, by));
    lifted.all()
}

/// The same for the one tile of a set.
#[inline(always)]
pub(super) fn lift_tile<const V: usize>(weights: &mut [[f32; LANES]; V], by: f32) -> (f32, f32) {
    let (mut lifted, by) = (Lifted::NONE, f32x8::splat(by));
    for lw in weights {
        lifted.lift(lw, by);
    }
    lifted.all()
}

/// Tiles of V vectors under all samples of a pass: log-weights fall.
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
        3 => weigh::<3>(samples, tiles),
        4 => weigh::<4>(samples, tiles),
        _ => weigh::<TILE>(samples, tiles),
    }
}

/// Vectors that hold n hypotheses: whole tiles, and 1 to 4 vectors more.
pub(super) fn padded(n: usize) -> usize {
    let vectors = n.div_ceil(LANES);
    match vectors % TILE {
        0..=4 => vectors,
        _ => vectors.next_multiple_of(TILE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_agree_with_the_library() {
        let mut worst: f64 = 0.0;
        for k in 0..155_000 {
            let x = 29.0 - 1e-3 * k as f32;
            if x > LEAST {
                let [p, ..] = power_of_two(f32x8::splat(x)).to_array();
                worst = worst.max((f64::from(p) / f64::from(x).exp2() - 1.0).abs());
            }
        }
        assert!(worst < 4e-7, "{worst:e}");
        for x in [LEAST, -1e4, -1e30, f32::NEG_INFINITY] {
            let [e, ..] = power_of_two(f32x8::splat(x)).to_array();
            assert!((0.0..2e-38).contains(&e), "{e:e}");
        }
        assert_eq!(power_of_two(f32x8::ZERO).to_array(), [1.0; LANES]);
    }
}
