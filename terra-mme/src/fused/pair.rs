//! The pass for the sample that is most common: two rows, each a force of one wheel under a load that stays, so that four nodes
//! make a row. All that hypotheses share at it then stays in registers.
//!
//! # Equation
//! e = Σ_a g_a F_a - y, d = Σ_a h_a G_a - z + c e, log2 w <- log2 w - e² - d², whitened: g, h, y, z have their scales in them.

use wide::f32x8;

use super::grid::{ALONG, LANES};
use super::kernel::{Group, Sample, Source};

/// What hypotheses share at such a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) groups: [Group; 2],
    pub(super) observed: [f32; 2],
    /// What the second row takes of the first.
    pub(super) cross: f32,
}

/// The same in every lane.
#[derive(Clone, Copy)]
struct Lanes {
    weight: [[f32x8; ALONG]; 2],
    observed: [f32x8; 2],
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
        Some(Pair {
            groups: [*a, *b],
            observed: [one.observed, two.observed],
            cross: two.whiten[0],
        })
    }

    /// Sources that the rows look at.
    pub(super) fn sources(&self) -> [usize; 2] {
        self.groups.map(|group| group.source)
    }

    /// Weighs tiles of `length` vectors, given the sources of both rows there.
    #[inline]
    pub(super) fn weigh(&self, length: usize, sources: [Source<'_>; 2], w: &mut [[f32; LANES]]) {
        match length {
            1 => self.tiles::<1>(sources, w),
            2 => self.tiles::<2>(sources, w),
            3 => self.tiles::<3>(sources, w),
            4 => self.tiles::<4>(sources, w),
            _ => self.tiles::<8>(sources, w),
        }
    }

    /// Weighs the one tile of a set, given the forces that the rows look at.
    #[inline]
    pub(super) fn weigh_one<const V: usize>(
        &self,
        values: [&[[f32; LANES]]; 2],
        weights: &mut [[f32; LANES]; V],
    ) {
        let [a, b] = [0, 1].map(|k| {
            let first = self.groups[k].block * V;
            let nodes = values[k].get(first..first + ALONG * V)?;
            nodes.as_chunks().0.first_chunk()
        });
        if let (Some(a), Some(b)) = (a, b) {
            self.lanes().fall(a, b, weights);
        }
    }

    fn tiles<const V: usize>(&self, sources: [Source<'_>; 2], weights: &mut [[f32; LANES]]) {
        // A copy may stay in registers from tile to tile.
        let (own, blocks) = (self.lanes(), self.groups.map(|group| group.block));
        let [mut a, mut b] = sources.map(|s| s.values.as_chunks::<V>().0);
        for weights in weights.as_chunks_mut::<V>().0 {
            let [Some(one), Some(two)] = [(a, 0), (b, 1)].map(|(tile, k)| {
                let from = tile.get(blocks[k]..);
                from.and_then(|from| from.first_chunk())
            }) else {
                return;
            };
            own.fall(one, two, weights);
            a = a.get(sources[0].blocks..).unwrap_or_default();
            b = b.get(sources[1].blocks..).unwrap_or_default();
        }
    }

    #[inline]
    fn lanes(&self) -> Lanes {
        let all = f32x8::splat;
        Lanes {
            weight: self.groups.map(|group| group.weight.map(all)),
            observed: self.observed.map(|y| all(-y)),
            cross: all(self.cross),
        }
    }
}

impl Lanes {
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
