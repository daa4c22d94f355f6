//! What can go wrong in a model, with the numbers inside.

use crate::catalogue::Missing;

/// Error of a model, an effect, a registry name or a catalogue.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The soil cannot carry the wheel at any sinkage up to the axle, or it gives way beneath it: a braked wheel may be
    /// carried by less the deeper it sinks, and what lies below that it does not reach at rest.
    #[error(
        "no equilibrium: the soil carries at most {max_load:.4} N of the {load:.4} N on the wheel"
    )]
    NoEquilibrium {
        /// Normal load asked for \[N\].
        load: f64,
        /// Largest load the soil carries as the wheel sinks, up to an entry angle of 90° \[N\].
        max_load: f64,
    },
    /// A parameter of the model outside its legal range.
    #[error("{model}: {parameter} = {value}, expected {expected}")]
    Parameter {
        /// Model or effect.
        model: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What would be legal.
        expected: &'static str,
    },
    /// A quantity of the contact outside its legal range.
    #[error("contact: {quantity} = {value}, expected {expected}")]
    Contact {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What would be legal.
        expected: &'static str,
    },
    /// A parameter vector of the wrong length.
    #[error("{model} takes {expected} parameters, got {found}")]
    ParameterCount {
        /// Model.
        model: String,
        /// Number expected.
        expected: usize,
        /// Number given.
        found: usize,
    },
    /// A query beyond what a force map was built for.
    #[error("outside the map: {quantity} = {value}, the map covers [{low}, {high}]")]
    OutsideMap {
        /// slip or normal_load.
        quantity: &'static str,
        /// What was asked.
        value: f64,
        /// Least value of the map.
        low: f64,
        /// Largest, at this slip.
        high: f64,
    },
    /// A force map that the largest number of nodes does not make exact enough.
    #[error("a force map of these soils and loads reaches {reached:.1e}, not {wanted:.1e}")]
    MapAccuracy {
        /// Largest error of the finest map tried.
        reached: f64,
        /// What was asked for.
        wanted: f64,
    },
    /// Columns of a batch that differ in length.
    #[error("a batch of {expected} slips has a column of {found} values")]
    BatchLength {
        /// Number of slips.
        expected: usize,
        /// Length of the column.
        found: usize,
    },
    /// An effect that acts through a hook the model does not have.
    #[error("effect {effect} needs the hook '{hook}', which model {model} does not have")]
    EffectNotApplicable {
        /// Model.
        model: &'static str,
        /// Effect.
        effect: &'static str,
        /// Missing hook.
        hook: &'static str,
    },
    /// An effect that needs a soil value the model does not know.
    #[error("effect {effect} needs the soil's {quantity}, which model {model} does not know")]
    SoilUnknown {
        /// Model.
        model: &'static str,
        /// Effect.
        effect: &'static str,
        /// Missing quantity.
        quantity: &'static str,
    },
    /// The same form of an effect twice in one law.
    #[error(
        "effect {effect} twice, expected each effect once: name it once, with the magnitude it should have"
    )]
    EffectTwice {
        /// Effect.
        effect: String,
    },
    /// Two effects, or two forms of one, in a place that holds one.
    #[error(
        "effects {first} and {second} both set the {hook}, of which a wheel has one: name one of them"
    )]
    HookTwice {
        /// The one named first.
        first: String,
        /// The other.
        second: String,
        /// The place.
        hook: &'static str,
    },
    /// A name nobody registered.
    #[error("unknown {kind} '{name}'{}", nearest.as_ref().map(|n| format!(", did you mean '{n}'?")).unwrap_or_default())]
    UnknownName {
        /// model, effect, terrain, ...
        kind: &'static str,
        /// The name.
        name: String,
        /// The closest known one.
        nearest: Option<String>,
    },
    /// Slots of a model name that do not go together.
    #[error("model '{name}': {reason}")]
    Combination {
        /// The name.
        name: String,
        /// Why not.
        reason: String,
    },
    /// A catalogue row that lacks a value the model needs.
    #[error("terrain '{terrain}' gives no {parameter}, which model {model} needs: {reason}")]
    MissingValue {
        /// Terrain id.
        terrain: String,
        /// Parameter.
        parameter: &'static str,
        /// Model.
        model: &'static str,
        /// Why there is none.
        reason: Missing,
    },
    /// Forces that no rigid contact can have.
    #[error(
        "|T| = {torque} N m exceeds R hypot(D, W) = {limit} N m: no single resultant has these forces"
    )]
    NotAResultant {
        /// Torque \[N m\].
        torque: f64,
        /// Its limit \[N m\].
        limit: f64,
    },
    /// A bevameter test that cannot be fitted.
    #[error("test '{test}': {what} = {found}, expected {expected}")]
    Curve {
        /// Name of the test.
        test: String,
        /// What is wrong with it.
        what: &'static str,
        /// What was found.
        found: f64,
        /// What would do.
        expected: &'static str,
    },
    /// The iteration for the entry angle did not settle.
    #[error(
        "sinkage iteration did not settle within {iterations} steps (load {load} N, slip {slip})"
    )]
    NotConverged {
        /// Steps taken.
        iterations: usize,
        /// Normal load \[N\].
        load: f64,
        /// Slip.
        slip: f64,
    },
}
