//! Bayes' rule at a cost per sample that does not depend on the number of hypotheses.
//!
//! # Equation
//! With forces linear in shared features, A F_j = Φ θ_j, and one S for all hypotheses,
//! Σ_k ln N(Φ_k θ_j - y_k; 0, S_k) = -(θ_jᵀ M θ_j - 2 bᵀθ_j + c)/2,
//! M = Σ ΦᵀS⁻¹Φ, b = Σ ΦᵀS⁻¹y, c = Σ (yᵀS⁻¹y + ln det 2πS).
//! Prewhitening (Φ~ = Φ_k - ρ Φ_(k-1), likewise y) and forgetting (M, b, c <- λ M, λ b, λ c) stay exact. A floor, a
//! transition and a covariance per hypothesis do not, and are refused.
//!
//! S takes its slopes in slip and load from the mean of the tabulated hypotheses. A hypothesis that cannot carry the
//! wheel somewhere in the table's box gets the penalty of an infeasible one at every sample.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};
use terra_model::Contact;

use crate::choice::Choice;
use crate::consistency::{AlarmRule, Consistency, Window};
use crate::error::EstimatorError;
use crate::estimator::{History, INFEASIBLE_LOG_LIKELIHOOD, ParameterEstimator, Weighed};
use crate::force_table::{ForceTable, TableBox};
use crate::hypothesis::HypothesisSet;
use crate::observation::ForceObservation;
use crate::posterior::Posterior;
use crate::residual::{covariance, score};
use crate::whiten::{Clock, Prewhitening};

/// Quadratic sums of all observations.
#[derive(Clone, Debug)]
struct Sums {
    matrix: DMatrix<f64>,
    vector: DVector<f64>,
    constant: f64,
    penalty: f64,
}

impl Sums {
    fn zero(n: usize) -> Self {
        Sums {
            matrix: DMatrix::zeros(n, n),
            vector: DVector::zeros(n),
            constant: 0.0,
            penalty: 0.0,
        }
    }

    fn discount(&mut self, lambda: f64) {
        self.matrix *= lambda;
        self.vector *= lambda;
        self.constant *= lambda;
        self.penalty *= lambda;
    }

    /// ln likelihood of each hypothesis (N). The quadratic form is taken around the best hypothesis, so that near rivals
    /// do not drown in the rounding of the large part they share.
    fn log_likelihoods(&self, table: &ForceTable, n: usize) -> Vec<f64> {
        let raw = |theta: &DVector<f64>| {
            -0.5 * (theta.dot(&(&self.matrix * theta)) - 2.0 * self.vector.dot(theta)
                + self.constant)
        };
        let rough: Vec<Option<f64>> = (0..n).map(|j| table.coefficients(j).map(raw)).collect();
        let feasible = (0..n).filter_map(|j| table.coefficients(j).zip(rough[j]));
        let Some((centre, base)) = feasible.max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return vec![self.penalty; n];
        };
        let gradient = &self.matrix * centre - &self.vector;
        let centred = |theta: &DVector<f64>| {
            let d = theta - centre;
            base - 0.5 * d.dot(&(&self.matrix * &d)) - gradient.dot(&d)
        };
        (0..n)
            .map(|j| table.coefficients(j).map_or(self.penalty, centred))
            .collect()
    }
}

/// One whitened observation in feature space.
#[derive(Clone, Debug)]
struct Row {
    features: DMatrix<f64>,
    forces: DVector<f64>,
    covariance: DMatrix<f64>,
    follows: bool,
}

/// The estimator by sufficient statistics.
#[derive(Clone, Debug)]
pub struct SufficientStatistics {
    set: HypothesisSet,
    table: ForceTable,
    mean: DVector<f64>,
    choice: Choice,
    whitening: Option<Prewhitening>,
    rule: AlarmRule,
    /// With the choice applied: what the posterior follows from.
    sums: Sums,
    /// Without it: the accumulated log-likelihood.
    total: Sums,
    samples: usize,
    previous: Option<(DMatrix<f64>, DVector<f64>)>,
    clock: Clock,
    recent: VecDeque<Row>,
    history: Option<History>,
}

impl SufficientStatistics {
    /// Equal prior, choice `none`, no prewhitening; forces are tabulated over a box on contacts like the template.
    ///
    /// # Errors
    /// As [`ForceTable::new`]; [`EstimatorError::AllInfeasible`] when no hypothesis is feasible in the whole box.
    pub fn new(
        set: HypothesisSet,
        range: TableBox,
        template: &Contact<f64>,
    ) -> Result<Self, EstimatorError> {
        let table = ForceTable::new(&set, range, template)?;
        let feasible: Vec<&DVector<f64>> = (0..set.len())
            .filter_map(|j| table.coefficients(j))
            .collect();
        if feasible.is_empty() {
            return Err(EstimatorError::AllInfeasible {
                time: 0.0,
                hypotheses: set.len(),
            });
        }
        let n = 3 * table.features();
        let mut mean = DVector::zeros(n);
        for theta in &feasible {
            mean += *theta / feasible.len() as f64;
        }
        Ok(SufficientStatistics {
            mean,
            choice: Choice::None,
            whitening: None,
            rule: AlarmRule::default(),
            sums: Sums::zero(n),
            total: Sums::zero(n),
            samples: 0,
            previous: None,
            clock: Clock::default(),
            recent: VecDeque::new(),
            history: None,
            table,
            set,
        })
    }

    /// What happens to old evidence: `none` or `forgetting`.
    ///
    /// # Errors
    /// [`EstimatorError::NotSupported`] for the others, [`EstimatorError::Value`].
    pub fn with_choice(mut self, choice: Choice) -> Result<Self, EstimatorError> {
        if let Choice::Floor(_) | Choice::Transition(_) = choice {
            return Err(EstimatorError::NotSupported {
                estimator: "sufficient-statistics",
                choice: choice.to_string(),
                reason: "only none and forgetting are exact in sums",
            });
        }
        self.choice = choice.checked(Some(self.set.len()))?;
        Ok(self)
    }

    /// Takes the correlation from sample to sample out of the residuals.
    #[must_use]
    pub fn with_prewhitening(mut self, whitening: Option<Prewhitening>) -> Self {
        self.whitening = whitening;
        self
    }

    /// When the alarm is raised.
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn with_alarm(mut self, rule: AlarmRule) -> Result<Self, EstimatorError> {
        self.rule = rule.checked()?;
        Ok(self)
    }

    /// Keeps the posterior after each sample; each then costs a query over all hypotheses.
    #[must_use]
    pub fn with_history(mut self) -> Self {
        self.history = Some(History {
            ids: self.set.ids(),
            ..History::default()
        });
        self
    }

    /// The tabulated forces.
    pub fn table(&self) -> &ForceTable {
        &self.table
    }

    /// S (m x m) that all hypotheses share at an observation, before prewhitening.
    ///
    /// # Errors
    /// [`EstimatorError::OutsideTable`].
    pub fn shared_covariance(
        &self,
        obs: &ForceObservation,
    ) -> Result<DMatrix<f64>, EstimatorError> {
        let (_, slopes) = self.table.observe(obs)?;
        let columns: Vec<DVector<f64>> = slopes.iter().map(|s| s * &self.mean).collect();
        Ok(covariance(obs, &DMatrix::from_columns(&columns)))
    }
}

impl ParameterEstimator for SufficientStatistics {
    fn update(&mut self, obs: &ForceObservation) -> Result<(), EstimatorError> {
        obs.check()?;
        let rho = self.clock.correlation(obs, self.whitening)?;
        let (features, _) = self.table.observe(obs)?;
        let s = self.shared_covariance(obs)? * (1.0 - rho * rho);
        let forces = obs.forces.clone();
        let (white, y) = match &self.previous {
            Some((last, last_y)) if rho > 0.0 => (&features - last * rho, &forces - last_y * rho),
            _ => (features.clone(), forces.clone()),
        };
        let fail = || EstimatorError::NotPositiveDefinite {
            hypothesis: "all".to_owned(),
            time: obs.time,
        };
        let factor = s.clone().cholesky().ok_or_else(fail)?;
        // One score of y itself gives yᵀS⁻¹y + ln det 2πS.
        let constant = -2.0 * score(&y, &s).ok_or_else(fail)?.log_density;
        let weighted = factor.solve(&white);
        let matrix = white.tr_mul(&weighted);
        let vector = weighted.tr_mul(&y);
        if !matrix.iter().chain(vector.iter()).all(|x| x.is_finite()) {
            return Err(fail());
        }

        if let Choice::Forgetting(lambda) = self.choice {
            self.sums.discount(lambda);
        }
        for sums in [&mut self.sums, &mut self.total] {
            sums.matrix += &matrix;
            sums.vector += &vector;
            sums.constant += constant;
            sums.penalty += INFEASIBLE_LOG_LIKELIHOOD;
        }
        self.samples += 1;
        if self.recent.len() >= self.rule.window {
            self.recent.pop_front();
        }
        let follows = self.clock.follows(obs);
        self.recent.push_back(Row {
            features: white,
            forces: y,
            covariance: s,
            follows,
        });
        self.previous = Some((features, forces));
        self.clock.advance(obs);
        if self.history.is_some() {
            let row = self.probabilities();
            if let Some(history) = &mut self.history {
                history.step.push(self.samples);
                history.time.push(obs.time);
                history.probability.push(row);
            }
        }
        Ok(())
    }
}

impl Weighed for SufficientStatistics {
    fn name(&self) -> &'static str {
        "sufficient-statistics"
    }

    fn hypotheses(&self) -> &HypothesisSet {
        &self.set
    }

    fn choice(&self) -> &Choice {
        &self.choice
    }

    fn samples(&self) -> usize {
        self.samples
    }

    fn probabilities(&self) -> Vec<f64> {
        let n = self.set.len();
        let log_likelihood = self.sums.log_likelihoods(&self.table, n);
        let equal = vec![1.0 / n as f64; n];
        let Ok(mut posterior) = Posterior::uniform(n) else {
            return equal;
        };
        // The sums are finite, so a step from an equal prior cannot fail.
        match posterior.step(&Choice::None, &log_likelihood) {
            Ok(_) => posterior.probabilities().to_vec(),
            Err(_) => equal,
        }
    }

    fn log_likelihoods(&self) -> Vec<f64> {
        self.total.log_likelihoods(&self.table, self.set.len())
    }

    fn infeasible_samples(&self) -> Vec<usize> {
        let count = |j| {
            if self.table.coefficients(j).is_none() {
                self.samples
            } else {
                0
            }
        };
        (0..self.set.len()).map(count).collect()
    }

    fn consistency(&self) -> Consistency {
        let mut window = Window::default();
        let theta = self.table.coefficients(self.map_index());
        for row in &self.recent {
            let scored = theta
                .and_then(|theta| score(&(&row.features * theta - &row.forces), &row.covariance));
            window.push(scored.map(|s| s.standardised), row.follows, self.rule);
        }
        window.verdict(self.rule)
    }

    fn history(&self) -> Option<&History> {
        self.history.as_ref()
    }
}
