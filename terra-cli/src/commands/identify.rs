//! `terra identify`.

use std::path::Path;

use nalgebra::DMatrix;
use serde_json::Value;
use terra_data::{DriveLog, LogKind, Rover};
use terra_mme::Choice;
use terra_model::Registry;

use crate::args::{IdentifyArgs, ReportArgs};
use crate::commands::identify_view;
use crate::error::CliError;
use crate::identify::{
    Identification, IdentifyOptions, hypotheses, identify_drive_among, identify_rig_among, to_json,
    twins,
};
use crate::input::{BLOCK, LogFile, rover};
use crate::output::{self, short, table};
use crate::progress::Spinner;
use crate::report;

pub(crate) fn run(args: &IdentifyArgs, quiet: bool) -> Result<(), CliError> {
    let inputs: [&Path; 2] = [&args.log, &args.rover];
    output::claim_with(&args.report, &[args.json.as_deref()], &inputs)?;
    let options = IdentifyOptions {
        estimator: args.estimator.clone(),
        choice: choice(&args.choice)?,
        join: args.join,
        history: args.history,
        refine: !args.no_refine,
        filter: args.filter.clone(),
        ..IdentifyOptions::default()
    };
    let rover = rover(&args.rover)?;
    let spinner = Spinner::start(quiet, "weighing soils");
    let file = LogFile::open(&args.log)?;
    let case = Case {
        log: &file,
        log_name: &args.log,
        rover,
        rover_name: &args.rover,
        folder: args.rover.parent().unwrap_or(Path::new("")),
        registry: &Registry::builtin(),
        hypotheses: args.hypotheses.as_deref(),
        rows: args.rows,
    };
    let weighed = weigh(&case, &options, &args.report)?;
    drop(spinner);
    if let Some(path) = &args.json {
        output::json(Some(path), &weighed.as_json())?;
    }
    output::stdout(&summary(&weighed.id))
}

/// What is weighed.
pub(crate) struct Case<'a> {
    pub(crate) log: &'a LogFile<'a>,
    pub(crate) log_name: &'a Path,
    /// With its fingerprint.
    pub(crate) rover: (Rover, String),
    pub(crate) rover_name: &'a Path,
    /// Where the rover file's own references start.
    pub(crate) folder: &'a Path,
    pub(crate) registry: &'a Registry,
    /// In place of the rover file's.
    pub(crate) hypotheses: Option<&'a str>,
    /// Rows of a drive log, the first being 1.
    pub(crate) rows: Option<(usize, usize)>,
}

/// What was found.
pub(crate) struct Weighed {
    id: Identification,
    log_sha256: String,
    rover_sha256: String,
}

impl Weighed {
    /// `terra identify --json`.
    pub(crate) fn as_json(&self) -> Value {
        to_json(&self.id, &self.log_sha256, &self.rover_sha256)
    }
}

/// Weighs the soils; writes the report, where one was asked for.
pub(crate) fn weigh(
    case: &Case<'_>,
    options: &IdentifyOptions,
    report: &ReportArgs,
) -> Result<Weighed, CliError> {
    let (rover, rover_sha) = &case.rover;
    let (file, registry) = (case.log, case.registry);
    let set = hypotheses(rover, registry, case.folder, case.hypotheses)?;
    let asked = options;
    let options = IdentifyOptions {
        // The report shows the posterior over time.
        history: asked.history || report.asked(),
        ..asked.clone()
    };
    let mut measured = None;
    let mut id = match file.kind(rover)? {
        LogKind::Drive => {
            let log = drive(file, rover, case.rows)?;
            identify_drive_among(&log, rover, registry, &set, &options)
        }
        LogKind::Rig if case.rows.is_some() => {
            return Err(CliError::usage(
                "--rows cuts a drive log, and this is a rig log",
                "leave --rows out: all rows of a rig log are weighed",
            ));
        }
        LogKind::Rig => {
            let log = measured.insert(file.rig(rover)?);
            identify_rig_among(log, rover, &set, &options)
        }
    }
    .map_err(|e| e.in_files(case.log_name, case.rover_name))?;
    id.near_duplicates = twins(&set, rover);
    let log_sha = file.sha256();
    output::report(report, || report::Page {
        title: "What soil is it?".to_owned(),
        subtitle: case.log_name.display().to_string(),
        sections: vec![report::identify_section(&identify_view::view(
            &id,
            &identify_view::Context {
                title: "Posterior over soils",
                truth: None,
                set: &set,
                rover,
                measured: measured.as_ref(),
            },
        ))],
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("log SHA-256".to_owned(), log_sha.clone()),
            ("rover SHA-256".to_owned(), rover_sha.clone()),
        ],
    })?;
    if !asked.history {
        id.groups.iter_mut().for_each(|g| g.history = None);
    }
    Ok(Weighed {
        id,
        log_sha256: log_sha,
        rover_sha256: rover_sha.clone(),
    })
}

/// Most rows that are weighed: every one takes some 10 kB of memory.
const MOST_ROWS: usize = 300_000;

/// The drive log, or the rows of it that were asked for.
fn drive(
    file: &LogFile<'_>,
    rover: &Rover,
    rows: Option<(usize, usize)>,
) -> Result<DriveLog, CliError> {
    let (first, last) = rows.unwrap_or((1, usize::MAX));
    let mut blocks = file.drive_blocks(rover)?;
    let mut passed = 0;
    while passed + 1 < first {
        let before = blocks.next_block(BLOCK.min(first - 1 - passed))?;
        passed += before.map_or(first, |block| block.log.len());
    }
    let asked = (last - first).saturating_add(1);
    let log = blocks.next_block(asked.min(MOST_ROWS + 1))?;
    let log = log.unwrap_or_default().log;
    if log.len() > MOST_ROWS {
        return Err(CliError::data(
            format!("more than {MOST_ROWS} rows, each of which takes some 10 kB of memory"),
            "weigh a part of the log, as in --rows 1-20000",
        ));
    }
    if log.is_empty() && rows.is_some() {
        return Err(CliError::data(
            format!("the log has no row {first}"),
            "`terra inspect` says how many rows it has",
        ));
    }
    Ok(log)
}

pub(crate) fn choice(text: &str) -> Result<Choice, CliError> {
    let Some(file) = text.strip_prefix("transition:") else {
        return Choice::parse(text).map_err(|e| {
            CliError::usage(
                e.to_string(),
                "none, floor:F, forgetting:L, or transition:FILE",
            )
        });
    };
    let bad = |why: String| {
        CliError::usage(
            format!("{file}: {why}"),
            "rows of N numbers in [0, 1], each summing to 1",
        )
    };
    let content = std::fs::read_to_string(file).map_err(|e| bad(e.to_string()))?;
    let rows: Vec<Vec<f64>> = content
        .lines()
        .enumerate()
        .filter(|(_, l)| !l.trim().is_empty())
        .map(|(k, l)| {
            l.split(|c: char| c == ',' || c.is_whitespace())
                .filter(|s| !s.is_empty())
                .map(|s| {
                    s.parse::<f64>()
                        .map_err(|_| bad(format!("line {}: '{s}' is no number", k + 1)))
                })
                .collect()
        })
        .collect::<Result<_, _>>()?;
    let n = rows.len();
    if let Some((k, row)) = rows.iter().enumerate().find(|(_, r)| r.len() != n) {
        return Err(bad(format!(
            "row {} has {} numbers, expected {n}",
            k + 1,
            row.len()
        )));
    }
    Ok(Choice::transition(DMatrix::from_fn(n, n, |r, c| {
        rows[r][c]
    }))?)
}

/// Ten lines a person can act on.
pub(crate) fn summary(id: &Identification) -> String {
    let mut out = format!(
        "{} rows: {} weighed, {} before the filter settled, {} outside every model\n",
        id.samples.rows, id.samples.used, id.samples.waiting, id.samples.rejected
    );
    if id.flags.contains(&"no-ground-speed") {
        out.push_str("no ground speed: slip follows from the soils themselves\n");
    }
    if let Some(first) = id.near_duplicates.first() {
        out.push_str(&format!(
            "warning: {} pairs of hypotheses are the same soil by any force ({} and {} first); each such pair holds twice the prior of one soil\n",
            id.near_duplicates.len(),
            first.pair[0],
            first.pair[1]
        ));
    }
    for g in &id.groups {
        out.push_str(&format!("\n{}\n", g.name));
        let rows: Vec<Vec<String>> = g
            .posterior
            .iter()
            .take(4)
            .map(|p| {
                vec![
                    format!("  {}", p.id),
                    format!("{:.3}", p.probability),
                    p.infeasible_samples.to_string(),
                ]
            })
            .collect();
        out.push_str(&table(
            &["  soil", "probability", "samples it cannot carry"],
            &rows,
        ));
        if !g.known_to.is_empty() {
            out.push_str(&format!(
                "  not told apart on this log: {}\n",
                g.known_to.join(", ")
            ));
        }
        match &g.refined {
            Ok(r) => {
                let values: Vec<String> = r
                    .fit
                    .fitted()
                    .iter()
                    .map(|p| format!("{} {} ± {} {}", p.name, short(p.value), short(p.sd), p.unit))
                    .collect();
                out.push_str(&format!(
                    "  refined from {}: {}\n",
                    r.start,
                    values.join("; ")
                ));
                for u in &r.fit.identifiability.undetermined {
                    out.push_str(&format!("  cannot be known: {u}\n"));
                }
            }
            Err(reason) => out.push_str(&format!("  not refined: {reason}\n")),
        }
        if g.consistency.alarm {
            let reason = g.consistency.reason.clone().unwrap_or_default();
            out.push_str(&format!("  ALARM: do not trust this soil; {reason}\n"));
        }
    }
    out
}
