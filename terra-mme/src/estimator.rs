//! What every estimator of terra-mme offers, whatever it does inside.

use terra_model::Contact;
use terra_model::order::descending;

use crate::belief::ParameterBelief;
use crate::choice::Choice;
use crate::consistency::Consistency;
use crate::error::EstimatorError;
use crate::hypothesis::{Hypothesis, HypothesisSet};
use crate::observation::ForceObservation;
use crate::prediction::{ForcePrediction, contact_grid, mixture};

/// One row of a posterior.
#[derive(Clone, Debug, PartialEq)]
pub struct HypothesisPosterior {
    /// Id of the hypothesis.
    pub id: String,
    /// Name of its law.
    pub model: String,
    /// Posterior probability.
    pub probability: f64,
    /// Sum of its log-likelihoods over the samples used, penalties included, whatever the choice.
    pub log_likelihood: f64,
    /// Samples it could not predict.
    pub infeasible_samples: usize,
}

/// The posterior after each sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// 1 is the first sample weighed.
    pub step: Vec<usize>,
    /// t \[s\] of each step.
    pub time: Vec<f64>,
    /// Columns of `probability`.
    pub ids: Vec<String>,
    /// One row a step, summing to 1.
    pub probability: Vec<Vec<f64>>,
}

/// A hypothesis that cannot carry the wheel gets this log-likelihood: finite, so that it can return.
pub const INFEASIBLE_LOG_LIKELIHOOD: f64 = -1e4;

/// Hypotheses within this many nats per sample of the winner count as not told apart.
pub const KNOWN_TO_NATS: f64 = 0.5;

/// Weighs hypotheses by observations: forces that a filter has estimated, or
/// [`MotionSample`](crate::MotionSample)s straight from the log.
pub trait ParameterEstimator<O = ForceObservation>: Weighed {
    /// Weighs one observation. Nothing is changed when it fails.
    ///
    /// # Errors
    /// A typed [`EstimatorError`].
    fn update(&mut self, observation: &O) -> Result<(), EstimatorError>;

    /// Says that the log has ended: estimators that need all of it compute their answer here, the others have it.
    ///
    /// # Errors
    /// A typed [`EstimatorError`]; the answer from the samples so far stays.
    fn finish(&mut self) -> Result<(), EstimatorError> {
        Ok(())
    }
}

/// Hypotheses with a posterior: all that may be asked of an estimator.
pub trait Weighed: Send + Sync {
    /// Name in the registry.
    fn name(&self) -> &'static str;
    /// The hypotheses.
    fn hypotheses(&self) -> &HypothesisSet;
    /// What happens to old evidence.
    fn choice(&self) -> &Choice;
    /// Observations weighed.
    fn samples(&self) -> usize;
    /// Posterior probability of each hypothesis (N), in the order of the set.
    fn probabilities(&self) -> Vec<f64>;
    /// Accumulated log-likelihood of each hypothesis (N).
    fn log_likelihoods(&self) -> Vec<f64>;
    /// Samples each hypothesis could not predict (N).
    fn infeasible_samples(&self) -> Vec<usize>;
    /// Whether the winner explains the last samples.
    fn consistency(&self) -> Consistency;
    /// The posterior after each sample, when asked for at construction.
    fn history(&self) -> Option<&History>;

    /// Parameters under the posterior.
    fn belief(&self) -> ParameterBelief {
        ParameterBelief::of(self.hypotheses(), &self.probabilities())
    }

    /// Index of the most probable hypothesis; the first of equals, log-likelihood deciding between probabilities
    /// that round to the same number.
    fn map_index(&self) -> usize {
        let (p, l) = (self.probabilities(), self.log_likelihoods());
        let better = |a: usize, b: usize| p[a].total_cmp(&p[b]).then(l[a].total_cmp(&l[b])).is_gt();
        (1..p.len()).fold(0, |best, j| if better(j, best) { j } else { best })
    }

    /// The most probable hypothesis.
    fn map(&self) -> &Hypothesis {
        &self.hypotheses().hypotheses()[self.map_index()]
    }

    /// Every hypothesis, most probable first; equals by log-likelihood, then in the order of the set.
    fn posterior(&self) -> Vec<HypothesisPosterior> {
        let (p, l, n) = (
            self.probabilities(),
            self.log_likelihoods(),
            self.infeasible_samples(),
        );
        let hypotheses = self.hypotheses().hypotheses();
        let mut order: Vec<usize> = (0..hypotheses.len()).collect();
        descending(&mut order, |&j| l[j]);
        descending(&mut order, |&j| p[j]);
        let row = |j: usize| HypothesisPosterior {
            id: hypotheses[j].id.clone(),
            model: terra_model::ForceLaw::name(&*hypotheses[j].law),
            probability: p[j],
            log_likelihood: l[j],
            infeasible_samples: n[j],
        };
        order.into_iter().map(row).collect()
    }

    /// Ids of the other hypotheses within [`KNOWN_TO_NATS`] per sample of the most probable one, nearest first.
    fn known_to(&self) -> Vec<String> {
        let (l, best) = (self.log_likelihoods(), self.map_index());
        let limit = KNOWN_TO_NATS * self.samples() as f64;
        let mut near: Vec<usize> = (0..l.len())
            .filter(|&j| j != best && (l[best] - l[j]).abs() < limit)
            .collect();
        descending(&mut near, |&j| l[j]);
        near.into_iter()
            .map(|j| self.hypotheses().hypotheses()[j].id.clone())
            .collect()
    }

    /// The mixture of forces at every slip and load (loads outermost) on a contact like the template.
    ///
    /// # Errors
    /// [`EstimatorError::Model`] for a contact that no law accepts.
    fn force_prediction(
        &self,
        slips: &[f64],
        loads: &[f64],
        template: &Contact<f64>,
    ) -> Result<Vec<ForcePrediction>, EstimatorError> {
        let weights = self.probabilities();
        contact_grid(slips, loads, template)
            .iter()
            .map(|at| mixture(self.hypotheses(), &weights, at))
            .collect()
    }
}
