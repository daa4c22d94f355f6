//! One pass over the set: all log-weights fall by what the samples say, and are lifted by what the winner is known to be above.

use std::f64::consts::LN_2;
use std::ops::Range;

use wide::f32x8;

use super::FusedModel;
use crate::fused::grid::LANES;
use crate::fused::kernel::{ROWS, SOURCES, Sample, Source, TILE, Tiles, lift, weigh_tiles};
use crate::fused::pair::Pair;

/// Log-weight (to base 2) of the winner beyond which all are shifted back.
const HIGH: f32 = 29.0;
/// Tiles whose log-weights stay at hand between falling and being lifted.
const RUN: usize = 16;

impl FusedModel {
    /// The pass itself. Returns what was taken out of every log-weight, to base e.
    pub(super) fn pass(&mut self, samples: &[Sample]) -> f64 {
        let rows = match samples {
            [one] => one.rows,
            _ => samples.iter().map(|s| s.rows).sum(),
        };
        // As much as a right hypothesis falls on average, so that a long block ends near 0.
        let lift = rows as u32 as f32 * (0.5 * std::f32::consts::LOG2_E) - self.top;
        let (where_highest, highest) = match self.one_tile(samples, lift) {
            Some((sum, highest)) => {
                self.total = f64::from(sum);
                (0, highest)
            }
            None => self.all_tiles(samples, lift),
        };
        let vectors = self.log_weights.get(where_highest..).unwrap_or_default();
        for (k, lw) in vectors.iter().enumerate() {
            let same = f32x8::from(*lw).simd_eq(f32x8::splat(highest));
            let bits = same.to_bitmask();
            if bits != 0 {
                self.best = (where_highest + k) * LANES + bits.trailing_zeros() as usize;
                break;
            }
        }
        self.top = highest;
        let mut taken_out = -f64::from(lift);
        // A new winner far above the old one, or an old one that fell far: all are shifted.
        if highest.abs() > HIGH {
            taken_out += f64::from(highest);
            self.top = 0.0;
            self.total = self
                .runs()
                .map(|(vectors, _)| f64::from(self.lift(&vectors, -highest).0))
                .sum();
        }
        taken_out * LN_2
    }

    /// A set that is one tile, under a sample of two short rows: the sum of its weights and the largest log-weight. `None` for
    /// others.
    #[inline]
    fn one_tile(&mut self, samples: &[Sample], lift: f32) -> Option<(f32, f32)> {
        let ([sample], true, true) = (
            samples,
            self.previous.is_empty(),
            self.table.vectors <= TILE,
        ) else {
            return None;
        };
        let pair = Pair::of(sample)?;
        let sources = pair.sources();
        let sources = sources.map(|k| self.slices.source(&self.table, k).values);
        let length = self.table.vectors;
        Some(pair.one_tile(length, sources, &mut self.log_weights, lift))
    }

    /// Run by run: where the largest log-weight is, or some vectors before, and the largest.
    #[inline(never)]
    fn all_tiles(&mut self, samples: &[Sample], lift: f32) -> (usize, f32) {
        let pair = match samples {
            [sample] if self.previous.is_empty() => Pair::of(sample),
            _ => None,
        };
        let (mut where_highest, mut highest) = (0, f32::MIN);
        self.total = 0.0;
        for (vectors, length) in self.runs() {
            match &pair {
                Some(pair) => self.weigh_pair(&vectors, length, pair),
                None => self.weigh_alike(&vectors, length, samples),
            }
            let (sum, top) = self.lift(&vectors, lift);
            self.total += f64::from(sum);
            // The first of equals wins.
            if top > highest {
                (highest, where_highest) = (top, vectors.start);
            }
        }
        (where_highest, highest)
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
