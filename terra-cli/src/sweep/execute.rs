//! Runs what is left of a shard.

use std::path::Path;

use rayon::prelude::*;
use serde_json::{Map, Value, json};
use terra_data::{Rover, hypothesis_terrains};
use terra_gap::{Provenance, Settings, diagnose_drive, diagnose_rig};
use terra_model::Registry;
use terra_model::catalogue::Terrain;

use super::file::Growing;
use super::plan::{Plan, Shard, Task};
use crate::challenge::design::{AnyLog, simulate};
use crate::error::CliError;
use crate::identify::{self, IdentifyOptions, identify_drive, identify_rig};
use crate::input::sha256;
use crate::progress::Watch;
use crate::start::{Log, complete};

/// What every run shares.
struct Shared<'a> {
    plan: &'a Plan,
    registry: Registry,
    terrains: Vec<Terrain>,
    rover_sha256: String,
}

/// Runs a shard into a file, going on where it stopped; `step` is told of each run, those already there included.
/// Returns how many runs were left to do.
///
/// # Errors
/// Configuration; a file of another plan; one that cannot be written. A run that comes to a bad end is a result.
pub(crate) fn execute(
    plan: &Plan,
    shard: Shard,
    out: &Path,
    watch: &Watch,
    step: &(dyn Fn() + Sync),
) -> Result<usize, CliError> {
    let runs: Vec<u64> = shard.runs(plan.total()).collect();
    let mut file = Growing::open(out, plan, &runs)?;
    (0..file.done).for_each(|_| step());
    let rover_bytes = std::fs::read(&plan.rover_file).map_err(|e| CliError::BadData {
        message: format!("{}: cannot be read: {e}", plan.rover_file.display()),
        help: None,
    })?;
    let shared = Shared {
        plan,
        registry: Registry::builtin(),
        terrains: hypothesis_terrains(
            &plan.rover.terrain,
            plan.rover_file.parent().unwrap_or(Path::new("")),
        )?,
        rover_sha256: sha256(&rover_bytes),
    };
    let left = runs.get(file.done..).unwrap_or_default().to_vec();
    // Enough to keep all threads at work, few enough that an interrupt costs little.
    let batch = 4 * rayon::current_num_threads();
    for some in left.chunks(batch) {
        let lines: Vec<Result<String, CliError>> = some
            .par_iter()
            .map(|run| {
                watch.go_on()?;
                let line = shared.line(*run);
                step();
                line
            })
            .collect();
        // Another sweep may go on with the file by now: it is left as it is.
        watch.go_on()?;
        let mut text = String::new();
        let mut failure = None;
        for line in lines {
            match line {
                Ok(line) => text.push_str(&line),
                Err(e) => {
                    failure = Some(e);
                    break;
                }
            }
        }
        file.append(&text)?;
        if let Some(e) = failure {
            file.give_up();
            return Err(e);
        }
    }
    file.finish()?;
    Ok(left.len())
}

impl Shared<'_> {
    fn line(&self, number: u64) -> Result<String, CliError> {
        let run = self.plan.run(number)?;
        let result = simulate(&run.scenario, &self.plan.rover, &self.registry)
            .and_then(|log| self.result(&log, run.seed));
        let result = match result {
            Ok(result) => result,
            // A soil that does not carry the vehicle is an outcome of the campaign.
            Err(e @ CliError::BadData { .. }) => json!({ "error": e.to_string() }),
            Err(e) => return Err(e.within(&self.plan.scenario_file)),
        };
        let line = json!({ "run": number, "seed": run.seed, "vary": run.vary, "result": result });
        Ok(format!("{line}\n"))
    }

    fn result(&self, log: &AnyLog, seed: u64) -> Result<Value, CliError> {
        let bytes = log.bytes()?;
        let log_sha256 = sha256(&bytes);
        match self.plan.task {
            Task::Simulate => Ok(summary(&bytes, &log_sha256)),
            Task::Identify => {
                let options = IdentifyOptions::default();
                let (rover, registry, terrains) =
                    (&self.plan.rover, &self.registry, &self.terrains);
                let id = match log {
                    AnyLog::Drive(log) => identify_drive(log, rover, registry, terrains, &options)?,
                    AnyLog::Rig(log) => identify_rig(log, rover, registry, terrains, &options)?,
                };
                Ok(identify::to_json(&id, &log_sha256, &self.rover_sha256))
            }
            Task::Gap => {
                let mut rover: Rover = self.plan.rover.clone();
                let settings = Settings::of(&rover);
                let of = match log {
                    AnyLog::Drive(log) => Log::Drive(log),
                    AnyLog::Rig(log) => Log::Rig(log),
                };
                complete(&mut rover, &[of], &self.registry, &self.terrains)?;
                let diagnosis = match log {
                    AnyLog::Drive(log) => diagnose_drive(log, &rover, &self.registry, &settings)?,
                    AnyLog::Rig(log) => diagnose_rig(log, &rover, &self.registry, &settings)?.0,
                };
                let provenance = Provenance {
                    log_sha256,
                    rover_sha256: self.rover_sha256.clone(),
                    seed,
                };
                Ok(terra_gap::to_json(&diagnosis, &provenance))
            }
        }
    }
}

/// Rows, fingerprint, and mean, smallest and largest value of each numeric column.
fn summary(bytes: &[u8], log_sha256: &str) -> Value {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut seen: Vec<Option<(f64, f64, f64, usize)>> = vec![None; names.len()];
    let mut rows = 0;
    for line in lines {
        rows += 1;
        for (slot, cell) in seen.iter_mut().zip(line.split(',')) {
            if let Ok(x) = cell.parse::<f64>() {
                let (sum, low, high, n) = slot.unwrap_or((0.0, x, x, 0));
                *slot = Some((sum + x, low.min(x), high.max(x), n + 1));
            }
        }
    }
    let columns: Map<String, Value> = names
        .iter()
        .zip(seen)
        .filter_map(|(name, s)| {
            let (sum, min, max, n) = s?;
            Some((
                (*name).to_owned(),
                json!({ "mean": sum / n as f64, "min": min, "max": max, "n": n }),
            ))
        })
        .collect();
    json!({ "rows": rows, "log_sha256": log_sha256, "columns": columns })
}
