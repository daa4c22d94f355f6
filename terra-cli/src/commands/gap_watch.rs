//! `terra gap --watch`: when and where a gap opens in a long drive.

use std::path::Path;

use serde_json::Value;
use terra_data::{DriveBlock, LogKind, Rover};
use terra_gap::{
    BaselineSpan, Provenance, Watch, WatchEvent, WatchSettings, WatchStep, watch_json,
};
use terra_model::Registry;

use crate::args::GapArgs;
use crate::error::CliError;
use crate::input::{BLOCK, LogFile, rover};
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
    let mut watched = Watched::new(&case, &settings)?;
    match &args.track {
        None => watched.follow(&case, &mut |_| Ok(()))?,
        Some(path) => output::pieces(Some(path), |put| watched.follow(&case, put))?,
    }
    drop(spinner);
    if let Some(path) = &args.json {
        output::json(Some(path), &watched.as_json())?;
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

impl Case<'_> {
    fn in_files(&self, error: terra_gap::GapError) -> CliError {
        CliError::from(error).in_files(self.log_name, self.rover_name)
    }
}

/// A watch of a whole log, and what it gave.
pub(crate) struct Watched {
    watch: Watch,
    /// Every event with all that was learned until it closed or the log ended.
    events: Vec<WatchEvent>,
    provenance: Provenance,
}

impl Watched {
    /// `terra gap --watch --json`.
    pub(crate) fn as_json(&self) -> Value {
        watch_json(&self.watch, &self.events, &self.provenance)
    }

    /// A watch that has seen nothing yet.
    ///
    /// # Errors
    /// A rig log; a rover file without a start; what the watch itself refuses.
    pub(crate) fn new(case: &Case<'_>, settings: &WatchSettings) -> Result<Self, CliError> {
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
        let watch = Watch::new(rover, case.registry, settings).map_err(|e| case.in_files(e))?;
        Ok(Watched {
            watch,
            events: vec![],
            provenance: Provenance {
                log_sha256: case.log.sha256(),
                rover_sha256: rover_sha256.clone(),
                seed: 0,
            },
        })
    }

    /// Watches the log, which may be longer than memory; `track` takes what its windows show, as CSV.
    ///
    /// # Errors
    /// A log without torques or ground speed; what the watch itself refuses; a track that cannot be written.
    pub(crate) fn follow(
        &mut self,
        case: &Case<'_>,
        track: &mut dyn FnMut(&str) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        track(&header())?;
        let mut blocks = case.log.drive_blocks(&case.rover.0)?;
        while let Some(DriveBlock { log, .. }) = blocks.next_block(BLOCK)? {
            if log.wheel_torque.is_none() || log.ground_speed.is_none() {
                return Err(CliError::data(
                    format!(
                        "{}: a watch needs ground speed and wheel torques (or motor currents with [drivetrain])",
                        case.log_name.display()
                    ),
                    "without torques `terra gap` diagnoses the whole log by its accelerations or its motion",
                ));
            }
            let steps = self.watch.push(&log).map_err(|e| case.in_files(e))?;
            self.see(&steps, track)?;
        }
        let steps = self.watch.finish().map_err(|e| case.in_files(e))?;
        self.see(&steps, track)
    }

    fn see(
        &mut self,
        steps: &[WatchStep],
        track: &mut dyn FnMut(&str) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        self.events
            .extend(steps.iter().filter_map(|s| s.closed.clone()));
        track(&rows(steps))
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

/// Seconds, or else the name of a manoeuvre.
fn span(text: &str) -> BaselineSpan {
    match text.parse::<f64>() {
        Ok(seconds) => BaselineSpan::Seconds(seconds),
        Err(_) => BaselineSpan::Segment(text.to_owned()),
    }
}

/// Windows that the columns of a track are summed over.
const SPANS: [usize; 3] = [5, 20, 80];

fn header() -> String {
    let mut out = "time_s,path_m,segment,window,open".to_owned();
    for n in SPANS {
        out.push_str(&format!(",score_{n},sigma_{n},threshold_{n}"));
    }
    out.push('\n');
    out
}

/// A row a window after the baseline.
fn rows(steps: &[WatchStep]) -> String {
    let mut out = String::new();
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
        for n in SPANS {
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
        let heed = |n: &&String| n.starts_with("the nominal") || n.contains("is held in between");
        for note in b.notes.iter().filter(heed) {
            out.push_str(&format!("note: {note}\n"));
        }
    }
    if events.is_empty() {
        out.push_str(&format!(
            "quiet: no gap opens in the {} windows that were watched after the baseline\n",
            watch.watched()
        ));
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
            .map(|h| {
                let unit = if h.unit == "1" { "" } else { &h.unit };
                format!(
                    "{} ({})",
                    h.effect,
                    format!("{} {unit}", short(h.magnitude)).trim_end()
                )
            })
            .collect();
        out.push_str(&format!(
            "  looks like (no verdict): {}\n",
            hints.join(", ")
        ));
        match &e.closed {
            Some(at) => out.push_str(&format!("  over at t = {} s\n", short(at.time_s))),
            None => out.push_str(
                "  open at the end of the log: what else changed meanwhile was not looked for\n",
            ),
        }
    }
    out
}
