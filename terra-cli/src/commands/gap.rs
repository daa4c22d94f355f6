//! `terra gap`.

use std::path::Path;

use terra_data::{LogKind, Rover, SoilSharing};
use terra_gap::{Baseline, Cause, CauseKind, Diagnosis, HoldOut, Settings, to_json};

use super::gap_case::{Against, Verdict, diagnose_files};
use super::gap_watch;
use crate::args::{GapArgs, HoldOutArg, ReportArgs, SoilArg};
use crate::error::CliError;
use crate::input::LogFile;
use crate::output::{self, short};
use crate::progress::Spinner;
use crate::report::{self, magnitudes};

/// Probability from which two causes are told of that one would do for.
const UNSEEN_FROM: f64 = 0.005;

pub(crate) fn run(args: &GapArgs, quiet: bool) -> Result<(), CliError> {
    if args.watch {
        return gap_watch::run(args, quiet);
    }
    let logs: Vec<&Path> = args.logs.iter().map(AsRef::as_ref).collect();
    let mut inputs = logs.clone();
    inputs.push(&args.rover);
    inputs.extend(args.sim.as_deref());
    output::claim_with(&args.report, &[args.json.as_deref()], &inputs)?;
    let settings = |rover: &Rover, kind: LogKind| -> Result<Settings, CliError> {
        let mut settings = Settings::of(rover);
        settings.combine = args.combine.into();
        settings.calibrate = args.calibrate as usize;
        settings.seed = args.seed;
        settings.windows = args.windows as usize;
        settings.effects = args.effects();
        settings.motion_only = args.motion_only;
        settings.hold_out = hold_out(args.hold_out, kind)?;
        settings.soil = match args.soil {
            SoilArg::Shared => SoilSharing::Shared,
            SoilArg::Own => SoilSharing::Own,
        };
        Ok(settings)
    };
    let spinner = Spinner::start(quiet, "diagnosing");
    let against = args
        .sim
        .as_deref()
        .map(|sim| {
            Ok::<_, CliError>(Against {
                sim: LogFile::open(sim)?,
                same_soil: args.same_bed,
            })
        })
        .transpose()?;
    let verdict = diagnose_files(&logs, against, &args.rover, &settings)?;
    drop(spinner);
    if let Some(path) = &args.json {
        output::json(
            Some(path),
            &to_json(&verdict.diagnosis, &verdict.provenance),
        )?;
    }
    report(&args.report, &logs, &verdict)?;
    output::stdout(&format!("{}{}", verdict.said, summary(&verdict.diagnosis)))
}

/// Writes the report, where one was asked for.
pub(crate) fn report(
    report: &ReportArgs,
    logs: &[&Path],
    verdict: &Verdict,
) -> Result<(), CliError> {
    let provenance = &verdict.provenance;
    output::report(report, || report::Page {
        title: "Where the simulator differs from reality".to_owned(),
        subtitle: subtitle(logs),
        sections: vec![report::gap_section(
            &verdict.diagnosis,
            verdict.curves.as_ref(),
        )],
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("log SHA-256".to_owned(), provenance.log_sha256.clone()),
            ("rover SHA-256".to_owned(), provenance.rover_sha256.clone()),
        ],
    })
}

fn subtitle(logs: &[&Path]) -> String {
    let names: Vec<String> = logs.iter().map(|l| l.display().to_string()).collect();
    names.join(", ")
}

pub(crate) fn hold_out(
    asked: Option<HoldOutArg>,
    kind: LogKind,
) -> Result<Option<HoldOut>, CliError> {
    Ok(match (asked, kind) {
        (None, _) => None,
        (Some(HoldOutArg::Slip), _) => Some(HoldOut::Slip),
        (Some(HoldOutArg::Segment), LogKind::Drive) => Some(HoldOut::Segment),
        (Some(HoldOutArg::Trial), LogKind::Rig) => Some(HoldOut::Trial),
        (Some(HoldOutArg::Condition), LogKind::Rig) => Some(HoldOut::Condition),
        (Some(_), LogKind::Drive) => {
            return Err(CliError::usage(
                "a drive log is held out by segment or slip",
                "--hold-out segment",
            ));
        }
        (Some(_), LogKind::Rig) => {
            return Err(CliError::usage(
                "a rig log is held out by trial, condition or slip",
                "--hold-out trial",
            ));
        }
    })
}

/// Ten lines a person can act on.
pub(crate) fn summary(d: &Diagnosis) -> String {
    let mut out = format!("verdict: {}", d.verdict);
    if !d.set.is_empty() {
        out.push_str(&format!(" {{{}}}", d.set.join(", ")));
    }
    out.push('\n');
    if let Some(reason) = &d.reason {
        out.push_str(&format!("  because: {reason}\n"));
    }
    if let Some(logs) = &d.logs {
        let soil = match logs.soil {
            SoilSharing::Shared => "one soil for all",
            SoilSharing::Own => "a soil of its own for each",
        };
        let names = logs.names.join(", ");
        out.push_str(&format!("logs: {names}; {soil}\n"));
    }
    if let (Some(a), Some(b)) = (d.waterfall.as_given, d.waterfall.refitted) {
        out.push_str(&format!(
            "misfit (chi2/n, 1 = noise): {} as given, {} after re-fitting the soil{}\n",
            short(a),
            short(b),
            d.waterfall
                .after
                .map(|c| format!(", {} with {}", short(c), d.accepted_names.join(" + ")))
                .unwrap_or_default()
        ));
    }
    for h in &d.heed {
        out.push_str(&format!("heed: {h}\n"));
    }
    if let Some(b) = &d.baseline {
        out.push_str(&format!(
            "baseline: the nominal simulator follows the simulator's log with chi2/n {} and a form error of {}\n",
            short(b.chi2_per_dof),
            form_error(b)
        ));
        let shows: Vec<String> = b.shows.iter().map(|s| s.effect.clone()).collect();
        if !shows.is_empty() {
            out.push_str(&format!(
                "baseline: the simulator's log shows {} too; of these only a change is asked for\n",
                shows.join(", ")
            ));
        }
    }
    for p in d.places.iter().take(2) {
        out.push_str(&format!(
            "where: {} at {} {}: measured is {} {} {} the re-fitted model ({:.1} sigma)\n",
            p.channel,
            p.factor,
            range(p.from, p.to),
            short(p.bias.abs()),
            p.unit,
            if p.bias < 0.0 { "below" } else { "above" },
            p.sigma
        ));
    }
    for c in d.causes.iter().filter(|c| !c.unseen_second).take(3) {
        out.push_str(&format!(
            "cause: {} with probability {:.2} ({:+.1} nats over the re-fitted soil){}\n",
            c.name,
            c.probability,
            c.log_evidence_gain,
            how_large(d, c)
        ));
    }
    for line in alike(d) {
        out.push_str(&line);
    }
    for first in d
        .causes
        .iter()
        .filter(|c| c.kind == CauseKind::Effect)
        .take(3)
    {
        let unseen = beside(d, first);
        if !unseen.is_empty() {
            out.push_str(&format!(
                "cannot be ruled out beside {}, as it would hardly show here: {}\n",
                first.name,
                unseen.join(", ")
            ));
        }
    }
    if !d.causes.is_empty() {
        out.push_str(&format!(
            "nothing missing: {:.2}, something unknown: {:.2}\n",
            d.probability_none, d.probability_unknown
        ));
    }
    if !d.nearest.is_empty() {
        out.push_str(&format!("nearest: {}\n", d.nearest.join(", ")));
    }
    if let Some(h) = &d.held_out {
        match h.closed {
            Some(c) if !c.tells() => out.push_str(&format!(
                "held out by {}: too near the noise to say how much of the gap closes\n",
                h.by.name()
            )),
            Some(c) => out.push_str(&format!(
                "held out by {}: {:.0} % of the gap closes (95 %: {:.0} to {:.0} %)\n",
                h.by.name(),
                100.0 * c.mean,
                100.0 * c.lo,
                100.0 * c.hi
            )),
            None => out.push_str(&format!(
                "held out by {}: no share can be given, {}\n",
                h.by.name(),
                h.why_open()
            )),
        }
    }
    for u in &d.undetermined {
        out.push_str(&format!("cannot be known: {u}\n"));
    }
    if let Some(n) = d.next.first() {
        out.push_str(&format!(
            "next: {} ({:.1} nats expected)\n",
            n.manoeuvre, n.expected_nats
        ));
    }
    out
}

/// Answers of the set whose trace others leave too, each pair once.
/// How much a simulator differs from the nominal law's form: in pull, or by motion alone in how far its vehicle turns.
fn form_error(b: &Baseline) -> String {
    let percent = 100.0 * b.form_error.first().copied().unwrap_or(0.0);
    if b.form_error_of.first() == Some(&"pull") {
        format!("{percent:.1} % of the load in pull")
    } else {
        format!("{percent:.0} % of an ideal drive's yaw rate")
    }
}

fn alike(d: &Diagnosis) -> Vec<String> {
    let mut told: Vec<&str> = vec![];
    let mut lines = vec![];
    for c in d.causes.iter().filter(|c| d.set.contains(&c.name)) {
        let others = c.indistinguishable_from.iter().map(String::as_str);
        let new: Vec<&str> = others.filter(|name| !told.contains(name)).collect();
        if !new.is_empty() {
            let (name, new) = (&c.name, new.join(", "));
            lines.push(format!(
                "alike: {name} leaves the same trace in this log as {new}\n"
            ));
        }
        told.push(&c.name);
    }
    lines
}

/// From where to where, or where.
fn range(from: f64, to: f64) -> String {
    match (short(from), short(to)) {
        (from, to) if from == to => from,
        (from, to) => format!("{from} to {to}"),
    }
}

/// How large an answer of the set is, and by which formula where that is not the usual one.
fn how_large(d: &Diagnosis, cause: &Cause) -> String {
    let sizes = magnitudes(cause).join(", ").replace('\u{a0}', " ");
    if sizes.is_empty() || !d.set.contains(&cause.name) {
        return String::new();
    }
    let form = match cause.form.as_str() {
        "default" => String::new(),
        "free" => ", by a formula left free".to_owned(),
        "edge" => ", where another soil begins".to_owned(),
        form => format!(", by the form {form}"),
    };
    let what = match cause.kind {
        CauseKind::Effect => "magnitude ",
        CauseKind::Combination | CauseKind::Structure => "",
    };
    format!(": {what}{sizes}{form}")
}

/// Second causes that may stand unseen beside one, with their probabilities.
fn beside(d: &Diagnosis, first: &Cause) -> Vec<String> {
    // The pair has a share of its first cause's probability: beside a less probable one it is not listed.
    let listed = UNSEEN_FROM..=first.probability;
    let pairs = d
        .causes
        .iter()
        .filter(|c| c.unseen_second && listed.contains(&c.probability));
    pairs
        .filter_map(|c| {
            let (a, b) = c.name.split_once('+')?;
            let second = if a == first.name { b } else { a };
            (a == first.name || b == first.name).then(|| format!("{second} ({:.2})", c.probability))
        })
        .collect()
}
