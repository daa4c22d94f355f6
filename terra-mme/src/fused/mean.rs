//! Means of the parameters under the posterior as it stands: a pass over what is kept for them, nothing allocated.
//!
//! # Equation
//! x̄_k = c_k + Σ_j w_j (x_jk - c_k) / Σ_j w_j, c the mean without weights: differences from it are exact enough in single
//! precision. Sums of 4 096 hypotheses are added up in double precision.
//!
//! # Reference
//! L. E. Ray, Proc. SPIE (2008), eq. 24.

use wide::f32x8;

use super::grid::LANES;
use super::kernel::power_of_two;
use crate::hypothesis::HypothesisSet;

/// Parameters of a block: as many sums stay in registers.
const BLOCK: usize = 8;
/// Vectors whose sums are taken in single precision.
const CHUNK: usize = 512;
/// Vectors whose weights are made before they are used: constants of a power and sums do not fit into the registers at once.
const SOME: usize = 64;
/// From so many on that is worth its buffer.
const MANY: usize = 16;
/// Vectors to a turn of a loop, which itself then costs a quarter.
const AT_ONCE: usize = 4;

/// The parameters of a set under one law.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    count: usize,
    blocks: Vec<Block>,
}

/// Up to [`BLOCK`] parameters.
#[derive(Clone, Debug)]
struct Block {
    centre: [f64; BLOCK],
    /// What they are off it, vector by vector.
    off: Vec<[[f32; LANES]; BLOCK]>,
}

impl Parameters {
    /// Of a set in so many vectors; `None` for hypotheses of several laws.
    pub(super) fn of(set: &HypothesisSet, vectors: usize) -> Option<Self> {
        let hypotheses = set.hypotheses();
        let count = hypotheses.first()?.parameters.len();
        if set.structures().len() > 1 {
            return None;
        }
        let empty = Block {
            centre: [0.0; BLOCK],
            off: vec![[[0.0; LANES]; BLOCK]; vectors],
        };
        let mut blocks = vec![empty; count.div_ceil(BLOCK)];
        for k in 0..count {
            let (block, own) = (&mut blocks[k / BLOCK], k % BLOCK);
            let all = || hypotheses.iter().filter_map(|h| h.parameters.get(k));
            let centre = all().sum::<f64>() / hypotheses.len() as f64;
            block.centre[own] = centre;
            for (j, x) in all().enumerate() {
                block.off[j / LANES][own][j % LANES] = (x - centre) as f32;
            }
        }
        Some(Parameters { count, blocks })
    }

    /// Number of parameters.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The means, given log2 w and Σ w.
    #[inline]
    pub(super) fn mean(&self, log_weights: &[[f32; LANES]], total: f64, mean: &mut [f64]) {
        let share = 1.0 / total;
        for (block, mean) in self.blocks.iter().zip(mean.chunks_mut(BLOCK)) {
            let mut found = summed(log_weights, &block.off);
            for (x, centre) in found.iter_mut().zip(&block.centre) {
                *x = *x * share + centre;
            }
            // A whole block is eight numbers and not a copy of unknown length.
            match <&mut [f64; BLOCK]>::try_from(&mut *mean) {
                Ok(whole) => *whole = found,
                Err(_) => mean.copy_from_slice(&found[..mean.len()]),
            }
        }
    }
}

/// Σ w x of each parameter of a block, chunk by chunk.
#[inline]
fn summed(log_weights: &[[f32; LANES]], off: &[[[f32; LANES]; BLOCK]]) -> [f64; BLOCK] {
    if log_weights.len() <= CHUNK {
        return weighted(log_weights, off).map(f64::from);
    }
    let mut sums = [0.0; BLOCK];
    for (some, off) in log_weights.chunks(CHUNK).zip(off.chunks(CHUNK)) {
        for (sum, part) in sums.iter_mut().zip(weighted(some, off)) {
            *sum += f64::from(part);
        }
    }
    sums
}

/// The same of a chunk, in single precision.
#[inline]
fn weighted(log_weights: &[[f32; LANES]], off: &[[[f32; LANES]; BLOCK]]) -> [f32; BLOCK] {
    let sums = if log_weights.len() < MANY {
        one_by_one(log_weights, off)
    } else {
        in_turns(log_weights, off)
    };
    let [a, b, c, d, e, f, g, h] = f32x8::transpose(sums);
    (((a + b) + (c + d)) + ((e + f) + (g + h))).to_array()
}

/// Adds each vector as its weights are made.
#[inline]
fn one_by_one(log_weights: &[[f32; LANES]], off: &[[[f32; LANES]; BLOCK]]) -> [f32x8; BLOCK] {
    let mut sums = [f32x8::ZERO; BLOCK];
    for (lw, off) in log_weights.iter().zip(off) {
        add(&mut sums, power_of_two(f32x8::from(*lw)), off);
    }
    sums
}

/// Makes the weights of [`SOME`] vectors before any of them is used.
#[inline(never)]
fn in_turns(log_weights: &[[f32; LANES]], off: &[[[f32; LANES]; BLOCK]]) -> [f32x8; BLOCK] {
    let mut sums = [f32x8::ZERO; BLOCK];
    let mut weights = [[0.0; LANES]; SOME];
    for (lw, off) in log_weights.chunks(SOME).zip(off.chunks(SOME)) {
        let weights = &mut weights[..lw.len()];
        powers(lw, weights);
        let (fours, last) = weights.as_chunks::<AT_ONCE>();
        let (fours_off, last_off) = off.as_chunks::<AT_ONCE>();
        for (w, off) in fours.iter().zip(fours_off) {
            add_all(&mut sums, w, off);
        }
        add_all(&mut sums, last, last_off);
    }
    sums
}

/// Adds w x of some vectors to the sums of a block.
#[inline]
fn add_all(sums: &mut [f32x8; BLOCK], weights: &[[f32; LANES]], off: &[[[f32; LANES]; BLOCK]]) {
    for (w, off) in weights.iter().zip(off) {
        add(sums, f32x8::from(*w), off);
    }
}

/// Adds w x of one vector to the sums of a block.
#[inline]
fn add(sums: &mut [f32x8; BLOCK], w: f32x8, off: &[[f32; LANES]; BLOCK]) {
    for (sum, x) in sums.iter_mut().zip(off) {
        *sum = f32x8::from(*x).mul_add(w, *sum);
    }
}

/// Weights of log-weights.
#[inline(never)]
fn powers(log_weights: &[[f32; LANES]], weights: &mut [[f32; LANES]]) {
    let (fours, last) = weights.as_chunks_mut::<AT_ONCE>();
    let (fours_of, last_of) = log_weights.as_chunks::<AT_ONCE>();
    for (w, lw) in fours.iter_mut().zip(fours_of) {
        powers_of(w, lw);
    }
    powers_of(last, last_of);
}

/// The same of some vectors.
#[inline]
fn powers_of(weights: &mut [[f32; LANES]], log_weights: &[[f32; LANES]]) {
    for (w, lw) in weights.iter_mut().zip(log_weights) {
        *w = power_of_two(f32x8::from(*lw)).to_array();
    }
}
