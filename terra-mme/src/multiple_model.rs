//! Multiple-model estimation: every hypothesis predicts the forces observed, Bayes' rule weighs them.
//!
//! # Equation
//! ln p(y_k | j) = ln N(r~_jk; 0, S~_jk), with residual and covariance of [`compare`] after the prewhitening of
//! [`Prewhitening`]; p_j <- p_j p(y_k | j) / Z after the [`Choice`] has acted on p.
//!
//! # Reference
//! D. T. Magill, IEEE Trans. Automatic Control 10(4):434-439, 1965 (the estimator); L. E. Ray, Proc. SPIE, 2008,
//! eqs 22-23 (terrain), with side sums in place of the proportional split.

use nalgebra::DVector;

use crate::choice::Choice;
use crate::consistency::{AlarmRule, Consistency, Window};
use crate::error::EstimatorError;
use crate::estimator::{History, INFEASIBLE_LOG_LIKELIHOOD, ParameterEstimator, Weighed};
use crate::hypothesis::HypothesisSet;
use crate::observation::ForceObservation;
use crate::posterior::Posterior;
use crate::residual::{Comparison, compare, score};
use crate::split_load::proportional_split;
use crate::whiten::{Clock, Prewhitening};

/// What becomes of an observation before it is compared.
type Intake = fn(&ForceObservation) -> Result<ForceObservation, EstimatorError>;

fn single_wheel_rows(obs: &ForceObservation) -> Result<ForceObservation, EstimatorError> {
    obs.check()?;
    let single = |row: usize| {
        let row = obs.map.row(row);
        row.iter().filter(|a| **a != 0.0).count() == 1 && row.iter().any(|a| *a == 1.0)
    };
    match (0..obs.forces.len()).find(|&row| !single(row)) {
        None => Ok(obs.clone()),
        Some(row) => Err(EstimatorError::Observation {
            time: obs.time,
            reason: format!("row {} of the map is not the force of one wheel", row + 1),
        }),
    }
}

/// A hypothesis set weighed sample by sample. The observation's map says what is compared: one wheel, a side, an axle.
#[derive(Clone, Debug)]
pub struct MultipleModel {
    name: &'static str,
    intake: Option<Intake>,
    set: HypothesisSet,
    choice: Choice,
    whitening: Option<Prewhitening>,
    table_error: f64,
    rule: AlarmRule,
    posterior: Posterior,
    log_evidence: f64,
    log_likelihood: Vec<f64>,
    infeasible: Vec<usize>,
    /// Last residual of each hypothesis, for whitening.
    previous: Vec<Option<DVector<f64>>>,
    clock: Clock,
    windows: Vec<Window>,
    history: Option<History>,
}

impl MultipleModel {
    /// Equal prior, choice `none`, no prewhitening.
    ///
    /// # Errors
    /// [`EstimatorError::EmptySet`].
    pub fn new(set: HypothesisSet) -> Result<Self, EstimatorError> {
        let n = set.len();
        Ok(MultipleModel {
            name: "side-sum",
            intake: None,
            posterior: Posterior::uniform(n)?,
            choice: Choice::None,
            whitening: None,
            table_error: 0.0,
            rule: AlarmRule::default(),
            log_evidence: 0.0,
            log_likelihood: vec![0.0; n],
            infeasible: vec![0; n],
            previous: vec![None; n],
            clock: Clock::default(),
            windows: vec![Window::default(); n],
            history: None,
            set,
        })
    }

    /// As [`MultipleModel::new`], but takes only rows of single wheel forces: a sum slipped in by mistake is refused.
    ///
    /// # Errors
    /// [`EstimatorError::EmptySet`].
    pub fn wheel(set: HypothesisSet) -> Result<Self, EstimatorError> {
        Ok(MultipleModel {
            name: "wheel",
            intake: Some(single_wheel_rows),
            ..Self::new(set)?
        })
    }

    /// As [`MultipleModel::new`], on the front wheel's share of each side by [`proportional_split`]: kept to show its
    /// flaw.
    ///
    /// # Errors
    /// [`EstimatorError::EmptySet`].
    pub fn proportional_split(set: HypothesisSet) -> Result<Self, EstimatorError> {
        let front: Intake = |side| proportional_split(side, 0);
        Ok(MultipleModel {
            name: "proportional-split",
            intake: Some(front),
            ..Self::new(set)?
        })
    }

    /// Prior weights (N), normalised here. Call before the first update: it restarts the posterior.
    ///
    /// # Errors
    /// [`EstimatorError::Size`], [`EstimatorError::Value`], [`EstimatorError::Impossible`].
    pub fn with_prior(mut self, prior: &[f64]) -> Result<Self, EstimatorError> {
        if prior.len() != self.set.len() {
            return Err(EstimatorError::Size {
                what: "prior",
                found: prior.len(),
                expected: self.set.len(),
            });
        }
        self.posterior = Posterior::with_prior(prior)?;
        Ok(self)
    }

    /// What happens to old evidence.
    ///
    /// # Errors
    /// [`EstimatorError::Value`], [`EstimatorError::Size`].
    pub fn with_choice(mut self, choice: Choice) -> Result<Self, EstimatorError> {
        self.choice = choice.checked(Some(self.set.len()))?;
        Ok(self)
    }

    /// Takes the correlation from sample to sample out of the residuals.
    #[must_use]
    pub fn with_prewhitening(mut self, whitening: Option<Prewhitening>) -> Self {
        self.whitening = whitening;
        self
    }

    /// Relative error of every predicted wheel force, added to the diagonal of S; for tabulated laws.
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn with_table_error(mut self, relative: f64) -> Result<Self, EstimatorError> {
        if !(relative.is_finite() && relative >= 0.0) {
            let (what, expected) = ("table error".to_owned(), "a finite share of at least 0");
            return Err(EstimatorError::Value {
                what,
                value: relative,
                expected,
            });
        }
        self.table_error = relative;
        Ok(self)
    }

    /// When the alarm is raised.
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn with_alarm(mut self, rule: AlarmRule) -> Result<Self, EstimatorError> {
        self.rule = rule.checked()?;
        Ok(self)
    }

    /// Keeps the posterior after each sample.
    #[must_use]
    pub fn with_history(mut self) -> Self {
        self.history = Some(History {
            ids: self.set.ids(),
            ..History::default()
        });
        self
    }

    /// The same options over another set, before its first sample.
    pub(crate) fn over(&self, set: HypothesisSet) -> Result<Self, EstimatorError> {
        Ok(MultipleModel {
            name: self.name,
            intake: self.intake,
            choice: self.choice.clone(),
            whitening: self.whitening,
            table_error: self.table_error,
            rule: self.rule,
            ..Self::new(set)?
        })
    }

    /// ln p(all observations so far): the evidence for the set as a whole under its choice.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    /// ln p (N) of the hypotheses: finite where the probability rounds to 0.
    pub fn log_probabilities(&self) -> &[f64] {
        self.posterior.log_probabilities()
    }
}

/// One hypothesis after one observation.
struct Compared {
    log_likelihood: f64,
    residual: Option<DVector<f64>>,
    standardised: Option<DVector<f64>>,
}

impl MultipleModel {
    fn weigh(
        &self,
        j: usize,
        obs: &ForceObservation,
        rho: f64,
    ) -> Result<Compared, EstimatorError> {
        let h = &self.set.hypotheses()[j];
        let residual = match compare(&h.id, &h.law, &h.parameters, obs, self.table_error)? {
            Comparison::Feasible(residual) => residual,
            Comparison::Infeasible(_) => {
                let log_likelihood = INFEASIBLE_LOG_LIKELIHOOD;
                return Ok(Compared {
                    log_likelihood,
                    residual: None,
                    standardised: None,
                });
            }
        };
        // After a sample it could not predict a hypothesis starts afresh: that residual does not exist.
        let (r, s) = match &self.previous[j] {
            Some(last) if rho > 0.0 => (
                &residual.value - last * rho,
                residual.covariance * (1.0 - rho * rho),
            ),
            _ => (residual.value.clone(), residual.covariance),
        };
        let scored = score(&r, &s).ok_or_else(|| EstimatorError::NotPositiveDefinite {
            hypothesis: h.id.clone(),
            time: obs.time,
        })?;
        Ok(Compared {
            log_likelihood: scored.log_density,
            residual: Some(residual.value),
            standardised: Some(scored.standardised),
        })
    }
}

impl MultipleModel {
    fn weigh_all(&self, obs: &ForceObservation, rho: f64) -> Result<Vec<Compared>, EstimatorError> {
        (0..self.set.len())
            .map(|j| self.weigh(j, obs, rho))
            .collect()
    }

    fn take(&mut self, obs: &ForceObservation, weighed: Vec<Compared>) {
        let follows = self.clock.follows(obs);
        for (j, w) in weighed.into_iter().enumerate() {
            self.log_likelihood[j] += w.log_likelihood;
            self.infeasible[j] += usize::from(w.residual.is_none());
            self.windows[j].push(w.standardised, follows, self.rule);
            self.previous[j] = w.residual;
        }
        self.clock.advance(obs);
    }

    /// Weighs a sample that another set has already taken: hypotheses that cannot carry it get their penalty, even when
    /// none can. The posterior waits for [`joined`](Self::joined).
    pub(crate) fn replay(&mut self, obs: &ForceObservation) -> Result<(), EstimatorError> {
        let taken = self.intake.map(|intake| intake(obs)).transpose()?;
        let obs = taken.as_ref().unwrap_or(obs);
        obs.check()?;
        let rho = self.clock.correlation(obs, self.whitening)?;
        let weighed = self.weigh_all(obs, rho)?;
        self.take(obs, weighed);
        Ok(())
    }

    /// The hypotheses `kept` and those of `others`, which have seen the same samples, under a prior given anew: as if
    /// they had been one set from the first sample on. For the choice `none`.
    pub(crate) fn joined(
        &self,
        kept: &[usize],
        others: MultipleModel,
        prior: &[f64],
    ) -> Result<Self, EstimatorError> {
        fn pick<T: Clone>(from: &[T], kept: &[usize], more: Vec<T>) -> Vec<T> {
            let kept = kept.iter().filter_map(|&j| from.get(j).cloned());
            kept.chain(more).collect()
        }
        let mine = pick(self.set.hypotheses(), kept, Vec::new());
        let set = HypothesisSet::new(mine)?.joined(others.set)?;
        let log_likelihood = pick(&self.log_likelihood, kept, others.log_likelihood);
        let mut out = MultipleModel {
            infeasible: pick(&self.infeasible, kept, others.infeasible),
            previous: pick(&self.previous, kept, others.previous),
            windows: pick(&self.windows, kept, others.windows),
            clock: self.clock.clone(),
            ..self.over(set)?
        };
        let total: f64 = prior.iter().sum();
        out = out.with_prior(prior)?;
        let steps = self.posterior.steps();
        out.log_evidence = out.posterior.replace(&log_likelihood, steps)?.ln() + total.ln();
        out.log_likelihood = log_likelihood;
        Ok(out)
    }
}

impl ParameterEstimator for MultipleModel {
    fn update(&mut self, obs: &ForceObservation) -> Result<(), EstimatorError> {
        let taken = self.intake.map(|intake| intake(obs)).transpose()?;
        let obs = taken.as_ref().unwrap_or(obs);
        obs.check()?;
        let rho = self.clock.correlation(obs, self.whitening)?;
        let weighed = self.weigh_all(obs, rho)?;
        if weighed.iter().all(|w| w.residual.is_none()) {
            return Err(EstimatorError::AllInfeasible {
                time: obs.time,
                hypotheses: weighed.len(),
            });
        }
        let log_likelihood: Vec<f64> = weighed.iter().map(|w| w.log_likelihood).collect();
        self.log_evidence += self.posterior.step(&self.choice, &log_likelihood)?.ln();
        // Nothing below can fail: an observation counts in full or not at all.
        self.take(obs, weighed);
        if let Some(history) = &mut self.history {
            history.step.push(self.posterior.steps());
            history.time.push(obs.time);
            history
                .probability
                .push(self.posterior.probabilities().to_vec());
        }
        Ok(())
    }
}

impl Weighed for MultipleModel {
    fn name(&self) -> &'static str {
        self.name
    }

    fn hypotheses(&self) -> &HypothesisSet {
        &self.set
    }

    fn choice(&self) -> &Choice {
        &self.choice
    }

    fn samples(&self) -> usize {
        self.posterior.steps()
    }

    fn probabilities(&self) -> Vec<f64> {
        self.posterior.probabilities().to_vec()
    }

    fn log_likelihoods(&self) -> Vec<f64> {
        self.log_likelihood.clone()
    }

    fn infeasible_samples(&self) -> Vec<usize> {
        self.infeasible.clone()
    }

    fn map_index(&self) -> usize {
        self.posterior.map()
    }

    fn consistency(&self) -> Consistency {
        self.windows[self.posterior.map()].verdict(self.rule)
    }

    fn history(&self) -> Option<&History> {
        self.history.as_ref()
    }
}
