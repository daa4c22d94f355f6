//! What can go wrong in a filter, with the numbers inside.

use terra_model::ModelError;

/// Error of a state space, a filter, a smoother or the log driver.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// A name nobody registered.
    #[error("unknown {kind} '{name}'{}", nearest.as_ref().map(|n| format!(", did you mean '{n}'?")).unwrap_or_default())]
    UnknownName {
        /// filter, state space, ...
        kind: &'static str,
        /// The name.
        name: String,
        /// The closest known one.
        nearest: Option<String>,
    },
    /// A number of the configuration outside its legal range.
    #[error("{key} = {value}, expected {expected}")]
    Config {
        /// Which number.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What would be legal.
        expected: &'static str,
    },
    /// A vector or matrix of the wrong size.
    #[error("{what} has size {found}, expected {expected}")]
    Size {
        /// Which one.
        what: &'static str,
        /// Size needed.
        expected: usize,
        /// Size given.
        found: usize,
    },
    /// A filter that needs a linear state space was given another.
    #[error("filter {filter} needs a linear time-invariant state space, which {space} is not")]
    NotLinear {
        /// Filter.
        filter: &'static str,
        /// State space.
        space: &'static str,
    },
    /// A state space whose independent groups are too large to lie side by side.
    #[error(
        "filter lanes needs groups of at most 3 states and 2 channels with independent noise; {space} has one of {states} states and {channels} channels"
    )]
    NoLanes {
        /// State space.
        space: &'static str,
        /// States of its largest group.
        states: usize,
        /// Channels of its best seen group.
        channels: usize,
    },
    /// A time step that is zero, negative or not finite.
    #[error("time step {dt} s at t = {time} s, expected a positive one")]
    TimeStep {
        /// Step \[s\].
        dt: f64,
        /// Time since the filter began, or of the log \[s\].
        time: f64,
    },
    /// A number that is not finite went in or would have come out.
    #[error("{what} is not finite (element {index})")]
    NotFinite {
        /// Which vector or matrix.
        what: &'static str,
        /// Which element.
        index: usize,
    },
    /// A covariance that is not symmetric and positive semi-definite.
    #[error("{what} is not a covariance: {reason} ({value})")]
    NotACovariance {
        /// Which matrix.
        what: &'static str,
        /// What is wrong.
        reason: &'static str,
        /// The offending number.
        value: f64,
    },
    /// An innovation covariance without inverse: neither the prior nor the sensor has any noise in this channel.
    #[error("the innovation covariance is singular in channel {channel}")]
    SingularInnovation {
        /// Channel.
        channel: String,
    },
    /// Scalar-sequential updates need independent channels.
    #[error(
        "scalar-sequential updates need a diagonal measurement noise; channels {first} and {second} are correlated"
    )]
    CorrelatedNoise {
        /// One channel.
        first: String,
        /// The other.
        second: String,
    },
    /// An iteration that did not settle.
    #[error("{what} did not settle within {iterations} iterations (last step {step})")]
    NotConverged {
        /// What was iterated.
        what: &'static str,
        /// Iterations made.
        iterations: usize,
        /// Length of the last step in prior standard deviations.
        step: f64,
    },
    /// A sample so far from its prediction that its square overflows, in a filter that rejects nothing.
    #[error(
        "{channel} reads {value}, {deviations:e} standard deviations from its prediction: no filter without robust update can use it"
    )]
    Implausible {
        /// Channel.
        channel: String,
        /// Reading, unit of z.
        value: f64,
        /// |ν| over its standard deviation.
        deviations: f64,
    },
    /// What went wrong at one row of a log.
    #[error("row {row}, t = {time} s: {source}")]
    AtRow {
        /// Row, counted from 0.
        row: usize,
        /// Time \[s\].
        time: f64,
        /// What it was.
        source: Box<FilterError>,
    },
    /// A channel that a log must have.
    #[error("the log has no {channel}; {advice}")]
    MissingChannel {
        /// Channel.
        channel: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// Rows of a segment that the log does not have, or that overlap.
    #[error("segment {segment} covers rows {start}..{end} of a log of {rows} rows")]
    Segment {
        /// Number of the segment.
        segment: usize,
        /// First row.
        start: usize,
        /// One past its last row.
        end: usize,
        /// Rows in the log.
        rows: usize,
    },
    /// The second pass over a log met more rows than the first.
    #[error(
        "segment {segment} has more rows than in the first pass over the log: it must not change between the two"
    )]
    FirstPass {
        /// Number of the segment, counted from 0.
        segment: usize,
    },
    /// A terrain model inside a state space failed.
    #[error(transparent)]
    Model(#[from] ModelError),
}
