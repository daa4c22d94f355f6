//! What can go wrong in a simulation, with time, wheel and numbers inside.

use terra_data::WHEELS;
use terra_model::ModelError;

/// Name of a wheel in messages.
fn wheel_name(wheel: usize) -> &'static str {
    WHEELS.get(wheel).copied().unwrap_or("?")
}

/// Error of a scenario's text: always with its place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
pub struct ScenarioError {
    /// Name of the file, as given.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What was found and what was expected.
    pub message: String,
}

/// Error of a simulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimError {
    /// The scenario's text.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The scenario file cannot be read.
    #[error("cannot read {file}: {reason}")]
    Unreadable {
        /// File.
        file: String,
        /// The system's reason.
        reason: String,
    },
    /// A model, terrain or effect, outside any instant of the run.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A model error while the vehicle moves.
    #[error("at {time:.4} s, wheel {}: {source}", wheel_name(*wheel))]
    Wheel {
        /// t \[s\].
        time: f64,
        /// Wheel, 0 to 3 for fl, fr, rl, rr.
        wheel: usize,
        /// What the model said.
        source: ModelError,
    },
    /// The soil does not carry a wheel.
    #[error(
        "at {time:.4} s, wheel {}: no equilibrium: the soil carries at most {max_load:.4} N of the {load:.4} N",
        wheel_name(*wheel)
    )]
    NoEquilibrium {
        /// t \[s\].
        time: f64,
        /// Wheel, 0 to 3 for fl, fr, rl, rr.
        wheel: usize,
        /// Normal load \[N\].
        load: f64,
        /// Largest load the soil carries \[N\].
        max_load: f64,
    },
    /// A model error in a rig's trial.
    #[error("trial {trial} (slip {slip}, load {load} N): {source}")]
    Trial {
        /// Number of the grid point, from 1.
        trial: usize,
        /// Library slip \[1\].
        slip: f64,
        /// W \[N\].
        load: f64,
        /// What the model said.
        source: ModelError,
    },
    /// A wheel turns against its motion.
    #[error(
        "at {time:.4} s, wheel {} turns against its motion: rim {rim_speed:.4} m/s, travel {travel_speed:.4} m/s",
        wheel_name(*wheel)
    )]
    AgainstMotion {
        /// t \[s\].
        time: f64,
        /// Wheel, 0 to 3 for fl, fr, rl, rr.
        wheel: usize,
        /// R ω \[m/s\].
        rim_speed: f64,
        /// v of the wheel's centre \[m/s\].
        travel_speed: f64,
    },
    /// A wheel loses the ground.
    #[error("at {time:.4} s, wheel {} lifts: its normal load would be {load:.4} N", wheel_name(*wheel))]
    WheelLift {
        /// t \[s\].
        time: f64,
        /// Wheel, 0 to 3 for fl, fr, rl, rr.
        wheel: usize,
        /// Normal load that balance would ask for \[N\].
        load: f64,
    },
    /// Acceleration and load transfer do not agree on one value.
    #[error(
        "at {time:.4} s: acceleration and load transfer did not settle, {residual:.3e} m/s² apart"
    )]
    LoadTransfer {
        /// t \[s\].
        time: f64,
        /// What is left \[m/s²\].
        residual: f64,
    },
    /// The integrator cannot go on.
    #[error("at {time:.4} s: the step fell to {step:.3e} s without meeting the tolerance")]
    StepTooSmall {
        /// t \[s\].
        time: f64,
        /// Step \[s\].
        step: f64,
    },
    /// A state stopped being a number.
    #[error("at {time:.4} s: the state is no longer finite")]
    NotFinite {
        /// t \[s\].
        time: f64,
    },
    /// The rover has no `[vehicle]`, or the scenario no `[[segment]]`.
    #[error(
        "a drive needs a rover with [vehicle] and at least one [[segment]]: {missing} is missing"
    )]
    NotADrive {
        /// What is missing.
        missing: &'static str,
    },
    /// The scenario has no `[[trial]]`, or the rover is a vehicle.
    #[error("a rig needs a rig.toml without [vehicle] and at least one [[trial]]: {missing}")]
    NotARig {
        /// What is wrong.
        missing: &'static str,
    },
    /// An effect that cannot show on this kind of log.
    #[error("effect {effect} cannot show on a {kind} log")]
    EffectScope {
        /// Effect.
        effect: String,
        /// drive or rig.
        kind: &'static str,
    },
    /// A magnitude outside its legal range, or the wrong number of them.
    #[error("effect {effect}: {parameter} = {value}, expected {min} to {max} {unit}")]
    Magnitude {
        /// Effect.
        effect: String,
        /// Which of its numbers.
        parameter: &'static str,
        /// Value.
        value: f64,
        /// Smallest legal value.
        min: f64,
        /// Largest legal value.
        max: f64,
        /// Unit.
        unit: &'static str,
    },
    /// The wrong number of magnitudes.
    #[error("effect {effect} takes {expected} numbers, got {found}")]
    MagnitudeCount {
        /// Effect.
        effect: String,
        /// Expected.
        expected: usize,
        /// Found.
        found: usize,
    },
    /// A used channel without its standard deviation.
    #[error("[noise] of the rover lacks {key}, which this log needs (or set noise_scale = 0)")]
    MissingNoise {
        /// Key of `[noise]`.
        key: String,
    },
    /// A terrain table that lacks a parameter of the model.
    #[error("terrain table: {model} needs {parameter}")]
    TerrainParameter {
        /// Model.
        model: String,
        /// Parameter.
        parameter: &'static str,
    },
    /// A number of the scenario or the rover that makes no sense.
    #[error("{quantity} = {value}, expected {expected}")]
    Value {
        /// What.
        quantity: String,
        /// Value.
        value: f64,
        /// What would be legal.
        expected: &'static str,
    },
}
