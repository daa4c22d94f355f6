//! A batch estimator as a [`ParameterEstimator`]: multiple models while the log comes in, its own answer at the end.

use terra_model::Contact;
use terra_model::order::descending;

use super::ensemble::{EnsembleOptions, ensemble};
use super::least_squares::{LeastSquaresOptions, distinct, least_squares};
use crate::choice::Choice;
use crate::consistency::Consistency;
use crate::error::EstimatorError;
use crate::estimator::{History, ParameterEstimator, Weighed};
use crate::fit_space::FitSpace;
use crate::hypothesis::{Hypothesis, HypothesisSet};
use crate::multiple_model::MultipleModel;
use crate::observation::ForceObservation;
use crate::posterior::Posterior;
use crate::prior::{Centre, Priors};

/// Minima whose forces lie within this many nats of each other are one.
const SAME_MINIMUM: f64 = 0.05;
/// Draws of an ensemble that become hypotheses; the rest are thinned out evenly.
const MOST_DRAWS: usize = 480;

/// What is done once the log has ended.
#[derive(Clone, Debug)]
pub enum BatchMethod {
    /// A bounded fit from each of the best hypotheses. The answer is the distinct minima, each weighed by its likelihood.
    LeastSquares(LeastSquaresOptions),
    /// Draws from the posterior around the winner, each a hypothesis of equal weight.
    Ensemble(EnsembleOptions),
}

#[derive(Clone, Debug)]
struct Answer {
    set: HypothesisSet,
    probabilities: Vec<f64>,
    log_likelihoods: Vec<f64>,
    consistency: Consistency,
}

/// A set weighed sample by sample that is replaced by a fit or by draws when [`finish`](ParameterEstimator::finish) is
/// called. The samples are kept, so memory grows with the log.
#[derive(Clone, Debug)]
pub struct Batch {
    method: BatchMethod,
    priors: Priors,
    models: MultipleModel,
    observations: Vec<ForceObservation>,
    answer: Option<Answer>,
}

impl Batch {
    /// `models` weigh while the log comes in and name the starts; priors scale the steps of a fit and are the prior of
    /// an ensemble. A fit knows one soil for the whole log, so the choice on old evidence must be `none`.
    ///
    /// # Errors
    /// [`EstimatorError::NotSupported`].
    pub fn new(
        models: MultipleModel,
        priors: Priors,
        method: BatchMethod,
    ) -> Result<Self, EstimatorError> {
        if *models.choice() != Choice::None {
            return Err(EstimatorError::NotSupported {
                estimator: name(&method),
                choice: models.choice().to_string(),
                reason: "a fit takes one soil for the whole log: only none",
            });
        }
        Ok(Batch {
            method,
            priors,
            models,
            observations: Vec::new(),
            answer: None,
        })
    }

    fn space(&self, h: &Hypothesis) -> Result<FitSpace, EstimatorError> {
        let mut widths: Vec<f64> = self
            .observations
            .iter()
            .flat_map(|o| o.contacts.iter().map(|c: &Contact<f64>| c.width))
            .collect();
        widths.dedup();
        FitSpace::new(
            &h.law,
            Centre::Parameters(&h.parameters),
            &widths,
            &self.priors,
        )
    }

    fn fits(&self, options: &LeastSquaresOptions) -> Result<Answer, EstimatorError> {
        let log_likelihoods = self.models.log_likelihoods();
        let mut order: Vec<usize> = (0..log_likelihoods.len()).collect();
        descending(&mut order, |&j| log_likelihoods[j]);
        let (mut fits, mut refusal) = (Vec::new(), None);
        for &j in order.iter().take(options.starts.max(1)) {
            let h = &self.models.hypotheses().hypotheses()[j];
            let fit = self
                .space(h)
                .and_then(|space| least_squares(&h.law, &space, &self.observations, options));
            match fit {
                Ok(fit) => fits.push((j.to_string(), fit)),
                Err(e) => refusal = Some(e),
            }
        }
        if fits.is_empty() {
            return Err(refusal.unwrap_or(EstimatorError::NoObservations));
        }
        let mut hypotheses = Vec::new();
        let mut log_likelihoods = Vec::new();
        for (j, fit) in distinct(fits, SAME_MINIMUM) {
            let start = j
                .parse::<usize>()
                .ok()
                .and_then(|j| self.models.hypotheses().hypotheses().get(j));
            let Some(start) = start else { continue };
            hypotheses.push(Hypothesis {
                id: format!("{}:fit", start.id),
                law: start.law.clone(),
                parameters: fit.parameters,
            });
            log_likelihoods.push(fit.log_likelihood);
        }
        let mut posterior = Posterior::uniform(hypotheses.len())?;
        posterior.step(&Choice::None, &log_likelihoods)?;
        let probabilities = posterior.probabilities().to_vec();
        self.answer(
            HypothesisSet::new(hypotheses)?,
            probabilities,
            log_likelihoods,
        )
    }

    fn draws(&self, options: &EnsembleOptions) -> Result<Answer, EstimatorError> {
        let winner = self.models.map();
        let space = self.space(winner)?;
        let walkers = options.walkers.max(2 * space.dim() + 2).next_multiple_of(2);
        let options = EnsembleOptions {
            walkers,
            ..*options
        };
        let drawn = ensemble(&winner.law, &space, &self.observations, &options)?;
        let keep = drawn.draws.len().div_ceil(MOST_DRAWS).max(1);
        // Whole steps: walkers of one step are further apart than steps of one walker.
        let steps: Vec<usize> = (0..drawn.draws.len())
            .filter(|k| (k / walkers).is_multiple_of(keep))
            .collect();
        let vectors = steps
            .iter()
            .map(|&k| space.parameters(drawn.draws[k].as_slice()));
        let prefix = format!("{}:draw", winner.id);
        let set = HypothesisSet::from_vectors(&winner.law, &prefix, vectors)?;
        let n = set.len();
        let likelihoods = steps.iter().map(|&k| drawn.log_likelihood[k]).collect();
        self.answer(set, vec![1.0 / n as f64; n], likelihoods)
    }

    /// The windows of the best of the answers, run over the log once more.
    fn answer(
        &self,
        set: HypothesisSet,
        probabilities: Vec<f64>,
        log_likelihoods: Vec<f64>,
    ) -> Result<Answer, EstimatorError> {
        let best = (0..log_likelihoods.len())
            .reduce(|a, b| {
                if log_likelihoods[b] > log_likelihoods[a] {
                    b
                } else {
                    a
                }
            })
            .and_then(|j| set.hypotheses().get(j))
            .ok_or(EstimatorError::EmptySet)?;
        let mut again = self.models.over(HypothesisSet::new(vec![best.clone()])?)?;
        for o in &self.observations {
            match again.update(o) {
                Ok(()) | Err(EstimatorError::AllInfeasible { .. }) => {}
                Err(e) => return Err(e),
            }
        }
        Ok(Answer {
            consistency: again.consistency(),
            set,
            probabilities,
            log_likelihoods,
        })
    }
}

fn name(method: &BatchMethod) -> &'static str {
    match method {
        BatchMethod::LeastSquares(_) => "least-squares",
        BatchMethod::Ensemble(_) => "ensemble",
    }
}

impl ParameterEstimator for Batch {
    fn update(&mut self, obs: &ForceObservation) -> Result<(), EstimatorError> {
        self.models.update(obs)?;
        self.observations.push(obs.clone());
        self.answer = None;
        Ok(())
    }

    fn finish(&mut self) -> Result<(), EstimatorError> {
        self.answer = Some(match &self.method {
            BatchMethod::LeastSquares(options) => self.fits(options)?,
            BatchMethod::Ensemble(options) => self.draws(options)?,
        });
        Ok(())
    }
}

impl Weighed for Batch {
    fn name(&self) -> &'static str {
        name(&self.method)
    }

    fn hypotheses(&self) -> &HypothesisSet {
        self.answer
            .as_ref()
            .map_or_else(|| self.models.hypotheses(), |a| &a.set)
    }

    fn choice(&self) -> &Choice {
        self.models.choice()
    }

    fn samples(&self) -> usize {
        self.models.samples()
    }

    fn probabilities(&self) -> Vec<f64> {
        let streaming = || self.models.probabilities();
        self.answer
            .as_ref()
            .map_or_else(streaming, |a| a.probabilities.clone())
    }

    fn log_likelihoods(&self) -> Vec<f64> {
        let streaming = || self.models.log_likelihoods();
        self.answer
            .as_ref()
            .map_or_else(streaming, |a| a.log_likelihoods.clone())
    }

    fn infeasible_samples(&self) -> Vec<usize> {
        let streaming = || self.models.infeasible_samples();
        self.answer
            .as_ref()
            .map_or_else(streaming, |a| vec![0; a.set.len()])
    }

    /// Draws are no rivals of each other.
    fn known_to(&self) -> Vec<String> {
        let minima = |a: &Answer| match self.method {
            BatchMethod::Ensemble(_) => Vec::new(),
            BatchMethod::LeastSquares(_) => a.set.ids().into_iter().skip(1).collect(),
        };
        self.answer
            .as_ref()
            .map_or_else(|| self.models.known_to(), minima)
    }

    fn consistency(&self) -> Consistency {
        let streaming = || self.models.consistency();
        self.answer
            .as_ref()
            .map_or_else(streaming, |a| a.consistency.clone())
    }

    fn history(&self) -> Option<&History> {
        self.models.history()
    }
}
