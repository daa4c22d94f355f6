//! What the commands do, as functions: the same answers for a program that is no command line (the Python package).
//!
//! Nothing here prints, and nothing is written but the files that are asked for; a registry may hold the caller's own models
//! and effects.

mod beginnings;
mod campaigns;
mod challenges;
mod soils;
mod sweeps;
mod watching;
mod wheel;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::Value;
use terra_data::{
    LogKind, Rover, SoilSharing, names_a_file, parse_rover_in, read_rover_with, write_drive_log_to,
    write_rig_log_to,
};
use terra_gap::{HoldOut, Settings, to_json};
use terra_model::Registry;
use terra_sim::{Scenario, SimError, simulate_drive, simulate_rig};

use crate::args::{HoldOutArg, ImportArg};
use crate::bevameter::{Columns, Kind, to_json as to_bevameter_json};
use crate::commands::gap::{hold_out as hold_out_of, report as report_of};
use crate::commands::{
    bevameter as pressing, estimate as estimating, gap_case as diagnosing, identifiability as rows,
    identify as weighing, import as importing, inspect as looking, lists, simulate as simulating,
};
use crate::error::CliError;
use crate::identify::IdentifyOptions;
use crate::input::{self, LogFile};
use crate::output;

pub use crate::args::ReportArgs as ReportFiles;
pub use crate::progress::Stop;
pub use beginnings::{Demonstration, demo, init, init_into};
pub use campaigns::{
    Cases, campaign_cross_structure, campaign_faults, campaign_gap, campaign_gap_calibration,
    campaign_ramps, campaign_reproduction,
};
pub use challenges::{
    ChallengeOptions, challenge_make, challenge_reveal, challenge_run, challenge_score,
};
pub use soils::{
    ComplianceOptions, ExportOptions, Soil, cite, hypotheses, import_scm_json, scm_json,
    slip_compliance,
};
pub use sweeps::{merge, merge_into, sweep, sweep_runs};
pub use watching::{WatchOptions, Watched, watch};
pub use wheel::{WheelOptions, WheelTables, law, law_on, wheel};

/// A log or a rover file: on disk, or in memory under a name for messages.
#[derive(Clone, Debug)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// Its bytes.
    Memory {
        /// How messages call it.
        name: String,
        /// What a file would hold.
        bytes: Vec<u8>,
    },
}

impl Source {
    /// The file, where it is one.
    fn path(&self) -> Option<&Path> {
        match self {
            Source::File(path) => Some(path),
            Source::Memory { .. } => None,
        }
    }

    fn name(&self) -> &Path {
        match self {
            Source::File(path) => path,
            Source::Memory { name, .. } => Path::new(name),
        }
    }

    fn log(&self) -> Result<LogFile<'_>, CliError> {
        match self {
            Source::File(path) => LogFile::open(path),
            Source::Memory { name, bytes } => Ok(LogFile::in_memory(name, bytes)),
        }
    }

    fn rover(&self, registry: &Registry) -> Result<(Rover, String), CliError> {
        match self {
            Source::File(path) => input::rover_with(path, registry),
            Source::Memory { name, bytes } => {
                let text = String::from_utf8_lossy(bytes);
                let rover = parse_rover_in(&text, name, Path::new(""), registry)?;
                Ok((rover, input::sha256(bytes)))
            }
        }
    }

    /// Where a rover file's own references start.
    fn folder(&self) -> &Path {
        match self {
            Source::File(path) => path.parent().unwrap_or(Path::new("")),
            Source::Memory { .. } => Path::new(""),
        }
    }
}

/// The terrain models of a registry, as `terra models --json`.
pub fn models(registry: &Registry) -> Value {
    lists::models_json(registry)
}

/// The effects of a registry, as `terra effects --json`.
pub fn effects(registry: &Registry) -> Value {
    lists::effects_json(registry)
}

/// The soils of the literature, as `terra terrains --json`.
pub fn terrains() -> Value {
    lists::terrains_json()
}

/// The filters, as `terra filters --json`.
pub fn filters() -> Value {
    lists::filters_json()
}

/// The estimators, as `terra estimators --json`.
pub fn estimators() -> Value {
    lists::estimators_json()
}

/// Refuses a report that cannot be written, or would replace an input.
fn claim(report: &ReportFiles, inputs: &[Option<&Path>]) -> Result<(), CliError> {
    let inputs: Vec<&Path> = inputs.iter().copied().flatten().collect();
    output::claim_with(report, &[], &inputs)
}

/// A number within a range that ends at `most`.
fn within(what: &str, value: usize, least: usize, most: usize) -> Result<(), CliError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(CliError::usage(
        format!("{what} = {value}"),
        format!("expected a whole number from {least} to {most}"),
    ))
}

/// `terra inspect --json`: what is in a log, and what in it looks wrong.
///
/// # Errors
/// As the command.
pub fn inspect(log: &Source, rover: Option<&Source>) -> Result<Value, CliError> {
    let given = rover.map(|r| r.rover(&Registry::builtin())).transpose()?;
    let file = log.log()?;
    let found = looking::look(log.name(), &file, given.map(|(r, _)| r))?;
    Ok(looking::as_json(log.name(), &file, &found))
}

/// The effects and forms that only the simulator has, as `terra simulate --list`.
pub fn scenario_effects() -> Value {
    simulating::list_json()
}

/// `terra bevameter --json`: soil from plates (`plate`) or from shear tests (`shear`); writes the report, where one is asked
/// for.
///
/// # Errors
/// As the command; another kind.
pub fn bevameter(
    log: &Source,
    kind: &str,
    columns: Option<&Path>,
    report: &ReportFiles,
) -> Result<Value, CliError> {
    let kind = match kind {
        "plate" => Kind::Plate,
        "shear" => Kind::Shear,
        other => {
            return Err(CliError::usage(
                format!("kind = '{other}'"),
                "expected plate or shear",
            ));
        }
    };
    claim(report, &[log.path(), columns])?;
    let columns = columns.map(Columns::read).transpose()?.unwrap_or_default();
    let read;
    let bytes = match log {
        Source::File(path) => {
            read = input::bytes(path)?;
            &read
        }
        Source::Memory { bytes, .. } => bytes,
    };
    let (tests, soils) = pressing::fitted(log.name(), bytes, kind, &columns, report)?;
    Ok(to_bevameter_json(kind, &tests, &soils))
}

/// What `terra identifiability` asks beside soil, wheel, slips and loads; the defaults are the command's.
#[derive(Clone, Debug)]
pub struct IdentifiabilityOptions {
    /// Terrain model, with effects.
    pub model: String,
    /// A file with soils of one's own.
    pub catalogue: Option<PathBuf>,
    /// Parameters in place of the soils' own, SI.
    pub values: Vec<(String, f64)>,
    /// Measured channels with their sd.
    pub noise: Vec<(String, f64)>,
    /// Soils that should be told apart.
    pub set: String,
    /// Further rows to propose.
    pub add: usize,
    /// Report to write.
    pub report: ReportFiles,
}

/// `terra identifiability --json`: what rows at these slips, loads \[N\] and widths \[m\] could tell.
///
/// # Errors
/// As the command.
pub fn identifiability(
    terrain: &str,
    radius: f64,
    widths: &[f64],
    loads: &[f64],
    slips: &[f64],
    options: &IdentifiabilityOptions,
) -> Result<Value, CliError> {
    for (what, values) in [("widths", widths), ("loads", loads), ("slips", slips)] {
        if values.is_empty() {
            return Err(CliError::usage(
                format!("no {what}"),
                "rows are made of slips, loads and widths, at least one of each",
            ));
        }
    }
    within("add", options.add, 0, 50)?;
    let set_file = names_a_file(&options.set).then(|| Path::new(&options.set));
    claim(&options.report, &[options.catalogue.as_deref(), set_file])?;
    let noise: Vec<String> = options
        .noise
        .iter()
        .map(|(channel, sd)| format!("{channel}={sd}"))
        .collect();
    let asked = rows::Question {
        model: options.model.clone(),
        terrain: terrain.to_owned(),
        catalogue: options.catalogue.clone(),
        values: options.values.clone(),
        radius,
        widths: widths.to_vec(),
        loads: loads.to_vec(),
        slips: slips.to_vec(),
        noise: rows::noise(&noise.join(","))?,
        set: options.set.clone(),
        add: options.add,
    };
    Ok(rows::as_json(
        &asked,
        &rows::ask_with(&asked, &options.report)?,
    ))
}

/// The log of `terra import`, as the CSV it writes, with what its user should know.
///
/// # Errors
/// As the command; a kind that is no log (`scm-json`).
pub fn import(
    kind: &str,
    source: &Path,
    map: Option<&Path>,
) -> Result<(Vec<u8>, Vec<String>), CliError> {
    let known = || -> Vec<String> {
        let names = ImportArg::value_variants().iter();
        let names = names.filter_map(|k| Some(k.to_possible_value()?.get_name().to_owned()));
        names.filter(|n| n != "scm-json").collect()
    };
    let no_log = || {
        CliError::usage(
            format!("kind = '{kind}'"),
            format!("expected one of {}", known().join(", ")),
        )
    };
    let asked = ImportArg::from_str(kind, false).map_err(|_| no_log())?;
    let log = importing::log(asked, source, map)?.ok_or_else(no_log)?;
    let mut csv = Vec::new();
    log.write_to(&mut csv).map_err(|reason| CliError::Write {
        target: "memory".to_owned(),
        reason,
    })?;
    Ok((csv, log.notes))
}

/// The table of `terra estimate`, as CSV; writes the report, where one is asked for.
///
/// # Errors
/// As the command: a rig log, a rover file that does not do, a filter by an unknown name.
pub fn estimate(
    log: &Source,
    rover: &Source,
    filter: &str,
    smooth: bool,
    report: &ReportFiles,
) -> Result<String, CliError> {
    claim(report, &[log.path(), rover.path()])?;
    let (nominal, rover_sha256) = rover.rover(&Registry::builtin())?;
    let file = log.log()?;
    if file.kind(&nominal)? == LogKind::Rig {
        return Err(estimating::no_rig(log.name()));
    }
    let within = |e: CliError| e.in_files(log.name(), rover.name());
    if smooth || report.asked() {
        let known = estimating::Known {
            file: &file,
            name: log.name(),
            rover: &nominal,
            rover_name: rover.name(),
            rover_sha256: &rover_sha256,
        };
        return estimating::in_memory(&known, filter, smooth, report);
    }
    let mut table = String::new();
    let mut put = |piece: &str| {
        table.push_str(piece);
        Ok(())
    };
    let passes = estimating::Passes::new(&file, &nominal, filter).map_err(within)?;
    let run = passes.first().map_err(within)?;
    passes.second(run, &mut put).map_err(within)?;
    Ok(table)
}

/// What is asked of [`identify`] beside how it runs.
#[derive(Clone, Debug, Default)]
pub struct IdentifyAsked {
    /// In place of the rover file's hypotheses: a catalogue set, a CSV of soils, or a TOML plan of sets.
    pub hypotheses: Option<String>,
    /// First and last row of a drive log to weigh, from 1.
    pub rows: Option<(usize, usize)>,
    /// Report to write.
    pub report: ReportFiles,
}

/// `identify.json` of `terra identify`; writes the report, where one is asked for.
///
/// # Errors
/// As the command.
pub fn identify(
    log: &Source,
    rover: &Source,
    registry: &Registry,
    asked: &IdentifyAsked,
    options: &IdentifyOptions,
) -> Result<Value, CliError> {
    if let Some((first, last)) = asked.rows {
        within("first of rows", first, 1, usize::MAX)?;
        within("last of rows", last, first, usize::MAX)?;
    }
    claim(&asked.report, &[log.path(), rover.path()])?;
    let case = weighing::Case {
        log: &log.log()?,
        log_name: log.name(),
        rover: rover.rover(registry)?,
        rover_name: rover.name(),
        folder: rover.folder(),
        registry,
        hypotheses: asked.hypotheses.as_deref(),
        rows: asked.rows,
    };
    Ok(weighing::weigh(&case, options, &asked.report)?.as_json())
}

/// What happens to old evidence, as `--choice` says it: `none`, `floor:F`, `forgetting:L`, `transition:FILE`.
///
/// # Errors
/// [`CliError::Usage`].
pub fn choice(text: &str) -> Result<terra_mme::Choice, CliError> {
    weighing::choice(text)
}

/// What is asked of [`gap`].
#[derive(Clone, Debug)]
pub struct GapOptions {
    /// Candidate effects by name; `None` for all.
    pub effects: Option<Vec<String>>,
    /// `segment`, `trial`, `condition` or `slip`; `None` for the default of the log's kind.
    pub hold_out: Option<String>,
    /// Most effects combined (1 or 2).
    pub combine: usize,
    /// Most windows of a drive that are used, at least 16.
    pub windows: usize,
    /// Mock cases to calibrate with; 0 takes what ships.
    pub calibrate: usize,
    /// Seed of the mock cases.
    pub seed: u64,
    /// `shared` or `own`: what several logs share.
    pub soil: String,
    /// An outside simulator's log of the same.
    pub sim: Option<Source>,
    /// The simulator's log and the others are of the same ground.
    pub same_bed: bool,
    /// A drive without torques is diagnosed by its motion alone, even where its accelerations tell of forces.
    pub motion_only: bool,
    /// Report to write.
    pub report: ReportFiles,
}

impl Default for GapOptions {
    fn default() -> Self {
        GapOptions {
            effects: None,
            hold_out: None,
            combine: 2,
            windows: Settings::WINDOWS,
            calibrate: 0,
            seed: 1,
            soil: "shared".to_owned(),
            sim: None,
            same_bed: false,
            motion_only: false,
            report: ReportFiles::default(),
        }
    }
}

/// `verdict.json` of `terra gap`, of one log or of several together; writes the report, where one is asked for.
///
/// # Errors
/// As the command.
pub fn gap(
    logs: &[Source],
    rover: &Source,
    registry: &Registry,
    options: &GapOptions,
) -> Result<Value, CliError> {
    if !(1..=2).contains(&options.combine) {
        return Err(CliError::usage(
            format!("combine = {}: expected 1 or 2", options.combine),
            "1 tries effects one by one, 2 also pairs",
        ));
    }
    within("windows", options.windows, 16, u32::MAX as usize)?;
    within("calibrate", options.calibrate, 0, 100_000)?;
    if options.same_bed && options.sim.is_none() {
        return Err(CliError::usage(
            "same_bed without sim",
            "it says that the simulator's log and the others are of the same ground",
        ));
    }
    let mut inputs: Vec<Option<&Path>> = logs.iter().map(Source::path).collect();
    inputs.push(rover.path());
    inputs.push(options.sim.as_ref().and_then(Source::path));
    claim(&options.report, &inputs)?;
    let soil = match options.soil.as_str() {
        "shared" => SoilSharing::Shared,
        "own" => SoilSharing::Own,
        other => {
            return Err(CliError::usage(
                format!("soil = '{other}': expected shared or own"),
                "shared takes one soil for all logs, own one for each",
            ));
        }
    };
    let settings = |nominal: &Rover, kind: LogKind| -> Result<Settings, CliError> {
        let mut settings = Settings::of(nominal);
        settings.effects = options.effects.clone();
        settings.combine = options.combine;
        settings.windows = options.windows;
        settings.calibrate = options.calibrate;
        settings.seed = options.seed;
        settings.soil = soil;
        settings.motion_only = options.motion_only;
        settings.hold_out = hold_out(options.hold_out.as_deref(), kind)?;
        Ok(settings)
    };
    let names: Vec<&Path> = logs.iter().map(Source::name).collect();
    let logs = logs
        .iter()
        .map(|log| {
            let (file, name) = (log.log()?, log.name());
            Ok(diagnosing::CaseLog { file, name })
        })
        .collect::<Result<_, CliError>>()?;
    let case = diagnosing::Case {
        logs,
        rover: rover.rover(registry)?,
        rover_name: rover.name(),
        folder: rover.folder(),
        registry,
        against: options
            .sim
            .as_ref()
            .map(|sim| {
                Ok::<_, CliError>(diagnosing::Against {
                    sim: sim.log()?,
                    same_soil: options.same_bed,
                })
            })
            .transpose()?,
    };
    let verdict = diagnosing::diagnose(case, &settings)?;
    report_of(&options.report, &names, &verdict)?;
    Ok(to_json(&verdict.diagnosis, &verdict.provenance))
}

fn hold_out(asked: Option<&str>, kind: LogKind) -> Result<Option<HoldOut>, CliError> {
    let asked = asked
        .map(|name| {
            HoldOutArg::from_str(name, false).map_err(|_| {
                CliError::usage(
                    format!("hold_out = '{name}': expected segment, trial, condition or slip"),
                    "leave it out for the default of the log's kind",
                )
            })
        })
        .transpose()?;
    hold_out_of(asked, kind)
}

/// A simulated log and its truth, as the CSV files that `terra simulate` writes.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The log a user would have.
    pub log: Vec<u8>,
    /// What really happened.
    pub truth: String,
}

/// Runs a scenario file.
///
/// # Errors
/// As `terra simulate`.
pub fn simulate(
    scenario: &Path,
    seed: Option<u64>,
    registry: &Registry,
) -> Result<Simulated, CliError> {
    let mut said = Scenario::read(scenario)?;
    if let Some(seed) = seed {
        said.seed = seed;
    }
    let rover = read_rover_with(said.rover_path(scenario), registry)?;
    let at = |e: SimError| CliError::from(e).within(scenario);
    let memory = |reason| CliError::Write {
        target: "memory".to_owned(),
        reason,
    };
    let mut log = Vec::new();
    let truth = if said.trials.is_empty() {
        let run = simulate_drive(&said, &rover, registry).map_err(at)?;
        write_drive_log_to(&mut log, &run.log).map_err(memory)?;
        simulating::csv(&run.truth.columns())
    } else {
        let run = simulate_rig(&said, &rover, registry).map_err(at)?;
        write_rig_log_to(&mut log, &run.log).map_err(memory)?;
        simulating::csv(&run.truth.columns())
    };
    Ok(Simulated { log, truth })
}
