//! Grids of runs.

use std::path::{Path, PathBuf};

use crate::commands::sweep as sweeping;
use crate::error::CliError;
use crate::progress::{Stop, Watch};
use crate::sweep::{self, Plan};

/// How many runs a sweep's plan asks for, after every value of it was tried.
///
/// # Errors
/// As `terra sweep`, before its first run.
pub fn sweep_runs(plan: &Path) -> Result<u64, CliError> {
    Ok(Plan::read(plan)?.total())
}

/// `terra sweep`: runs what is left of a plan, or of its shard `i/n`, into a file of JSON lines; how many runs those are, and
/// how many were left.
///
/// # Errors
/// As the command.
pub fn sweep(
    plan: &Path,
    out: &Path,
    shard: Option<&str>,
    stop: &Stop,
) -> Result<(usize, usize), CliError> {
    sweeping::grow(plan, shard, out, &Watch::silent(stop))
}

/// The lines of `terra merge`: shards of a sweep, joined.
///
/// # Errors
/// As the command.
pub fn merge(shards: &[PathBuf]) -> Result<String, CliError> {
    sweep::merge(shards)
}

/// `terra merge --out`: those lines in a file.
///
/// # Errors
/// As the command.
pub fn merge_into(shards: &[PathBuf], out: &Path) -> Result<(), CliError> {
    sweeping::merge(shards, Some(out))
}
