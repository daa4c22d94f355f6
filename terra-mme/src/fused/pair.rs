//! The pass for the sample that is most common: two rows, each a force of one wheel under a load that stays, so that four nodes
//! make a row. All that hypotheses share at it then stays in registers.

use wide::f32x8;

use super::grid::{ALONG, LANES};
use super::kernel::{Group, Row, SOURCES, Sample, Source, Tiles};

/// What hypotheses share at such a sample.
struct Pair {
    weight: [[f32x8; ALONG]; 2],
    observed: [f32x8; 2],
    /// What the second row takes of the first.
    cross: f32x8,
}

/// Weighs tiles of V vectors if the sample is such a one; whether it was.
pub(super) fn weigh_pair<const V: usize>(sample: &Sample, tiles: &mut Tiles<'_>) -> bool {
    let [one, two, ..] = &sample.row;
    let (2, true, [a], [b]) = (
        sample.rows,
        tiles.previous.is_empty(),
        one.groups.as_slice(),
        two.groups.as_slice(),
    ) else {
        return false;
    };
    let all = f32x8::splat;
    let observed = |row: &Row| all(-row.observed);
    let pair = Pair {
        weight: [a.weight.map(all), b.weight.map(all)],
        observed: [observed(one), observed(two)],
        cross: all(two.whiten[0]),
    };
    let (weights, _) = tiles.weights.as_chunks_mut::<V>();
    let nodes = nodes::<V>(&tiles.sources, a).zip(nodes::<V>(&tiles.sources, b));
    for (weights, (a, b)) in weights.iter_mut().zip(nodes) {
        pair.fall(a, b, weights);
    }
    true
}

/// The nodes of a group, tile by tile.
fn nodes<'a, const V: usize>(
    sources: &[Source<'a>; SOURCES],
    group: &Group,
) -> impl Iterator<Item = &'a [[[f32; LANES]; V]; ALONG]> {
    let Source { values, blocks } = sources[group.source % SOURCES];
    let (values, _) = values.as_chunks::<V>();
    let from = values.get(group.block..).unwrap_or_default();
    // The last tile ends before a whole stride from its node does.
    from.chunks(blocks.max(1))
        .map_while(|tile| tile.first_chunk())
}

impl Pair {
    #[inline]
    fn fall<const V: usize>(
        &self,
        a: &[[[f32; LANES]; V]; ALONG],
        b: &[[[f32; LANES]; V]; ALONG],
        weights: &mut [[f32; LANES]; V],
    ) {
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
