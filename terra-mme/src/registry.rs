//! Estimators by name.

use terra_model::{Contact, ModelError, nearest};

use crate::adaptive::{Adaptation, AdaptiveModel};
use crate::bank::{InnovationBank, MotionSample, Plant, SideBank, SoilMaps};
use crate::batch::{Batch, BatchMethod, EnsembleOptions, LeastSquaresOptions};
use crate::choice::Choice;
use crate::consistency::AlarmRule;
use crate::error::EstimatorError;
use crate::estimator::ParameterEstimator;
use crate::force_table::TableBox;
use crate::fused::FusedModel;
use crate::hypothesis::HypothesisSet;
use crate::multiple_model::MultipleModel;
use crate::prior::Priors;
use crate::sufficient::SufficientStatistics;
use crate::whiten::Prewhitening;

/// What an estimator weighs hypotheses by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorInput {
    /// [`ForceObservation`](crate::ForceObservation)s of a force filter or a rig.
    Forces,
    /// [`MotionSample`](crate::MotionSample)s straight from a drive log.
    Motion,
}

/// What an estimator is, for lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EstimatorInfo {
    /// Kebab-case name.
    pub name: &'static str,
    /// One line: what it does.
    pub summary: &'static str,
    /// Source.
    pub reference: &'static str,
    /// What it is fed: [`estimator`] builds those of forces, [`motion_estimator`] those of motion.
    pub input: EstimatorInput,
}

/// Options common to all estimators.
#[derive(Clone, Debug)]
pub struct EstimatorOptions {
    /// What happens to old evidence.
    pub choice: Choice,
    /// Correlation from sample to sample; none for independent rows.
    pub whitening: Option<Prewhitening>,
    /// Relative error of every predicted wheel force; not for sufficient statistics.
    pub table_error: f64,
    /// When the alarm is raised.
    pub alarm: AlarmRule,
    /// Keep the posterior after each sample.
    pub history: bool,
    /// Slips and loads to tabulate, for sufficient statistics only.
    pub table: TableBox,
    /// Wheel to tabulate, for sufficient statistics only.
    pub template: Contact<f64>,
    /// Prior of the parameters, for estimators that fit them.
    pub priors: Priors,
    /// Seed, for estimators that draw.
    pub seed: u64,
}

impl EstimatorOptions {
    /// Choice `none`, independent samples, default alarm, no history, driving slips and loads from a third to three
    /// times that of the template.
    pub fn new(template: Contact<f64>) -> Self {
        let load = template.normal_load;
        EstimatorOptions {
            choice: Choice::None,
            whitening: None,
            table_error: 0.0,
            alarm: AlarmRule::default(),
            history: false,
            table: TableBox {
                slip: (0.0, 1.0),
                load: (load / 3.0, load * 3.0),
                nodes: (16, 6),
            },
            template,
            priors: Priors::default(),
            seed: 1,
        }
    }
}

/// Nodes of the grid of the fused estimator: forces within 1e-4 of the law's over the default box.
const FUSED_NODES: (usize, usize) = (48, 12);
const MAGILL: &str = "D. T. Magill, IEEE Trans. Automatic Control 10(4):434-439, 1965";
const BLOM: &str =
    "H. A. P. Blom, Y. Bar-Shalom, IEEE Trans. Automatic Control 33(8):780-783, 1988";
const LI: &str = "X. R. Li, Y. Bar-Shalom, IEEE Trans. Automatic Control 41(4):478-493, 1996";
const GOODMAN: &str =
    "J. Goodman, J. Weare, Comm. Applied Mathematics and Computational Science 5(1):65-80, 2010";
const RAY: &str = "L. E. Ray, Proc. SPIE, 2008";

const ESTIMATORS: &[EstimatorInfo] = &[
    EstimatorInfo {
        name: "side-sum",
        summary: "multiple models on the sum of a side's pulls and each wheel's torque; any map of wheel forces",
        reference: MAGILL,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "wheel",
        summary: "multiple models on the forces of single wheels (rigs)",
        reference: MAGILL,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "proportional-split",
        summary: "multiple models on a side's force split by load; biased, kept for comparison",
        reference: RAY,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "sufficient-statistics",
        summary: "multiple models in sums whose cost per sample does not grow with the number of hypotheses",
        reference: MAGILL,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "fused",
        summary: "multiple models in single precision, all hypotheses in one pass; for very many of them",
        reference: MAGILL,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "adaptive",
        summary: "multiple models that add perturbed copies of the winner and drop the dead, evidence kept exact",
        reference: LI,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "least-squares",
        summary: "bounded fits of the parameters from the best hypotheses, at the end of the log",
        reference: RAY,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "ensemble",
        summary: "draws from the posterior of the winner's parameters by affine-invariant walkers, at the end of the log",
        reference: GOODMAN,
        input: EstimatorInput::Forces,
    },
    EstimatorInfo {
        name: "innovation-bank",
        summary: "one vehicle filter a soil, weighed by its innovations from the first sample; needs no ground speed",
        reference: MAGILL,
        input: EstimatorInput::Motion,
    },
    EstimatorInfo {
        name: "imm",
        summary: "the bank with mixing of states, for ground that changes under way",
        reference: BLOM,
        input: EstimatorInput::Motion,
    },
];

/// All estimators of this crate.
pub fn estimators() -> &'static [EstimatorInfo] {
    ESTIMATORS
}

/// An estimator by name.
///
/// # Errors
/// [`EstimatorError::Name`] with the nearest name; what its constructor refuses.
pub fn estimator(
    name: &str,
    set: HypothesisSet,
    options: &EstimatorOptions,
) -> Result<Box<dyn ParameterEstimator>, EstimatorError> {
    let models = |models: MultipleModel, history: bool| -> Result<MultipleModel, EstimatorError> {
        let models = models
            .with_choice(options.choice.clone())?
            .with_prewhitening(options.whitening)
            .with_table_error(options.table_error)?
            .with_alarm(options.alarm)?;
        Ok(if history {
            models.with_history()
        } else {
            models
        })
    };
    let batch = |set, method| -> Result<Box<dyn ParameterEstimator>, EstimatorError> {
        let models = models(MultipleModel::new(set)?, options.history)?;
        Ok(Box::new(Batch::new(
            models,
            options.priors.clone(),
            method,
        )?))
    };
    match name {
        "side-sum" => Ok(Box::new(models(MultipleModel::new(set)?, options.history)?)),
        "wheel" => Ok(Box::new(models(
            MultipleModel::wheel(set)?,
            options.history,
        )?)),
        "proportional-split" => {
            let split = MultipleModel::proportional_split(set)?;
            Ok(Box::new(models(split, options.history)?))
        }
        "fused" if options.choice != Choice::None || options.table_error > 0.0 => {
            Err(EstimatorError::NotSupported {
                estimator: "fused",
                choice: options.choice.to_string(),
                reason: "one covariance for all hypotheses and all evidence kept: only none, without table error",
            })
        }
        "fused" => {
            let range = TableBox {
                nodes: FUSED_NODES,
                ..options.table
            };
            let fused = FusedModel::new(set, range, &options.template)?
                .with_prewhitening(options.whitening)
                .with_alarm(options.alarm)?;
            Ok(Box::new(if options.history {
                fused.with_history()
            } else {
                fused
            }))
        }
        "adaptive" => {
            let how = Adaptation {
                seed: options.seed,
                ..Adaptation::default()
            };
            let adaptive = AdaptiveModel::new(models(MultipleModel::new(set)?, false)?, how)?;
            Ok(Box::new(if options.history {
                adaptive.with_history()
            } else {
                adaptive
            }))
        }
        "least-squares" => {
            let fits = LeastSquaresOptions {
                whitening: options.whitening,
                ..LeastSquaresOptions::default()
            };
            batch(set, BatchMethod::LeastSquares(fits))
        }
        "ensemble" => {
            let draws = EnsembleOptions {
                whitening: options.whitening,
                seed: options.seed,
                ..EnsembleOptions::default()
            };
            batch(set, BatchMethod::Ensemble(draws))
        }
        "sufficient-statistics" if options.table_error > 0.0 => Err(EstimatorError::NotSupported {
            estimator: "sufficient-statistics",
            choice: format!("table error {}", options.table_error),
            reason: "a table error differs from hypothesis to hypothesis, the covariance must not",
        }),
        "sufficient-statistics" => {
            let sums = SufficientStatistics::new(set, options.table, &options.template)?
                .with_choice(options.choice.clone())?
                .with_prewhitening(options.whitening)
                .with_alarm(options.alarm)?;
            Ok(Box::new(if options.history {
                sums.with_history()
            } else {
                sums
            }))
        }
        _ => Err(refused(name, EstimatorInput::Forces)),
    }
}

/// An estimator of motion by name, with one soil under all wheels.
///
/// # Errors
/// [`EstimatorError::Name`] with the nearest name; [`EstimatorError::NotSupported`] for an estimator of forces and for
/// a choice it cannot honour.
pub fn motion_estimator(
    name: &str,
    maps: SoilMaps,
    plant: Plant,
    choice: &Choice,
    history: bool,
) -> Result<Box<dyn ParameterEstimator<MotionSample>>, EstimatorError> {
    let mixing = motion_mixing(name)?;
    let bank = InnovationBank::new(maps, plant)?;
    let bank = if mixing { bank.with_mixing() } else { bank };
    let bank = bank.with_choice(choice.clone())?;
    Ok(Box::new(if history { bank.with_history() } else { bank }))
}

/// As [`motion_estimator`], with a soil of its own under each side.
///
/// # Errors
/// As there.
pub fn side_bank(
    name: &str,
    maps: SoilMaps,
    plant: Plant,
    choice: &Choice,
    history: bool,
) -> Result<SideBank, EstimatorError> {
    let mixing = motion_mixing(name)?;
    let bank = SideBank::new(maps, plant)?;
    let bank = if mixing { bank.with_mixing() } else { bank };
    let bank = bank.with_choice(choice.clone())?;
    Ok(if history { bank.with_history() } else { bank })
}

/// Whether the estimator of motion of this name mixes states.
fn motion_mixing(name: &str) -> Result<bool, EstimatorError> {
    match name {
        "innovation-bank" => Ok(false),
        "imm" => Ok(true),
        _ => Err(refused(name, EstimatorInput::Motion)),
    }
}

/// Why no estimator of that name is fed with `wanted`.
fn refused(name: &str, wanted: EstimatorInput) -> EstimatorError {
    match ESTIMATORS.iter().find(|e| e.name == name) {
        Some(other) => EstimatorError::NotSupported {
            estimator: other.name,
            choice: match wanted {
                EstimatorInput::Forces => "force observations".to_owned(),
                EstimatorInput::Motion => "motion samples".to_owned(),
            },
            reason: match other.input {
                EstimatorInput::Forces => "it weighs forces: of a force filter, or of a rig",
                EstimatorInput::Motion => "it weighs a drive log as it is: torques and motion",
            },
        },
        None => ModelError::UnknownName {
            kind: "estimator",
            name: name.to_owned(),
            nearest: nearest(name, ESTIMATORS.iter().map(|e| e.name)).map(str::to_owned),
        }
        .into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bank::MotionNoise;
    use std::sync::Arc;
    use terra_model::{Registry, Vehicle};

    #[test]
    fn every_listed_name_builds_and_a_slip_of_the_pen_is_helped() {
        let law = Arc::new(Registry::builtin().law("wong-reece").unwrap());
        let options = EstimatorOptions::new(Contact::new(0.2, 245.25, 0.254, 0.15));
        let car = Vehicle {
            mass: 100.0,
            yaw_inertia: 10.0,
            track: 0.6,
            wheelbase: 0.6,
            cg_to_front_axle: 0.3,
            cg_height: 0.22,
            yaw_damping: 8.0,
            wheel_radius: 0.254,
            wheel_width: 0.15,
            wheel_inertia: 0.25,
            wheel_damping: 0.1,
            pitch: 0.0,
        };
        let plant = Plant::new(car, MotionNoise::default()).unwrap();
        for info in estimators() {
            let set = HypothesisSet::from_catalogue(&law, "wong21").unwrap();
            if info.input == EstimatorInput::Motion {
                assert!(estimator(info.name, set.clone(), &options).is_err());
                let maps = SoilMaps::new(set, &car).unwrap();
                let bank = motion_estimator(info.name, maps, plant, &Choice::None, true).unwrap();
                assert_eq!(bank.name(), info.name);
                continue;
            }
            assert_eq!(
                estimator(info.name, set, &options).unwrap().name(),
                info.name
            );
        }
        let set = HypothesisSet::from_catalogue(&law, "wong21").unwrap();
        let Err(error) = estimator("side_sums", set, &options) else {
            panic!("accepted")
        };
        assert!(
            error.to_string().contains("did you mean 'side-sum'"),
            "{error}"
        );
    }
}
