//! Copies of soils with every parameter a little off: does the data tell a soil from its like?
//!
//! # Reference
//! L. E. Ray, Proc. SPIE (2008): soils of the set perturbed by 10 %.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use terra_model::{ForceLaw, Param};

use super::axis::countable;
use crate::error::EstimatorError;
use crate::hypothesis::{Hypothesis, HypothesisSet};

/// Draws of one parameter before a legal value must have come.
const ATTEMPTS: usize = 1000;

impl HypothesisSet {
    /// `copies` perturbed copies of every hypothesis, named `id~1`, `id~2`, ...; the originals are not among them
    /// ([`joined`](HypothesisSet::joined) puts them there). Parameters that are 0 stay 0. A copy is the same whatever
    /// the number of copies or the hypotheses behind its own: it draws from a stream of its own.
    ///
    /// # Equation
    /// p' = p e^(sd z), z ~ N(0, 1) for each parameter; drawn again while outside the law's range.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a spread that is negative or not finite, or a parameter of which no draw is legal;
    /// [`EstimatorError::Size`], [`EstimatorError::EmptySet`], [`EstimatorError::DuplicateId`].
    pub fn perturbed(&self, copies: usize, sd: f64, seed: u64) -> Result<Self, EstimatorError> {
        if !(sd.is_finite() && sd >= 0.0) {
            return Err(EstimatorError::Value {
                what: "spread of perturbed copies".to_owned(),
                value: sd,
                expected: "a finite sd of ln(parameter) of at least 0",
            });
        }
        countable(self.len().checked_mul(copies))?;
        let mut hypotheses = Vec::with_capacity(self.len() * copies);
        for (j, h) in self.hypotheses().iter().enumerate() {
            for copy in 0..copies {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(((j as u64) << 32) | copy as u64);
                let off = |(p, param): (&f64, &Param)| drawn(*p, param, sd, &mut rng);
                hypotheses.push(Hypothesis {
                    id: format!("{}~{}", h.id, copy + 1),
                    law: h.law.clone(),
                    parameters: h
                        .parameters
                        .iter()
                        .zip(h.law.params())
                        .map(off)
                        .collect::<Result<_, _>>()?,
                });
            }
        }
        Self::new(hypotheses)
    }
}

fn drawn(p: f64, param: &Param, sd: f64, rng: &mut ChaCha8Rng) -> Result<f64, EstimatorError> {
    if p == 0.0 {
        return Ok(p);
    }
    for _ in 0..ATTEMPTS {
        let z: f64 = StandardNormal.sample(rng);
        let value = p * (sd * z).exp();
        if (param.min..=param.max).contains(&value) {
            return Ok(value);
        }
    }
    Err(EstimatorError::Value {
        what: format!("perturbed {}", param.name),
        value: p,
        expected: "a value within reach of the law's range",
    })
}
