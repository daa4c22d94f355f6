//! From a log and a rover file to a diagnosis.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use terra_data::{DriveLog, RigLog, Rover, slip_against_speeds};
use terra_model::{Law, Registry};

use crate::apart::better_apart;
use crate::contrast::against;
use crate::dataset::{ChannelInfo, DataSet};
use crate::diagnose::{Diagnosis, diagnose};
use crate::drive::{self, DriveWindows};
use crate::error::GapError;
use crate::kinematic::diagnose_logs;
use crate::logs::{Logs, Named};
use crate::parallel::among_them;
use crate::predictor::Predictor;
use crate::rig;
use crate::roomier::by_roomier_windows;
use crate::settings::{LogKind, Settings};
use crate::setup::{Rival, Setup};
use crate::soil::{free_soil, rival_soil};
use crate::soil_space::SoilSpace;

/// Diagnoses a rig log. Returns the predictor too, for curves.
///
/// # Errors
/// A configuration that makes no sense, or a used channel without noise level.
pub fn diagnose_rig(
    log: &RigLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<(Diagnosis, rig::RigPredictor), GapError> {
    rig_logs(&Logs::one(log), None, rover, registry, settings)
}

/// Diagnoses several logs of one rig as one: trials are prefixed with the log's name, and the soil is one for all or one a log
/// ([`Settings::soil`]). The order of the logs does not matter.
///
/// # Errors
/// As [`diagnose_rig`]; two logs of one name.
pub fn diagnose_rigs(
    logs: &[Named<'_, RigLog>],
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<(Diagnosis, rig::RigPredictor), GapError> {
    let logs = Logs::new(logs, settings.soil)?;
    rig_logs(&logs, None, rover, registry, settings)
}

/// Diagnoses a drive log. Without torques the ground's forces are known by the accelerations that they cause, where the log holds
/// `accel_x_m_s2` and the rover file names its soil. Where that is not so, or what forces leave unknown the motion explains, it is
/// diagnosed by its motion alone ([`diagnose_kinematic`](crate::diagnose_kinematic)).
///
/// # Errors
/// A configuration that makes no sense, or a used channel without noise level.
pub fn diagnose_drive(
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    drive_logs(&Logs::one(log), None, rover, registry, settings)
}

/// Diagnoses several logs of one vehicle as one: manoeuvres are prefixed with the log's name, time, path and ruts start anew
/// with each, a channel that one lacks is missing there only, and the soil is one for all or one a log ([`Settings::soil`]).
/// The order of the logs does not matter. Without torques in any of them it is as with [one](diagnose_drive).
///
/// # Errors
/// As [`diagnose_drive`]; two logs of one name.
pub fn diagnose_drives(
    logs: &[Named<'_, DriveLog>],
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    let logs = Logs::new(logs, settings.soil)?;
    drive_logs(&logs, None, rover, registry, settings)
}

/// Diagnoses a rig log against an outside simulator, whose log of the same trials is fitted first. `same_soil`: the simulator
/// was given this very soil, so other soil is no answer.
///
/// # Errors
/// As [`diagnose_rig`]; a simulator's log that the nominal law cannot be fitted to.
pub fn diagnose_rig_against(
    sim: &RigLog,
    log: &RigLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
    same_soil: bool,
) -> Result<(Diagnosis, rig::RigPredictor), GapError> {
    let sim = Some((sim, same_soil));
    rig_logs(&Logs::one(log), sim, rover, registry, settings)
}

/// The same of several real logs.
///
/// # Errors
/// As [`diagnose_rig_against`] and [`diagnose_rigs`].
pub fn diagnose_rigs_against(
    sim: &RigLog,
    logs: &[Named<'_, RigLog>],
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
    same_soil: bool,
) -> Result<(Diagnosis, rig::RigPredictor), GapError> {
    let logs = Logs::new(logs, settings.soil)?;
    rig_logs(&logs, Some((sim, same_soil)), rover, registry, settings)
}

/// Diagnoses a drive log against an outside simulator, whose log of the same manoeuvres is fitted first: by forces where both hold
/// wheel torques, else by their motion alone.
///
/// # Errors
/// As [`diagnose_drive`]; a simulator's log that the nominal law cannot be fitted to.
pub fn diagnose_drive_against(
    sim: &DriveLog,
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
    same_soil: bool,
) -> Result<Diagnosis, GapError> {
    let sim = Some((sim, same_soil));
    drive_logs(&Logs::one(log), sim, rover, registry, settings)
}

/// The same of several real logs.
///
/// # Errors
/// As [`diagnose_drive_against`] and [`diagnose_drives`].
pub fn diagnose_drives_against(
    sim: &DriveLog,
    logs: &[Named<'_, DriveLog>],
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
    same_soil: bool,
) -> Result<Diagnosis, GapError> {
    let logs = Logs::new(logs, settings.soil)?;
    drive_logs(&logs, Some((sim, same_soil)), rover, registry, settings)
}

/// Diagnoses drive logs of any length by the windows kept of each, alone or against an outside simulator's, which comes
/// with whether it was given this very soil. At least one must hold torques or accelerations.
///
/// # Errors
/// As [`diagnose_drives`] and [`diagnose_drive_against`].
pub fn diagnose_windows(
    logs: &[Named<'_, DriveWindows>],
    sim: Option<(&DriveWindows, bool)>,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    let logs = Logs::new(logs, settings.soil)?;
    drive_windows(&logs, sim, rover, registry, settings)
}

fn rig_logs(
    logs: &Logs<'_, RigLog>,
    sim: Option<(&RigLog, bool)>,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<(Diagnosis, rig::RigPredictor), GapError> {
    let read = rig::from_logs(logs, rover)?;
    let (dropped, stuck) = (read.0.dropped.clone(), stuck(&read.0));
    let sim = match sim {
        None => None,
        // One law is fitted to it.
        Some((sim, same_soil)) => Some((rig::from_log(sim, &rig::on_one_soil(rover))?, same_soil)),
    };
    let soils = rig::soils(logs, rover);
    let (mut diagnosis, predictor) =
        with_baseline(read, sim, LogKind::Rig, &soils, rover, registry, settings)?;
    for (name, log) in logs.iter() {
        // Where all rows contradict their speeds they are left out, and no slip is used.
        if slip_against_speeds(log, rover).is_none() {
            diagnosis.heed.extend(contradictions(name, &log.warnings));
        }
    }
    // Where none is left, that is the reason.
    let some_left = diagnosis.null.is_some();
    diagnosis
        .heed
        .extend(left_out(&dropped).filter(|_| some_left));
    diagnosis.heed.extend(stuck);
    diagnosis.heed.extend(unmatched(logs, rover));
    diagnosis.logs = logs.joined();
    Ok((diagnosis, predictor))
}

/// Rows from which a sensor that always says the same is stuck: by chance readings with noise hardly ever do.
const STUCK: usize = 8;

/// Channels that read one and the same in all rows.
fn stuck(data: &DataSet) -> Vec<String> {
    let of = |channel: usize| {
        let rows = data.observations.iter();
        let each = rows.flat_map(|o| o.channels.iter().zip(&o.values));
        let values: Vec<f64> = each
            .filter(|(c, _)| **c == channel)
            .map(|(_, v)| *v)
            .collect();
        let first = *values.first()?;
        let same = values.len() >= STUCK && values.iter().all(|v| *v == first);
        same.then(|| {
            let ChannelInfo { name, unit, .. } = &data.channels[channel];
            format!(
                "{name} is {first} {unit} in all {} rows: a sensor that is stuck tells nothing and misleads; leave its column out",
                values.len()
            )
        })
    };
    (0..data.channels.len()).filter_map(of).collect()
}

/// Rows that are not used, each of which was meant to count.
fn left_out(dropped: &BTreeMap<String, usize>) -> Option<String> {
    let each = dropped.iter().map(|(why, n)| format!("{n} {why}"));
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| format!("rows left out: {}", each.join(", ")))
}

/// Windows in which no model has an answer, where they are more than those that are used.
fn mostly_refused(data: &DataSet) -> Option<String> {
    let no_answer =
        |why: &str| why == drive::AGAINST_THE_MOTION || why.starts_with("outside the model");
    let refused = data.dropped.iter().filter(|(why, _)| no_answer(why));
    let each: Vec<String> = refused
        .clone()
        .map(|(why, n)| format!("{n} {why}"))
        .collect();
    let (lost, used) = (
        refused.map(|(_, n)| n).sum::<usize>(),
        data.observations.len(),
    );
    (lost > used).then(|| {
        format!(
            "the verdict is of {used} windows and {lost} are left out: {}; signs, radius_m or track_m may be wrong",
            each.join(", ")
        )
    })
}

/// Conditions of the rover file that no row has: perhaps another was meant.
fn unmatched(logs: &Logs<'_, RigLog>, rover: &Rover) -> Option<String> {
    let rows = logs.iter().flat_map(|(_, log)| &log.rows);
    let there: BTreeSet<&str> = rows.map(|row| row.condition.as_str()).collect();
    let declared = rover.conditions.keys().map(String::as_str);
    let none: Vec<&str> = declared.filter(|c| !there.contains(c)).collect();
    let named = there.into_iter().filter(|c| !c.is_empty());
    let named: Vec<&str> = named.collect();
    (!none.is_empty()).then(|| {
        let of_log = match named.is_empty() {
            true => "the log names none".to_owned(),
            false => format!("the log's are {}", named.join(", ")),
        };
        format!(
            "[condition] {} of the rover file is in no row: {of_log}",
            none.join(", ")
        )
    })
}

/// What a log says against itself, by the first of its rows that do.
fn contradictions(prefix: &str, warnings: &[String]) -> Option<String> {
    let first = warnings.first()?;
    let more = match warnings.len() {
        1 => String::new(),
        n => format!(" ({} rows more; terra inspect LOG lists all)", n - 1),
    };
    Some(format!("{prefix}{first}{more}"))
}

/// What it takes to tell forces where no log holds torques.
const FORCES_TAKE: &str = "forces are told too where accel_x_m_s2 is logged, [noise] states its noise, and [terrain] start names a soil";

/// A drive in memory: its windows where some log tells of forces, else its motion alone.
fn drive_logs(
    logs: &Logs<'_, DriveLog>,
    sim: Option<(&DriveLog, bool)>,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    let tells = |log: &DriveLog| DriveWindows::tell_of_forces(log, rover, settings);
    let forces = logs.iter().any(|(_, log)| tells(log));
    let torques = |log: &DriveLog| log.wheel_torque.is_some();
    if let Some((against, _)) = sim
        && !(torques(against) && logs.iter().any(|(_, log)| torques(log)))
    {
        return diagnose_logs(logs, sim, rover, registry, settings);
    }
    if !forces && sim.is_none() {
        let mut by_motion = diagnose_logs(logs, None, rover, registry, settings)?;
        if !settings.motion_only {
            by_motion.notice(FORCES_TAKE.to_owned());
        }
        return Ok(by_motion);
    }
    let most = settings.windows;
    let windows_by = |rover: &Rover| -> Result<Vec<DriveWindows>, GapError> {
        let each = logs
            .iter()
            .map(|(_, log)| DriveWindows::of(log, rover, most));
        each.collect()
    };
    let windows = windows_by(rover)?;
    let sim = match sim {
        None => None,
        Some((sim, same_soil)) => Some((DriveWindows::of(sim, rover, most)?, same_soil)),
    };
    let against = sim.as_ref().map(|(sim, same_soil)| (sim, *same_soil));
    let told = logs.replaced_by(&windows);
    let by_forces = drive_windows(&told, against, rover, registry, settings);
    if sim.is_some() {
        return by_forces;
    }
    let by_forces = by_forces.and_then(|found| {
        by_roomier_windows(found, &windows, rover, |wide| {
            let windows = windows_by(wide)?;
            drive_windows(&logs.replaced_by(&windows), None, wide, registry, settings)
        })
    });
    if windows.iter().any(DriveWindows::has_torques) {
        return by_forces;
    }
    or_by_motion(by_forces, || {
        diagnose_logs(logs, None, rover, registry, settings)
    })
}

/// What forces tell of a drive without torques, or where they leave it open what its motion tells: on ground that the terrain model does
/// not describe that is more. A cause that motion alone shows is an answer; that it shows none is none, as it shows but few.
fn or_by_motion(
    by_forces: Result<Diagnosis, GapError>,
    by_motion: impl FnOnce() -> Result<Diagnosis, GapError>,
) -> Result<Diagnosis, GapError> {
    let open = |d: &Diagnosis| matches!(d.verdict, "unknown" | "unidentifiable");
    if by_forces.as_ref().is_ok_and(|d| !open(d)) {
        return by_forces;
    }
    match (by_forces, by_motion()) {
        (Ok(mut by_forces), Ok(mut by_motion)) => {
            let causes =
                |d: &Diagnosis| d.set.iter().all(|name| name != "none" && name != "unknown");
            let names = |d: &Diagnosis| matches!(d.verdict, "named" | "ambiguous") && causes(d);
            // Of two refusals the one by motion says what to record.
            let neither = by_forces.verdict == "unidentifiable" && open(&by_motion);
            if names(&by_motion) || neither {
                by_motion.notice(format!(
                    "by forces, known by the accelerations that they cause, the answer is {}",
                    by_forces.verdict
                ));
                return Ok(by_motion);
            }
            by_forces.notice(format!(
                "by motion alone the answer is {}",
                by_motion.verdict
            ));
            Ok(by_forces)
        }
        (Err(e), Ok(mut by_motion)) => {
            by_motion.notice(format!("forces cannot be told: {e}"));
            Ok(by_motion)
        }
        (Ok(mut by_forces), Err(e)) => {
            by_forces.notice(format!("motion alone cannot be told: {e}"));
            Ok(by_forces)
        }
        (Err(e), Err(_)) => Err(e),
    }
}

/// What to heed where no log holds torques.
const BY_ACCELERATIONS: &str = "no torques: the ground's forces are known by the accelerations that they cause, what shows in torques alone is not asked, and the probabilities are calibrated on drives with torques";

fn drive_windows(
    logs: &Logs<'_, DriveWindows>,
    sim: Option<(&DriveWindows, bool)>,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    let torques = logs.iter().any(|(_, log)| log.has_torques());
    let neither = "no wheel torques: windows are compared by forces, which both logs must tell of; whole logs are compared by motion too";
    if let Some((sim, _)) = sim {
        if !sim.has_torques() {
            return Err(GapError::Simulator(neither.to_owned()));
        }
        if !torques {
            return Err(GapError::Log(neither.to_owned()));
        }
    }
    // As long as the longest windows of the logs, for what the ground's roughness comes to in them.
    let mut rover = rover.clone();
    let all = logs
        .iter()
        .map(|(_, log)| log)
        .chain(sim.map(|(sim, _)| sim));
    rover.gap.window = all
        .map(DriveWindows::window)
        .fold(rover.gap.window, f64::max);
    let rover = &rover;
    let compared = sim.is_some();
    let read = |logs: &Logs<'_, DriveWindows>| drive::from_logs(logs, rover, settings.windows);
    let sim = match sim {
        None => None,
        Some((sim, same_soil)) => Some((read(&Logs::one(sim))?, same_soil)),
    };
    let (labels, kind) = (logs.labels(), LogKind::Drive);
    let (mut diagnosis, _) =
        with_baseline(read(logs)?, sim, kind, labels, rover, registry, settings)?;
    if !compared
        && let Some(uneven) = diagnosis.uneven.take()
        && let (mut data, predictor) = read(logs)?
        && let Some(predictor) = uneven.met(&mut data, &predictor)
    {
        let read = (data, predictor);
        let (second, _) = with_baseline(read, None, kind, labels, rover, registry, settings)?;
        diagnosis = uneven.taken(second, diagnosis);
    }
    for (name, log) in logs.iter() {
        diagnosis.heed.extend(log.held(name));
        diagnosis.heed.extend(log.widened(name));
        diagnosis.heed.extend(log.rounded(name));
    }
    if let Some(line) = mostly_refused(&diagnosis.data) {
        diagnosis.notice(line);
    }
    if !torques {
        diagnosis.notice(BY_ACCELERATIONS.to_owned());
    }
    if !compared
        && diagnosis.verdict != "none"
        && let Some(own) = logs.with_own_soils()
        && let Some(line) = better_apart(&diagnosis, read(&own)?, own.labels(), rover, registry)?
    {
        diagnosis.notice(line);
    }
    diagnosis.logs = logs.joined();
    Ok(diagnosis)
}

/// Diagnoses what was read, alone or against a simulator's log, which comes with whether it was given this very soil.
fn with_baseline<P: Predictor>(
    (data, predictor): (DataSet, P),
    sim: Option<((DataSet, P), bool)>,
    kind: LogKind,
    labels: &[String],
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<(Diagnosis, P), GapError> {
    let diagnosed = among_them(|| {
        let (setup, baseline) = match sim {
            None => (setup(registry, rover, kind, labels)?, None),
            Some(((data, predictor), same_soil)) => {
                let (setup, baseline) = against(
                    data, &predictor, registry, rover, kind, settings, same_soil, labels,
                )?;
                (setup, Some(baseline))
            }
        };
        // As the simulator's vehicle is.
        let otherwise = baseline.as_ref().is_some_and(|b| b.otherwise_loaded);
        let otherwise = otherwise.then(|| Predictor::otherwise_loaded(&predictor));
        let by = otherwise.flatten();
        let by: &dyn Predictor = by.as_deref().unwrap_or(&predictor);
        let mut diagnosis = diagnose(data, by, &setup, settings)?;
        diagnosis.baseline = baseline;
        Ok(diagnosis)
    });
    diagnosed.map(|diagnosis| (diagnosis, predictor))
}

/// The nominal simulator and its rivals; `labels` are the logs that have a soil of their own.
pub(crate) fn setup<'a>(
    registry: &'a Registry,
    rover: &'a Rover,
    kind: LogKind,
    labels: &[String],
) -> Result<Setup<'a>, GapError> {
    let law = registry.law(&rover.terrain.model)?.quick();
    let soil = |each| Arc::new(SoilSpace::new(each, labels));
    let nominal = soil(free_soil(&law, rover)?);
    let (mut structures, mut without) = (vec![], vec![]);
    let others = registry.models().iter();
    for m in others.filter(|m| m.name() != law.model().name()) {
        let name = format!("structure:{}", m.name());
        let Ok(other) = Law::new(Arc::clone(m), law.effects().to_vec()) else {
            continue;
        };
        match rival_soil(&other, rover) {
            Ok(each) => structures.push(Rival {
                name,
                law: other.quick(),
                soil: soil(each),
            }),
            Err(why) => without.push((name, format!("[terrain] start does not give it: {why}"))),
        }
    }
    Ok(Setup {
        registry,
        rover,
        law,
        soil: nominal,
        structures,
        without,
        kind,
        inherited: None,
    })
}
