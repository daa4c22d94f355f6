//! `terra simulate`: a log with known truth from a scenario file.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};
use terra_data::{read_rover, write_drive_log, write_rig_log};
use terra_model::Registry;
use terra_sim::{Scenario, SimError, TruthColumn, TruthOnly, simulate_drive, simulate_rig};

use crate::error::CliError;
use crate::output;
use crate::progress::Spinner;

pub(crate) fn run(
    path: &Path,
    out: &Path,
    truth: Option<&Path>,
    seed: Option<u64>,
    quiet: bool,
) -> Result<(), CliError> {
    output::claim(&[Some(out), truth], &[path])?;
    let mut scenario = Scenario::read(path)?;
    if let Some(seed) = seed {
        scenario.seed = seed;
    }
    let rover_path = scenario.rover_path(path);
    output::claim(&[Some(out), truth], &[&rover_path])?;
    let rover = read_rover(&rover_path)?;
    let registry = Registry::builtin();
    let _spinner = Spinner::start(quiet, "simulating");
    let at = |e: SimError| CliError::from(e).within(path);
    if scenario.trials.is_empty() {
        let run = simulate_drive(&scenario, &rover, &registry).map_err(at)?;
        write_drive_log(out, &run.log)?;
        if let Some(truth) = truth {
            output::text(Some(truth), &csv(&run.truth.columns()))?;
        }
    } else {
        let run = simulate_rig(&scenario, &rover, &registry).map_err(at)?;
        write_rig_log(out, &run.log)?;
        if let Some(truth) = truth {
            output::text(Some(truth), &csv(&run.truth.columns()))?;
        }
    }
    Ok(())
}

/// What a scenario may hold beside the effects of the library: a diagnosis does not know them.
fn listed() -> impl Iterator<Item = &'static TruthOnly> {
    let own = terra_sim::off_library().iter();
    own.chain(terra_sim::form_variants())
}

/// `terra simulate --list` as JSON.
pub(crate) fn list_json() -> Value {
    let rows = listed().map(|e| {
        let (low, high) = e.magnitude;
        json!({
            "name": e.name, "form": e.form, "min": low, "max": high, "unit": e.unit, "summary": e.summary,
            "reference": e.reference,
        })
    });
    rows.collect()
}

pub(crate) fn list() -> Result<(), CliError> {
    let rows: Vec<Vec<String>> = listed()
        .map(|e| {
            let (low, high) = e.magnitude;
            vec![
                e.name.to_owned(),
                e.form.to_owned(),
                format!("{low} to {high}"),
                e.unit.to_owned(),
                e.summary.to_owned(),
                e.reference.to_owned(),
            ]
        })
        .collect();
    let head = [
        "effect",
        "form",
        "magnitude",
        "unit",
        "what happens",
        "source",
    ];
    output::stdout(&output::table(&head, &rows))
}

/// Columns as CSV; a value that does not exist is empty.
pub(crate) fn csv(columns: &[TruthColumn<'_>]) -> String {
    let mut out = columns
        .iter()
        .map(|c| c.name.as_str())
        .collect::<Vec<_>>()
        .join(",");
    out.push('\n');
    for row in 0..columns.first().map_or(0, |c| c.values.len()) {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                out.push(',');
            }
            if let Some(v) = column.values.get(row).filter(|v| v.is_finite()) {
                // Writing to a string cannot fail.
                let _ = write!(out, "{v}");
            }
        }
        out.push('\n');
    }
    out
}
