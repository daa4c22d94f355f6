//! `terra gap --watch`: when and where a gap opens in a long drive.

use std::path::Path;

use terra_data::LogKind;
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
    let settings = WatchSettings {
        baseline: baseline(&args.baseline),
        false_alarms: args.false_alarms,
        effects: args.effects(),
    };
    let (rover, rover_sha256) = rover(&args.rover)?;
    let file = LogFile::open(log_path)?;
    if file.kind(&rover)? == LogKind::Rig {
        return Err(CliError::usage(
            format!("{} is a rig log", log_path.display()),
            "--watch looks at a drive log with wheel torques",
        ));
    }
    if rover.terrain.start.is_none() {
        return Err(CliError::rover(
            format!(
                "{}: --watch needs a soil to start from",
                args.rover.display()
            ),
            "name one: start = \"dry_sand\" in [terrain]; `terra identify` on the log's beginning finds it",
        ));
    }
    let in_files = |e: terra_gap::GapError| CliError::from(e).in_files(log_path, &args.rover);
    let spinner = Spinner::start(quiet, "watching");
    let log = file.drive(&rover)?;
    if log.wheel_torque.is_none() || log.ground_speed.is_none() {
        return Err(CliError::data(
            format!(
                "{}: a watch needs ground speed and wheel torques (or motor currents with [drivetrain])",
                log_path.display()
            ),
            "without torques `terra gap` diagnoses the motion of the whole log",
        ));
    }
    let mut watch = Watch::new(&rover, &Registry::builtin(), &settings).map_err(in_files)?;
    let mut steps = watch.push(&log).map_err(in_files)?;
    steps.extend(watch.finish().map_err(in_files)?);
    drop(spinner);
    let events = events(&steps);
    if let Some(path) = &args.json {
        let provenance = Provenance {
            log_sha256: file.sha256(),
            rover_sha256,
            seed: 0,
        };
        output::json(Some(path), &watch_json(&watch, &events, &provenance))?;
    }
    if let Some(path) = &args.track {
        output::text(Some(path), &track(&steps))?;
    }
    output::stdout(&summary(&watch, &events))
}

/// Seconds, or else the name of a manoeuvre.
fn baseline(text: &str) -> BaselineSpan {
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
fn track(steps: &[WatchStep]) -> String {
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
