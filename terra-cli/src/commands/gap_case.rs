//! The case of `terra gap`: one log or several with their rover file, and its diagnosis.

use std::path::{Path, PathBuf};

use terra_data::{
    DriveInspector, DriveLog, LogKind, RigLog, Rover, Suspicion, hypothesis_terrains,
    inspect_drive, inspect_rig,
};
use terra_gap::{
    Diagnosis, DriveWindows, GapError, Named, Provenance, Settings, by_roomier_windows,
    diagnose_drives, diagnose_drives_against, diagnose_rigs, diagnose_rigs_against,
    diagnose_windows,
};
use terra_model::Registry;

use crate::error::CliError;
use crate::input::{BLOCK, LogFile, rover, sha256};
use crate::report::GapCurves;
use crate::start::{Log, Prior, complete};

/// The verdict of a log that excites too little to say anything.
const UNIDENTIFIABLE: &str = "unidentifiable";

/// A case diagnosed.
pub(crate) struct Verdict {
    pub(crate) diagnosis: Diagnosis,
    pub(crate) provenance: Provenance,
    /// Where the prior soil comes from, when the rover file does not say.
    pub(crate) said: String,
    pub(crate) curves: Option<GapCurves>,
}

/// What `terra inspect` finds that is a gap of its own: units, signs, places of wheels, a sensor that is stuck, a slope not logged.
const MISLEADS: [&str; 31] = [
    "accel-sign",
    "accel-unit",
    "axle-swapped",
    "copies",
    "degrees",
    "empty-channel",
    "gravity-on-x",
    "km-h",
    "load-sign",
    "load-unit",
    "millimetres",
    "payload-unit",
    "pitch-missing",
    "pitch-sign",
    "pull-sign",
    "pull-unit",
    "radius-unit",
    "rpm",
    "sides-swapped",
    "sinkage-sign",
    "speed-sign",
    "speed-unit",
    "stuck",
    "time-unit",
    "torque-sign",
    "torque-unit",
    "track-unit",
    "unsigned-speed",
    "unsigned-torque",
    "width-unit",
    "zeros",
];

/// The log of an outside simulator.
pub(crate) struct Against<'a> {
    pub(crate) sim: LogFile<'a>,
    pub(crate) same_soil: bool,
}

/// A log file with its name in messages.
pub(crate) struct CaseLog<'a> {
    pub(crate) file: LogFile<'a>,
    pub(crate) name: &'a Path,
}

/// Logs and their rover file, wherever they come from.
pub(crate) struct Case<'a> {
    pub(crate) logs: Vec<CaseLog<'a>>,
    /// With its fingerprint.
    pub(crate) rover: (Rover, String),
    pub(crate) rover_name: &'a Path,
    /// Where the rover file's own references start.
    pub(crate) folder: &'a Path,
    pub(crate) registry: &'a Registry,
    /// An outside simulator's log of the same.
    pub(crate) against: Option<Against<'a>>,
}

/// Diagnoses log files as the command does, alone or against an outside simulator's.
pub(crate) fn diagnose_files(
    logs: &[&Path],
    against: Option<Against<'_>>,
    rover_path: &Path,
    settings: &dyn Fn(&Rover, LogKind) -> Result<Settings, CliError>,
) -> Result<Verdict, CliError> {
    let rover = rover(rover_path)?;
    let logs = logs
        .iter()
        .map(|&name| {
            let file = LogFile::open(name)?;
            Ok(CaseLog { file, name })
        })
        .collect::<Result<_, CliError>>()?;
    let case = Case {
        logs,
        rover,
        rover_name: rover_path,
        folder: rover_path.parent().unwrap_or(Path::new("")),
        registry: &Registry::builtin(),
        against,
    };
    diagnose(case, settings)
}

/// Diagnoses a case.
pub(crate) fn diagnose(
    case: Case<'_>,
    settings: &dyn Fn(&Rover, LogKind) -> Result<Settings, CliError>,
) -> Result<Verdict, CliError> {
    let (mut rover, rover_sha256) = case.rover;
    let registry = case.registry;
    let terrains = hypothesis_terrains(&rover.terrain, case.folder)?;
    let kind = kind_of(&case.logs, &rover)?;
    let settings = settings(&rover, kind)?;
    let paths: Vec<String> = case
        .logs
        .iter()
        .map(|l| l.name.display().to_string())
        .collect();
    let all = PathBuf::from(paths.join(", "));
    let in_files = |e: CliError| e.in_files(&all, case.rover_name);
    let names = names(&case.logs)?;
    let sim_path = case.against.as_ref().map(|a| a.sim.path());
    // What is wrong with the simulator's log is told of that file.
    let of_files = |e: GapError| match (&e, sim_path) {
        (GapError::Simulator(_), Some(path)) => CliError::from(e).within(path),
        _ => in_files(e.into()),
    };
    let same_soil = case.against.as_ref().is_some_and(|a| a.same_soil);
    let sim = case.against.map(|a| a.sim);
    if let Some(sim) = &sim
        && sim.kind(&rover)? != kind
    {
        return Err(CliError::usage(
            "one log is of a vehicle and the other of a rig",
            "give the simulator's log of the same manoeuvres or trials",
        ));
    }
    let torques = match kind {
        LogKind::Rig => vec![],
        LogKind::Drive => torques(&case.logs, &rover)?,
    };
    // A simulator is compared by forces where both tell of them, else by motion.
    let by_motion = match &sim {
        Some(sim) => torques.is_empty() || !holds_torques(sim, &rover)?,
        None => torques.is_empty(),
    };
    if settings.motion_only && (kind == LogKind::Rig || !torques.is_empty()) {
        return Err(CliError::usage(
            "motion_only: the log tells of forces by a wheel on its own or by torques",
            "it is for drives without wheel torques and motor currents",
        ));
    }
    let mut cut = false;
    let mut odd = vec![];
    let (prior, mut diagnosis, curves) = match kind {
        LogKind::Rig => {
            let logs: Vec<RigLog> = case
                .logs
                .iter()
                .map(|l| l.file.rig(&rover))
                .collect::<Result<_, _>>()?;
            let each: Vec<Log<'_>> = logs.iter().map(Log::Rig).collect();
            let prior = complete(&mut rover, &each, registry, &terrains).map_err(in_files)?;
            for (name, log) in names.iter().zip(&logs) {
                let mut found = inspect_rig(log, Some(&rover)).suspicions;
                // The diagnosis tells of these by itself.
                found.retain(|s| s.code != "stuck");
                odd.push((name, found));
            }
            let named = named(&names, &logs);
            let (d, predictor) = match &sim {
                Some(sim) => {
                    let sim = sim.rig(&rover)?;
                    diagnose_rigs_against(&sim, &named, &rover, registry, &settings, same_soil)
                }
                None => diagnose_rigs(&named, &rover, registry, &settings),
            }
            .map_err(of_files)?;
            let curves = GapCurves::of_rig(&d, &predictor);
            (prior, d, Some(curves))
        }
        LogKind::Drive => {
            let (prior, d) = match by_motion {
                // Without torques no soil is sought: a log may tell of motion alone.
                true => {
                    let logs = whole(&case.logs, &rover)?;
                    for (name, log) in names.iter().zip(&logs) {
                        let found = inspect_drive(log, Some(&rover)).suspicions;
                        odd.push((name, found));
                    }
                    let named = named(&names, &logs);
                    let d = match &sim {
                        Some(sim) => {
                            let sim = sim.drive(&rover)?;
                            let same = same_soil;
                            diagnose_drives_against(&sim, &named, &rover, registry, &settings, same)
                        }
                        None => diagnose_drives(&named, &rover, registry, &settings),
                    };
                    (Prior::Given, d)
                }
                false => {
                    let prior = if rover.terrain.start.is_some() {
                        Prior::Given
                    } else {
                        let logs = beginnings(&torques, &rover)?;
                        cut = logs.iter().any(|log| log.len() == PRIOR_ROWS);
                        let each: Vec<Log<'_>> = logs.iter().map(Log::Drive).collect();
                        complete(&mut rover, &each, registry, &terrains).map_err(in_files)?
                    };
                    let most = settings.windows;
                    let windows_of = |file: &LogFile<'_>| windows(file, &rover, most);
                    let mut logs = vec![];
                    for (name, log) in names.iter().zip(&case.logs) {
                        let (kept, found) = windows_of(&log.file).map_err(in_files)?;
                        logs.push(kept);
                        odd.push((name, found));
                    }
                    let of_sim = |e: CliError| match sim_path {
                        Some(path) => e.in_files(path, case.rover_name),
                        None => in_files(e),
                    };
                    let sim = sim.as_ref().map(windows_of).transpose().map_err(of_sim)?;
                    let sim = sim.as_ref().map(|(sim, _)| (sim, same_soil));
                    let d = {
                        let named = named(&names, &logs);
                        diagnose_windows(&named, sim, &rover, registry, &settings)
                    };
                    let again = |wide: &Rover| -> Result<Diagnosis, CliError> {
                        let read = |l: &CaseLog<'_>| windows(&l.file, wide, most).map(|(w, _)| w);
                        let logs: Vec<DriveWindows> =
                            case.logs.iter().map(read).collect::<Result<_, _>>()?;
                        let named = named(&names, &logs);
                        Ok(diagnose_windows(&named, None, wide, registry, &settings)?)
                    };
                    let d = match d {
                        Ok(found) if sim.is_none() => Ok(by_roomier_windows(
                            found, &logs, &rover, again,
                        )
                        .map_err(in_files)?),
                        other => other,
                    };
                    (prior, d)
                }
            };
            (prior, d.map_err(of_files)?, None)
        }
    };
    for (name, found) in &odd {
        let of = |s: &Suspicion| match odd.len() {
            1 => s.message.clone(),
            _ => format!("{name}: {}", s.message),
        };
        let told = found.iter().filter(|s| MISLEADS.contains(&s.code)).map(of);
        told.for_each(|line| diagnosis.notice(line));
    }
    let mut said = String::new();
    match prior {
        Prior::Given => {}
        Prior::Identified(id) => {
            let part = if cut {
                format!("the first {PRIOR_ROWS} rows of ")
            } else {
                String::new()
            };
            said = format!(
                "prior soil: {id}, the winner of {} on {part}{}\n",
                rover.terrain.hypotheses,
                if paths.len() > 1 {
                    "these logs"
                } else {
                    "this log"
                }
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
        log_sha256: fingerprint(&case.logs),
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

/// The drive logs that hold torques, by their first row.
fn torques<'c, 'a>(
    logs: &'c [CaseLog<'a>],
    rover: &Rover,
) -> Result<Vec<&'c CaseLog<'a>>, CliError> {
    let mut with = vec![];
    for log in logs {
        if holds_torques(&log.file, rover)? {
            with.push(log);
        }
    }
    Ok(with)
}

fn holds_torques(log: &LogFile<'_>, rover: &Rover) -> Result<bool, CliError> {
    let first = log.drive_blocks(rover)?.next_block(1)?;
    Ok(first.is_some_and(|block| block.log.wheel_torque.is_some()))
}

fn whole(logs: &[CaseLog<'_>], rover: &Rover) -> Result<Vec<DriveLog>, CliError> {
    logs.iter().map(|log| Ok(log.file.drive(rover)?)).collect()
}

/// Rows of a drive log that a prior soil is sought on: it is where a diagnosis begins, not what it finds.
const PRIOR_ROWS: usize = 20_000;

fn beginnings(logs: &[&CaseLog<'_>], rover: &Rover) -> Result<Vec<DriveLog>, CliError> {
    let beginning = |log: &&CaseLog<'_>| {
        let first = log.file.drive_blocks(rover)?.next_block(PRIOR_ROWS)?;
        Ok(first.unwrap_or_default().log)
    };
    logs.iter().map(beginning).collect()
}

/// What is kept of a drive log, which may be longer than memory, and what in it looks wrong.
fn windows(
    file: &LogFile<'_>,
    rover: &Rover,
    most: usize,
) -> Result<(DriveWindows, Vec<Suspicion>), CliError> {
    let mut windows = DriveWindows::new(rover, most)?;
    let mut inspector = DriveInspector::new(Some(rover));
    let mut blocks = file.drive_blocks(rover)?;
    while let Some(block) = blocks.next_block(BLOCK)? {
        windows.push(&block.log)?;
        inspector.block(&block);
    }
    windows.finish()?;
    Ok((windows, inspector.finish().suspicions))
}

/// What the logs are of; they must be of the same.
fn kind_of(logs: &[CaseLog<'_>], rover: &Rover) -> Result<LogKind, CliError> {
    let mut first: Option<(LogKind, &Path)> = None;
    for log in logs {
        let kind = log.file.kind(rover)?;
        match first {
            None => first = Some((kind, log.name)),
            Some((other, name)) if other != kind => {
                let (vehicle, rig) = match kind {
                    LogKind::Rig => (name, log.name),
                    LogKind::Drive => (log.name, name),
                };
                return Err(CliError::usage(
                    format!(
                        "{} is a drive log and {} a rig log",
                        vehicle.display(),
                        rig.display()
                    ),
                    "logs that are diagnosed together must be of one vehicle or of one rig",
                ));
            }
            Some(_) => {}
        }
    }
    first
        .map(|f| f.0)
        .ok_or_else(|| CliError::usage("no log was given", "terra gap LOG --rover FILE"))
}

/// The names that prefix groups: of the files, or their paths where two files have one name.
fn names(logs: &[CaseLog<'_>]) -> Result<Vec<String>, CliError> {
    let paths: Vec<String> = logs.iter().map(|l| l.name.display().to_string()).collect();
    if let Some(twice) = doubled(&paths) {
        return Err(CliError::usage(
            format!("{twice} is given twice"),
            "a log counts once",
        ));
    }
    let short: Vec<String> = logs
        .iter()
        .map(|l| {
            let name = l.name.file_name().unwrap_or(l.name.as_os_str());
            name.to_string_lossy().into_owned()
        })
        .collect();
    Ok(match doubled(&short) {
        Some(_) => paths,
        None => short,
    })
}

fn doubled(names: &[String]) -> Option<&String> {
    let again = |(k, name): &(usize, &String)| names.iter().take(*k).any(|n| n == *name);
    names.iter().enumerate().find(again).map(|(_, name)| name)
}

fn named<'a, L>(names: &'a [String], logs: &'a [L]) -> Vec<Named<'a, L>> {
    let both = names.iter().zip(logs);
    both.map(|(name, log)| Named { name, log }).collect()
}

/// SHA-256 of the log; of several, the SHA-256 of their fingerprints in ascending order, one a line.
fn fingerprint(logs: &[CaseLog<'_>]) -> String {
    let mut each: Vec<String> = logs.iter().map(|l| l.file.sha256()).collect();
    match each.as_slice() {
        [one] => one.clone(),
        _ => {
            each.sort_unstable();
            let lines: String = each.iter().map(|hex| format!("{hex}\n")).collect();
            sha256(lines.as_bytes())
        }
    }
}
