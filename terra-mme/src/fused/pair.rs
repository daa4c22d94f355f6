//! The pass for the sample that is most common: two rows, each a force of one wheel under a load that stays, so that four nodes
//! make a row. All that hypotheses share at it then stays in registers.

use wide::f32x8;

use super::grid::{ALONG, LANES};
use super::kernel::{Group, Sample, Source, lift};

/// What hypotheses share at such a sample.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    groups: [Group; 2],
    weight: [[f32x8; ALONG]; 2],
    observed: [f32x8; 2],
    /// What the second row takes of the first.
    cross: f32x8,
}

/// Nodes of a row in a tile of V vectors.
type Nodes<const V: usize> = [[[f32; LANES]; V]; ALONG];

impl Pair {
    /// Of a sample of that kind, whose rows have their scale in their weights.
    #[inline]
    pub(super) fn of(sample: &Sample) -> Option<Self> {
        let [one, two, ..] = &sample.row;
        let (2, [a], [b]) = (sample.rows, one.groups.as_slice(), two.groups.as_slice()) else {
            return None;
        };
        let all = f32x8::splat;
        Some(Pair {
            groups: [*a, *b],
            weight: [a.weight.map(all), b.weight.map(all)],
            observed: [all(-one.observed), all(-two.observed)],
            cross: all(two.whiten[0]),
        })
    }

    /// Sources that the rows look at.
    pub(super) fn sources(&self) -> [usize; 2] {
        [self.groups[0].source, self.groups[1].source]
    }

    /// Weighs tiles of `length` vectors, given the sources of both rows there.
    #[inline]
    pub(super) fn weigh(&self, length: usize, sources: [Source<'_>; 2], w: &mut [[f32; LANES]]) {
        match length {
            1 => self.tiles::<1>(sources, w),
            2 => self.tiles::<2>(sources, w),
            4 => self.tiles::<4>(sources, w),
            _ => self.tiles::<8>(sources, w),
        }
    }

    /// Weighs a set of one tile and lifts it: the sum of its weights and the largest log-weight.
    #[inline]
    pub(super) fn one_tile(
        &self,
        length: usize,
        values: [&[[f32; LANES]]; 2],
        weights: &mut [[f32; LANES]],
        by: f32,
    ) -> (f32, f32) {
        match length {
            1 => self.first::<1>(values, weights),
            2 => self.first::<2>(values, weights),
            4 => self.first::<4>(values, weights),
            _ => self.first::<8>(values, weights),
        }
        lift(weights, by)
    }

    #[inline]
    fn first<const V: usize>(&self, values: [&[[f32; LANES]]; 2], weights: &mut [[f32; LANES]]) {
        let [a, b] = [0, 1].map(|k| {
            let tile = values[k].as_chunks::<V>().0;
            let from = tile.get(self.groups[k].block..)?;
            from.first_chunk()
        });
        if let (Some(a), Some(b), Some(weights)) = (a, b, weights.first_chunk_mut()) {
            self.fall(a, b, weights);
        }
    }

    fn tiles<const V: usize>(&self, sources: [Source<'_>; 2], weights: &mut [[f32; LANES]]) {
        // A copy may stay in registers from tile to tile.
        let own_pair = *self;
        let [mut a, mut b] = sources.map(|s| s.values.as_chunks::<V>().0);
        for weights in weights.as_chunks_mut::<V>().0 {
            let [Some(own), Some(other)] = [(a, 0), (b, 1)].map(|(tile, k)| {
                let from = tile.get(own_pair.groups[k].block..);
                from.and_then(|from| from.first_chunk())
            }) else {
                return;
            };
            own_pair.fall(own, other, weights);
            a = a.get(sources[0].blocks..).unwrap_or_default();
            b = b.get(sources[1].blocks..).unwrap_or_default();
        }
    }

    #[inline]
    fn fall<const V: usize>(&self, a: &Nodes<V>, b: &Nodes<V>, weights: &mut [[f32; LANES]; V]) {
        for (v, lw) in weights.iter_mut().enumerate() {
            let [mut e, mut d] = self.observed;
            for k in 0..ALONG {
                e = f32x8::from(a[k][v]).mul_add(self.weight[0][k], e);
                d = f32x8::from(b[k][v]).mul_add(self.weight[1][k], d);
            }
            d = e.mul_add(self.cross, d);
            let left = e.mul_neg_add(e, f32x8::from(*lw));
            *lw = d.mul_neg_add(d, left).to_array();
        }
    }
}
