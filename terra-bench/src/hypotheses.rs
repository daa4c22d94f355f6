//! N hypotheses under the Bayes step, with the closed form of what many equal steps give.
//!
//! # Equation
//! k steps with the same log-likelihoods l from equal prior: p_j = e^(k l_j) / Σ e^(k l_i).

use terra_mme::{LogProb, bayes_step};

use crate::error::{BenchError, check};

/// Largest log-likelihood: so small that the set stays open over any number of repetitions, and no weight becomes
/// subnormal, which some processors are slow at.
const LARGEST: f64 = 1e-8;

/// Bytes of the arrays that one step touches, for each hypothesis: log-weight, weight, log-likelihood.
pub const BYTES_PER_HYPOTHESIS: usize = 3 * size_of::<f64>();

/// The arrays of N hypotheses.
#[derive(Clone, Debug)]
pub struct Hypotheses {
    log_weights: Vec<f64>,
    weights: Vec<f64>,
    log_likelihood: Vec<f64>,
    steps: usize,
}

/// Spread evenly over (-LARGEST, LARGEST), in an order without pattern.
fn log_likelihood(j: usize) -> f64 {
    let golden = (j as f64 * 0.618_033_988_749_894_9).fract();
    LARGEST * (2.0 * golden - 1.0)
}

impl Hypotheses {
    /// N equally likely ones.
    pub fn new(n: usize) -> Self {
        Hypotheses {
            log_weights: vec![-(n as f64).ln(); n],
            weights: vec![1.0 / n as f64; n],
            log_likelihood: (0..n).map(log_likelihood).collect(),
            steps: 0,
        }
    }

    /// N.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// True without hypotheses.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// One Bayes step.
    ///
    /// # Errors
    /// [`BenchError::Estimator`].
    pub fn step(&mut self) -> Result<LogProb, BenchError> {
        self.steps += 1;
        Ok(bayes_step(
            &mut self.log_weights,
            &self.log_likelihood,
            &mut self.weights,
        )?)
    }

    /// Compares all weights with the closed form after the steps made so far.
    ///
    /// # Errors
    /// [`BenchError::Wrong`].
    pub fn check(&self) -> Result<(), BenchError> {
        let k = self.steps as f64;
        // Of order k LARGEST, so no maximum has to be taken out.
        let total: f64 = self.log_likelihood.iter().map(|l| (k * l).exp()).sum();
        // A step rounds a logarithm of size ln N a few times; the sum of N terms here rounds as well.
        let n = self.len() as f64;
        let allowed = 4.0 * f64::EPSILON * (1.0 + n.ln()) * (k + n.sqrt());
        for (j, l) in self.log_likelihood.iter().enumerate() {
            let (ln, p) = (k * l - total.ln(), (k * l).exp() / total);
            let what = |name: &str| format!("{name} of hypothesis {j} of {n} after {k} steps");
            check(&what("log-weight"), self.log_weights[j], ln, 1.0, allowed)?;
            check(&what("weight"), self.weights[j], p, p, allowed)?;
        }
        Ok(())
    }
}

/// Compares one step from a lopsided prior, with log-likelihoods hundreds of nats apart, with Bayes' rule in the linear
/// domain, where every number still has its digits.
///
/// # Errors
/// [`BenchError::Wrong`], [`BenchError::Estimator`].
pub fn check_one_step(n: usize) -> Result<(), BenchError> {
    let prior: Vec<f64> = (0..n).map(|j| 1.0 + (j % 7) as f64).collect();
    let ll: Vec<f64> = (0..n).map(|j| -(((j * 31) % 400) as f64)).collect();
    let mut log_weights: Vec<f64> = prior.iter().map(|p| p.ln()).collect();
    let mut weights = vec![0.0; n];
    let evidence = bayes_step(&mut log_weights, &ll, &mut weights)?;
    let joint: Vec<f64> = prior.iter().zip(&ll).map(|(p, l)| p * l.exp()).collect();
    let total: f64 = joint.iter().sum();
    let allowed = 1e-13 + f64::EPSILON * (n as f64).sqrt();
    check("evidence", evidence.ln(), total.ln(), 1.0, allowed * 10.0)?;
    for (j, joint) in joint.iter().enumerate() {
        let p = joint / total;
        let what = format!("weight of hypothesis {j} of {n}");
        check(&what, weights[j], p, p, allowed * 10.0)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_agree_with_the_closed_form() {
        for n in [1, 10, 21, 1000] {
            check_one_step(n).unwrap();
            let mut set = Hypotheses::new(n);
            for _ in 0..100 {
                set.step().unwrap();
            }
            set.check().unwrap();
        }
    }

    #[test]
    fn a_step_left_out_is_noticed() {
        let mut set = Hypotheses::new(21);
        for _ in 0..100 {
            set.step().unwrap();
        }
        set.steps += 1;
        assert!(set.check().is_err());
    }
}
