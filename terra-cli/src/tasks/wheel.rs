//! Forces and stresses of one wheel.

use std::path::{Path, PathBuf};

use terra_model::{Law, Registry};

use super::{ReportFiles, claim};
use crate::commands::wheel as wheels;
use crate::error::CliError;

/// `model+effect=magnitude+...` to a law and its magnitudes.
///
/// # Errors
/// [`CliError::Usage`]: an unknown name, an effect without a magnitude, a pair that does not go together.
pub fn law(registry: &Registry, text: &str) -> Result<(Law, Vec<f64>), CliError> {
    wheels::law(registry, text)
}

/// As [`law`], with the parameters of a soil by its id before the magnitudes. The soil is one of the literature or, first,
/// of a file of one's own; `values` \[SI, rad\] take the place of its own or stand in for what it does not give.
///
/// # Errors
/// As [`law`]; an unknown soil; a parameter that neither gives, or a value for one that the model does not have.
pub fn law_on(
    registry: &Registry,
    text: &str,
    terrain: &str,
    catalogue: Option<&Path>,
    values: &[(String, f64)],
) -> Result<(Law, Vec<f64>), CliError> {
    wheels::law_on(registry, text, terrain, catalogue, &borrowed(values))
}

/// What `terra wheel` asks beside soil, wheel, load and slips; the defaults are the command's.
#[derive(Clone, Debug)]
pub struct WheelOptions {
    /// Terrain model, with effects.
    pub model: String,
    /// A file with soils of one's own.
    pub catalogue: Option<PathBuf>,
    /// Parameters in place of the soil's own, SI.
    pub values: Vec<(String, f64)>,
    /// Also the parts of the drawbar pull.
    pub contributions: bool,
    /// Also the stresses along the contact.
    pub stress: bool,
    /// Also what the lugs push during the passage of one.
    pub lugs: bool,
    /// Report to write.
    pub report: ReportFiles,
}

/// The tables of `terra wheel`, as CSV.
#[derive(Clone, Debug)]
pub struct WheelTables {
    /// A row a slip.
    pub forces: String,
    /// A row a slip and an angle, where asked for.
    pub stress: Option<String>,
    /// A row a slip and a moment of a lug's passage, where asked for.
    pub lugs: Option<String>,
}

/// `terra wheel`: the curve of a wheel of `radius` and `width` \[m\] under `load` \[N\] at these slips; writes the report,
/// where one is asked for.
///
/// # Errors
/// As the command.
pub fn wheel(
    terrain: &str,
    slips: &[f64],
    load: f64,
    radius: f64,
    width: f64,
    options: &WheelOptions,
) -> Result<WheelTables, CliError> {
    claim(&options.report, &[options.catalogue.as_deref()])?;
    let found = wheels::tables_of(&wheels::Asked {
        terrain,
        catalogue: options.catalogue.as_deref(),
        model: &options.model,
        values: &borrowed(&options.values),
        radius,
        width,
        load,
        slips,
        contributions: options.contributions,
        stress: options.stress,
        lugs: options.lugs,
        report: &options.report,
    })?;
    Ok(WheelTables {
        forces: found.forces,
        stress: found.stress,
        lugs: found.lugs,
    })
}

fn borrowed(values: &[(String, f64)]) -> Vec<(&str, f64)> {
    values.iter().map(|(n, v)| (n.as_str(), *v)).collect()
}
