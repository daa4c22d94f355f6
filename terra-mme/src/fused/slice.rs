//! Forces at a load that stays: on level ground a wheel carries the same load at every sample. The table is then interpolated
//! along the load once a node, and a look-up takes four nodes along the slip instead of sixteen.

use wide::f32x8;

use super::grid::{ALONG, GridTable, LANES, OUTPUTS, Stencil};
use super::kernel::{TILE, WHEELS};
use crate::observation::ForceObservation;

/// One load, `values[tile][output][slip][vector]`, a node filled when it is first asked for.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    load: f64,
    /// Samples after which it was last asked for.
    used: usize,
    filled: Vec<bool>,
    pub(super) values: Vec<[f32; LANES]>,
}

/// The loads that stay, at most as many as a vehicle has wheels.
#[derive(Clone, Debug, Default)]
pub(super) struct Slices {
    pub(super) slices: Vec<Slice>,
    /// Loads of the sample before.
    last: Vec<f64>,
    blocks: usize,
}

impl Slices {
    /// Finds or makes the slices of a block's first sample: of loads that were in the sample before or are in the next. They
    /// stay the same through the block.
    pub(super) fn begin(&mut self, table: &GridTable, block: &[ForceObservation]) {
        self.blocks += 1;
        let Some(first) = block.first() else { return };
        for at in first.contacts.iter().take(WHEELS) {
            let load = at.normal_load;
            if let Some(k) = self.find(load) {
                self.slices[k].used = self.blocks;
                continue;
            }
            let next = block.get(1).map(|next| &next.contacts);
            let next = next.is_some_and(|c| c.iter().any(|c| c.normal_load == load));
            if !next && !self.last.contains(&load) {
                continue;
            }
            let nodes = table.range.nodes.0 * OUTPUTS;
            let new = Slice {
                load,
                used: self.blocks,
                filled: vec![false; nodes],
                values: vec![[0.0; LANES]; nodes * table.vectors],
            };
            if self.slices.len() < WHEELS {
                self.slices.push(new);
            } else if let Some(oldest) = self.slices.iter_mut().min_by_key(|s| s.used) {
                *oldest = new;
            }
        }
        if let Some(last) = block.last() {
            self.last.clear();
            self.last
                .extend(last.contacts.iter().map(|c| c.normal_load));
        }
    }

    /// The slice of a load.
    pub(super) fn find(&self, load: f64) -> Option<usize> {
        self.slices.iter().position(|s| s.load == load)
    }

    /// Fills what a look-up of an output takes of slice k, and returns its first block.
    pub(super) fn ready(
        &mut self,
        k: usize,
        table: &GridTable,
        stencil: &Stencil,
        output: usize,
    ) -> usize {
        let nodes = table.range.nodes.0;
        let first = output * nodes + stencil.first_slip();
        let slice = &mut self.slices[k];
        for a in 0..ALONG {
            if !slice.filled[first + a] {
                slice.filled[first + a] = true;
                slice.fill(table, stencil, output, a);
            }
        }
        first
    }
}

impl Slice {
    /// Blocks of a tile.
    pub(super) fn blocks(&self) -> usize {
        self.filled.len()
    }

    /// One node of all hypotheses.
    fn fill(&mut self, table: &GridTable, stencil: &Stencil, output: usize, a: usize) {
        let (nodes, node) = (table.range.nodes.0, stencil.first_slip() + a);
        let (from, weight) = stencil.along_load(output, a);
        for tile in 0..table.vectors.div_ceil(TILE) {
            let start = tile * TILE;
            let size = TILE.min(table.vectors - start);
            let to = start * nodes * OUTPUTS + (output * nodes + node) * size;
            let from = start * table.blocks + from * size;
            for v in 0..size {
                let mut sum = f32x8::ZERO;
                for (b, weight) in weight.iter().enumerate() {
                    let values = f32x8::from(table.values[from + b * size + v]);
                    sum = values.mul_add(f32x8::splat(*weight), sum);
                }
                self.values[to + v] = sum.to_array();
            }
        }
    }
}
