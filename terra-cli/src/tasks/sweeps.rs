//! Grids of runs.

use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::sweep::{self, Plan};

/// How many runs a sweep's plan asks for, after every value of it was tried.
///
/// # Errors
/// As `terra sweep`, before its first run.
pub fn sweep_runs(plan: &Path) -> Result<u64, CliError> {
    Ok(Plan::read(plan)?.total())
}

/// The lines of `terra merge`: shards of a sweep, joined.
///
/// # Errors
/// As the command.
pub fn merge(shards: &[PathBuf]) -> Result<String, CliError> {
    sweep::merge(shards)
}
