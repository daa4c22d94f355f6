//! From a log and a rover file to a diagnosis.

use std::sync::Arc;

use terra_data::{DriveLog, RigLog, Rover};
use terra_mme::FitSpace;
use terra_model::{Law, Registry};

use crate::contrast::against;
use crate::diagnose::{Diagnosis, diagnose};
use crate::error::GapError;
use crate::kinematic::diagnose_kinematic;
use crate::settings::{LogKind, Settings};
use crate::setup::{Rival, Setup};
use crate::{drive, rig};

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
    let (data, predictor) = rig::from_log(log, rover)?;
    let setup = setup(registry, rover, LogKind::Rig)?;
    let diagnosis = diagnose(data, &predictor, &setup, settings)?;
    Ok((diagnosis, predictor))
}

/// Diagnoses a drive log; one without torques by its motion alone ([`diagnose_kinematic`]).
///
/// # Errors
/// A configuration that makes no sense, or a used channel without noise level.
pub fn diagnose_drive(
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    if log.wheel_torque.is_none() {
        return diagnose_kinematic(log, rover, registry, settings);
    }
    let (data, predictor) = drive::from_log(log, rover)?;
    let setup = setup(registry, rover, LogKind::Drive)?;
    diagnose(data, &predictor, &setup, settings)
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
    let (sim_data, sim_predictor) = rig::from_log(sim, rover)?;
    let (data, predictor) = rig::from_log(log, rover)?;
    let kind = LogKind::Rig;
    let (setup, baseline) = against(sim_data, &sim_predictor, registry, rover, kind, same_soil)?;
    let mut diagnosis = diagnose(data, &predictor, &setup, settings)?;
    diagnosis.baseline = Some(baseline);
    Ok((diagnosis, predictor))
}

/// Diagnoses a drive log against an outside simulator, whose log of the same manoeuvres is fitted first.
///
/// # Errors
/// As [`diagnose_drive`]; logs without torques; a simulator's log that the nominal law cannot be fitted to.
pub fn diagnose_drive_against(
    sim: &DriveLog,
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
    same_soil: bool,
) -> Result<Diagnosis, GapError> {
    if sim.wheel_torque.is_none() || log.wheel_torque.is_none() {
        return Err(GapError::Mismatch(
            "a simulator can be compared only where both logs hold torques".to_owned(),
        ));
    }
    let (sim_data, sim_predictor) = drive::from_log(sim, rover)?;
    let (data, predictor) = drive::from_log(log, rover)?;
    let kind = LogKind::Drive;
    let (setup, baseline) = against(sim_data, &sim_predictor, registry, rover, kind, same_soil)?;
    let mut diagnosis = diagnose(data, &predictor, &setup, settings)?;
    diagnosis.baseline = Some(baseline);
    Ok(diagnosis)
}

pub(crate) fn setup<'a>(
    registry: &'a Registry,
    rover: &'a Rover,
    kind: LogKind,
) -> Result<Setup<'a>, GapError> {
    let law = registry.law(&rover.terrain.model)?;
    let soil = Arc::new(soil_of(&law, rover)?);
    let structures = registry
        .models()
        .iter()
        .filter(|m| m.name() != law.model().name())
        .filter_map(|m| {
            let other = Law::new(Arc::clone(m), law.effects().to_vec()).ok()?;
            // A structure whose parameters the start does not give cannot compete; it is left out.
            let soil = soil_of(&other, rover).ok()?;
            Some(Rival {
                name: format!("structure:{}", m.name()),
                law: other,
                soil: Arc::new(soil),
            })
        })
        .collect();
    Ok(Setup {
        registry,
        rover,
        law,
        soil,
        structures,
        kind,
    })
}

/// The free soil parameters of a law around the rover file's start.
fn soil_of(law: &Law, rover: &Rover) -> Result<FitSpace, GapError> {
    crate::soil::free_soil(law, rover)
}
