//! `particle`: weighted samples of the states that move or are seen nonlinearly; the others are marginalised.
//!
//! On a linear state space every state can be marginalised, and what is left is the Kalman filter, exactly
//! (Rao-Blackwell: a conditional mean is never worse than a sample of it). With marginalising off, or on a nonlinear
//! state space, all states are sampled.
//!
//! # Equation
//! x_i ~ p(x_k | x_i at k-1), w_i <- w_i N(z; h(x_i), R), mean = Σ w_i x_i. Below half the effective number 1/Σ w_i²:
//! systematic resampling, then x_i <- m + √(1 - b²) (x_i - m) + b L ε with P = L Lᵀ and b the bandwidth of a Gaussian
//! kernel, which keeps mean and covariance. A likelihood too sharp for the samples is taken in by powers.
//!
//! # Reference
//! N. J. Gordon, D. J. Salmond, A. F. M. Smith, IEE Proc. F 140(2):107-113, 1993; A. Doucet et al., Proc. UAI 2000
//! (Rao-Blackwellised); J. Liu, M. West in *Sequential Monte Carlo Methods in Practice*, 2001 (kernel with shrinkage); C. Musso,
//! N. Oudjane, F. Le Gland, ibid. (progressive correction).

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};

use super::Model;
use super::dense::{Method, Update, View};
use super::kf::{Linear, drive, predict_linear};
use crate::config::Particles;
use crate::discretise::{propagate, runge_kutta, substeps};
use crate::error::FilterError;
use crate::gaussian::{Gaussian, square_root, symmetrise};

/// Powers of one likelihood at most.
const MOST_STAGES: usize = 60;

/// Method of `particle`.
#[derive(Clone)]
pub struct Particle {
    kind: Kind,
}

#[derive(Clone)]
enum Kind {
    /// Nothing left to sample.
    Marginal(Linear),
    Sampled(Box<Cloud>),
}

struct Cloud {
    states: Vec<DVector<f64>>,
    log_weights: Vec<f64>,
    rng: ChaCha8Rng,
}

impl Clone for Cloud {
    fn clone(&self) -> Self {
        // A generator is not cloned by accident; a filter that is must draw what it would have drawn.
        let mut rng = ChaCha8Rng::from_seed(self.rng.get_seed());
        rng.set_stream(self.rng.get_stream());
        rng.set_word_pos(self.rng.get_word_pos());
        Cloud {
            states: self.states.clone(),
            log_weights: self.log_weights.clone(),
            rng,
        }
    }
}

impl Particle {
    /// Samples of a prior; none where all can be marginalised.
    ///
    /// # Errors
    /// [`FilterError::NotACovariance`] for a prior that has no square root; [`FilterError::Config`] without particles.
    pub fn new(
        space: &dyn crate::AnyStateSpace,
        particles: Particles,
    ) -> Result<Self, FilterError> {
        if particles.count < 2 {
            return Err(FilterError::Config {
                key: "particles",
                value: particles.count as f64,
                expected: "at least 2",
            });
        }
        if particles.marginalise && space.is_linear() {
            let kind = Kind::Marginal(Linear::new(space)?);
            return Ok(Particle { kind });
        }
        let mut cloud = Cloud {
            states: vec![DVector::zeros(0); particles.count],
            log_weights: Vec::new(),
            rng: ChaCha8Rng::seed_from_u64(particles.seed),
        };
        cloud.draw(&space.prior())?;
        Ok(Particle {
            kind: Kind::Sampled(Box::new(cloud)),
        })
    }
}

/// Weights summing to 1.
fn weights(log_weights: &[f64]) -> Vec<f64> {
    let largest = log_weights
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let raw: Vec<f64> = log_weights.iter().map(|l| (l - largest).exp()).collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|w| w / sum).collect()
}

fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

impl Cloud {
    fn noise(&mut self, n: usize) -> DVector<f64> {
        DVector::from_fn(n, |_, _| StandardNormal.sample(&mut self.rng))
    }

    /// Equal samples of a belief.
    fn draw(&mut self, belief: &Gaussian) -> Result<(), FilterError> {
        let (n, root) = (belief.dim(), square_root("covariance", &belief.covariance)?);
        for i in 0..self.states.len() {
            self.states[i] = &belief.mean + &root * self.noise(n);
        }
        self.log_weights = vec![0.0; self.states.len()];
        Ok(())
    }

    /// w (N), summing to 1.
    fn weights(&self) -> Vec<f64> {
        weights(&self.log_weights)
    }

    /// Weighted mean, and weighted covariance of two sets of vectors that share the weights.
    fn moments(&self) -> Gaussian {
        let weights = self.weights();
        let mean = average(&self.states, &weights);
        let mut covariance = between(&self.states, &mean, &self.states, &mean, &weights);
        symmetrise(&mut covariance);
        Gaussian { mean, covariance }
    }

    /// Systematic resampling and a kernel that keeps mean and covariance.
    fn resample(&mut self) -> Result<(), FilterError> {
        let weights = self.weights();
        let count = self.states.len();
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        if effective >= 0.5 * count as f64 {
            return Ok(());
        }
        let told = self.moments();
        let root = square_root("covariance of the particles", &told.covariance)?;
        let n = told.dim() as f64;
        // Silverman's bandwidth for the number of samples that still say something.
        let bandwidth = (4.0 / (n + 2.0) / effective.max(1.0))
            .powf(1.0 / (n + 4.0))
            .min(1.0);
        let keep = (1.0 - bandwidth * bandwidth).sqrt();
        let start = uniform(&mut self.rng) / count as f64;
        let (mut source, mut sum) = (0, weights.first().copied().unwrap_or(1.0));
        let mut next = Vec::with_capacity(count);
        for i in 0..count {
            let at = start + i as f64 / count as f64;
            while sum < at && source + 1 < count {
                source += 1;
                sum += weights[source];
            }
            let shift = (&self.states[source] - &told.mean) * keep;
            let jitter = &root * self.noise(told.dim()) * bandwidth;
            next.push(&told.mean + shift + jitter);
        }
        self.states = next;
        self.log_weights = vec![0.0; count];
        Ok(())
    }

    fn predict(
        &mut self,
        model: &mut Model,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
        let before = self.states.clone();
        let q;
        if model.steps.is_some() {
            let drive = drive(model, u)?;
            let name = model.space.name();
            let Some(steps) = model.steps.as_mut() else {
                return Err(FilterError::NotLinear {
                    filter: "particle",
                    space: name,
                });
            };
            let step = steps.get(dt)?;
            let push = &step.gamma * drive;
            for x in &mut self.states {
                *x = &step.a * &*x + &push;
            }
            q = step.q.clone();
        } else {
            let space = &*model.space;
            let mean = self.moments().mean;
            q = propagate(space, &model.q, &mean, u, dt, model.config.max_step)?.2;
            let count = substeps(dt, model.config.max_step)?;
            let h = dt / count as f64;
            for x in &mut self.states {
                for _ in 0..count {
                    *x = runge_kutta(space, x, u, h)?;
                }
            }
        }
        let root = square_root("process noise", &q)?;
        for i in 0..self.states.len() {
            let push = &root * self.noise(q.nrows());
            self.states[i] += push;
        }
        let weights = self.weights();
        let (old, told) = (average(&before, &weights), self.moments());
        let cross = between(&before, &old, &self.states, &told.mean, &weights);
        Ok((told, cross))
    }

    fn observe(&self, model: &Model, belief: &Gaussian) -> Result<View, FilterError> {
        let seen = self.seen(model)?;
        let weights = self.weights();
        let predicted = average(&seen, &weights);
        let spread = between(&seen, &predicted, &seen, &predicted, &weights);
        let (_, c) = model.space.measure_jacobian(belief.mean.as_slice())?;
        let mut extra = spread - &c * &belief.covariance * c.transpose();
        symmetrise(&mut extra);
        Ok(View {
            predicted,
            c,
            extra: Some(extra),
            root: None,
        })
    }

    fn seen(&self, model: &Model) -> Result<Vec<DVector<f64>>, FilterError> {
        self.states
            .iter()
            .map(|x| {
                model
                    .space
                    .measure_value(x.as_slice())
                    .map(DVector::from_vec)
            })
            .collect()
    }

    /// The largest power of a likelihood, up to `left`, that leaves a third of the samples effective.
    fn bearable(&self, likelihood: &[f64], left: f64) -> f64 {
        let effective = |power: f64| {
            let moved: Vec<f64> = self
                .log_weights
                .iter()
                .zip(likelihood)
                .map(|(w, l)| w + power * l)
                .collect();
            1.0 / weights(&moved).iter().map(|w| w * w).sum::<f64>()
        };
        let enough = likelihood.len() as f64 / 3.0;
        if effective(left) >= enough {
            return left;
        }
        let (mut low, mut high) = (0.0, left);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if effective(middle) >= enough {
                low = middle;
            } else {
                high = middle;
            }
        }
        // Something must be taken in, however few are left by it.
        low.max(1e-6 * left)
    }

    fn weigh(&mut self, at: &Update<'_>) -> Result<Gaussian, usize> {
        let mut seen = self.seen(at.model).map_err(|_| 0usize)?;
        let mut noise = at.model.r.select_rows(at.rows).select_columns(at.rows);
        for (k, more) in at.inflation.iter().enumerate() {
            noise[(k, k)] += more;
        }
        let factor = noise.cholesky().ok_or(0usize)?;
        // A sharp sensor leaves few of the samples of a wide prior: it is taken in by powers of its likelihood, each as
        // large as leaves a third of the samples, with a resampling in between.
        let mut left = 1.0;
        for stage in 0..MOST_STAGES {
            if stage > 0 {
                self.resample().map_err(|_| 0usize)?;
                seen = self.seen(at.model).map_err(|_| 0usize)?;
            }
            let mut likelihood = Vec::with_capacity(seen.len());
            for z in &seen {
                let residual = at.values - z.select_rows(at.rows);
                let white = factor
                    .l_dirty()
                    .solve_lower_triangular(&residual)
                    .ok_or(0usize)?;
                likelihood.push(-0.5 * white.norm_squared());
            }
            let last = stage + 1 == MOST_STAGES;
            let share = if last {
                left
            } else {
                self.bearable(&likelihood, left)
            };
            for (lw, l) in self.log_weights.iter_mut().zip(&likelihood) {
                *lw += share * l;
            }
            if !self.log_weights.iter().all(|l| l.is_finite()) {
                return Err(0);
            }
            left -= share;
            if left <= 0.0 {
                break;
            }
        }
        let told = self.moments();
        self.resample().map_err(|_| 0usize)?;
        Ok(told)
    }
}

fn average(x: &[DVector<f64>], weights: &[f64]) -> DVector<f64> {
    let n = x.first().map_or(0, DVector::len);
    let mut mean = DVector::zeros(n);
    for (x, w) in x.iter().zip(weights) {
        mean.axpy(*w, x, 1.0);
    }
    mean
}

/// Σ w (x - x̄)(y - ȳ)ᵀ.
fn between(
    x: &[DVector<f64>],
    x_mean: &DVector<f64>,
    y: &[DVector<f64>],
    y_mean: &DVector<f64>,
    weights: &[f64],
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(x_mean.len(), y_mean.len());
    for ((x, y), w) in x.iter().zip(y).zip(weights) {
        out.ger(*w, &(x - x_mean), &(y - y_mean), 1.0);
    }
    out
}

impl Method for Particle {
    fn name(&self) -> &'static str {
        "particle"
    }

    fn begin(&mut self, belief: &Gaussian) -> Result<(), FilterError> {
        match &mut self.kind {
            Kind::Marginal(_) => Ok(()),
            Kind::Sampled(cloud) => cloud.draw(belief),
        }
    }

    fn predict(
        &mut self,
        model: &mut Model,
        belief: &Gaussian,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
        match &mut self.kind {
            Kind::Marginal(_) => predict_linear(model, belief, u, dt),
            Kind::Sampled(cloud) => cloud.predict(model, u, dt),
        }
    }

    fn observe(&self, model: &Model, belief: &Gaussian) -> Result<View, FilterError> {
        match &self.kind {
            Kind::Marginal(linear) => linear.observe(model, belief),
            Kind::Sampled(cloud) => cloud.observe(model, belief),
        }
    }

    fn commit(&mut self, at: &Update<'_>) -> Option<Result<Gaussian, usize>> {
        match &mut self.kind {
            Kind::Marginal(_) => None,
            Kind::Sampled(cloud) => Some(cloud.weigh(at)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also from the middle of a block of the generator.
    #[test]
    fn a_clone_draws_what_the_original_draws() {
        let mut cloud = Cloud {
            states: vec![],
            log_weights: vec![],
            rng: ChaCha8Rng::seed_from_u64(3),
        };
        cloud.rng.set_stream(5);
        for drawn in [0, 1, 7, 30] {
            for _ in 0..drawn {
                cloud.rng.next_u32();
            }
            let mut copy = cloud.clone();
            let next =
                |rng: &mut ChaCha8Rng| -> Vec<u64> { (0..9).map(|_| rng.next_u64()).collect() };
            assert_eq!(next(&mut copy.rng), next(&mut cloud.rng), "after {drawn}");
        }
    }
}
