//! Which soil is it? Bayesian sets of hypotheses over any mix of terrain models.
//!
//! A [`HypothesisSet`] lists candidate soils, each with its own law. A [`ForceObservation`] is what a log shows: forces
//! as a linear map of wheel forces, with slips, loads and one joint covariance. A [`ParameterEstimator`] weighs the
//! first by the second; [`MultipleModel`] does it hypothesis by hypothesis, [`SufficientStatistics`] in sums, and
//! [`estimator`] finds either by name. An [`InnovationBank`] needs no forces: it runs one vehicle filter a soil on the log
//! itself ([`MotionSample`]) and weighs their innovations. The result is a posterior, a mixture of forces ([`mixture`]) and a
//! [`Consistency`] that says whether the winner explains the forces at all. [`refine`] then fits the winner's
//! parameters in a [`FitSpace`] and says by name what the data cannot tell ([`Identifiability`]).
//!
//! ```
//! use std::sync::Arc;
//! use terra_mme::{ForceObservation, HypothesisSet, MultipleModel, ParameterEstimator, Weighed};
//! use terra_model::{Contact, Registry};
//!
//! let law = Arc::new(Registry::builtin().law("wong-reece").expect("a built-in law"));
//! let mut soils = MultipleModel::wheel(HypothesisSet::from_catalogue(&law, "wong21")?)?;
//! // Drawbar pull, torque and sinkage of one wheel at 20 % slip; 1-sigma of the three, of slip and of load.
//! let row = [Some(8.3), Some(16.7), Some(0.029)];
//! let at = Contact::new(0.2, 245.25, 0.254, 0.15);
//! soils.update(&ForceObservation::wheel(0.0, 0, row, at, &[0.5, 0.1, 0.003, 0.005, 0.5])?)?;
//! assert_eq!(soils.map().id, "dry_sand");
//! # Ok::<(), terra_mme::EstimatorError>(())
//! ```
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod adaptive;
mod bank;
mod batch;
mod belief;
mod choice;
mod consistency;
mod design;
mod error;
mod estimator;
mod fit_space;
mod force_table;
mod fused;
mod hypothesis;
mod identifiability;
mod linearise;
mod log_prob;
mod multiple_model;
mod observation;
mod posterior;
mod prediction;
mod prior;
mod profile;
mod random;
mod refine;
mod registry;
mod residual;
mod scan;
mod sets;
mod split_load;
mod sufficient;
mod update;
mod whiten;

pub use adaptive::{Adaptation, AdaptiveModel};
pub use bank::{
    AT_ACCEL, AT_SPEED, AT_WHEELS, AT_YAW, InnovationBank, MOTION_CHANNELS, Marginal, MotionNoise,
    MotionSample, OFFERED_GAIN, Plant, SYSTEMATIC, SideBank, SoilMaps, SystematicCandidate,
    systematic,
};
pub use batch::{
    Batch, BatchMethod, Ensemble, EnsembleOptions, LeastSquaresOptions, LocalFit, ensemble,
    least_squares,
};
pub use belief::{ParameterBelief, StructureBelief};
pub use choice::Choice;
pub use consistency::{AlarmRule, Consistency};
pub use design::{Design, DesignNoise, FurtherRow, separating_rows, separation};
pub use error::EstimatorError;
pub use estimator::{
    History, HypothesisPosterior, INFEASIBLE_LOG_LIKELIHOOD, KNOWN_TO_NATS, ParameterEstimator,
    Weighed,
};
pub use fit_space::FitSpace;
pub use force_table::{ForceTable, TableBox};
pub use fused::{FusedModel, GridTable, HeldCovariance};
pub use hypothesis::{Hypothesis, HypothesisSet, NearDuplicate};
pub use identifiability::{Direction, Identifiability, WEAK, identifiability};
pub use log_prob::{LogProb, log_sum_exp};
pub use multiple_model::MultipleModel;
pub use observation::ForceObservation;
pub use posterior::Posterior;
pub use prediction::{ForcePrediction, PredictionStatus, Spread, contact_grid, mixture};
pub use prior::{Centre, Priors};
pub use profile::{Profile, profiles};
pub use refine::{FittedParameter, RefineOptions, Refinement, refine};
pub use registry::{
    EstimatorInfo, EstimatorInput, EstimatorOptions, estimator, estimators, motion_estimator,
    side_bank,
};
pub use residual::{Comparison, Residual, Scored, compare, score};
pub use sets::{Axis, MOST_HYPOTHESES};
pub use split_load::proportional_split;
pub use sufficient::SufficientStatistics;
pub use update::{bayes_step, weighted_means};
pub use whiten::Prewhitening;
