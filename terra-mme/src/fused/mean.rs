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
const SOME: usize = 16;

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
            let mut sums = [0.0; BLOCK];
            let (mut log_weights, mut off) = (log_weights, block.off.as_slice());
            loop {
                let length = log_weights.len().min(off.len()).min(CHUNK);
                let (some, others) = log_weights.split_at(length);
                let (some_off, others_off) = off.split_at(length);
                for (sum, part) in sums.iter_mut().zip(weighted(some, some_off)) {
                    *sum += f64::from(part);
                }
                if others.is_empty() || others_off.is_empty() {
                    break;
                }
                (log_weights, off) = (others, others_off);
            }
            for (sum, centre) in sums.iter_mut().zip(&block.centre) {
                *sum = *sum * share + centre;
            }
            mean.copy_from_slice(&sums[..mean.len()]);
        }
    }
}

/// Σ w x of each parameter of a block.
#[inline]
fn weighted(log_weights: &[[f32; LANES]], off: &[[[f32; LANES]; BLOCK]]) -> [f32; BLOCK] {
    let mut sums = [f32x8::ZERO; BLOCK];
    let mut add = |w: f32x8, off: &[[f32; LANES]; BLOCK]| {
        for (sum, x) in sums.iter_mut().zip(off) {
            *sum = f32x8::from(*x).mul_add(w, *sum);
        }
    };
    let (some, last) = log_weights.as_chunks::<SOME>();
    let (some_off, last_off) = off.as_chunks::<SOME>();
    if !some.is_empty() {
        let mut weights = [[0.0; LANES]; SOME];
        for (lw, off) in some.iter().zip(some_off) {
            powers(lw, &mut weights);
            for (w, off) in weights.iter().zip(off) {
                add(f32x8::from(*w), off);
            }
        }
    }
    for (lw, off) in last.iter().zip(last_off) {
        add(power_of_two(f32x8::from(*lw)), off);
    }
    let [a, b, c, d, e, f, g, h] = f32x8::transpose(sums);
    (((a + b) + (c + d)) + ((e + f) + (g + h))).to_array()
}

/// Weights of log-weights.
#[inline(never)]
fn powers(log_weights: &[[f32; LANES]; SOME], weights: &mut [[f32; LANES]; SOME]) {
    for (w, lw) in weights.iter_mut().zip(log_weights) {
        *w = power_of_two(f32x8::from(*lw)).to_array();
    }
}
