//! `terra gap`.

use std::path::Path;

use terra_data::{LogKind, Rover, hypothesis_terrains};
use terra_gap::{
    Diagnosis, HoldOut, Provenance, Settings, diagnose_drive, diagnose_drive_against, diagnose_rig,
    diagnose_rig_against, to_json,
};
use terra_model::Registry;

use crate::args::{GapArgs, HoldOutArg};
use crate::error::CliError;
use crate::input::{LogFile, rover};
use crate::output::{self, short};
use crate::progress::Spinner;
use crate::report::{self, GapCurves};
use crate::start::{Log, Prior, complete};

/// The verdict of a log that excites too little to say anything.
const UNIDENTIFIABLE: &str = "unidentifiable";

/// A log diagnosed.
pub(crate) struct Verdict {
    pub(crate) diagnosis: Diagnosis,
    pub(crate) provenance: Provenance,
    /// Where the prior soil comes from, when the rover file does not say.
    said: String,
    curves: Option<GapCurves>,
}

/// The log of an outside simulator.
#[derive(Clone, Copy)]
pub(crate) struct Against<'a> {
    pub(crate) sim: &'a Path,
    pub(crate) same_soil: bool,
}

/// A log and its rover file, wherever they come from.
pub(crate) struct Case<'a> {
    pub(crate) log: &'a LogFile<'a>,
    pub(crate) log_name: &'a Path,
    /// With its fingerprint.
    pub(crate) rover: (Rover, String),
    pub(crate) rover_name: &'a Path,
    /// Where the rover file's own references start.
    pub(crate) folder: &'a Path,
    pub(crate) registry: &'a Registry,
    /// An outside simulator's log of the same.
    pub(crate) against: Option<Against<'a>>,
}

/// Diagnoses one log file as the command does, alone or against an outside simulator's.
pub(crate) fn diagnose_file(
    log: &Path,
    against: Option<Against<'_>>,
    rover_path: &Path,
    settings: &dyn Fn(&Rover, LogKind) -> Result<Settings, CliError>,
) -> Result<Verdict, CliError> {
    let rover = rover(rover_path)?;
    let case = Case {
        log: &LogFile::open(log)?,
        log_name: log,
        rover,
        rover_name: rover_path,
        folder: rover_path.parent().unwrap_or(Path::new("")),
        registry: &Registry::builtin(),
        against,
    };
    diagnose(case, settings)
}

/// Diagnoses one log.
pub(crate) fn diagnose(
    case: Case<'_>,
    settings: &dyn Fn(&Rover, LogKind) -> Result<Settings, CliError>,
) -> Result<Verdict, CliError> {
    let (mut rover, rover_sha256) = case.rover;
    let (file, registry) = (case.log, case.registry);
    let terrains = hypothesis_terrains(&rover.terrain, case.folder)?;
    let kind = file.kind(&rover)?;
    let settings = settings(&rover, kind)?;
    let in_files = |e: CliError| e.in_files(case.log_name, case.rover_name);
    let sim = case.against.map(|a| LogFile::open(a.sim)).transpose()?;
    if let Some(sim) = &sim
        && sim.kind(&rover)? != kind
    {
        return Err(CliError::usage(
            "one log is of a vehicle and the other of a rig",
            "give the simulator's log of the same manoeuvres or trials",
        ));
    }
    let same_soil = case.against.is_some_and(|a| a.same_soil);
    let (prior, mut diagnosis, curves) = match kind {
        LogKind::Rig => {
            let log = file.rig(&rover)?;
            let prior =
                complete(&mut rover, &Log::Rig(&log), registry, &terrains).map_err(in_files)?;
            let (d, predictor) = match &sim {
                Some(sim) => diagnose_rig_against(
                    &sim.rig(&rover)?,
                    &log,
                    &rover,
                    registry,
                    &settings,
                    same_soil,
                ),
                None => diagnose_rig(&log, &rover, registry, &settings),
            }
            .map_err(|e| in_files(e.into()))?;
            let curves = GapCurves::of_rig(&d, &predictor);
            (prior, d, Some(curves))
        }
        LogKind::Drive => {
            let log = file.drive(&rover)?;
            // A log without torques tells of motion alone: no soil is asked, none is needed.
            let prior = if log.wheel_torque.is_none() {
                Prior::Given
            } else {
                complete(&mut rover, &Log::Drive(&log), registry, &terrains).map_err(in_files)?
            };
            let d = match &sim {
                Some(sim) => diagnose_drive_against(
                    &sim.drive(&rover)?,
                    &log,
                    &rover,
                    registry,
                    &settings,
                    same_soil,
                ),
                None => diagnose_drive(&log, &rover, registry, &settings),
            }
            .map_err(|e| in_files(e.into()))?;
            (prior, d, None)
        }
    };
    let mut said = String::new();
    match prior {
        Prior::Given => {}
        Prior::Identified(id) => {
            said = format!(
                "prior soil: {id}, the winner of {} on this log\n",
                rover.terrain.hypotheses
            );
        }
        // A stand-in soil may only lead to the answer that it does not matter for.
        Prior::Unknown { why } if diagnosis.verdict == UNIDENTIFIABLE => {
            let reason = diagnosis
                .reason
                .take()
                .map(|r| format!("{r}; "))
                .unwrap_or_default();
            diagnosis.reason = Some(format!("{reason}no soil to start from: {why}"));
        }
        Prior::Unknown { why } => {
            return Err(in_files(CliError::data(
                format!("no soil to start from: {why}"),
                "name one: start = \"dry_sand\" in [terrain]; `terra terrains` lists them",
            )));
        }
    }
    let provenance = Provenance {
        log_sha256: file.sha256(),
        rover_sha256,
        seed: if settings.calibrate > 0 {
            settings.seed
        } else {
            0
        },
    };
    Ok(Verdict {
        diagnosis,
        provenance,
        said,
        curves,
    })
}

pub(crate) fn run(args: &GapArgs, quiet: bool) -> Result<(), CliError> {
    let mut inputs: Vec<&Path> = vec![&args.log, &args.rover];
    inputs.extend(args.sim.as_deref());
    output::claim_with(&args.report, &[args.json.as_deref()], &inputs)?;
    let settings = |rover: &Rover, kind: LogKind| -> Result<Settings, CliError> {
        let mut settings = Settings::of(rover);
        settings.combine = args.combine.into();
        settings.calibrate = args.calibrate as usize;
        settings.seed = args.seed;
        if args.effects != "all" {
            settings.effects = Some(
                args.effects
                    .split(',')
                    .map(|s| s.trim().to_owned())
                    .collect(),
            );
        }
        settings.hold_out = hold_out(args.hold_out, kind)?;
        Ok(settings)
    };
    let spinner = Spinner::start(quiet, "diagnosing");
    let against = args.sim.as_deref().map(|sim| Against {
        sim,
        same_soil: args.same_bed,
    });
    let verdict = diagnose_file(&args.log, against, &args.rover, &settings)?;
    drop(spinner);
    let Verdict {
        diagnosis,
        provenance,
        said,
        curves,
    } = verdict;
    if let Some(path) = &args.json {
        output::json(Some(path), &to_json(&diagnosis, &provenance))?;
    }
    output::report(&args.report, || report::Page {
        title: "Where the simulator differs from reality".to_owned(),
        subtitle: args.log.display().to_string(),
        sections: vec![report::gap_section(&diagnosis, curves.as_ref())],
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("log SHA-256".to_owned(), provenance.log_sha256.clone()),
            ("rover SHA-256".to_owned(), provenance.rover_sha256.clone()),
        ],
    })?;
    output::stdout(&format!("{said}{}", summary(&diagnosis)))
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
    if let Some(b) = &d.baseline {
        out.push_str(&format!(
            "baseline: the nominal simulator follows the simulator's log with chi2/n {} and a form error of {:.1} % of the load in pull\n",
            short(b.chi2_per_dof),
            100.0 * b.form_error[0]
        ));
    }
    for p in d.places.iter().take(2) {
        out.push_str(&format!(
            "where: {} at {} {} to {}: measured is {} {} {} the re-fitted model ({:.1} sigma)\n",
            p.channel,
            p.factor,
            short(p.from),
            short(p.to),
            short(p.bias.abs()),
            p.unit,
            if p.bias < 0.0 { "below" } else { "above" },
            p.sigma
        ));
    }
    for c in d.causes.iter().take(3) {
        out.push_str(&format!(
            "cause: {} with probability {:.2} ({:+.1} nats over the re-fitted soil)\n",
            c.name, c.probability, c.log_evidence_gain
        ));
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
                "held out by {}: nothing left to explain\n",
                h.by.name()
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
