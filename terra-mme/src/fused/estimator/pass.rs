//! One pass over the set: all log-weights fall by what the samples say, and are lifted by what the winner is known to be above.

use std::f64::consts::LN_2;
use std::ops::Range;

use wide::f32x8;

use super::FusedModel;
use crate::fused::grid::LANES;
use crate::fused::kernel::{
    ROWS, SOURCES, Sample, Source, TILE, Tiles, lift, lift_tile, weigh_tiles,
};
use crate::fused::pair::Pair;

/// Log-weight (to base 2) of the winner beyond which all are shifted back.
const HIGH: f32 = 29.0;
/// Tiles whose log-weights stay at hand between falling and being lifted.
const RUN: usize = 16;

impl FusedModel {
    /// The pass itself. Returns what was taken out of every log-weight, to base e.
    pub(super) fn pass(&mut self, samples: &[Sample]) -> f64 {
        if let [sample] = samples
            && self.previous.is_empty()
            && let Some(pair) = Pair::of(sample)
        {
            return self.pass_pair(&pair);
        }
        let lift = self.expected_fall(samples.iter().map(|s| s.rows).sum());
        let highest = self.all_tiles(lift, |model, vectors, length| {
            model.weigh_alike(vectors, length, samples);
        });
        self.settle(highest, lift)
    }

    /// The same for a sample of two short rows, nothing whitened in time.
    #[inline(always)]
    pub(super) fn pass_pair(&mut self, pair: &Pair) -> f64 {
        let lift = self.expected_fall(2);
        let highest = match self.table.vectors {
            1 => self.one_tile::<1>(pair, lift),
            2 => self.one_tile::<2>(pair, lift),
            3 => self.one_tile::<3>(pair, lift),
            4 => self.one_tile::<4>(pair, lift),
            TILE => self.one_tile::<TILE>(pair, lift),
            _ => self.all_tiles(lift, |model, vectors, length| {
                model.weigh_pair(vectors, length, pair);
            }),
        };
        self.settle(highest, lift)
    }

    /// What log-weights are lifted by: as much as a right hypothesis falls on average, so that a long block ends near 0.
    #[inline]
    fn expected_fall(&self, rows: usize) -> f32 {
        rows as u32 as f32 * (0.5 * std::f32::consts::LOG2_E) - self.top
    }

    /// The largest log-weight is known. Returns what was taken out of every log-weight, to base e.
    #[inline]
    fn settle(&mut self, highest: f32, lift: f32) -> f64 {
        self.top = highest;
        let taken_out = -f64::from(lift) * LN_2;
        // A new winner far above the old one, or an old one that fell far.
        if highest.abs() > HIGH {
            return taken_out + self.shift();
        }
        taken_out
    }

    /// Shifts all log-weights, the largest to 0; returns what that took out of them, to base e.
    #[cold]
    #[inline(never)]
    fn shift(&mut self) -> f64 {
        let highest = std::mem::take(&mut self.top);
        self.total = self
            .runs()
            .map(|(vectors, _)| f64::from(self.lift(&vectors, -highest).0))
            .sum();
        f64::from(highest) * LN_2
    }

    /// A set that is one tile of V vectors, under a sample of two short rows. Returns the largest log-weight.
    #[inline(never)]
    fn one_tile<const V: usize>(&mut self, pair: &Pair, by: f32) -> f32 {
        let forces = |k: usize| self.slices.source(&self.table, k).values;
        // Mostly one load, and so one source.
        let [one, two] = pair.sources();
        let first = forces(one);
        let second = if two == one { first } else { forces(two) };
        let Some(weights) = self.log_weights.first_chunk_mut::<V>() else {
            return 0.0;
        };
        pair.weigh_one([first, second], weights);
        let (sum, highest) = lift_tile(weights, by);
        self.total = f64::from(sum);
        self.run = 0;
        highest
    }

    /// Number of the winner, the first of equals.
    pub(super) fn best(&self) -> usize {
        let run = self.log_weights.get(self.run..).unwrap_or_default();
        self.run * LANES + first_of(run, self.top)
    }

    /// Run by run: each falls as `weigh` makes it. Returns the largest log-weight.
    #[inline]
    fn all_tiles(&mut self, by: f32, weigh: impl Fn(&mut Self, &Range<usize>, usize)) -> f32 {
        let mut highest = f32::MIN;
        self.total = 0.0;
        for (vectors, length) in self.runs() {
            weigh(self, &vectors, length);
            let (sum, top) = self.lift(&vectors, by);
            self.total += f64::from(sum);
            // The first of equals wins.
            if top > highest {
                (highest, self.run) = (top, vectors.start);
            }
        }
        highest
    }

    /// Vectors that are weighed and then lifted while they are at hand, and the length of their tiles: whole ones, then what is
    /// left of one.
    fn runs(&self) -> impl Iterator<Item = (Range<usize>, usize)> + use<> {
        let all = self.table.vectors;
        let whole = all / TILE * TILE;
        let runs = (0..whole)
            .step_by(RUN * TILE)
            .map(move |from| (from..(from + RUN * TILE).min(whole), TILE));
        runs.chain((whole < all).then(|| (whole..all, all - whole)))
    }

    /// Vectors of tiles of equal length under a sample of two short rows.
    fn weigh_pair(&mut self, vectors: &Range<usize>, length: usize, pair: &Pair) {
        let sources = pair.sources().map(|k| {
            let Source { values, blocks } = self.slices.source(&self.table, k);
            let values = values.get(vectors.start * blocks..vectors.end * blocks);
            Source {
                values: values.unwrap_or_default(),
                blocks,
            }
        });
        let weights = self.log_weights.get_mut(vectors.clone());
        pair.weigh(length, sources, weights.unwrap_or_default());
    }

    /// Vectors of tiles of equal length under all samples.
    fn weigh_alike(&mut self, vectors: &Range<usize>, length: usize, samples: &[Sample]) {
        let part = |each: usize| vectors.start * each..vectors.end * each;
        let mut sources = [Source::default(); SOURCES];
        let slices = self.slices.slices.iter().map(|s| (&s.values, s.blocks()));
        let all = std::iter::once((&self.table.values, self.table.blocks)).chain(slices);
        for (source, (values, blocks)) in sources.iter_mut().zip(all) {
            let values = values.get(part(blocks)).unwrap_or_default();
            *source = Source { values, blocks };
        }
        let tiles = Tiles {
            sources,
            previous: self.previous.get_mut(part(ROWS)).unwrap_or_default(),
            residuals: &mut self.residuals,
            weights: self.log_weights.get_mut(part(1)).unwrap_or_default(),
        };
        weigh_tiles(samples, length, tiles);
    }

    /// Adds the same to some log-weights: the sum of their weights and the largest of them.
    fn lift(&mut self, vectors: &Range<usize>, by: f32) -> (f32, f32) {
        let weights = self.log_weights.get_mut(vectors.clone());
        lift(weights.unwrap_or_default(), by)
    }
}

/// Number of the first log-weight that is this one.
#[inline]
fn first_of(weights: &[[f32; LANES]], one: f32) -> usize {
    for (k, lw) in weights.iter().enumerate() {
        let bits = f32x8::from(*lw).simd_eq(f32x8::splat(one)).to_bitmask();
        if bits != 0 {
            return k * LANES + bits.trailing_zeros() as usize;
        }
    }
    0
}
