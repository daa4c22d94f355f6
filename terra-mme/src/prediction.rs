//! Forces the ground would give, with how sure that is: the main output of an identification.
//!
//! # Equation
//! Over feasible hypotheses with weights w (renormalised): mean = Σ w F, and by the law of total variance
//! sd² = Σ w (F - mean)² + Σ w var(F).
//!
//! Forces are averaged, never parameters: the mean of a dry sand and a lean clay is a soil that pulls five times as
//! hard as either.

use terra_model::{Contact, ForceLaw, ModelError};

use crate::error::EstimatorError;
use crate::hypothesis::HypothesisSet;
use crate::residual::is_infeasible;

/// A number with its spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
}

/// Whether a prediction can be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PredictionStatus {
    /// Forces are given.
    Ok,
    /// At least half of the probability lies on soils that cannot carry this load at this slip: no forces.
    NoEquilibrium,
}

impl PredictionStatus {
    /// Name in results: `ok`, `no-equilibrium`.
    pub fn name(self) -> &'static str {
        match self {
            PredictionStatus::Ok => "ok",
            PredictionStatus::NoEquilibrium => "no-equilibrium",
        }
    }
}

/// Predicted forces of one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcePrediction {
    /// Library slip.
    pub slip: f64,
    /// W \[N\].
    pub normal_load: f64,
    /// D \[N\].
    pub drawbar_pull: Option<Spread>,
    /// T_r \[N m\].
    pub torque: Option<Spread>,
    /// z \[m\]; none also when a law in use has no sinkage.
    pub sinkage: Option<Spread>,
    /// Probability of the hypotheses that cannot carry this load.
    pub infeasible: f64,
    /// Whether forces are given.
    pub status: PredictionStatus,
}

impl ForcePrediction {
    /// No forces: the soil cannot carry the wheel.
    pub(crate) fn none(at: &Contact<f64>, infeasible: f64) -> Self {
        ForcePrediction {
            slip: at.slip,
            normal_load: at.normal_load,
            drawbar_pull: None,
            torque: None,
            sinkage: None,
            infeasible,
            status: PredictionStatus::NoEquilibrium,
        }
    }
}

/// Every slip at every load (loads outermost) on a contact like the template.
pub fn contact_grid(slips: &[f64], loads: &[f64], template: &Contact<f64>) -> Vec<Contact<f64>> {
    let at = |load: &f64, slip: &f64| Contact {
        slip: *slip,
        normal_load: *load,
        ..*template
    };
    loads
        .iter()
        .flat_map(|load| slips.iter().map(move |slip| at(load, slip)))
        .collect()
}

/// Below this weight a hypothesis moves no digit of a mean and is not evaluated.
const NEGLIGIBLE: f64 = 1e-17;

/// The mixture of forces of weighted hypotheses at one contact.
///
/// # Errors
/// [`EstimatorError::Size`] when weights and hypotheses differ in number; [`EstimatorError::Model`] for a contact
/// that no law accepts.
pub fn mixture(
    set: &HypothesisSet,
    weights: &[f64],
    at: &Contact<f64>,
) -> Result<ForcePrediction, EstimatorError> {
    if weights.len() != set.len() {
        return Err(EstimatorError::Size {
            what: "weights",
            found: weights.len(),
            expected: set.len(),
        });
    }
    let mut members: Vec<(f64, [Option<f64>; 3])> = Vec::new();
    let mut infeasible = 0.0;
    for (h, &w) in set
        .hypotheses()
        .iter()
        .zip(weights)
        .filter(|(_, w)| **w > NEGLIGIBLE)
    {
        match h.law.forces(&h.parameters, at) {
            Ok(f) => members.push((
                w,
                [Some(f.drawbar_pull), Some(f.resistive_torque), f.sinkage],
            )),
            Err(e) if is_infeasible(&e) => infeasible += w,
            Err(source) => return Err(model_error(&h.id, source)),
        }
    }
    let total: f64 = members.iter().map(|m| m.0).sum();
    if infeasible >= total {
        return Ok(ForcePrediction::none(at, infeasible));
    }
    let spread = |k: usize| -> Option<Spread> {
        let values: Option<Vec<(f64, f64)>> = members
            .iter()
            .map(|(w, f)| f[k].map(|f| (w / total, f)))
            .collect();
        let values = values?;
        let mean: f64 = values.iter().map(|(w, f)| w * f).sum();
        let variance: f64 = values.iter().map(|(w, f)| w * (f - mean).powi(2)).sum();
        Some(Spread {
            mean,
            sd: variance.sqrt(),
        })
    };
    Ok(ForcePrediction {
        slip: at.slip,
        normal_load: at.normal_load,
        drawbar_pull: spread(0),
        torque: spread(1),
        sinkage: spread(2),
        infeasible,
        status: PredictionStatus::Ok,
    })
}

pub(crate) fn model_error(id: &str, source: ModelError) -> EstimatorError {
    EstimatorError::Model {
        hypothesis: id.to_owned(),
        source,
    }
}
