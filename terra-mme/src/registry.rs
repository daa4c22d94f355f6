//! Estimators by name.

use terra_model::{Contact, ModelError, nearest};

use crate::choice::Choice;
use crate::consistency::AlarmRule;
use crate::error::EstimatorError;
use crate::estimator::ParameterEstimator;
use crate::force_table::TableBox;
use crate::hypothesis::HypothesisSet;
use crate::multiple_model::MultipleModel;
use crate::sufficient::SufficientStatistics;
use crate::whiten::Prewhitening;

/// What an estimator is, for lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EstimatorInfo {
    /// Kebab-case name.
    pub name: &'static str,
    /// One line: what it does.
    pub summary: &'static str,
    /// Source.
    pub reference: &'static str,
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
        }
    }
}

const MAGILL: &str = "D. T. Magill, IEEE Trans. Automatic Control 10(4):434-439, 1965";
const RAY: &str = "L. E. Ray, Proc. SPIE, 2008";

const ESTIMATORS: &[EstimatorInfo] = &[
    EstimatorInfo {
        name: "side-sum",
        summary: "multiple models on the sum of a side's pulls and each wheel's torque; any map of wheel forces",
        reference: MAGILL,
    },
    EstimatorInfo {
        name: "wheel",
        summary: "multiple models on the forces of single wheels (rigs)",
        reference: MAGILL,
    },
    EstimatorInfo {
        name: "proportional-split",
        summary: "multiple models on a side's force split by load; biased, kept for comparison",
        reference: RAY,
    },
    EstimatorInfo {
        name: "sufficient-statistics",
        summary: "multiple models in sums whose cost per sample does not grow with the number of hypotheses",
        reference: MAGILL,
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
    let models = |models: MultipleModel| -> Result<Box<dyn ParameterEstimator>, EstimatorError> {
        let models = models
            .with_choice(options.choice.clone())?
            .with_prewhitening(options.whitening)
            .with_table_error(options.table_error)?
            .with_alarm(options.alarm)?;
        Ok(Box::new(if options.history {
            models.with_history()
        } else {
            models
        }))
    };
    match name {
        "side-sum" => models(MultipleModel::new(set)?),
        "wheel" => models(MultipleModel::wheel(set)?),
        "proportional-split" => models(MultipleModel::proportional_split(set)?),
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
        _ => Err(ModelError::UnknownName {
            kind: "estimator",
            name: name.to_owned(),
            nearest: nearest(name, ESTIMATORS.iter().map(|e| e.name)).map(str::to_owned),
        }
        .into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use terra_model::Registry;

    #[test]
    fn every_listed_name_builds_and_a_slip_of_the_pen_is_helped() {
        let law = Arc::new(Registry::builtin().law("wong-reece").unwrap());
        let options = EstimatorOptions::new(Contact::new(0.2, 245.25, 0.254, 0.15));
        for info in estimators() {
            let set = HypothesisSet::from_catalogue(&law, "wong21").unwrap();
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
