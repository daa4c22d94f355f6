//! `terra inspect`: what is in a log, and what in it looks wrong.

use std::path::Path;

use serde_json::{Value, json};
use terra_data::{
    DataError, DriveInspector, Inspection, LogKind, Problem, Rover, inspect_rig, parse_rover,
};

use crate::error::CliError;
use crate::input::{self, LogFile};
use crate::output::{self, short, table};

/// Groups listed by name; a soil bin has hundreds of trials.
const LISTED: usize = 20;

pub(crate) fn run(
    path: &Path,
    rover: Option<&Path>,
    json_file: Option<&Path>,
) -> Result<(), CliError> {
    let inputs: Vec<&Path> = [Some(path), rover].into_iter().flatten().collect();
    output::claim(&[json_file], &inputs)?;
    let given = rover.map(input::rover).transpose()?.map(|(r, _)| r);
    let log = LogFile::open(path)?;
    let found = look(path, &log, given)?;
    if let Some(file) = json_file {
        output::json(Some(file), &as_json(path, &log, &found))?;
    }
    output::stdout(&as_text(path, &found))
}

/// Looks at a log, with the rover file or without.
pub(crate) fn look(
    path: &Path,
    log: &LogFile<'_>,
    given: Option<Rover>,
) -> Result<Inspection, CliError> {
    let reader = match &given {
        Some(rover) => rover.clone(),
        None => neutral()?,
    };
    Ok(
        match log.kind(&reader).map_err(|e| unnamed(e, given.is_some()))? {
            LogKind::Drive => {
                let mut inspector = DriveInspector::new(given.as_ref());
                let mut blocks = log.drive_blocks(&reader)?;
                while let Some(block) = blocks.next_block(input::BLOCK)? {
                    inspector.block(&block);
                }
                inspector.finish()
            }
            LogKind::Rig => {
                let rows = log.rig(&reader)?;
                // Slip of a rim speed in rad/s needs the radius, which only the rover file knows.
                if given.is_none() && !has_slip(log, &reader) {
                    return Err(CliError::usage(
                        format!(
                            "{}: slip follows from wheel_speed_rad_s only with the wheel's radius",
                            path.display()
                        ),
                        "add --rover rig.toml (`terra init single-wheel-rig` writes one), or log slip or rim_speed_m_s",
                    ));
                }
                inspect_rig(&rows, given.as_ref())
            }
        },
    )
}

/// Reads a log in the contract's own names and units.
fn neutral() -> Result<Rover, DataError> {
    parse_rover(
        "[wheel]\nradius_m = 1.0\nwidth_m = 1.0\n[terrain]\nmodel = \"wong-reece\"\n[filter]\nground_speed = \"none\"\n",
        "no rover file",
    )
}

/// Whether slip comes from a column that needs no radius.
fn has_slip(log: &LogFile<'_>, reader: &Rover) -> bool {
    let mut twice = reader.clone();
    twice.wheel.radius *= 2.0;
    match (log.rig(reader), log.rig(&twice)) {
        (Ok(one), Ok(two)) => one
            .rows
            .iter()
            .map(|r| r.slip)
            .eq(two.rows.iter().map(|r| r.slip)),
        _ => true,
    }
}

/// A log in the user's own names cannot be read without the file that explains them.
fn unnamed(e: DataError, given: bool) -> CliError {
    match e.problem() {
        Problem::UnknownLogKind { .. } if !given => CliError::data(
            e.to_string(),
            "--rover FILE with [columns] maps other names and units; `terra init CLASS` writes such a file",
        ),
        _ => e.into(),
    }
}

fn as_text(path: &Path, found: &Inspection) -> String {
    let words = match found.kind {
        LogKind::Drive => ("drive log", "segments"),
        LogKind::Rig => ("rig log", "trials"),
    };
    let mut text = format!(
        "{}: {}, {} rows, {} {}\n\n",
        path.display(),
        words.0,
        found.rows,
        found.groups.len(),
        words.1
    );
    let rows: Vec<Vec<String>> = found
        .channels
        .iter()
        .map(|c| {
            let cell = |k: usize| {
                c.range
                    .and_then(|r| r.get(k).copied())
                    .map_or("-".to_owned(), short)
            };
            vec![
                c.name.clone(),
                c.present.to_string(),
                c.missing.blank.to_string(),
                c.missing.not_finite.to_string(),
                cell(0),
                cell(1),
                cell(2),
            ]
        })
        .collect();
    text.push_str(&table(
        &[
            "channel",
            "samples",
            "missing",
            "not finite",
            "min",
            "mean",
            "max",
        ],
        &rows,
    ));
    let rows: Vec<Vec<String>> = found
        .groups
        .iter()
        .take(LISTED)
        .map(|g| {
            let mut row = vec![g.name.clone(), g.rows.to_string()];
            match &g.pace {
                Some(p) => row.extend([
                    short(p.start),
                    short(p.end),
                    short(1.0 / p.step),
                    format!("{:.1}", 100.0 * p.uneven),
                    p.gaps.len().to_string(),
                ]),
                None => row.extend(std::iter::repeat_n("-".to_owned(), 5)),
            }
            row
        })
        .collect();
    text.push('\n');
    text.push_str(&table(
        &[
            words.1.trim_end_matches('s'),
            "rows",
            "from s",
            "to s",
            "rate Hz",
            "uneven %",
            "gaps",
        ],
        &rows,
    ));
    if found.groups.len() > LISTED {
        text.push_str(&format!("... and {} more\n", found.groups.len() - LISTED));
    }
    if !found.notes.ignored_columns.is_empty() {
        text.push_str(&format!(
            "\nnot used: {}\n",
            found.notes.ignored_columns.join(", ")
        ));
    }
    if let Some((line, reason)) = found.dropped.first() {
        text.push_str(&format!(
            "\n{} rows cannot be used; the first, line {line}: {reason}\n",
            found.dropped.len()
        ));
    }
    for warning in &found.warnings {
        text.push_str(&format!("\nnote: {warning}\n"));
    }
    text.push('\n');
    if found.suspicions.is_empty() {
        text.push_str("Nothing looks wrong.\n");
    }
    for s in &found.suspicions {
        text.push_str(&format!("check [{}]: {}\n", s.code, s.message));
    }
    text
}

pub(crate) fn as_json(path: &Path, log: &LogFile<'_>, found: &Inspection) -> Value {
    json!({
        "schema": "terra.inspect/1",
        "log": { "path": path.display().to_string(), "sha256": log.sha256() },
        "kind": match found.kind { LogKind::Drive => "drive", LogKind::Rig => "rig" },
        "rows": found.rows,
        "channels": found.channels.iter().map(|c| json!({
            "name": c.name, "samples": c.present, "missing": c.missing.blank, "not_finite": c.missing.not_finite,
            "min": c.range.map(|r| r[0]), "mean": c.range.map(|r| r[1]), "max": c.range.map(|r| r[2]),
        })).collect::<Vec<_>>(),
        "groups": found.groups.iter().map(|g| json!({
            "name": g.name, "rows": g.rows,
            "start_s": g.pace.as_ref().map(|p| p.start), "end_s": g.pace.as_ref().map(|p| p.end),
            "step_s": g.pace.as_ref().map(|p| p.step), "uneven": g.pace.as_ref().map(|p| p.uneven),
            "gaps": g.pace.iter().flat_map(|p| &p.gaps)
                .map(|h| json!({ "from_s": h.from, "length_s": h.length })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "ignored_columns": found.notes.ignored_columns,
        "dropped": found.dropped.iter().map(|(line, reason)| json!({ "line": line, "reason": reason })).collect::<Vec<_>>(),
        "warnings": found.warnings,
        "suspicions": found.suspicions.iter().map(|s| json!({ "code": s.code, "message": s.message })).collect::<Vec<_>>(),
    })
}
