//! `terra challenge run`: every log of a challenge diagnosed as `terra gap` does.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::Value;
use terra_data::{LogKind, Rover};
use terra_gap::{Settings, to_json};

use super::gap_case;
use crate::challenge::read_json;
use crate::error::CliError;
use crate::input::sha256;
use crate::output;
use crate::progress::Watch;

/// Diagnoses `case_*.csv` of a folder; a verdict that is there already is kept when it is of this log.
pub(crate) fn run(folder: &Path, out: &Path, quiet: bool) -> Result<(), CliError> {
    let done = diagnose_all(folder, out, &|_| Some(None), &Watch::shown(quiet))?;
    output::stdout(&done.said(out))
}

/// What became of the cases.
pub(crate) struct Done {
    pub(crate) cases: usize,
    /// Verdicts that were there already.
    pub(crate) kept: usize,
    /// How often each verdict was given.
    pub(crate) verdicts: BTreeMap<String, usize>,
    /// Cases without a verdict.
    pub(crate) failed: usize,
    /// Why the first of them has none.
    pub(crate) first: Option<CliError>,
}

impl Done {
    /// In a line or three.
    pub(crate) fn said(&self, out: &Path) -> String {
        let counts: Vec<String> = self
            .verdicts
            .iter()
            .map(|(v, n)| format!("{n} {v}"))
            .collect();
        let mut text = format!(
            "{} verdicts in {}, {} of them kept: {}\n",
            self.cases - self.failed,
            out.display(),
            self.kept,
            counts.join(", ")
        );
        if let Some(e) = &self.first {
            text.push_str(&format!(
                "{} cases could not be diagnosed\nthe first: {e}\n",
                self.failed
            ));
        }
        text
    }
}

/// The same for the cases that `asked` lets through, with the candidate effects it gives (none: all).
///
/// # Errors
/// The first case's, where none of them could be diagnosed.
pub(crate) fn diagnose_all(
    folder: &Path,
    out: &Path,
    asked: &(dyn Fn(&str) -> Option<Option<Vec<String>>> + Sync),
    watch: &Watch,
) -> Result<Done, CliError> {
    let cases: Vec<(String, PathBuf)> = cases(folder)?
        .into_iter()
        .filter(|(name, _)| asked(name).is_some())
        .collect();
    let rover = folder.join("rover.toml");
    fs::create_dir_all(out).map_err(|reason| CliError::Write {
        target: out.display().to_string(),
        reason,
    })?;
    let mut left = vec![];
    let mut said: BTreeMap<String, usize> = BTreeMap::new();
    for (name, log) in &cases {
        let path = out.join(format!("{name}.json"));
        match kept(&path, log, &rover)? {
            Some(verdict) => *said.entry(verdict).or_default() += 1,
            None => left.push((name, log, path)),
        }
    }
    let kept = cases.len() - left.len();
    let bar = watch.bar(left.len(), "diagnosing");
    // Each verdict is written when it is there, whole: an interrupt costs no more than what is in work.
    let done: Vec<Result<String, CliError>> = left
        .par_iter()
        .map(|(name, log, path)| {
            watch.go_on()?;
            let effects = asked(name).flatten();
            let settings = |rover: &Rover, _: LogKind| {
                Ok(Settings {
                    effects: effects.clone(),
                    ..Settings::of(rover)
                })
            };
            let verdict = gap_case::diagnose_files(&[log], None, &rover, &settings).and_then(|v| {
                output::json(Some(path), &to_json(&v.diagnosis, &v.provenance))?;
                Ok(v.diagnosis.verdict.to_string())
            });
            bar.step();
            verdict
        })
        .collect();
    drop(bar);
    watch.go_on()?;
    let mut failed = 0;
    let mut first = None;
    for verdict in done {
        match verdict {
            Ok(verdict) => *said.entry(verdict).or_default() += 1,
            Err(e) => {
                failed += 1;
                first.get_or_insert(e);
            }
        }
    }
    match first {
        Some(e) if failed == cases.len() => Err(e),
        first => Ok(Done {
            cases: cases.len(),
            kept,
            verdicts: said,
            failed,
            first,
        }),
    }
}

/// Names and logs of a challenge, in the order of names.
fn cases(folder: &Path) -> Result<Vec<(String, PathBuf)>, CliError> {
    let bad = |message: String| CliError::BadData {
        message: format!("{}: {message}", folder.display()),
        help: None,
    };
    let entries = fs::read_dir(folder).map_err(|e| bad(format!("cannot be read: {e}")))?;
    let mut out = vec![];
    for entry in entries {
        let path = entry
            .map_err(|e| bad(format!("cannot be read: {e}")))?
            .path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if name.starts_with("case_") && path.extension().is_some_and(|e| e == "csv") {
            out.push((name.into_owned(), path.clone()));
        }
    }
    out.sort();
    if out.is_empty() {
        return Err(bad("holds no case_*.csv".to_owned()));
    }
    Ok(out)
}

/// What a verdict that is there already says; none when there is no file.
///
/// # Errors
/// A file that is no verdict, or the verdict of another log or rover file: neither is replaced.
fn kept(path: &Path, log: &Path, rover: &Path) -> Result<Option<String>, CliError> {
    if !path.exists() {
        return Ok(None);
    }
    let verdict: Value = read_json(path)?;
    let bad = |message: String| CliError::BadData {
        message: format!("{}:1:1: {message}", path.display()),
        help: Some("name another folder with --out, or remove this file".to_owned()),
    };
    let Some(says) = verdict.get("verdict").and_then(Value::as_str) else {
        return Err(bad("holds no verdict".to_owned()));
    };
    for (key, of) in [("log_sha256", log), ("rover_sha256", rover)] {
        let bytes = fs::read(of).map_err(|e| CliError::BadData {
            message: format!("{}: cannot be read: {e}", of.display()),
            help: None,
        })?;
        // A verdict of another program may not say what it is of.
        let said = verdict.get("provenance").and_then(|p| p.get(key));
        if let Some(said) = said.and_then(Value::as_str)
            && said != sha256(&bytes)
        {
            return Err(bad(format!("is the verdict of another {}", of.display())));
        }
    }
    Ok(Some(says.to_owned()))
}
