//! A simulator's motion against a real one's, where a log holds no torques: what both do is no gap.

use terra::data::DriveLog;
use terra::gap::{Diagnosis, LogKind, Settings, diagnose_drive, diagnose_drive_against};
use terra::sim::{Scenario, simulate_drive};

use crate::vehicle::{effect as set, example};

/// Straight runs and turns to both sides, by wheel speeds left and right \[rad/s\]; every one twice.
const SIDES: [(f64, f64); 10] = [
    (3.0, 3.0),
    (5.0, 5.0),
    (-3.5, -3.5),
    (3.4, 4.4),
    (4.4, 3.4),
    (2.6, 5.2),
    (5.2, 2.6),
    (1.4, 6.0),
    (6.0, 1.4),
    (4.0, 4.0),
];

/// These by a wheel law on a soil, with effects, seen by wheel speeds, ground speed and yaw rate.
fn motion((law, terrain): (&str, &str), seed: u64, effects: &[(&str, f64)]) -> DriveLog {
    let (rover, registry, _) = example();
    let segment = |(k, (left, right)): (usize, &(f64, f64))| {
        format!(
            "[[segment]]\nname = \"{k}\"\nduration_s = 3.0\nreset = true\n\
             wheel_speed_rad_s = {{ fl = {left}, fr = {right}, rl = {left}, rr = {right} }}\n\
             start = {{ ground_speed_m_s = {}, wheel_speed_rad_s = {} }}\n",
            0.11 * (left + right),
            0.5 * (left + right)
        )
    };
    let twice = SIDES.iter().chain(&SIDES).enumerate();
    let segments: String = twice.map(segment).collect();
    let text = format!(
        "seed = {seed}\nrover = \"rover.toml\"\nrate_hz = 100.0\nterrain = \"{terrain}\"\nmodel = \"{law}\"\n\
         {segments}"
    );
    let mut scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    scenario.effects = effects.iter().copied().map(set).collect();
    let mut log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    (log.wheel_torque, log.accel_x) = (None, None);
    log
}

fn against(sim: &DriveLog, real: &DriveLog, same_soil: bool) -> Diagnosis {
    let (rover, registry, _) = example();
    let settings = Settings::of(&rover);
    let d = diagnose_drive_against(sim, real, &rover, &registry, &settings, same_soil).unwrap();
    assert_eq!(d.kind, LogKind::Kinematic);
    d
}

fn has(d: &Diagnosis, answer: &str) -> bool {
    d.set.iter().any(|a| a == answer)
}

/// Soil lets wheels slip more in turns than straight on, which an ideal drive does not: alone that is a gap, against a simulator whose
/// wheels slip so too it is none. By two wheel laws.
#[test]
fn what_a_simulator_s_motion_shares_is_no_gap() {
    let (rover, registry, _) = example();
    for law in ["wong-reece", "linear-stress"] {
        let (sim, real) = (
            motion((law, "dry_sand"), 101, &[]),
            motion((law, "dry_sand"), 1, &[]),
        );
        let alone = diagnose_drive(&real, &rover, &registry, &Settings::of(&rover)).unwrap();
        assert!(!has(&alone, "none"), "{law}: {:?}", alone.set);
        for log in [&real, &sim] {
            let d = against(&sim, log, false);
            assert_eq!(d.verdict, "none", "{law}: {:?} {:?}", d.set, d.reason);
        }
    }
}

/// What the real vehicle or its sensors have and the simulator has not is in the set, and nothing missing is not.
#[test]
fn what_a_simulator_s_motion_lacks_is_named() {
    let sim = motion(("wong-reece", "dry_sand"), 101, &[]);
    for missing in [
        ("wheel-radius-error", 0.06),
        ("ground-speed-scale", 0.06),
        ("yaw-rate-bias", 0.03),
        ("track-width-error", 0.1),
    ] {
        let d = against(
            &sim,
            &motion(("wong-reece", "dry_sand"), 1, &[missing]),
            true,
        );
        assert!(
            has(&d, missing.0),
            "{missing:?}: {:?} {:?}",
            d.set,
            d.reason
        );
        assert!(!has(&d, "none"), "{missing:?}: {:?}", d.set);
    }
}

/// Softer soil than the simulator's is an answer where the simulator was not given this very soil, and none where it was.
#[test]
fn other_soil_under_the_same_motion_is_an_answer() {
    let sim = motion(("wong-reece", "dry_sand"), 101, &[]);
    let real = motion(("wong-reece", "lunar_nominal"), 1, &[]);
    let d = against(&sim, &real, false);
    assert!(has(&d, "soil-change") && !has(&d, "none"), "{:?}", d.set);
    let d = against(&sim, &real, true);
    assert!(!has(&d, "soil-change") && !has(&d, "none"), "{:?}", d.set);
}
