//! The probabilities of a set of hypotheses from sample to sample: a choice on old evidence, then a Bayes step.

use nalgebra::DMatrix;

use crate::choice::Choice;
use crate::error::EstimatorError;
use crate::log_prob::{LogProb, log_sum_exp};
use crate::update::bayes_step;

/// The probabilities of N hypotheses and their logarithms. The logarithms are the truth: a probability may round to 0,
/// its logarithm does not.
#[derive(Clone, Debug)]
pub struct Posterior {
    log_weights: Vec<f64>,
    weights: Vec<f64>,
    /// Where the next prior is formed, so that a step that fails leaves the last one alone.
    next: Vec<f64>,
    steps: usize,
}

impl Posterior {
    /// N equally likely hypotheses.
    ///
    /// # Errors
    /// [`EstimatorError::EmptySet`].
    pub fn uniform(n: usize) -> Result<Self, EstimatorError> {
        Self::with_prior(&vec![1.0; n])
    }

    /// Given prior weights (N), normalised here.
    ///
    /// # Errors
    /// [`EstimatorError::EmptySet`]; [`EstimatorError::Value`] for a negative or non-finite weight;
    /// [`EstimatorError::Impossible`] when all are zero.
    pub fn with_prior(prior: &[f64]) -> Result<Self, EstimatorError> {
        if prior.is_empty() {
            return Err(EstimatorError::EmptySet);
        }
        if let Some(&value) = prior.iter().find(|p| !p.is_finite() || **p < 0.0) {
            let expected = "a finite weight of at least 0";
            return Err(EstimatorError::Value {
                what: "prior weight".to_owned(),
                value,
                expected,
            });
        }
        let mut log_weights: Vec<f64> = prior.iter().map(|p| p.ln()).collect();
        let mut weights = vec![0.0; prior.len()];
        bayes_step(&mut log_weights, &vec![0.0; prior.len()], &mut weights)?;
        let next = log_weights.clone();
        Ok(Posterior {
            log_weights,
            weights,
            next,
            steps: 0,
        })
    }

    /// Applies the choice (not before the first step, which already starts from the prior), then one Bayes step.
    /// Returns ln of the predictive density of the sample. Nothing is changed when it fails.
    ///
    /// # Errors
    /// As [`bayes_step`].
    pub fn step(
        &mut self,
        choice: &Choice,
        log_likelihood: &[f64],
    ) -> Result<LogProb, EstimatorError> {
        let evidence = if self.steps == 0 || *choice == Choice::None {
            bayes_step(&mut self.log_weights, log_likelihood, &mut self.weights)?
        } else {
            self.predict(choice)?;
            let evidence = bayes_step(&mut self.next, log_likelihood, &mut self.weights)?;
            std::mem::swap(&mut self.log_weights, &mut self.next);
            evidence
        };
        self.steps += 1;
        Ok(evidence)
    }

    /// One Bayes step with the log-likelihoods of `steps` samples at once; ln of their predictive density.
    pub(crate) fn replace(
        &mut self,
        log_likelihood: &[f64],
        steps: usize,
    ) -> Result<LogProb, EstimatorError> {
        let evidence = bayes_step(&mut self.log_weights, log_likelihood, &mut self.weights)?;
        self.steps += steps;
        Ok(evidence)
    }

    /// Forms the prior of the next sample.
    fn predict(&mut self, choice: &Choice) -> Result<(), EstimatorError> {
        match choice {
            Choice::None => self.next.copy_from_slice(&self.log_weights),
            Choice::Floor(f) => {
                let floor = f / self.weights.len() as f64;
                for (next, w) in self.next.iter_mut().zip(&self.weights) {
                    *next = ((1.0 - f) * w + floor).ln();
                }
            }
            Choice::Forgetting(lambda) => {
                for (next, lw) in self.next.iter_mut().zip(&self.log_weights) {
                    *next = lw * lambda;
                }
                let norm = log_sum_exp(&self.next);
                for next in &mut self.next {
                    *next -= norm;
                }
            }
            Choice::Transition(m) => self.next = transition(m, &self.log_weights)?,
        }
        Ok(())
    }

    /// p (N), summing to 1.
    pub fn probabilities(&self) -> &[f64] {
        &self.weights
    }

    /// ln p (N).
    pub fn log_probabilities(&self) -> &[f64] {
        &self.log_weights
    }

    /// Number of samples weighed.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Index of the most probable hypothesis; the first of equals.
    pub fn map(&self) -> usize {
        let mut best = 0;
        for (j, lw) in self.log_weights.iter().enumerate() {
            if *lw > self.log_weights[best] {
                best = j;
            }
        }
        best
    }
}

/// ln(Mᵀ p) in the log domain, O(N²).
fn transition(m: &DMatrix<f64>, log_weights: &[f64]) -> Result<Vec<f64>, EstimatorError> {
    let n = log_weights.len();
    if m.shape() != (n, n) {
        return Err(EstimatorError::Size {
            what: "transition matrix",
            found: m.nrows(),
            expected: n,
        });
    }
    let mut terms = vec![0.0; n];
    Ok((0..n)
        .map(|j| {
            for (i, term) in terms.iter_mut().enumerate() {
                *term = log_weights[i] + m[(i, j)].ln();
            }
            log_sum_exp(&terms)
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::update::weighted_means;

    #[test]
    fn matches_the_definition_for_sizes_around_the_lane_width() {
        for n in [1, 2, 7, 8, 9, 21, 64, 65] {
            let ll: Vec<f64> = (0..n).map(|j| -0.3 * j as f64 + (j as f64).sin()).collect();
            let mut post = Posterior::uniform(n).unwrap();
            let z = post.step(&Choice::None, &ll).unwrap();
            let direct: Vec<f64> = ll.iter().map(|l| l.exp() / n as f64).collect();
            let total: f64 = direct.iter().sum();
            assert!((z.ln() - total.ln()).abs() < 1e-13);
            for (a, b) in post.probabilities().iter().zip(&direct) {
                assert!((a - b / total).abs() < 1e-15);
            }
            let values: Vec<f64> = (0..n).map(|j| j as f64).collect();
            let mut mean = [0.0];
            weighted_means(post.probabilities(), &[&values], &mut mean).unwrap();
            let expected: f64 = direct.iter().zip(&values).map(|(d, v)| d / total * v).sum();
            assert!((mean[0] - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn an_impossible_hypothesis_is_zero_and_all_impossible_is_an_error_that_changes_nothing() {
        let mut post = Posterior::uniform(3).unwrap();
        post.step(&Choice::None, &[0.0, f64::NEG_INFINITY, -1e4])
            .unwrap();
        assert_eq!(&post.probabilities()[..3], &[1.0, 0.0, 0.0]);
        assert!((post.log_probabilities()[2] + 1e4).abs() < 1e-9);
        for (choice, ll) in [
            (Choice::None, [f64::NEG_INFINITY; 3]),
            (Choice::Floor(0.1), [f64::NEG_INFINITY; 3]),
            (Choice::Floor(0.1), [0.0, f64::NAN, 0.0]),
            (Choice::Forgetting(0.5), [0.0, f64::INFINITY, 0.0]),
        ] {
            let before = post.clone();
            assert!(post.step(&choice, &ll).is_err());
            assert_eq!(post.probabilities(), before.probabilities());
            assert_eq!(post.log_probabilities(), before.log_probabilities());
            assert_eq!(post.steps(), before.steps());
        }
    }

    #[test]
    fn a_floor_is_a_transition_with_equal_spread_and_identity_is_none() {
        let lls = [[0.0, -3.0, 1.0], [-20.0, 0.0, -1.0], [0.5, 0.0, -60.0]];
        let f = 0.05;
        let spread = DMatrix::from_fn(3, 3, |i, j| f / 3.0 + if i == j { 1.0 - f } else { 0.0 });
        let pairs = [
            (Choice::Floor(f), Choice::transition(spread).unwrap()),
            (
                Choice::None,
                Choice::transition(DMatrix::identity(3, 3)).unwrap(),
            ),
            (Choice::None, Choice::Forgetting(1.0)),
        ];
        for (a, b) in pairs {
            let (mut p, mut q) = (
                Posterior::uniform(3).unwrap(),
                Posterior::uniform(3).unwrap(),
            );
            for ll in &lls {
                let (za, zb) = (p.step(&a, ll).unwrap(), q.step(&b, ll).unwrap());
                assert!((za.ln() - zb.ln()).abs() < 1e-12);
                for (x, y) in p.probabilities().iter().zip(q.probabilities()) {
                    assert!((x - y).abs() < 1e-14);
                }
            }
        }
    }
}
