//! A hypothesis set that grows around its winner and sheds its dead, without bending the evidence.
//!
//! A hypothesis stands for a cell of soils and holds the cell's prior. To refine it is to cut the cell: its prior is
//! divided evenly between it and its copies, and the copies are weighed by every sample since the first. The posterior
//! is therefore that of a set which had held them all along under that prior: nothing is counted twice, and the priors
//! of the set, with those of the dropped, always sum to 1.
//!
//! # Equation
//! At refinement g: copies p' = p e^(sd 2^-g z) of the winner w, π_w <- π_w/(k+1) for it and each of its k copies;
//! p_j ∝ π_j Π_n p(y_n | j). Dropped: p_j < e^-d max p; the share so lost is kept as a bound.
//!
//! # Reference
//! X. R. Li, Y. Bar-Shalom, IEEE Trans. Automatic Control 41(4):478-493, 1996 (variable-structure multiple models).

use crate::choice::Choice;
use crate::consistency::Consistency;
use crate::error::EstimatorError;
use crate::estimator::{History, ParameterEstimator, Weighed};
use crate::hypothesis::{Hypothesis, HypothesisSet};
use crate::log_prob::log_sum_exp;
use crate::multiple_model::MultipleModel;
use crate::observation::ForceObservation;

/// How a set adapts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptation {
    /// Samples before the first refinement; each later one waits twice as long.
    pub first: usize,
    /// Copies of the winner at each.
    pub copies: usize,
    /// sd of ln(parameter) of the first copies; halved at each refinement.
    pub sd: f64,
    /// Nats behind the winner at which a hypothesis is dropped.
    pub drop: f64,
    /// Refinements at most.
    pub generations: usize,
    /// Seed of the copies.
    pub seed: u64,
}

impl Default for Adaptation {
    fn default() -> Self {
        Adaptation {
            first: 25,
            copies: 12,
            sd: 0.1,
            drop: 40.0,
            generations: 4,
            seed: 1,
        }
    }
}

/// Multiple models with a set that adapts. The samples are kept, so memory grows with the log.
#[derive(Clone, Debug)]
pub struct AdaptiveModel {
    models: MultipleModel,
    how: Adaptation,
    /// Prior of each hypothesis.
    prior: Vec<f64>,
    generation: usize,
    observations: Vec<ForceObservation>,
    dropped_prior: f64,
    dropped_probability: f64,
    history: Option<History>,
}

impl AdaptiveModel {
    /// An adaptive set that begins as `models`, with an equal prior. Old evidence must stay: choice `none`.
    ///
    /// # Errors
    /// [`EstimatorError::NotSupported`]; [`EstimatorError::Value`] for an adaptation that never or always acts.
    pub fn new(models: MultipleModel, how: Adaptation) -> Result<Self, EstimatorError> {
        if *models.choice() != Choice::None {
            return Err(EstimatorError::NotSupported {
                estimator: "adaptive",
                choice: models.choice().to_string(),
                reason: "copies are weighed by every sample since the first: only none",
            });
        }
        for (what, value) in [
            ("samples before a refinement", how.first as f64),
            ("copies", how.copies as f64),
            ("spread of the copies", how.sd),
            ("nats at which a hypothesis is dropped", how.drop),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(EstimatorError::Value {
                    what: what.to_owned(),
                    value,
                    expected: "a finite value above 0",
                });
            }
        }
        let n = models.hypotheses().len();
        Ok(AdaptiveModel {
            models,
            how,
            prior: vec![1.0 / n as f64; n],
            generation: 0,
            observations: Vec::new(),
            dropped_prior: 0.0,
            dropped_probability: 0.0,
            history: None,
        })
    }

    /// Keeps the posterior after each sample; a hypothesis has 0 before it joins and after it is dropped.
    #[must_use]
    pub fn with_history(mut self) -> Self {
        self.history = Some(History {
            ids: self.models.hypotheses().ids(),
            ..History::default()
        });
        self
    }

    /// Prior of each hypothesis (N); with [`dropped_prior`](Self::dropped_prior) they sum to 1.
    pub fn prior(&self) -> &[f64] {
        &self.prior
    }

    /// Prior of the hypotheses that were dropped.
    pub fn dropped_prior(&self) -> f64 {
        self.dropped_prior
    }

    /// Sum of what the dropped ones had left when they went: the error it makes in any probability, if they had kept it.
    pub fn dropped_probability(&self) -> f64 {
        self.dropped_probability
    }

    /// ln p(all observations) under the set and its prior.
    pub fn log_evidence(&self) -> f64 {
        self.models.log_evidence()
    }

    /// Refinements so far.
    pub fn generation(&self) -> usize {
        self.generation
    }

    fn adapt(&mut self) -> Result<(), EstimatorError> {
        let log_p = self.models.log_probabilities();
        let best = self.models.map_index();
        let limit = log_p[best] - self.how.drop;
        let (kept, gone): (Vec<usize>, Vec<usize>) =
            (0..log_p.len()).partition(|&j| j == best || log_p[j] >= limit);
        let lost: Vec<f64> = gone.iter().map(|&j| log_p[j]).collect();
        let lost = log_sum_exp(&lost).exp();
        let winner = self.models.hypotheses().hypotheses()[best].clone();
        let spread = self.how.sd / 2.0_f64.powi(self.generation as i32);
        let seed = self.how.seed.wrapping_add(self.generation as u64);
        let generation = self.generation + 1;
        let copies = HypothesisSet::new(vec![winner.clone()])?
            .perturbed(self.how.copies, spread, seed)?
            .hypotheses()
            .iter()
            .enumerate()
            .map(|(k, h)| Hypothesis {
                id: format!("{}~{generation}.{}", winner.id, k + 1),
                ..h.clone()
            })
            .collect();
        let mut joining = self.models.over(HypothesisSet::new(copies)?)?;
        for o in &self.observations {
            joining.replay(o)?;
        }
        let share = self.prior[best] / (self.how.copies + 1) as f64;
        let mut prior: Vec<f64> = kept
            .iter()
            .map(|&j| if j == best { share } else { self.prior[j] })
            .collect();
        prior.resize(kept.len() + self.how.copies, share);
        let gone_prior: f64 = gone.iter().map(|&j| self.prior[j]).sum();
        if let Some(history) = &mut self.history {
            history.ids.extend(joining.hypotheses().ids());
            let columns = history.ids.len();
            for row in &mut history.probability {
                row.resize(columns, 0.0);
            }
        }
        self.models = self.models.joined(&kept, joining, &prior)?;
        self.prior = prior;
        self.dropped_prior += gone_prior;
        self.dropped_probability += lost;
        self.generation = generation;
        Ok(())
    }
}

impl ParameterEstimator for AdaptiveModel {
    fn update(&mut self, obs: &ForceObservation) -> Result<(), EstimatorError> {
        self.models.update(obs)?;
        self.observations.push(obs.clone());
        let due = self.how.first << self.generation;
        if self.generation < self.how.generations && self.observations.len() >= due {
            self.adapt()?;
        }
        if let Some(history) = &mut self.history {
            let ids = self.models.hypotheses().hypotheses();
            let p = self.models.probabilities();
            let mut row = vec![0.0; history.ids.len()];
            for (h, p) in ids.iter().zip(p) {
                let column = history.ids.iter().position(|id| *id == h.id);
                if let Some(cell) = column.and_then(|c| row.get_mut(c)) {
                    *cell = p;
                }
            }
            history.step.push(self.observations.len());
            history.time.push(obs.time);
            history.probability.push(row);
        }
        Ok(())
    }
}

impl Weighed for AdaptiveModel {
    fn name(&self) -> &'static str {
        "adaptive"
    }

    fn hypotheses(&self) -> &HypothesisSet {
        self.models.hypotheses()
    }

    fn choice(&self) -> &Choice {
        self.models.choice()
    }

    fn samples(&self) -> usize {
        self.observations.len()
    }

    fn probabilities(&self) -> Vec<f64> {
        self.models.probabilities()
    }

    fn log_likelihoods(&self) -> Vec<f64> {
        self.models.log_likelihoods()
    }

    fn infeasible_samples(&self) -> Vec<usize> {
        self.models.infeasible_samples()
    }

    fn map_index(&self) -> usize {
        self.models.map_index()
    }

    fn consistency(&self) -> Consistency {
        self.models.consistency()
    }

    fn history(&self) -> Option<&History> {
        self.history.as_ref()
    }
}
