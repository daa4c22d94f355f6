//! How often the answer is right, on many runs with known truth.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::within;
use crate::args::CampaignCases;
use crate::campaign::faults::faults;
use crate::campaign::{ramps, reproduction};
use crate::challenge::DESIGNS;
use crate::commands::{campaign as counting, campaign_cross, campaign_gap as sealed};
use crate::error::CliError;
use crate::progress::{Stop, Watch};

/// The tables of [`campaign_reproduction`].
const TABLES: [&str; 4] = ["exact", "switch", "perturbed", "mismatch"];

/// `terra campaign ramps --json`: `runs` noise draws (1 to 1 000 000) on each soil.
///
/// # Errors
/// As the command.
pub fn campaign_ramps(
    terrains: &[String],
    runs: usize,
    seed: u64,
    stop: &Stop,
) -> Result<Value, CliError> {
    within("runs", runs, 1, 1_000_000)?;
    let names: Vec<&str> = terrains.iter().map(String::as_str).collect();
    let rows = ramps(&names, runs, seed, counting::RAMP, stop)?;
    Ok(counting::ramps_json(runs, seed, &rows))
}

/// `terra campaign faults --json`: at least `runs` runs (1 to 10 000 000) with a fault.
///
/// # Errors
/// As the command.
pub fn campaign_faults(
    runs: usize,
    seed: u64,
    filter: &str,
    stop: &Stop,
) -> Result<Value, CliError> {
    within("runs", runs, 1, 10_000_000)?;
    let report = faults(runs, seed, filter, stop)?;
    Ok(counting::faults_json(filter, seed, &report))
}

/// `terra campaign reproduction --json`: the published figures beside those of this build, `runs` noise draws (1 to
/// 1 000 000) a case.
///
/// # Errors
/// As the command; an unknown table.
pub fn campaign_reproduction(
    runs: usize,
    seed: u64,
    tables: &[String],
    stop: &Stop,
) -> Result<Value, CliError> {
    within("runs", runs, 1, 1_000_000)?;
    among("table", tables, &TABLES)?;
    let figures = reproduction(runs, seed, tables, stop)?;
    Ok(counting::reproduction_json(runs, seed, &figures))
}

/// The sealed cases of a campaign.
#[derive(Clone, Debug)]
pub struct Cases {
    /// Designs, as [`DESIGNS`].
    pub designs: Vec<String>,
    /// Cases of each, 1 to 100 000.
    pub cases: usize,
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Folder for logs, keys and verdicts; what is there already is kept.
    pub out: PathBuf,
}

impl Cases {
    fn asked(&self) -> Result<CampaignCases, CliError> {
        within("cases", self.cases, 1, 100_000)?;
        among("design", &self.designs, &DESIGNS)?;
        Ok(CampaignCases {
            designs: self.designs.clone(),
            cases: u32::try_from(self.cases).unwrap_or(u32::MAX),
            seed: self.seed,
            out: self.out.clone(),
        })
    }
}

/// `terra campaign gap --json`: sealed cases made, diagnosed and marked.
///
/// # Errors
/// As the command.
pub fn campaign_gap(cases: &Cases, left_out: bool, stop: &Stop) -> Result<Value, CliError> {
    let watch = Watch::silent(stop);
    sealed::marked(&cases.asked()?, left_out, &mut |_| Ok(()), &watch)
}

/// `terra campaign gap-calibration`: what the `calibration.toml` that it writes holds. `nulls`: cases of each design without any
/// effect beside these, 0 to 100 000.
///
/// # Errors
/// As the command.
pub fn campaign_gap_calibration(
    cases: &Cases,
    nulls: usize,
    stop: &Stop,
) -> Result<String, CliError> {
    within("nulls", nulls, 0, 100_000)?;
    let nulls = u32::try_from(nulls).unwrap_or(u32::MAX);
    let watch = Watch::silent(stop);
    sealed::learned(&cases.asked()?, nulls, &mut |_| Ok(()), &watch)
}

/// `terra campaign cross-structure --json`: 1 to 100 000 cases in a folder, where those that are there already are kept.
///
/// # Errors
/// As the command.
pub fn campaign_cross_structure(
    design: &str,
    cases: usize,
    seed: u64,
    out: &Path,
    stop: &Stop,
) -> Result<Value, CliError> {
    within("cases", cases, 1, 100_000)?;
    among("design", &[design.to_owned()], &DESIGNS)?;
    let rows = campaign_cross::marked(design, cases, seed, out, &Watch::silent(stop))?;
    Ok(campaign_cross::as_json(design, cases, seed, &rows))
}

/// Names that are all known.
fn among(what: &str, names: &[String], known: &[&str]) -> Result<(), CliError> {
    let strange = names.iter().find(|name| !known.contains(&name.as_str()));
    match strange {
        None => Ok(()),
        Some(name) => Err(CliError::usage(
            format!("no {what} '{name}'"),
            format!("expected {}", known.join(", ")),
        )),
    }
}
