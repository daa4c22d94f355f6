//! Soils for other simulators, and what is weighed.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use terra_model::{ForceLaw, Registry};

use super::Source;
use crate::commands::lists::terrain_json;
use crate::commands::{export as exporting, import as importing};
use crate::error::CliError;
use crate::identify::hypotheses as weighed;
use crate::output;

/// A soil to export.
#[derive(Clone, Debug)]
pub enum Soil {
    /// An id of the catalogues, or the path of what `terra identify --json` wrote.
    Named(String),
    /// What [`identify`](super::identify) gave.
    Identified(Value),
}

/// Where an exported soil is looked up.
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    /// A file with soils of one's own.
    pub catalogue: Option<PathBuf>,
    /// Group of the identification, where it has several.
    pub group: Option<String>,
}

impl Soil {
    fn asked<'a>(&'a self, options: &'a ExportOptions) -> exporting::Asked<'a> {
        let (soil, identified) = match self {
            Soil::Named(name) => (name.as_str(), None),
            Soil::Identified(json) => ("the identification", Some(json)),
        };
        exporting::Asked {
            soil,
            identified,
            catalogue: options.catalogue.as_deref(),
            group: options.group.as_deref(),
        }
    }
}

/// `terra export scm-json`: a soil for Chrono's soil contact model.
///
/// # Errors
/// As the command.
pub fn scm_json(soil: &Soil, options: &ExportOptions) -> Result<Value, CliError> {
    exporting::scm(&soil.asked(options))
}

/// The wheel of a slip compliance, and how the line is fitted; the defaults are the command's.
#[derive(Clone, Debug)]
pub struct ComplianceOptions {
    /// Wheel radius \[m\].
    pub radius: f64,
    /// Wheel width \[m\].
    pub width: f64,
    /// Terrain model.
    pub model: String,
    /// Parameters in place of the soil's own, SI.
    pub values: Vec<(String, f64)>,
    /// How far the line may be from the law, as a share of the largest traction on its range.
    pub tolerance: f64,
}

/// The table of `terra export slip-compliance`, as CSV, at these loads \[N\].
///
/// # Errors
/// As the command.
pub fn slip_compliance(
    soil: &Soil,
    loads: &[f64],
    wheel: &ComplianceOptions,
    options: &ExportOptions,
) -> Result<Vec<u8>, CliError> {
    if loads.is_empty() {
        return Err(CliError::usage(
            "no loads",
            "name at least one normal load in N",
        ));
    }
    let values: Vec<(&str, f64)> = wheel.values.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    let wheel = exporting::Wheel {
        radius: wheel.radius,
        width: wheel.width,
        loads,
        model: &wheel.model,
        values: &values,
        tolerance: wheel.tolerance,
    };
    exporting::compliance(&soil.asked(options), &wheel)
}

/// `terra import scm-json`: the soil of Chrono's JSON, as [`terrains`](super::terrains) gives soils; writes a catalogue with
/// it, where one is asked for.
///
/// # Errors
/// As the command.
pub fn import_scm_json(source: &Path, catalogue: Option<&Path>) -> Result<Value, CliError> {
    output::claim(&[catalogue], &[source])?;
    Ok(terrain_json(&importing::soil(source, catalogue)?))
}

/// What [`identify`](super::identify) weighs: the hypotheses of the rover file, or of the set, file or plan that is named
/// in their place, each with its law and parameters.
///
/// # Errors
/// As `terra identify --hypotheses`.
pub fn hypotheses(
    rover: &Source,
    registry: &Registry,
    named: Option<&str>,
) -> Result<Value, CliError> {
    let (nominal, _) = rover.rover(registry)?;
    let set = weighed(&nominal, registry, rover.folder(), named)?;
    let all = set.hypotheses().iter().map(|h| {
        let names = h.law.params().iter().map(|p| p.name.to_owned());
        let values = h.parameters.iter().map(|v| json!(v));
        json!({
            "id": h.id,
            "model": h.law.name(),
            "parameters": names.zip(values).collect::<Map<String, Value>>(),
        })
    });
    Ok(Value::Array(all.collect()))
}

/// `terra cite --json`: the references owed for what a scenario or a rover file uses.
///
/// # Errors
/// As the command.
pub fn cite(file: &Path) -> Result<Value, CliError> {
    crate::commands::cite::as_json(file)
}
