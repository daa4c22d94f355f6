//! `terra sweep` and `terra merge`.

use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::output;
use crate::progress::Watch;
use crate::sweep::{self, Plan, Shard};

pub(crate) fn run(
    path: &Path,
    shard: Option<&str>,
    out: &Path,
    quiet: bool,
) -> Result<(), CliError> {
    let (runs, now) = grow(path, shard, out, &Watch::shown(quiet))?;
    output::stdout(&format!(
        "{runs} runs in {}, {now} of them now\n",
        out.display()
    ))
}

/// Runs what is left of a shard into its file: how many runs it has, and how many were left.
pub(crate) fn grow(
    path: &Path,
    shard: Option<&str>,
    out: &Path,
    watch: &Watch,
) -> Result<(usize, usize), CliError> {
    let shard = shard.map_or(Ok(Shard::ALL), Shard::parse)?;
    output::claim(&[Some(out)], &[path])?;
    let plan = Plan::read(path)?;
    output::claim(&[Some(out)], &[path, &plan.scenario_file, &plan.rover_file])?;
    let runs = shard.runs(plan.total()).count();
    let bar = watch.bar(runs, "running");
    let left = sweep::execute(&plan, shard, out, watch, &|| bar.step())?;
    Ok((runs, left))
}

pub(crate) fn merge(files: &[PathBuf], out: Option<&Path>) -> Result<(), CliError> {
    let inputs: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    output::claim(&[out], &inputs)?;
    output::text(out, &sweep::merge(files)?)
}
