//! The posterior of a law's parameters by an ensemble of walkers that need no tuning: a move that is invariant under any
//! affine map of the space, so that a posterior stretched along a trade-off costs no more than a round one.
//!
//! # Equation
//! ln π(q) = -qᵀq/2 - Σ_k r~_kᵀ S~_k⁻¹ r~_k/2 over the [`FitSpace`], S~_k held at the most probable q. A walker x moves to
//! y = x_j + z (x - x_j), x_j of the other half of the ensemble, z in [1/a, a] with density ∝ 1/√z, and stays there with
//! probability min(1, z^(d-1) π(y)/π(x)).
//!
//! # Reference
//! J. Goodman, J. Weare, Communications in Applied Mathematics and Computational Science 5(1):65-80, 2010;
//! D. Foreman-Mackey et al., Publ. Astronomical Society of the Pacific 125:306-312, 2013 (two halves).

use std::sync::Arc;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};
use terra_model::Law;

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;
use crate::linearise::Problem;
use crate::observation::ForceObservation;
use crate::random::{below, uniform};
use crate::refine::{RefineOptions, refine};
use crate::whiten::Prewhitening;

/// a: the published choice.
const STRETCH: f64 = 2.0;
/// Draws of a walker's start before a feasible one must have come.
const ATTEMPTS: usize = 200;

/// How an ensemble runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnsembleOptions {
    /// As in the weighing.
    pub whitening: Option<Prewhitening>,
    /// Walkers: even, at least twice the number of fitted parameters plus two.
    pub walkers: usize,
    /// Moves of each walker that are kept.
    pub steps: usize,
    /// Moves of each walker before, thrown away.
    pub burn_in: usize,
    /// Seed of the moves.
    pub seed: u64,
}

impl Default for EnsembleOptions {
    fn default() -> Self {
        EnsembleOptions {
            whitening: None,
            walkers: 24,
            steps: 80,
            burn_in: 40,
            seed: 1,
        }
    }
}

/// Draws from a posterior.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// Draws of q, step by step, walker by walker within a step.
    pub draws: Vec<DVector<f64>>,
    /// ln of the likelihood of each, up to one constant.
    pub log_likelihood: Vec<f64>,
    /// Walkers of a step.
    pub walkers: usize,
    /// Share of moves accepted.
    pub acceptance: f64,
    /// Integrated autocorrelation time in steps, of the slowest component. Trust it when the run is 20 times as long.
    pub autocorrelation_time: f64,
}

impl Ensemble {
    /// Draws over the autocorrelation time: as many independent ones would say the same.
    pub fn effective_draws(&self) -> f64 {
        self.draws.len() as f64 / self.autocorrelation_time.max(1.0)
    }

    /// Mean of q.
    pub fn mean(&self) -> DVector<f64> {
        let n = self.draws.len().max(1) as f64;
        let dim = self.draws.first().map_or(0, DVector::len);
        self.draws
            .iter()
            .fold(DVector::zeros(dim), |sum, q| sum + q / n)
    }

    /// Covariance of q.
    pub fn covariance(&self) -> DMatrix<f64> {
        let (mean, n) = (self.mean(), self.draws.len().max(1) as f64);
        let dim = mean.len();
        self.draws.iter().fold(DMatrix::zeros(dim, dim), |sum, q| {
            let d = q - &mean;
            sum + &d * d.transpose() / n
        })
    }
}

/// Draws from the posterior of a law's parameters around a centre. Same seed, same draws.
///
/// # Errors
/// [`EstimatorError::Value`] for too few walkers or no step; [`EstimatorError::Impossible`] when no start near the most
/// probable parameters is feasible; as [`refine`], which is run first.
pub fn ensemble(
    law: &Arc<Law>,
    space: &FitSpace,
    observations: &[ForceObservation],
    options: &EnsembleOptions,
) -> Result<Ensemble, EstimatorError> {
    let (dim, walkers) = (space.dim(), options.walkers);
    if walkers < 2 * dim + 2 || !walkers.is_multiple_of(2) {
        return Err(EstimatorError::Value {
            what: "walkers".to_owned(),
            value: walkers as f64,
            expected: "an even number of at least twice the fitted parameters plus two",
        });
    }
    if options.steps == 0 || dim == 0 {
        return Err(EstimatorError::Value {
            what: "steps, and parameters to fit".to_owned(),
            value: options.steps.min(dim) as f64,
            expected: "at least 1",
        });
    }
    let how = RefineOptions {
        whitening: options.whitening,
        ..RefineOptions::default()
    };
    let fit = refine(law, space.clone(), observations, &how)?;
    let problem = Problem::new(law, space, observations, options.whitening)?;
    let factors = problem.linearise(fit.q.as_slice())?.factors;
    let lower = space.lower_bounds();
    // ln π and ln likelihood; none where the law or a bound refuses.
    let density = |q: &DVector<f64>| -> Option<(f64, f64)> {
        if q.iter().zip(&lower).any(|(q, low)| q < low) {
            return None;
        }
        let r = problem.residual(q.as_slice(), &factors)?;
        let likelihood = -0.5 * r.norm_squared();
        let sum = likelihood - 0.5 * q.norm_squared();
        sum.is_finite().then_some((sum, likelihood))
    };
    let root = fit
        .covariance
        .clone()
        .cholesky()
        .ok_or(EstimatorError::Decomposition {
            what: "Cholesky of the Laplace covariance",
        })?;
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut places: Vec<(DVector<f64>, f64, f64)> = Vec::with_capacity(walkers);
    for _ in 0..walkers {
        let mut start = || {
            let z = DVector::from_fn(dim, |_, _| StandardNormal.sample(&mut rng));
            let q = &fit.q + root.l() * z;
            density(&q).map(|(pi, like)| (q, pi, like))
        };
        let found = (0..ATTEMPTS).find_map(|_| start());
        places.push(found.ok_or(EstimatorError::Impossible)?);
    }
    let mut out = Ensemble {
        draws: Vec::with_capacity(walkers * options.steps),
        log_likelihood: Vec::with_capacity(walkers * options.steps),
        walkers,
        acceptance: 0.0,
        autocorrelation_time: 1.0,
    };
    let half = walkers / 2;
    let mut accepted = 0usize;
    for step in 0..options.burn_in + options.steps {
        for k in 0..walkers {
            // The partner is of the half that does not move now.
            let other = if k < half { half } else { 0 } + below(&mut rng, half);
            let u = uniform(&mut rng);
            let z = ((STRETCH - 1.0) * u + 1.0).powi(2) / STRETCH;
            let accept = uniform(&mut rng).ln();
            let next = &places[other].0 + (&places[k].0 - &places[other].0) * z;
            if let Some((pi, like)) = density(&next)
                && accept < (dim as f64 - 1.0) * z.ln() + pi - places[k].1
            {
                places[k] = (next, pi, like);
                accepted += usize::from(step >= options.burn_in);
            }
        }
        if step >= options.burn_in {
            for (q, _, like) in &places {
                out.draws.push(q.clone());
                out.log_likelihood.push(*like);
            }
        }
    }
    out.acceptance = accepted as f64 / (walkers * options.steps) as f64;
    out.autocorrelation_time = (0..dim)
        .map(|k| autocorrelation_time(&out.draws, walkers, k))
        .fold(1.0, f64::max);
    Ok(out)
}

/// τ = 1 + 2 Σ ρ_t of one component, ρ averaged over walkers, summed while the lag is below 5 τ (Sokal's window).
fn autocorrelation_time(draws: &[DVector<f64>], walkers: usize, k: usize) -> f64 {
    let steps = draws.len() / walkers.max(1);
    let at = |step: usize, w: usize| draws[step * walkers + w][k];
    let mean = draws.iter().map(|q| q[k]).sum::<f64>() / draws.len().max(1) as f64;
    let product = |lag: usize| -> f64 {
        let pairs = (steps - lag) * walkers;
        let sum: f64 = (0..walkers)
            .map(|w| {
                (0..steps - lag)
                    .map(|s| (at(s, w) - mean) * (at(s + lag, w) - mean))
                    .sum::<f64>()
            })
            .sum();
        sum / pairs as f64
    };
    let variance = product(0);
    if variance <= 0.0 || steps < 2 {
        return 1.0;
    }
    let mut tau = 1.0;
    for lag in 1..steps {
        tau += 2.0 * product(lag) / variance;
        if lag as f64 >= 5.0 * tau {
            break;
        }
    }
    tau.max(1.0)
}
