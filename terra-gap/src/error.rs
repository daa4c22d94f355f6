//! Why a diagnosis could not be made at all. (What a log cannot *tell* is a verdict, not an error.)

use terra_model::ModelError;

/// Error of a diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum GapError {
    /// A model, effect or soil could not be set up or evaluated.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The soil's fit could not be set up.
    #[error("{0}")]
    Soil(String),
    /// No noise level for a channel that is used.
    #[error("no noise level for '{channel}': add {channel} = ... to [noise] in the rover file{or}")]
    NoiseMissing {
        /// Channel.
        channel: String,
        /// What would do as well.
        or: String,
    },
    /// The log and the rover file do not belong together.
    #[error("{0}")]
    Mismatch(String),
    /// The log to be diagnosed does not hold what was asked of it.
    #[error("{0}")]
    Log(String),
    /// The nominal simulator could not be made like the simulator whose log was given.
    #[error("as the simulator's log: {0}")]
    Simulator(String),
    /// A matrix that must be positive definite is not: an input is degenerate.
    #[error(
        "covariance of '{what}' is not positive definite: its noise is beyond what numbers hold; check its units (N, rad/s, slip as a share) and [noise]"
    )]
    NotPositiveDefinite {
        /// What it belongs to.
        what: String,
    },
    /// The table of frozen calibrations could not be used.
    #[error("frozen calibrations: {0}")]
    Calibration(String),
    /// A manoeuvre that the log has not.
    #[error("the log has no segment '{name}': expected one of {there}")]
    Segment {
        /// What was asked for.
        name: String,
        /// Those it has.
        there: String,
    },
    /// An option outside its legal range.
    #[error("{option} = {value}: expected {expected}")]
    Option {
        /// Option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What would be legal.
        expected: &'static str,
    },
}
