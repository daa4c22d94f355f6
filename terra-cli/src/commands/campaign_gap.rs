//! `terra campaign gap` and `gap-calibration`: the diagnosis on sealed cases, from their making to the table.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Value, json};
use terra_data::atomic_write;
use terra_gap::{Calibration, Case, Evidence, LogKind};

use super::{challenge, challenge_run};
use crate::args::{CampaignCases, ChallengeMake};
use crate::campaign::targets::{Target, left_out, targets};
use crate::challenge::{KeyFile, Library, ScoreOptions, read_json, score};
use crate::error::CliError;
use crate::output::{self, table};
use crate::progress::Watch;

/// What hears of a long campaign's parts as they end.
type Say<'a> = &'a mut dyn FnMut(&str) -> Result<(), CliError>;

/// Where the parts of one design's campaign lie.
struct Places {
    logs: PathBuf,
    key: PathBuf,
    verdicts: PathBuf,
    left_out: PathBuf,
}

impl Places {
    fn of(out: &Path, design: &str) -> Self {
        let folder = out.join(design);
        Places {
            logs: folder.join("logs"),
            key: folder.join("key.json"),
            verdicts: folder.join("verdicts"),
            left_out: folder.join("left-out"),
        }
    }

    /// Makes the cases of these kinds, or keeps those that are there.
    fn make(
        &self,
        design: &str,
        cases: &CampaignCases,
        kinds: Option<&str>,
        say: Say<'_>,
        watch: &Watch,
    ) -> Result<KeyFile, CliError> {
        if !self.key.exists() || !self.logs.is_dir() {
            let folder = self.key.parent().unwrap_or(Path::new(""));
            fs::create_dir_all(folder).map_err(|reason| CliError::Write {
                target: folder.display().to_string(),
                reason,
            })?;
            let make = ChallengeMake {
                design: design.to_owned(),
                cases: cases.cases,
                seed: cases.seed,
                out: self.logs.clone(),
                key: self.key.clone(),
                kinds: kinds.map(str::to_owned),
            };
            let challenge = challenge::written(&make, watch)?;
            say(&challenge::made(&make, &challenge))?;
        }
        KeyFile::open(&self.key)
    }
}

pub(crate) fn run(
    cases: &CampaignCases,
    also_left_out: bool,
    file: Option<&Path>,
    quiet: bool,
) -> Result<(), CliError> {
    let all = marked(
        cases,
        also_left_out,
        &mut output::stdout,
        &Watch::shown(quiet),
    )?;
    match file {
        Some(_) => output::json(file, &all),
        None => Ok(()),
    }
}

/// Marks sealed cases of every design: `terra campaign gap --json`.
pub(crate) fn marked(
    cases: &CampaignCases,
    also_left_out: bool,
    say: Say<'_>,
    watch: &Watch,
) -> Result<Value, CliError> {
    let mut all = serde_json::Map::new();
    for design in &cases.designs {
        let places = Places::of(&cases.out, design);
        let key = places.make(design, cases, None, say, watch)?;
        let done =
            challenge_run::diagnose_all(&places.logs, &places.verdicts, &|_| Some(None), watch)?;
        let bar = watch.bar(key.cases.len(), "marking");
        let options = ScoreOptions { closing: true };
        let marked = score(&key, &places.verdicts, &options, &|| bar.step())?;
        drop(bar);
        let said = done.said(&places.verdicts);
        let mut text = format!("{design}: {said}{}\n", marked.summary());
        let mut rows = targets(design, &marked);
        let mut part = marked.to_json();
        if also_left_out {
            let found = without_the_truth(&places, &key, watch)?;
            rows.extend(found);
        }
        text.push_str(&shown(&rows));
        if let Value::Object(map) = &mut part {
            map.insert("targets".to_owned(), json!(rows));
        }
        all.insert(design.clone(), part);
        say(&text)?;
    }
    Ok(json!({ "campaign": "gap", "cases": cases.cases, "seed": cases.seed, "designs": all }))
}

/// The single cases once more, their cause unknown to the diagnosis.
fn without_the_truth(
    places: &Places,
    key: &KeyFile,
    watch: &Watch,
) -> Result<Vec<Target>, CliError> {
    let known: Vec<String> = Library::builtin()
        .known()
        .into_iter()
        .map(|k| k.name)
        .collect();
    let mut truths = std::collections::BTreeMap::new();
    for case in &key.cases {
        let sealed = case.read()?;
        if sealed.kind == "single" {
            truths.insert(case.case.clone(), sealed.truth());
        }
    }
    let others = |name: &str| {
        let truth = truths.get(name)?;
        Some(Some(
            known.iter().filter(|k| *k != truth).cloned().collect(),
        ))
    };
    challenge_run::diagnose_all(&places.logs, &places.left_out, &others, watch)?;
    left_out(key, &places.verdicts, &places.left_out)
}

pub(super) fn shown(rows: &[Target]) -> String {
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    let body: Vec<Vec<String>> = rows
        .iter()
        .map(|t| {
            vec![
                t.figure.clone(),
                t.n.to_string(),
                number(t.value),
                match (t.lo, t.hi) {
                    (Some(lo), Some(hi)) => format!("[{lo:.2}, {hi:.2}]"),
                    _ => "-".to_owned(),
                },
                t.prototype.to_owned(),
                t.must.to_owned(),
                t.ambitious.to_owned(),
            ]
        })
        .collect();
    let header = [
        "figure",
        "n",
        "found",
        "95 %",
        "prototype",
        "must",
        "ambitious",
    ];
    format!("\n{}", table(&header, &body))
}

/// What a calibration reads of a verdict.
#[derive(Deserialize)]
struct Weighed {
    evidence: Evidence,
}

pub(crate) fn run_calibration(
    cases: &CampaignCases,
    nulls: u32,
    quiet: bool,
) -> Result<(), CliError> {
    let learned = learned(cases, nulls, &mut output::stdout, &Watch::shown(quiet))?;
    let path = cases.out.join(CALIBRATION);
    output::stdout(&format!("{learned}written to {}\n", path.display()))
}

/// What a calibration is written to, in the folder of its cases.
const CALIBRATION: &str = "calibration.toml";

/// What the cases at a place teach.
fn taught(places: &Places, key: &KeyFile, watch: &Watch) -> Result<Vec<Case>, CliError> {
    challenge_run::diagnose_all(&places.logs, &places.verdicts, &|_| Some(None), watch)?;
    let mut known: Vec<Case> = vec![];
    for case in &key.cases {
        let path = places.verdicts.join(format!("{}.json", case.case));
        if path.exists() {
            let found: Weighed = read_json(&path)?;
            let truth = case.read()?;
            let one = found.evidence.case(&truth.truth());
            // The name that the key's kinds have.
            known.push(if truth.kind == "form-variant" {
                one.in_another_form()
            } else {
                one
            });
        }
    }
    Ok(known)
}

/// Learns temperatures, floors, thresholds and set levels from cases with known truth, and from so many more without any effect what
/// a cause must gain to be heard; returns what `calibration.toml` holds then.
pub(crate) fn learned(
    cases: &CampaignCases,
    nulls: u32,
    say: Say<'_>,
    watch: &Watch,
) -> Result<String, CliError> {
    let mut text = String::new();
    for design in &cases.designs {
        let places = Places::of(&cases.out, design);
        let key = places.make(design, cases, None, say, watch)?;
        let mut known = taught(&places, &key, watch)?;
        let (kind, groups) = match design.as_str() {
            "rig" => (LogKind::Rig, 1),
            "ramp" | "steps" => (LogKind::Drive, 1),
            _ => (LogKind::Drive, usize::MAX),
        };
        let mut source = format!(
            "terra campaign gap-calibration --designs {design} --cases {} --seed {}",
            cases.cases, cases.seed
        );
        let fallback = Calibration::frozen(kind, groups)?;
        let mut learned = Calibration::learn(&known, &fallback, source.clone());
        if nulls > 0 {
            // Another seed: cases of one number share their soil. Told to the user, who must not mark by it.
            let others = CampaignCases {
                cases: nulls,
                seed: cases.seed.wrapping_add(1),
                ..cases.clone()
            };
            let places = Places::of(&cases.out.join("nulls"), design);
            let key = places.make(design, &others, Some("none=1"), say, watch)?;
            known.extend(taught(&places, &key, watch)?);
            source.push_str(&format!(" --nulls {nulls}"));
            learned = Calibration {
                source,
                ..learned.with_nulls(&known)
            };
        }
        text.push_str(&learned.to_toml()?);
        text.push('\n');
    }
    let path = cases.out.join(CALIBRATION);
    atomic_write(&path, |w| std::io::Write::write_all(w, text.as_bytes()))?;
    Ok(text)
}
