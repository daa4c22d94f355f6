//! `terra campaign cross-structure`: the diagnosis where ground and simulator do not share the wheel law.

use std::fs;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};
use terra_data::atomic_write;
use terra_gap::{
    Calibration, Diagnosis, Evidence, GapError, Settings, diagnose_rig, diagnose_rig_against,
};
use terra_model::Registry;

use super::campaign_gap::shown;
use crate::campaign::cross::{Answer, Case, Marked, Programme, Truth, figures};
use crate::campaign::targets::Target;
use crate::challenge::read_json;
use crate::error::CliError;
use crate::output;
use crate::progress::Watch;

/// Answers kept of each diagnosis.
const RANKED: usize = 8;

pub(crate) fn run(
    cases: usize,
    seed: u64,
    out: &Path,
    file: Option<&Path>,
    quiet: bool,
) -> Result<(), CliError> {
    let rows = marked(cases, seed, out, &Watch::shown(quiet))?;
    if file.is_some() {
        output::json(file, &as_json(cases, seed, &rows))?;
    }
    output::stdout(&format!(
        "{cases} cases of a rig, ground and nominal simulator of different structure{}",
        shown(&rows)
    ))
}

/// `terra campaign cross-structure --json`.
pub(crate) fn as_json(cases: usize, seed: u64, rows: &[Target]) -> Value {
    json!({ "campaign": "cross-structure", "cases": cases, "seed": seed, "figures": rows })
}

/// Draws, diagnoses and marks the cases, into a folder.
pub(crate) fn marked(
    cases: usize,
    seed: u64,
    out: &Path,
    watch: &Watch,
) -> Result<Vec<Target>, CliError> {
    fs::create_dir_all(out).map_err(|reason| CliError::Write {
        target: out.display().to_string(),
        reason,
    })?;
    let programme = Programme::new()?;
    let registry = Registry::builtin();
    let bar = watch.bar(cases, "diagnosing");
    let digits = cases.to_string().len().max(3);
    let marked: Vec<Result<Marked, CliError>> = (0..cases)
        .into_par_iter()
        .map(|k| {
            watch.go_on()?;
            // Each case is written when it is there, whole: an interrupt costs no more than what is in work.
            let path = out.join(format!("seed_{seed}_case_{:0digits$}.json", k + 1));
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
    learn(&marked, seed, out)?;
    Ok(figures(&marked))
}

/// What these cases teach for those of another seed, beside them.
fn learn(marked: &[Marked], seed: u64, out: &Path) -> Result<(), CliError> {
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
        "terra campaign cross-structure --cases {} --seed {seed}",
        marked.len()
    );
    let learned = Calibration::learn(&known, &Calibration::frozen_contrast()?, source).to_toml()?;
    atomic_write(out.join("calibration.toml"), |w| {
        std::io::Write::write_all(w, learned.as_bytes())
    })?;
    Ok(())
}

fn mark(case: &Case, programme: &Programme, registry: &Registry) -> Marked {
    let own = programme.rover(case.ground);
    let other = programme.rover(case.nominal);
    let against = |rover| {
        let settings = Settings::of(rover);
        diagnose_rig_against(&case.sim, &case.real, rover, registry, &settings, false)
    };
    let alone = diagnose_rig(&case.real, &other, registry, &Settings::of(&other));
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
        evidence: with_baseline.map_or_else(|_| Evidence::default(), |(d, _)| d.evidence),
    }
}

/// The answer, or that there is none: an error in one case is counted against the diagnosis and costs no other case.
fn told<P>(found: Result<&(Diagnosis, P), &GapError>) -> Answer {
    match found {
        Ok((diagnosis, _)) => answer(diagnosis),
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
