//! Forces at a load that stays: on level ground a wheel carries the same load at every sample. The table is then interpolated
//! along the load once a node, and a look-up takes four nodes along the slip instead of sixteen.

use wide::f32x8;

use super::grid::{ALONG, GridTable, LANES, OUTPUTS};
use super::kernel::{Source, TILE, WHEELS};
use crate::observation::ForceObservation;

/// One load, `values[tile][output][slip][vector]`, a node filled when it is first asked for.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    load: f64,
    /// First node along the load, and weights.
    node: usize,
    weight: [f32; ALONG],
    /// Samples after which it was last asked for.
    used: usize,
    filled: Vec<bool>,
    pub(super) values: Vec<[f32; LANES]>,
}

/// Normal loads of an observation.
fn loads(obs: &ForceObservation) -> impl Iterator<Item = f64> {
    obs.contacts.iter().map(|c| c.normal_load)
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
        let Some(first) = block.first() else { return };
        self.keep(table, loads(first), |load| {
            let next = block.get(1);
            next.is_some_and(|obs| obs.contacts.iter().any(|c| c.normal_load == load))
        });
        if let Some(last) = block.last() {
            self.end(loads(last));
        }
    }

    /// Finds or makes the slices of loads that were in the sample before or are `next`.
    pub(super) fn keep(
        &mut self,
        table: &GridTable,
        loads: impl Iterator<Item = f64>,
        next: impl Fn(f64) -> bool,
    ) {
        self.blocks += 1;
        for load in loads.take(WHEELS) {
            if let Some(k) = self.find(load) {
                self.slices[k].used = self.blocks;
            } else if self.last.contains(&load) || next(load) {
                self.make(table, load);
            }
        }
    }

    /// Loads of the last sample.
    pub(super) fn end(&mut self, loads: impl Iterator<Item = f64>) {
        self.last.clear();
        self.last.extend(loads);
    }

    /// In the place of the one not asked for longest; none of a load outside the table, which the look-up refuses.
    fn make(&mut self, table: &GridTable, load: f64) {
        let Ok((node, weight, _)) = table.along_load(load) else {
            return;
        };
        let nodes = table.range.nodes.0 * OUTPUTS;
        let new = Slice {
            load,
            node,
            weight: weight.map(|w| w as f32),
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

    /// The slice of a load that was the only one of the sample before: nothing of what is kept would change.
    #[inline]
    pub(super) fn same(&self, load: f64) -> Option<usize> {
        match self.last.as_slice() {
            [last] if *last == load => self.find(load),
            _ => None,
        }
    }

    /// The slice of a load.
    #[inline]
    pub(super) fn find(&self, load: f64) -> Option<usize> {
        self.slices.iter().position(|s| s.load == load)
    }

    /// Forces of all vectors: source 0 is the table, the others are slices.
    #[inline]
    pub(super) fn source<'a>(&'a self, table: &'a GridTable, source: usize) -> Source<'a> {
        // One less than 0 is the number of no slice.
        match self.slices.get(source.wrapping_sub(1)) {
            Some(slice) => Source {
                values: &slice.values,
                blocks: slice.blocks(),
            },
            None => Source {
                values: &table.values,
                blocks: table.blocks,
            },
        }
    }

    /// Fills what a look-up of an output takes of slice k, from a node along slip on, and returns its first block.
    #[inline]
    pub(super) fn ready(
        &mut self,
        k: usize,
        table: &GridTable,
        slip: usize,
        output: usize,
    ) -> usize {
        let first = output * table.range.nodes.0 + slip;
        let slice = &mut self.slices[k];
        if slice.filled[first..first + ALONG] != [true; ALONG] {
            slice.make_ready(table, slip, output);
        }
        first
    }

    /// The first block of a look-up of an output in slice k, from a node along slip on, where all of it is filled.
    #[inline]
    pub(super) fn at_hand(
        &self,
        k: usize,
        table: &GridTable,
        slip: usize,
        output: usize,
    ) -> Option<usize> {
        let first = output * table.range.nodes.0 + slip;
        let filled = self.slices.get(k)?.filled.get(first..first + ALONG)?;
        (*filled == [true; ALONG]).then_some(first)
    }
}

impl Slice {
    /// Blocks of a tile.
    pub(super) fn blocks(&self) -> usize {
        self.filled.len()
    }

    #[cold]
    fn make_ready(&mut self, table: &GridTable, slip: usize, output: usize) {
        let first = output * table.range.nodes.0;
        for node in slip..slip + ALONG {
            if !self.filled[first + node] {
                self.filled[first + node] = true;
                self.fill(table, output, node);
            }
        }
    }

    /// One node of all hypotheses.
    fn fill(&mut self, table: &GridTable, output: usize, node: usize) {
        let nodes = table.range.nodes.0;
        let from = table.block(node, output, self.node);
        for tile in 0..table.vectors.div_ceil(TILE) {
            let start = tile * TILE;
            let size = TILE.min(table.vectors - start);
            let to = start * nodes * OUTPUTS + (output * nodes + node) * size;
            let first = start * table.blocks + from * size;
            for v in 0..size {
                let mut sum = f32x8::ZERO;
                for (b, weight) in self.weight.iter().enumerate() {
                    let values = f32x8::from(table.values[first + b * size + v]);
                    sum = values.mul_add(f32x8::splat(*weight), sum);
                }
                self.values[to + v] = sum.to_array();
            }
        }
    }
}
