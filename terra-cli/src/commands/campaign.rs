//! `terra campaign`: how often the answer is right, on runs with known truth.

use std::path::Path;

use serde_json::{Value, json};

use crate::campaign::faults::{FaultReport, faults};
use crate::campaign::{Asked, Figure, LOOK_AT, RampRow, Rate, ramps, reason, reproduction};
use crate::error::CliError;
use crate::output::{self, table};
use crate::progress::{Spinner, Stop};

/// Length of the ramps \[s\].
pub(crate) const RAMP: f64 = 2.0;

/// `terra campaign ramps --json`.
pub(crate) fn ramps_json(runs: usize, seed: u64, rows: &[RampRow]) -> Value {
    json!({ "campaign": "ramps", "runs": runs, "seed": seed, "rows": rows })
}

/// `terra campaign faults --json`.
pub(crate) fn faults_json(filter: &str, seed: u64, report: &FaultReport) -> Value {
    json!({ "campaign": "faults", "filter": filter, "seed": seed, "report": report })
}

/// `terra campaign reproduction --json`.
pub(crate) fn reproduction_json(runs: usize, seed: u64, figures: &[Figure]) -> Value {
    json!({ "campaign": "reproduction", "runs": runs, "seed": seed, "figures": figures })
}

pub(crate) fn run_ramps(
    terrains: &[String],
    runs: usize,
    seed: u64,
    file: Option<&Path>,
    quiet: bool,
) -> Result<(), CliError> {
    let names: Vec<&str> = terrains.iter().map(String::as_str).collect();
    let spinner = Spinner::start(quiet, format!("{} ramps", runs * names.len()));
    let rows = ramps(&names, runs, seed, RAMP, &Stop::default())?;
    drop(spinner);
    if file.is_some() {
        output::json(file, &ramps_json(runs, seed, &rows))?;
    }
    let cell = |r: Option<&Rate>| {
        r.map_or("-".to_owned(), |r| {
            format!("{:.3} [{:.3}, {:.3}]", r.value, r.lo, r.hi)
        })
    };
    let mut header = vec!["soil".to_owned()];
    header.extend(LOOK_AT.iter().map(|k| format!("right @{k}")));
    header.extend(["at end".to_owned(), "not run".to_owned()]);
    let body: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mut cells = vec![row.terrain.clone()];
            cells.extend(LOOK_AT.iter().map(|k| {
                cell(
                    row.right_after
                        .iter()
                        .find(|(at, _)| at == k)
                        .map(|(_, r)| r),
                )
            }));
            cells.extend([cell(Some(&row.right_at_end)), row.failed.0.to_string()]);
            cells
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    output::stdout(&table(&header, &body))
}

pub(crate) fn run_faults(
    runs: usize,
    seed: u64,
    filter: &str,
    file: Option<&Path>,
    quiet: bool,
) -> Result<(), CliError> {
    let spinner = Spinner::start(quiet, format!("{runs} faults"));
    let report = faults(runs, seed, filter, &Stop::default())?;
    drop(spinner);
    if file.is_some() {
        output::json(file, &faults_json(filter, seed, &report))?;
    }
    let cell = |r: &Rate| format!("{:.4} [{:.4}, {:.4}]", r.value, r.lo, r.hi);
    let body: Vec<Vec<String>> = report
        .rows
        .iter()
        .chain([&report.total])
        .map(|row| {
            vec![
                row.kind.clone(),
                row.runs.to_string(),
                row.knowable.to_string(),
                cell(&row.flagged),
                cell(&row.recovered),
                row.not_finite.to_string(),
                row.refused.0.to_string(),
                row.panics.to_string(),
            ]
        })
        .collect();
    let header = [
        "fault",
        "runs",
        "knowable",
        "flagged",
        "NIS nominal after .5 s",
        "not finite",
        "refused",
        "panics",
    ];
    output::stdout(&table(&header, &body))
}

pub(crate) fn run_reproduction(
    runs: usize,
    seed: u64,
    tables: &[String],
    file: Option<&Path>,
    quiet: bool,
) -> Result<(), CliError> {
    let spinner = Spinner::start(quiet, "reproduction".to_owned());
    let figures = reproduction(runs, seed, tables, &Stop::default())?;
    drop(spinner);
    if file.is_some() {
        output::json(file, &reproduction_json(runs, seed, &figures))?;
    }
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.3}"));
    let body: Vec<Vec<String>> = figures
        .iter()
        .map(|f| {
            let interval = match (f.lo, f.hi) {
                (Some(lo), Some(hi)) => format!("[{lo:.3}, {hi:.3}]"),
                _ => "-".to_owned(),
            };
            let asked = f.asked.map_or(String::new(), |a| match a {
                Asked::AtLeast(x) => format!(">= {x:.3}"),
                Asked::AtMost(x) => format!("<= {x:.3}"),
            });
            let met = match f.met() {
                None => "",
                Some(true) => "yes",
                Some(false) if f.within_chance() => "by chance no",
                Some(false) => "NO",
            };
            vec![
                f.table.to_owned(),
                f.case.clone(),
                f.figure.clone(),
                number(f.value),
                interval,
                f.n.to_string(),
                number(f.published),
                asked,
                met.to_owned(),
            ]
        })
        .collect();
    let header = [
        "table",
        "case",
        "figure",
        "found",
        "95 %",
        "n",
        "published",
        "asked",
        "met",
    ];
    output::stdout(&table(&header, &body))?;
    let missed: Vec<&Figure> = figures.iter().filter(|f| f.met() == Some(false)).collect();
    let asked = figures.iter().filter(|f| f.met().is_some()).count();
    let mut text = format!("\n{} of {asked} bounds are met.\n", asked - missed.len());
    for f in missed {
        let chance = if f.within_chance() {
            "; the bound lies within the interval"
        } else {
            ""
        };
        let why = reason(f).map_or(String::new(), |why| format!("; {why}"));
        text += &format!(
            "missed: {}, {}, {}: {}{chance}{why}\n",
            f.table,
            f.case,
            f.figure,
            number(f.value)
        );
    }
    output::stdout(&text)
}
