//! Banks as estimators: one soil under all wheels, or one under each side.

use nalgebra::DMatrix;

use super::core::{Core, SoilMaps};
use super::motion::{MotionSample, Plant};
use crate::choice::Choice;
use crate::consistency::{AlarmRule, Consistency};
use crate::error::EstimatorError;
use crate::estimator::{History, ParameterEstimator, Weighed};
use crate::hypothesis::HypothesisSet;
use crate::log_prob::log_sum_exp;

/// A bank over one soil under all wheels: true multiple-model adaptive estimation, or with mixing of states the
/// interacting multiple models for ground that changes.
///
/// # Equation
/// p_j <- p_j N(ν_j; 0, S_j)/Z with ν_j, S_j the innovation of the vehicle filter whose forces follow from soil j.
///
/// # Reference
/// D. T. Magill, IEEE Trans. Automatic Control 10(4):434-439, 1965; H. A. P. Blom, Y. Bar-Shalom, IEEE Trans.
/// Automatic Control 33(8):780-783, 1988.
#[derive(Clone, Debug)]
pub struct InnovationBank {
    core: Core,
    history: Option<History>,
}

fn history(set: &HypothesisSet) -> History {
    History {
        ids: set.ids(),
        ..History::default()
    }
}

impl InnovationBank {
    /// Equal prior, choice `none`, no mixing.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a plant whose wheels are not those of the maps.
    pub fn new(maps: SoilMaps, plant: Plant) -> Result<Self, EstimatorError> {
        let members = (0..maps.set.len()).map(|j| [j, j]).collect();
        Ok(InnovationBank {
            core: Core::new(maps, plant, members)?,
            history: None,
        })
    }

    /// One vehicle filter with soil `left` under the left and soil `right` under the right wheels (indices of the set):
    /// a named answer held against the log. Returns whether its innovations are what they should be.
    ///
    /// # Errors
    /// [`EstimatorError::Size`] for an index beyond the set; what the bank refuses.
    pub fn check(
        maps: &SoilMaps,
        plant: &Plant,
        soils: [usize; 2],
        samples: &[MotionSample],
        rule: AlarmRule,
    ) -> Result<Consistency, EstimatorError> {
        if let Some(&found) = soils.iter().find(|&&j| j >= maps.set.len()) {
            return Err(EstimatorError::Size {
                what: "index of a soil",
                found,
                expected: maps.set.len(),
            });
        }
        let mut core = Core::new(maps.clone(), *plant, vec![soils])?;
        core.rule = rule.checked()?;
        let mut refused = 0;
        for sample in samples {
            match core.update(sample) {
                Ok(()) => {}
                Err(EstimatorError::AllInfeasible { .. }) => refused += 1,
                Err(e) => return Err(e),
            }
        }
        let mut seen = core.windows[0].verdict(rule);
        if 2 * refused > samples.len() {
            seen.alarm = true;
            seen.reason = Some(format!(
                "the vehicle cannot drive like this on the winner in {refused} of {} samples",
                samples.len()
            ));
        }
        Ok(seen)
    }

    /// With mixing of states by the choice: the interacting multiple models.
    #[must_use]
    pub fn with_mixing(mut self) -> Self {
        self.core.mixing = true;
        self
    }

    /// What happens to old evidence.
    ///
    /// # Errors
    /// [`EstimatorError::Value`], [`EstimatorError::Size`]; [`EstimatorError::NotSupported`] for forgetting with
    /// mixing, which needs to know where each hypothesis goes.
    pub fn with_choice(mut self, choice: Choice) -> Result<Self, EstimatorError> {
        self.core.choice =
            mixable(choice, self.core.mixing)?.checked(Some(self.core.maps.set.len()))?;
        Ok(self)
    }

    /// When the alarm is raised.
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn with_alarm(mut self, rule: AlarmRule) -> Result<Self, EstimatorError> {
        self.core.rule = rule.checked()?;
        Ok(self)
    }

    /// Keeps the posterior after each sample.
    #[must_use]
    pub fn with_history(mut self) -> Self {
        self.history = Some(history(&self.core.maps.set));
        self
    }

    /// ln p(all samples so far).
    pub fn log_evidence(&self) -> f64 {
        self.core.log_evidence
    }

    /// ln p (N) of the hypotheses.
    pub fn log_probabilities(&self) -> &[f64] {
        self.core.posterior.log_probabilities()
    }

    /// v \[m/s\], r \[rad/s\], ω fl fr rl rr \[rad/s\] as hypothesis j sees them; none before the first sample.
    pub fn state(&self, j: usize) -> Option<[f64; 6]> {
        self.core.state(j)
    }
}

fn mixable(choice: Choice, mixing: bool) -> Result<Choice, EstimatorError> {
    if mixing && matches!(choice, Choice::Forgetting(_)) {
        return Err(EstimatorError::NotSupported {
            estimator: "imm",
            choice: choice.to_string(),
            reason: "mixing needs to know where each hypothesis goes: transition or floor",
        });
    }
    Ok(choice)
}

impl ParameterEstimator<MotionSample> for InnovationBank {
    fn update(&mut self, sample: &MotionSample) -> Result<(), EstimatorError> {
        self.core.update(sample)?;
        if let Some(history) = &mut self.history {
            history.step.push(self.core.posterior.steps());
            history.time.push(sample.time);
            history
                .probability
                .push(self.core.posterior.probabilities().to_vec());
        }
        Ok(())
    }
}

impl Weighed for InnovationBank {
    fn name(&self) -> &'static str {
        name(&self.core)
    }
    fn hypotheses(&self) -> &HypothesisSet {
        &self.core.maps.set
    }
    fn choice(&self) -> &Choice {
        &self.core.choice
    }
    fn samples(&self) -> usize {
        self.core.posterior.steps()
    }
    fn probabilities(&self) -> Vec<f64> {
        self.core.posterior.probabilities().to_vec()
    }
    fn log_likelihoods(&self) -> Vec<f64> {
        self.core.log_likelihood.clone()
    }
    fn infeasible_samples(&self) -> Vec<usize> {
        self.core.infeasible.clone()
    }
    fn map_index(&self) -> usize {
        self.core.posterior.map()
    }
    fn consistency(&self) -> Consistency {
        self.core.windows[self.core.posterior.map()].verdict(self.core.rule)
    }
    fn history(&self) -> Option<&History> {
        self.history.as_ref()
    }
}

fn name(core: &Core) -> &'static str {
    if core.mixing {
        "imm"
    } else {
        "innovation-bank"
    }
}

/// A bank over every pair of soils under the left and the right wheels; each side has its own posterior.
///
/// One vehicle filter a pair, since both sides move one body: N² members, exact, and meant for sets of tens.
#[derive(Clone, Debug)]
pub struct SideBank {
    core: Core,
    /// As asked for, for one side.
    choice: Choice,
    history: Option<[History; 2]>,
}

impl SideBank {
    /// Equal prior, choice `none`, no mixing.
    ///
    /// # Errors
    /// [`EstimatorError::Size`] for a set too large to pair; [`EstimatorError::Value`].
    pub fn new(maps: SoilMaps, plant: Plant) -> Result<Self, EstimatorError> {
        let n = maps.set.len();
        let members = (0..n)
            .flat_map(|left| (0..n).map(move |right| [left, right]))
            .collect();
        Ok(SideBank {
            core: Core::new(maps, plant, members)?,
            choice: Choice::None,
            history: None,
        })
    }

    /// As [`InnovationBank::with_mixing`].
    #[must_use]
    pub fn with_mixing(mut self) -> Self {
        self.core.mixing = true;
        self
    }

    /// What happens to old evidence, on each side by itself.
    ///
    /// # Errors
    /// As [`InnovationBank::with_choice`].
    pub fn with_choice(mut self, choice: Choice) -> Result<Self, EstimatorError> {
        let n = self.core.maps.set.len();
        let choice = mixable(choice, self.core.mixing)?.checked(Some(n))?;
        let one = match &choice {
            Choice::Floor(f) => Some(DMatrix::from_fn(n, n, |i, j| {
                f / n as f64 + if i == j { 1.0 - f } else { 0.0 }
            })),
            Choice::Transition(m) => Some(m.clone()),
            Choice::None | Choice::Forgetting(_) => None,
        };
        self.core.choice = match one {
            Some(m) => Choice::Transition(m.kronecker(&m)),
            None => choice.clone(),
        };
        self.choice = choice;
        Ok(self)
    }

    /// When the alarm is raised.
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn with_alarm(mut self, rule: AlarmRule) -> Result<Self, EstimatorError> {
        self.core.rule = rule.checked()?;
        Ok(self)
    }

    /// Keeps the posterior after each sample.
    #[must_use]
    pub fn with_history(mut self) -> Self {
        let set = &self.core.maps.set;
        self.history = Some([history(set), history(set)]);
        self
    }

    /// One row of the log. Nothing is changed when it fails.
    ///
    /// # Errors
    /// As [`InnovationBank`]'s update.
    pub fn update(&mut self, sample: &MotionSample) -> Result<(), EstimatorError> {
        self.core.update(sample)?;
        let rows = [0, 1].map(|side| marginal(&self.core, side));
        if let Some(histories) = &mut self.history {
            for (history, row) in histories.iter_mut().zip(rows) {
                history.step.push(self.core.posterior.steps());
                history.time.push(sample.time);
                history.probability.push(row);
            }
        }
        Ok(())
    }

    /// What is known about the soil under the left wheels.
    pub fn left(&self) -> Marginal<'_> {
        Marginal {
            bank: self,
            side: 0,
        }
    }

    /// What is known about the soil under the right wheels.
    pub fn right(&self) -> Marginal<'_> {
        Marginal {
            bank: self,
            side: 1,
        }
    }
}

/// Probability of each soil under one side.
fn marginal(core: &Core, side: usize) -> Vec<f64> {
    let mut p = vec![0.0; core.maps.set.len()];
    for (member, w) in core.members.iter().zip(core.posterior.probabilities()) {
        p[member[side]] += w;
    }
    p
}

/// The posterior of one side of a [`SideBank`], summed over what may be under the other.
#[derive(Clone, Copy, Debug)]
pub struct Marginal<'a> {
    bank: &'a SideBank,
    side: usize,
}

impl Marginal<'_> {
    /// Members with soil j under this side.
    fn pairs(&self, j: usize) -> impl Iterator<Item = usize> {
        let members = &self.bank.core.members;
        (0..members.len()).filter(move |&k| members[k][self.side] == j)
    }
}

impl Weighed for Marginal<'_> {
    fn name(&self) -> &'static str {
        name(&self.bank.core)
    }
    fn hypotheses(&self) -> &HypothesisSet {
        &self.bank.core.maps.set
    }
    fn choice(&self) -> &Choice {
        &self.bank.choice
    }
    fn samples(&self) -> usize {
        self.bank.core.posterior.steps()
    }
    fn probabilities(&self) -> Vec<f64> {
        marginal(&self.bank.core, self.side)
    }
    /// ln of the likelihood averaged over the other side's soils.
    fn log_likelihoods(&self) -> Vec<f64> {
        let (core, n) = (&self.bank.core, self.bank.core.maps.set.len());
        (0..n)
            .map(|j| {
                let all: Vec<f64> = self.pairs(j).map(|k| core.log_likelihood[k]).collect();
                log_sum_exp(&all) - (n as f64).ln()
            })
            .collect()
    }
    fn infeasible_samples(&self) -> Vec<usize> {
        let core = &self.bank.core;
        (0..core.maps.set.len())
            .map(|j| {
                let least = self.pairs(j).map(|k| core.infeasible[k]).min();
                least.unwrap_or(0)
            })
            .collect()
    }
    fn consistency(&self) -> Consistency {
        let core = &self.bank.core;
        core.windows[core.posterior.map()].verdict(core.rule)
    }
    fn history(&self) -> Option<&History> {
        self.bank.history.as_ref().map(|h| &h[self.side])
    }
}
