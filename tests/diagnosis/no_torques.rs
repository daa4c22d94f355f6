//! Drives without torques: the ground's forces show in the accelerations that they cause.

use terra::data::{DriveLog, Rover};
use terra::gap::{Diagnosis, LogKind, Settings, diagnose_drive};
use terra::model::Registry;
use terra::sim::simulate_drive;

use crate::magnitude;
use crate::vehicle::{effect, example};

/// The example's drive with what is missing, seen by everything but the motors.
fn without_torques(missing: Option<(&str, f64)>) -> (DriveLog, Rover) {
    let (rover, registry, mut scenario) = example();
    scenario.effects = missing.map(effect).into_iter().collect();
    let mut log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    log.wheel_torque = None;
    (log, rover)
}

fn diagnosed(missing: Option<(&str, f64)>) -> Diagnosis {
    let (log, rover) = without_torques(missing);
    diagnose_drive(&log, &rover, &Registry::builtin(), &Settings::of(&rover)).unwrap()
}

/// Soil that the terrain model describes is no gap, however the wheels slip on it, and what shows in torques alone is not asked.
#[test]
fn a_drive_that_lacks_nothing_lacks_nothing_without_torques_either() {
    let d = diagnosed(None);
    assert_eq!((d.kind, d.verdict), (LogKind::Drive, "none"), "{:?}", d.set);
    for name in ["torque-scale", "torque-bias", "drivetrain-coulomb-friction"] {
        let why = d.not_asked.iter().find(|(effect, _)| effect == name);
        assert_eq!(why.unwrap().1, "no torque in the log", "{name}");
    }
    assert!(
        d.data
            .notes
            .iter()
            .any(|line| line.starts_with("no torques"))
    );
}

/// Physics, a geometry and an instrument, each named with its size.
#[test]
fn causes_are_named_without_torques() {
    for missing in [
        ("tow-load", 40.0),
        ("slope", 0.05),
        ("wheel-radius-error", 0.06),
        ("yaw-rate-bias", 0.03),
    ] {
        let d = diagnosed(Some(missing));
        let first = (d.kind, d.causes[0].name.as_str());
        assert_eq!(
            first,
            (LogKind::Drive, missing.0),
            "{} {:?}",
            d.verdict,
            d.set
        );
        let (found, sd) = magnitude(&d);
        assert!(
            (found - missing.1).abs() < 4.0 * sd,
            "{missing:?}: {found} ± {sd}"
        );
    }
}

/// By motion alone where that is asked for, where no acceleration is logged or its noise is not known, and where no soil is named.
#[test]
fn only_motion_is_told_where_forces_cannot_be() {
    let (log, rover) = without_torques(None);
    let kind = |log: &DriveLog, rover: &Rover, settings: &Settings| {
        diagnose_drive(log, rover, &Registry::builtin(), settings)
            .unwrap()
            .kind
    };
    let asked = Settings {
        motion_only: true,
        ..Settings::of(&rover)
    };
    assert_eq!(kind(&log, &rover, &asked), LogKind::Kinematic);
    let usual = Settings::of(&rover);
    let mut unfelt = log.clone();
    unfelt.accel_x = None;
    assert_eq!(kind(&unfelt, &rover, &usual), LogKind::Kinematic);
    let mut silent = rover.clone();
    silent.noise.0.remove("accel_x_m_s2");
    assert_eq!(kind(&log, &silent, &usual), LogKind::Kinematic);
    let mut nowhere = rover.clone();
    nowhere.terrain.start = None;
    assert_eq!(kind(&log, &nowhere, &usual), LogKind::Kinematic);
}
