//! A Latin hypercube: each of n equal slices of every axis holds exactly one of n members.
//!
//! # Reference
//! M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21(2):239-245, 1979.

use std::sync::Arc;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use terra_model::Law;

use super::Axis;
use super::axis::{countable, placed};
use crate::error::EstimatorError;
use crate::hypothesis::HypothesisSet;
use crate::random::{below, uniform};

impl HypothesisSet {
    /// A Latin hypercube of `count` members around a parameter vector: what no axis names stays at the centre. Slices
    /// are equal in the logarithm where the parameter is fitted so. Same seed, same set; each axis draws from a stream
    /// of its own.
    ///
    /// # Equation
    /// p_k = axis((π_k + u)/n), π a random permutation of 0 .. n-1 and u uniform in [0, 1), both anew for each axis.
    ///
    /// # Errors
    /// As [`HypothesisSet::grid`].
    pub fn latin_hypercube(
        law: &Arc<Law>,
        prefix: &str,
        centre: &[f64],
        axes: &[Axis],
        count: usize,
        seed: u64,
    ) -> Result<Self, EstimatorError> {
        let found = placed(law, centre, axes)?;
        let count = countable(Some(count))?;
        let mut vectors = vec![centre.to_vec(); count];
        for (stream, axis) in found.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream as u64);
            let slices = permutation(count, &mut rng);
            for (p, slice) in vectors.iter_mut().zip(slices) {
                let share = (slice as f64 + uniform(&mut rng)) / count as f64;
                if let Some(value) = p.get_mut(axis.index) {
                    *value = axis.at(share);
                }
            }
        }
        Self::from_vectors(law, prefix, vectors)
    }
}

/// Fisher and Yates: every order of 0 .. n-1 equally likely.
fn permutation(n: usize, rng: &mut impl Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    for k in (1..n).rev() {
        order.swap(k, below(rng, k + 1));
    }
    order
}
