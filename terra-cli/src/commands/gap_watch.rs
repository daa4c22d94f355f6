//! `terra gap --watch`: when and where a gap opens in a long drive.

use std::path::Path;

use serde_json::Value;
use terra_data::{LogKind, Rover};
use terra_gap::{
    BaselineSpan, Provenance, Watch, WatchEvent, WatchSettings, WatchStep, watch_json,
};
use terra_model::Registry;

use crate::args::GapArgs;
use crate::error::CliError;
use crate::input::{LogFile, rover};
use crate::output::{self, short};
use crate::progress::Spinner;

pub(crate) fn run(args: &GapArgs, quiet: bool) -> Result<(), CliError> {
    let [log_path] = args.logs.as_slice() else {
        return Err(CliError::usage(
            "--watch looks at one log",
            "terra gap LOG --rover FILE --watch",
        ));
    };
    let inputs: [&Path; 2] = [log_path, &args.rover];
    output::claim(&[args.json.as_deref(), args.track.as_deref()], &inputs)?;
    let file = LogFile::open(log_path)?;
    let case = Case {
        log: &file,
        log_name: log_path,
        rover: rover(&args.rover)?,
        rover_name: &args.rover,
        registry: &Registry::builtin(),
    };
    let settings = settings(&args.baseline, args.false_alarms, args.effects());
    let spinner = Spinner::start(quiet, "watching");
    let watched = watch(&case, &settings)?;
    drop(spinner);
    if let Some(path) = &args.json {
        output::json(Some(path), &watched.as_json())?;
    }
    if let Some(path) = &args.track {
        output::text(Some(path), &track(&watched.steps))?;
    }
    output::stdout(&summary(&watched.watch, &watched.events))
}

/// What is watched.
pub(crate) struct Case<'a> {
    pub(crate) log: &'a LogFile<'a>,
    pub(crate) log_name: &'a Path,
    /// The nominal simulator with its fingerprint.
    pub(crate) rover: (Rover, String),
    pub(crate) rover_name: &'a Path,
    pub(crate) registry: &'a Registry,
}

/// What a watch of a whole log gave.
pub(crate) struct Watched {
    watch: Watch,
    pub(crate) steps: Vec<WatchStep>,
    events: Vec<WatchEvent>,
    provenance: Provenance,
}

impl Watched {
    /// `terra gap --watch --json`.
    pub(crate) fn as_json(&self) -> Value {
        watch_json(&self.watch, &self.events, &self.provenance)
    }
}

/// A baseline of so many seconds or of a manoeuvre, a share of false alarms, hints by name.
pub(crate) fn settings(
    baseline: &str,
    false_alarms: f64,
    effects: Option<Vec<String>>,
) -> WatchSettings {
    WatchSettings {
        baseline: span(baseline),
        false_alarms,
        effects,
    }
}

/// Watches a whole log.
///
/// # Errors
/// A rig log; a rover file without a start; a log without torques or ground speed; what the watch itself refuses.
pub(crate) fn watch(case: &Case<'_>, settings: &WatchSettings) -> Result<Watched, CliError> {
    let (rover, rover_sha256) = &case.rover;
    if case.log.kind(rover)? == LogKind::Rig {
        return Err(CliError::usage(
            format!("{} is a rig log", case.log_name.display()),
            "--watch looks at a drive log with wheel torques",
        ));
    }
    if rover.terrain.start.is_none() {
        return Err(CliError::rover(
            format!(
                "{}: --watch needs a soil to start from",
                case.rover_name.display()
            ),
            "name one: start = \"dry_sand\" in [terrain]; `terra identify` on the log's beginning finds it",
        ));
    }
    let in_files =
        |e: terra_gap::GapError| CliError::from(e).in_files(case.log_name, case.rover_name);
    let log = case.log.drive(rover)?;
    if log.wheel_torque.is_none() || log.ground_speed.is_none() {
        return Err(CliError::data(
            format!(
                "{}: a watch needs ground speed and wheel torques (or motor currents with [drivetrain])",
                case.log_name.display()
            ),
            "without torques `terra gap` diagnoses the motion of the whole log",
        ));
    }
    let mut watch = Watch::new(rover, case.registry, settings).map_err(in_files)?;
    let mut steps = watch.push(&log).map_err(in_files)?;
    steps.extend(watch.finish().map_err(in_files)?);
    Ok(Watched {
        events: events(&steps),
        watch,
        steps,
        provenance: Provenance {
            log_sha256: case.log.sha256(),
            rover_sha256: rover_sha256.clone(),
            seed: 0,
        },
    })
}

/// Seconds, or else the name of a manoeuvre.
fn span(text: &str) -> BaselineSpan {
    match text.parse::<f64>() {
        Ok(seconds) => BaselineSpan::Seconds(seconds),
        Err(_) => BaselineSpan::Segment(text.to_owned()),
    }
}

/// Every event with all that was learned until it closed or the log ended.
fn events(steps: &[WatchStep]) -> Vec<WatchEvent> {
    steps.iter().filter_map(|s| s.closed.clone()).collect()
}

/// A row a window after the baseline.
pub(crate) fn track(steps: &[WatchStep]) -> String {
    let spans = [5, 20, 80];
    let mut out = "time_s,path_m,segment,window,open".to_owned();
    for n in spans {
        out.push_str(&format!(",score_{n},sigma_{n},threshold_{n}"));
    }
    out.push('\n');
    for step in steps
        .iter()
        .filter(|s| !s.looks.is_empty() || s.opened.is_some())
    {
        let quoted = step.at.segment.replace('"', "\"\"");
        out.push_str(&format!(
            "{},{},\"{quoted}\",{},{}",
            step.at.time_s,
            step.at.path_m,
            step.at.window,
            u8::from(step.open)
        ));
        for n in spans {
            match step.looks.iter().find(|l| l.windows == n) {
                Some(l) => out.push_str(&format!(",{},{},{}", l.score, l.sigma, l.threshold)),
                None => out.push_str(",,,"),
            }
        }
        out.push('\n');
    }
    out
}

fn summary(watch: &Watch, events: &[WatchEvent]) -> String {
    if let Some(reason) = watch.refused() {
        return format!("verdict: unidentifiable\n  because: {reason}\n");
    }
    let mut out = String::new();
    if let Some(b) = watch.baseline() {
        let [a, m, z] = watch.spans_s();
        out.push_str(&format!(
            "baseline: {} windows, misfit (chi2/n, 1 = noise) {}\nwatching: every channel and {} effects over {}, {} and {} s; at most {} % of logs without a gap raise an event\n",
            b.windows,
            short(b.chi2_per_dof),
            b.effects.len(),
            short(a),
            short(m),
            short(z),
            short(100.0 * watch.settings().false_alarms),
        ));
        for note in b.notes.iter().filter(|n| n.starts_with("the nominal")) {
            out.push_str(&format!("note: {note}\n"));
        }
    }
    let (windows, _) = watch.windows();
    if events.is_empty() {
        out.push_str(&format!("quiet: no gap opens in {windows} windows\n"));
    }
    for e in events {
        out.push_str(&format!(
            "gap: opens at t = {} s (path {} m, segment {}), flagged {} s later by {} ({} sigma, {} needed)\n",
            short(e.onset.time_s),
            short(e.onset.path_m),
            e.onset.segment,
            short(e.delay_s),
            e.score,
            short(e.sigma),
            short(e.threshold),
        ));
        out.push_str(&format!(
            "  {}: measured is {} {} {} the nominal simulator, most at {} {} to {}\n",
            e.channel,
            short(e.bias.abs()),
            e.unit,
            if e.bias < 0.0 { "below" } else { "above" },
            e.factor,
            short(e.from),
            short(e.to),
        ));
        let hints: Vec<String> = e
            .nearest
            .iter()
            .map(|h| format!("{} ({} {})", h.effect, short(h.magnitude), h.unit))
            .collect();
        out.push_str(&format!(
            "  looks like (no verdict): {}\n",
            hints.join(", ")
        ));
        match &e.closed {
            Some(at) => out.push_str(&format!("  over at t = {} s\n", short(at.time_s))),
            None => out.push_str("  open at the end of the log\n"),
        }
    }
    out
}
