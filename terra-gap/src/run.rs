//! From a log and a rover file to a diagnosis.

use std::sync::Arc;

use terra_data::{DriveLog, RigLog, Rover};
use terra_mme::FitSpace;
use terra_model::{Law, Registry};

use crate::diagnose::{Diagnosis, diagnose};
use crate::error::GapError;
use crate::kinematic::diagnose_kinematic;
use crate::settings::{LogKind, Settings};
use crate::setup::Setup;
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

fn setup<'a>(
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
            Some((other, Arc::new(soil)))
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
