//! What soil is it? From a log to a posterior per group, with refined parameters and what cannot be known.

mod alarm;
mod drive;
mod hypotheses;
mod json;
mod motion;
mod rig;

use terra_data::Rover;
use terra_mme::{
    AlarmRule, Centre, Choice, Consistency, EstimatorError, EstimatorOptions, FitSpace,
    ForceObservation, ForcePrediction, History, Hypothesis, HypothesisPosterior, HypothesisSet,
    NearDuplicate, ParameterBelief, Prewhitening, Priors, RefineOptions, Refinement,
    SystematicCandidate, Weighed, estimator, refine,
};
use terra_model::Contact;

pub(crate) use drive::observation as side_observation;
pub use drive::{identify_drive, identify_drive_among};
pub(crate) use hypotheses::{hypotheses, twins};
pub(crate) use json::to_json;
pub use rig::{identify_rig, identify_rig_among};

use crate::error::CliError;

/// Slips of a force prediction.
const SLIPS: [f64; 10] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// Estimators whose hypotheses are fits: a refinement would take a fit for its prior.
const FITTING: [&str; 2] = ["least-squares", "ensemble"];

/// How an identification runs.
#[derive(Clone, Debug)]
pub struct IdentifyOptions {
    /// Estimator by name; `None` for the default of the log's kind.
    pub estimator: Option<String>,
    /// What happens to old evidence.
    pub choice: Choice,
    /// One soil under both sides of a vehicle.
    pub join: bool,
    /// Keep the posterior after every sample.
    pub history: bool,
    /// Refine the winner's parameters.
    pub refine: bool,
    /// Hold the winners of a drive against the vehicle's motion.
    pub check: bool,
    /// Where that rings, weigh systematic errors together with every soil.
    pub explain: bool,
    /// Filter of the forces of a drive.
    pub filter: String,
    /// Take the correlation of the filter's force errors out of the residuals of a drive. Without it evidence is counted
    /// several times over: to show what that does.
    pub prewhiten: bool,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        IdentifyOptions {
            estimator: None,
            choice: Choice::None,
            join: false,
            history: false,
            refine: true,
            check: true,
            explain: true,
            filter: "block".to_owned(),
            prewhiten: true,
        }
    }
}

/// Where the rows of a log went: rows = used + waiting + rejected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Samples {
    /// Rows of the log.
    pub rows: usize,
    /// Weighed.
    pub used: usize,
    /// Before the filter had settled.
    pub waiting: usize,
    /// Outside every model (standstill, a lifted wheel, a wheel against its motion, forces no soil of the set gives).
    pub rejected: usize,
    /// Samples missing in the channels used.
    pub missing: usize,
}

/// A refined winner.
#[derive(Clone, Debug)]
pub struct Refined {
    /// Hypothesis it started from.
    pub start: String,
    /// The fit.
    pub fit: Refinement,
    /// Forces it predicts.
    pub force_prediction: Vec<ForcePrediction>,
}

/// One group: a side, a condition, or the whole log.
#[derive(Clone, Debug)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// All hypotheses, most probable first.
    pub posterior: Vec<HypothesisPosterior>,
    /// The most probable.
    pub map: Option<String>,
    /// Its law and parameters.
    pub winner: Hypothesis,
    /// Hypotheses this log cannot tell from it.
    pub known_to: Vec<String>,
    /// Parameters by structure.
    pub belief: ParameterBelief,
    /// Refined winner, and why there is none.
    pub refined: Result<Refined, String>,
    /// Mixture of forces.
    pub force_prediction: Vec<ForcePrediction>,
    /// Whether the winner explains the data.
    pub consistency: Consistency,
    /// When the alarm rings on a drive: systematic errors of vehicle and sensors weighed together with every soil.
    pub candidates: Vec<SystematicCandidate>,
    /// Posterior after each sample.
    pub history: Option<History>,
}

/// The result of an identification.
#[derive(Clone, Debug)]
pub struct Identification {
    /// `drive` or `rig`.
    pub log_kind: &'static str,
    /// Filter of the forces.
    pub filter: Option<String>,
    /// Estimator.
    pub estimator: String,
    /// What happened to old evidence.
    pub choice: Choice,
    /// ρ of the prewhitening.
    pub prewhiten_rho: Option<f64>,
    /// Where the rows went.
    pub samples: Samples,
    /// What limits the answer: `no-ground-speed`.
    pub flags: Vec<&'static str>,
    /// Pairs of hypotheses that no force tells apart.
    pub near_duplicates: Vec<NearDuplicate>,
    /// Groups.
    pub groups: Vec<Group>,
}

/// What all groups of a log share.
struct Job<'a> {
    set: &'a HypothesisSet,
    rover: &'a Rover,
    options: &'a IdentifyOptions,
    estimator: &'a str,
    whitening: Option<Prewhitening>,
    alarm: AlarmRule,
}

impl Job<'_> {
    /// Weighs the observations of one group. Returns the group, and how many observations were rejected.
    fn group(
        &self,
        name: &str,
        observations: &[ForceObservation],
    ) -> Result<(Group, usize), CliError> {
        let set = self.set.clone();
        let template = observations
            .first()
            .and_then(|o| o.contacts.first())
            .copied()
            .unwrap_or_else(|| {
                Contact::new(0.1, 1.0, self.rover.wheel.radius, self.rover.wheel.width)
            });
        let mut weigher = estimator(
            self.estimator,
            set,
            &EstimatorOptions {
                choice: self.options.choice.clone(),
                whitening: self.whitening,
                alarm: self.alarm,
                history: self.options.history,
                priors: self.priors(),
                ..EstimatorOptions::new(template)
            },
        )?;
        let mut used = vec![];
        let mut last_reason = None;
        for o in observations {
            match weigher.update(o) {
                Ok(()) => used.push(o.clone()),
                Err(e @ (EstimatorError::Size { .. } | EstimatorError::NotSupported { .. })) => {
                    return Err(e.into());
                }
                Err(e) => last_reason = Some(e.to_string()),
            }
        }
        if used.is_empty() {
            return Err(CliError::data(
                format!(
                    "{name}: no sample could be weighed{}",
                    last_reason
                        .map(|r| format!("; the last one: {r}"))
                        .unwrap_or_default()
                ),
                "the vehicle must move with slip; see the flags of `terra estimate`",
            ));
        }
        weigher.finish()?;
        let group = self.told(name, &*weigher, &used, &template)?;
        Ok((group, observations.len() - used.len()))
    }

    /// What a weigher says of one group; the winner is refined on the observations.
    fn told(
        &self,
        name: &str,
        weigher: &(impl Weighed + ?Sized),
        observations: &[ForceObservation],
        template: &Contact<f64>,
    ) -> Result<Group, CliError> {
        let mut loads = loads(observations);
        if loads.is_empty() {
            loads.push(template.normal_load);
        }
        let map = weigher.map().id.clone();
        let refined = if FITTING.contains(&self.estimator) {
            Err("the estimator fits the parameters itself".to_owned())
        } else if self.options.refine {
            self.refined(weigher.map(), observations, &loads, template)
        } else {
            Err("not asked for".to_owned())
        };
        Ok(Group {
            name: name.to_owned(),
            posterior: weigher.posterior(),
            known_to: weigher.known_to(),
            belief: weigher.belief(),
            refined,
            force_prediction: weigher.force_prediction(&SLIPS, &loads, template)?,
            consistency: weigher.consistency(),
            candidates: Vec::new(),
            history: weigher.history().cloned(),
            winner: weigher.map().clone(),
            map: Some(map),
        })
    }

    fn priors(&self) -> Priors {
        Priors::default().with(
            &self.rover.terrain.prior_sd,
            &self.rover.terrain.prior_abs_sd,
        )
    }

    fn refined(
        &self,
        winner: &Hypothesis,
        observations: &[ForceObservation],
        loads: &[f64],
        template: &Contact<f64>,
    ) -> Result<Refined, String> {
        let priors = self.priors();
        let fit = || -> Result<Refined, EstimatorError> {
            let space = FitSpace::new(
                &winner.law,
                Centre::Parameters(&winner.parameters),
                &[template.width],
                &priors,
            )?;
            let options = RefineOptions {
                whitening: self.whitening,
                ..RefineOptions::default()
            };
            let fit = refine(&winner.law, space, observations, &options)?;
            let force_prediction = fit.force_prediction(&SLIPS, loads, template)?;
            Ok(Refined {
                start: winner.id.clone(),
                fit,
                force_prediction,
            })
        };
        fit().map_err(|e| e.to_string())
    }
}

/// Smallest, median and largest load of the observations.
fn loads(observations: &[ForceObservation]) -> Vec<f64> {
    let mut all: Vec<f64> = observations
        .iter()
        .flat_map(|o| o.contacts.iter().map(|c| c.normal_load))
        .collect();
    all.sort_by(f64::total_cmp);
    let mut out = match (all.first(), all.get(all.len() / 2), all.last()) {
        (Some(a), Some(b), Some(c)) => vec![*a, *b, *c],
        _ => vec![],
    };
    out.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * b.abs());
    out
}
