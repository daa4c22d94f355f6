//! What can go wrong when forces are compared with hypotheses, with the numbers inside.

use terra_model::ModelError;

/// Error of a hypothesis set, an estimator, a fit or their options.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// A set without hypotheses.
    #[error("the hypothesis set is empty")]
    EmptySet,
    /// Two hypotheses of one name.
    #[error("the hypothesis id '{id}' occurs twice")]
    DuplicateId {
        /// The id.
        id: String,
    },
    /// The terrain model refused, and not because the soil is too soft.
    #[error("hypothesis '{hypothesis}': {source}")]
    Model {
        /// Id of the hypothesis.
        hypothesis: String,
        /// The model's reason.
        source: ModelError,
    },
    /// A name or a composition the model crate refused.
    #[error(transparent)]
    Name(#[from] ModelError),
    /// A number that is not finite or lies outside its legal range.
    #[error("{what} = {value}, expected {expected}")]
    Value {
        /// Name of the quantity.
        what: String,
        /// Its value.
        value: f64,
        /// What would be legal.
        expected: &'static str,
    },
    /// A vector or matrix of the wrong size.
    #[error("{what} has size {found}, expected {expected}")]
    Size {
        /// Name of the quantity.
        what: &'static str,
        /// Size given.
        found: usize,
        /// Size needed.
        expected: usize,
    },
    /// An observation that does not have the form the estimator asks for.
    #[error("observation at time {time}: {reason}")]
    Observation {
        /// Time of the observation \[s\].
        time: f64,
        /// What is wrong.
        reason: String,
    },
    /// Time ran backwards inside a group, or stood still.
    #[error("time {time} does not come after {previous} in the same group")]
    TimeOrder {
        /// Time of the observation \[s\].
        time: f64,
        /// Time of the one before \[s\].
        previous: f64,
    },
    /// A residual covariance that is not positive definite.
    #[error(
        "hypothesis '{hypothesis}', time {time}: the residual covariance is not positive definite"
    )]
    NotPositiveDefinite {
        /// Id of the hypothesis.
        hypothesis: String,
        /// Time of the observation \[s\].
        time: f64,
    },
    /// An observed sinkage and a model without sinkage.
    #[error("hypothesis '{hypothesis}': sinkage is observed, but model {model} predicts none")]
    NoSinkage {
        /// Id of the hypothesis.
        hypothesis: String,
        /// Name of the law.
        model: String,
    },
    /// No hypothesis can carry the wheel.
    #[error("time {time}: none of the {hypotheses} hypotheses can carry the load")]
    AllInfeasible {
        /// Time of the observation \[s\].
        time: f64,
        /// Number of hypotheses.
        hypotheses: usize,
    },
    /// Every hypothesis has likelihood zero.
    #[error("every hypothesis has likelihood zero")]
    Impossible,
    /// An option the estimator cannot honour exactly.
    #[error("estimator '{estimator}' cannot honour the choice '{choice}': {reason}")]
    NotSupported {
        /// Name of the estimator.
        estimator: &'static str,
        /// The choice or law.
        choice: String,
        /// Why.
        reason: &'static str,
    },
    /// A contact outside the box over which forces were tabulated.
    #[error("{quantity} = {value} lies outside the table [{min}, {max}]")]
    OutsideTable {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Lower end of the table.
        min: f64,
        /// Upper end of the table.
        max: f64,
    },
    /// A parameter to fit whose start is zero and whose absolute prior spread is unknown.
    #[error("'{parameter}' starts at 0 and has no prior_abs_sd")]
    NoPrior {
        /// Name of the parameter.
        parameter: String,
    },
    /// A fit without data.
    #[error("no observations to fit")]
    NoObservations,
    /// A decomposition that failed.
    #[error("{what} failed")]
    Decomposition {
        /// Name of the decomposition.
        what: &'static str,
    },
}
