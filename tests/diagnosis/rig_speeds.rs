//! What a rig's log tells of speeds and time: the path, an offset of the travel speed, and how fast the wheel turns.

use terra::data::{RigLog, Rover};
use terra::gap::{Diagnosis, Settings, diagnose_rig};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_rig};

use crate::{rig, rig_reading_slip};

fn log(rover: &Rover, trials: &str, effect: (&str, f64)) -> RigLog {
    let (name, magnitude) = effect;
    let text = format!(
        "seed = 8\nrover = \"rig.toml\"\nterrain = \"dry_sand\"\n{trials}\n[[effect]]\nname = \"{name}\"\nmagnitude = {magnitude}\n"
    );
    let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    simulate_rig(&scenario, rover, &Registry::builtin())
        .unwrap()
        .log
}

fn diagnosed(rover: &Rover, log: &RigLog) -> Diagnosis {
    let found = diagnose_rig(log, rover, &Registry::builtin(), &Settings::of(rover));
    found.unwrap().0
}

/// Size of the first cause, in its unit.
fn size(d: &Diagnosis) -> f64 {
    let first = &d.causes[0].weighed;
    let k = first.hypothesis.soil_len();
    first.fit.x[k] * first.hypothesis.effects()[0].params()[0].prior_sd
}

/// Ramps up and down again at two loads: soil that changes along the track answers the same slip otherwise, and time and travel
/// speed tell where along it. A log without time has no path, and says so.
#[test]
fn soil_that_changes_along_the_track_is_named() {
    let ramp = |from: f64, to: f64, load: f64| {
        format!(
            "[[trial]]\nslip = {{ from = {from}, to = {to}, steps = 20 }}\nnormal_load_N = {load}\ntravel_speed_m_s = 0.2\nramp_s = 20.0\n"
        )
    };
    let trials: String = [150.0, 300.0]
        .into_iter()
        .flat_map(|load| [ramp(0.02, 0.6, load), ramp(0.6, 0.02, load)])
        .collect();
    let mut log = log(&rig(), &trials, ("terrain-drift", 0.8));
    let d = diagnosed(&rig(), &log);
    assert_eq!((d.verdict, d.set[0].as_str()), ("named", "terrain-drift"));
    assert!((size(&d) - 0.8).abs() < 0.2, "{}", size(&d));
    for row in &mut log.rows {
        row.time = None;
    }
    let d = diagnosed(&rig(), &log);
    let mut why = d
        .not_asked
        .iter()
        .filter(|(name, _)| name == "terrain-drift");
    assert!(why.next().unwrap().1.contains("no path in the log"));
}

const TWO_SPEEDS: &str = "
    [[trial]]
    slip = [0.05, 0.15, 0.3, 0.5, 0.7]
    normal_load_N = [150.0, 300.0]
    repeats = 2
    travel_speed_m_s = 0.1
    [[trial]]
    slip = [0.05, 0.15, 0.3, 0.5, 0.7]
    normal_load_N = [150.0, 300.0]
    repeats = 2
    travel_speed_m_s = 0.3
";

/// At two travel speeds an offset of the speed moves the slip by different shares, where a scale moves it by the same.
#[test]
fn an_offset_of_the_travel_speed_is_told_from_a_scale() {
    for (name, magnitude) in [("ground-speed-bias", 0.02), ("ground-speed-scale", 0.1)] {
        let d = diagnosed(&rig(), &log(&rig(), TWO_SPEEDS, (name, magnitude)));
        assert_eq!(
            (d.verdict, d.set[0].as_str()),
            ("named", name),
            "{:?}",
            d.set
        );
        assert!(
            (size(&d) / magnitude - 1.0).abs() < 0.2,
            "{name}: {}",
            size(&d)
        );
    }
}

/// How fast the wheel turns follows from slip and travel speed: what acts by it is found alike with the column and without.
#[test]
fn a_log_without_wheel_speeds_still_tells_how_fast_the_wheel_turns() {
    let mut log = log(&rig(), TWO_SPEEDS, ("drivetrain-viscous-friction", 2.0));
    let with = diagnosed(&rig(), &log);
    for row in &mut log.rows {
        row.wheel_speed = None;
    }
    let without = diagnosed(&rig(), &log);
    for d in [&with, &without] {
        assert_eq!(
            d.causes[0].name, "drivetrain-viscous-friction",
            "{:?}",
            d.set
        );
        assert!((size(d) - 2.0).abs() < 0.3, "{}", size(d));
    }
    assert_eq!(with.set, without.set);
}

/// A torque that droops bends where it is large; a scale does not.
#[test]
fn a_torque_that_droops_is_told_from_a_scale() {
    let loads = TWO_SPEEDS.replace("[150.0, 300.0]", "[200.0, 600.0, 1000.0]");
    let d = diagnosed(&rig(), &log(&rig(), &loads, ("torque-droop", 0.4)));
    assert_eq!(
        (d.verdict, d.set[0].as_str()),
        ("named", "torque-droop"),
        "{:?}",
        d.set
    );
    assert!((size(&d) - 0.4).abs() < 0.1, "{}", size(&d));
}

/// Slips read to two hundredths, and ground that the nominal law first follows with wrong slopes: noise by the slopes of what
/// explains the log leaves a misfit of one per value.
#[test]
fn noise_of_slip_is_taken_at_the_best_explanation() {
    let noisy = rig_reading_slip(0.02, "");
    let d = diagnosed(
        &noisy,
        &log(&noisy, TWO_SPEEDS, ("ground-speed-scale", -0.25)),
    );
    assert_eq!(d.causes[0].name, "ground-speed-scale", "{:?}", d.set);
    let after = d.waterfall.after.unwrap();
    assert!((0.75..1.25).contains(&after), "{after}");
}

/// Slips of a ramp, twice, each read with .005 of noise.
fn dense_ramp(effect: &str, seed: u64) -> Diagnosis {
    let rover = rig();
    let text = format!(
        "seed = {seed}\nrover = \"rig.toml\"\nterrain = \"dry_sand\"\n[[trial]]\nslip = {{ from = 0.02, to = 0.75, steps = 200 }}\n\
         normal_load_N = 200.0\nrepeats = 2\ntravel_speed_m_s = 0.05\nramp_s = 20.0\n{effect}"
    );
    let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    let log = simulate_rig(&scenario, &rover, &Registry::builtin());
    diagnosed(&rover, &log.unwrap().log)
}

/// The more rows at one load, the less there is for a cause that is not there, and what is there keeps its name. An error of the
/// law's form along the slip as it was read would go with that slip's noise, row by row.
#[test]
fn many_rows_at_one_load_name_nothing_that_is_not_there() {
    for seed in [1, 2] {
        let d = dense_ramp("", seed);
        assert_eq!(d.verdict, "none", "{:?} {:?}", d.set, d.reason);
        assert!(d.causes.iter().all(|c| c.log_evidence_gain < 2.0));
    }
    let d = dense_ramp("[[effect]]\nname = \"torque-bias\"\nmagnitude = -1.5\n", 3);
    assert_eq!(d.set[0], "torque-bias", "{:?} {:?}", d.set, d.reason);
    assert!((size(&d) + 1.5).abs() < 0.3, "{}", size(&d));
    // Two trials whose slips are the same: held out by ranges of slip, of which there are five.
    let held = d.held_out.as_ref().unwrap();
    assert!(held.groups >= 2, "{held:?}");
}
