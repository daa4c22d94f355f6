//! `terra campaign cross-structure`: the diagnosis where ground and simulator do not share the wheel law.

use std::fs;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};
use terra_data::Rover;
use terra_data::atomic_write;
use terra_gap::{
    Calibration, Diagnosis, Evidence, GapError, LogKind, Settings, diagnose_drive,
    diagnose_drive_against, diagnose_rig, diagnose_rig_against,
};
use terra_model::Registry;

use super::campaign_gap::shown;
use crate::campaign::cross::{Answer, Case, Marked, Programme, Truth, figures};
use crate::campaign::targets::Target;
use crate::challenge::design::AnyLog;
use crate::challenge::read_json;
use crate::error::CliError;
use crate::output;
use crate::progress::Watch;

/// Answers kept of each diagnosis.
const RANKED: usize = 8;

pub(crate) fn run(
    design: &str,
    cases: usize,
    seed: u64,
    out: &Path,
    file: Option<&Path>,
    quiet: bool,
) -> Result<(), CliError> {
    let rows = marked(design, cases, seed, out, &Watch::shown(quiet))?;
    if file.is_some() {
        output::json(file, &as_json(design, cases, seed, &rows))?;
    }
    output::stdout(&format!(
        "{cases} cases of design {design}, ground and nominal simulator of different structure{}",
        shown(&rows)
    ))
}

/// `terra campaign cross-structure --json`.
pub(crate) fn as_json(design: &str, cases: usize, seed: u64, rows: &[Target]) -> Value {
    json!({ "campaign": "cross-structure", "design": design, "cases": cases, "seed": seed, "figures": rows })
}

/// Draws, diagnoses and marks the cases, into a folder.
pub(crate) fn marked(
    design: &str,
    cases: usize,
    seed: u64,
    out: &Path,
    watch: &Watch,
) -> Result<Vec<Target>, CliError> {
    fs::create_dir_all(out).map_err(|reason| CliError::Write {
        target: out.display().to_string(),
        reason,
    })?;
    let programme = Programme::new(design)?;
    let registry = Registry::builtin();
    let name = programme.name();
    let bar = watch.bar(cases, "diagnosing");
    let digits = cases.to_string().len().max(3);
    let marked: Vec<Result<Marked, CliError>> = (0..cases)
        .into_par_iter()
        .map(|k| {
            watch.go_on()?;
            // Each case is written when it is there, whole: an interrupt costs no more than what is in work.
            let path = out.join(format!("{name}_seed_{seed}_case_{:0digits$}.json", k + 1));
            let marked = if path.exists() {
                read_json(&path)
            } else {
                let case = programme.case(seed, k)?;
                let marked = mark(&case, &programme, &registry);
                output::json(Some(&path), &json!(marked)).map(|()| marked)
            };
            bar.step();
            marked
        })
        .collect();
    drop(bar);
    let marked: Vec<Marked> = marked.into_iter().collect::<Result<_, _>>()?;
    learn(&programme, &marked, seed, out)?;
    Ok(figures(&marked))
}

/// What these cases teach for those of another seed, beside them.
fn learn(programme: &Programme, marked: &[Marked], seed: u64, out: &Path) -> Result<(), CliError> {
    let known: Vec<terra_gap::Case> = marked
        .iter()
        .filter(|m| m.with_baseline.refused.is_none())
        .map(|m| {
            let case = m.evidence.case(&m.name);
            if m.truth == Truth::OtherForm {
                case.in_another_form()
            } else {
                case
            }
        })
        .collect();
    let source = format!(
        "terra campaign cross-structure --design {} --cases {} --seed {seed}",
        programme.name(),
        marked.len()
    );
    let (kind, groups) = match programme.manoeuvres() {
        0 => (LogKind::Rig, 0),
        n => (LogKind::Drive, n),
    };
    let frozen = Calibration::frozen_contrast(kind, groups)?;
    let learned = Calibration::learn(&known, &frozen, source).to_toml()?;
    atomic_write(out.join("calibration.toml"), |w| {
        std::io::Write::write_all(w, learned.as_bytes())
    })?;
    Ok(())
}

fn mark(case: &Case, programme: &Programme, registry: &Registry) -> Marked {
    let own = programme.rover(case.ground);
    let other = programme.rover(case.nominal);
    let against = |rover| diagnosed(Some(&case.sim), &case.real, rover, registry);
    let alone = diagnosed(None, &case.real, &other, registry);
    let (form, magnitude) = match &case.effect {
        Some(e) => (e.form.clone(), e.magnitude.clone()),
        None => (None, vec![]),
    };
    let with_baseline = against(&other);
    Marked {
        truth: case.truth,
        name: case.name.clone(),
        ground: case.ground.to_owned(),
        nominal: case.nominal.to_owned(),
        form,
        magnitude,
        with_baseline: told(with_baseline.as_ref()),
        without: told(alone.as_ref()),
        shared_law: told(against(&own).as_ref()),
        evidence: with_baseline.map_or_else(|_| Evidence::default(), |d| d.evidence),
    }
}

/// A log of either kind diagnosed, alone or against an outside simulator's of the same kind.
fn diagnosed(
    sim: Option<&AnyLog>,
    real: &AnyLog,
    rover: &Rover,
    registry: &Registry,
) -> Result<Diagnosis, GapError> {
    let settings = Settings::of(rover);
    match (sim, real) {
        (None, AnyLog::Rig(real)) => diagnose_rig(real, rover, registry, &settings).map(|d| d.0),
        (None, AnyLog::Drive(real)) => diagnose_drive(real, rover, registry, &settings),
        (Some(AnyLog::Rig(sim)), AnyLog::Rig(real)) => {
            diagnose_rig_against(sim, real, rover, registry, &settings, false).map(|d| d.0)
        }
        (Some(AnyLog::Drive(sim)), AnyLog::Drive(real)) => {
            diagnose_drive_against(sim, real, rover, registry, &settings, false)
        }
        (Some(_), _) => Err(GapError::Mismatch(
            "a drive can only be compared with a drive, a rig with a rig".to_owned(),
        )),
    }
}

/// The answer, or that there is none: an error in one case is counted against the diagnosis and costs no other case.
fn told(found: Result<&Diagnosis, &GapError>) -> Answer {
    match found {
        Ok(diagnosis) => answer(diagnosis),
        Err(why) => Answer::refused(why.to_string()),
    }
}

fn answer(d: &Diagnosis) -> Answer {
    let mut names: Vec<String> = d.set.iter().chain(&d.nearest).cloned().collect();
    names.sort_unstable();
    names.dedup();
    names.retain(|name| name != "unknown");
    let mut ranked: Vec<(String, f64)> = d
        .causes
        .iter()
        .map(|c| (c.name.clone(), c.probability))
        .collect();
    ranked.push(("none".to_owned(), d.probability_none));
    // Equal ones stay in the diagnosis' own order.
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.truncate(RANKED);
    Answer {
        verdict: d.verdict.to_owned(),
        names,
        ranked,
        probability_unknown: d.probability_unknown,
        refused: None,
    }
}
