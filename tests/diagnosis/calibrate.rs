//! A calibration made from mock cases of the log's own design: most of these must come about, and teach something of that log.

use terra::data::{DriveLog, Rover, SoilSharing, Start};
use terra::gap::{Calibration, Named, Settings, diagnose_drive, diagnose_drives};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_drive};

use crate::vehicle::{effect, example};

const MOCKS: usize = 12;
const ASKED: [&str; 3] = ["torque-bias", "cg-offset", "slope"];

/// One terrain model with the effects asked: others would cost most of the time and settle nothing here.
fn registry() -> Registry {
    let all = Registry::builtin();
    let one = Registry::empty().with_shared(all.model("wong-reece").unwrap());
    ASKED.into_iter().fold(one, |few, name| {
        few.with_shared_effect(all.effect(name).unwrap())
    })
}

/// A rover that starts from rest, drives at a walking pace, turns and nearly stops, on this soil.
pub(crate) fn with_a_stop(
    terrain: &str,
    seed: u64,
    missing: Option<(&str, f64)>,
) -> (DriveLog, Rover) {
    let (mut rover, registry, _) = example();
    rover.terrain.start = Some(Start::Id("dry_sand".to_owned()));
    let text = format!(
        r#"
        seed = {seed}
        rover = "rover.toml"
        rate_hz = 100.0
        terrain = "{terrain}"
        [[segment]]
        name = "starts"
        duration_s = 4.0
        wheel_speed_rad_s = {{ from = 0.1, to = 1.6 }}
        start = {{ ground_speed_m_s = 0.0, wheel_speed_rad_s = 0.1 }}
        [[segment]]
        name = "turns"
        duration_s = 3.0
        wheel_speed_rad_s = {{ fl = 1.0, fr = 1.7, rl = 1.0, rr = 1.7 }}
        [[segment]]
        name = "stops"
        duration_s = 4.0
        wheel_speed_rad_s = {{ from = 1.6, to = 0.12 }}
        "#
    );
    let mut scenario = Scenario::parse(&text, "stop.toml").unwrap();
    scenario.effects = missing.map(effect).into_iter().collect();
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    (log, rover)
}

fn settings(rover: &Rover) -> Settings {
    Settings {
        effects: Some(ASKED.map(str::to_owned).to_vec()),
        combine: 1,
        calibrate: MOCKS,
        ..Settings::of(rover)
    }
}

fn learned(calibration: Option<Calibration>) -> Calibration {
    let own = calibration.unwrap();
    assert!(own.source.contains("own design"), "{}", own.source);
    assert!(own.cases >= MOCKS / 2, "{} cases", own.cases);
    assert!(own.temperature < 5.0, "{}", own.temperature);
    own
}

/// Near a standstill a window may have no answer under another soil or another noise; the rest of the log has.
#[test]
fn a_log_with_a_stop_has_mock_cases() {
    let (log, rover) = with_a_stop("dry_sand", 3, None);
    let asked = settings(&rover);
    let d = diagnose_drive(&log, &rover, &registry(), &asked).unwrap();
    learned(d.calibration);
    assert_eq!(d.set[0], "none", "{:?}", d.set);
}

/// Two logs with a soil of their own each and a mass off its place. The re-fitted nominal soil stands for that, and is no soil to draw
/// mock cases at.
#[test]
fn several_logs_are_calibrated_on_their_own_noise() {
    let off = Some(("cg-offset", 0.06));
    let (one, rover) = with_a_stop("dry_sand", 5, off);
    let (two, _) = with_a_stop("upland_sandy_loam", 6, off);
    let logs = [("one", &one), ("two", &two)].map(|(name, log)| Named { name, log });
    let asked = Settings {
        soil: SoilSharing::Own,
        ..settings(&rover)
    };
    let d = diagnose_drives(&logs, &rover, &registry(), &asked).unwrap();
    assert_eq!(d.causes[0].name, "cg-offset");
    learned(d.calibration);
}
