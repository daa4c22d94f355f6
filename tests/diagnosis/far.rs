//! Causes whose gap is far beyond the noise: the re-fitted nominal law is then no guide to noise and inputs.

use terra::data::{DriveLog, Rover};
use terra::gap::{Diagnosis, Settings, diagnose_drive};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_drive};

use crate::vehicle::{effect, example};

/// Slow manoeuvres with what is missing, on known soil: their log, and the rover by these sensors.
pub(crate) fn slowly(missing: Option<(&str, f64)>, noise: [(&str, f64); 5]) -> (DriveLog, Rover) {
    let (mut rover, registry, _) = example();
    let text = r#"
        seed = 4
        rover = "rover.toml"
        rate_hz = 100.0
        terrain = "upland_sandy_loam"
        [[segment]]
        name = "accelerate"
        duration_s = 4.0
        wheel_speed_rad_s = { from = 0.25, to = 1.64 }
        start = { ground_speed_m_s = 0.02, wheel_speed_rad_s = 0.3 }
        [[segment]]
        name = "steps"
        duration_s = 3.0
        wheel_speed_rad_s = { from = 0.66, to = 2.13 }
        [[segment]]
        name = "left"
        duration_s = 6.0
        wheel_speed_rad_s = { fl = 0.9, fr = 1.8, rl = 0.9, rr = 1.8 }
        [[segment]]
        name = "right"
        duration_s = 6.0
        wheel_speed_rad_s = { fl = 1.8, fr = 0.9, rl = 1.8, rr = 0.9 }
        [[segment]]
        name = "fast"
        duration_s = 6.0
        wheel_speed_rad_s = 2.62
        [[segment]]
        name = "brake"
        duration_s = 5.0
        wheel_speed_rad_s = { from = 2.3, to = 0.33 }
        pitch_rad = -0.04
    "#;
    rover.noise.0 = noise
        .into_iter()
        .map(|(n, sd)| (n.to_owned(), sd))
        .collect();
    rover.terrain.start = Some(terra::data::Start::Id("upland_sandy_loam".to_owned()));
    let mut scenario = Scenario::parse(text, "scenario.toml").unwrap();
    scenario.effects = missing.map(effect).into_iter().collect();
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    (log, rover)
}

/// These on a slope that nobody told of.
fn on_a_slope(slope: f64) -> Diagnosis {
    let noise = [
        ("wheel_speed_rad_s", 0.05),
        ("wheel_torque_N_m", 0.1),
        ("ground_speed_m_s", 0.02),
        ("yaw_rate_rad_s", 0.005),
        ("accel_x_m_s2", 0.05),
    ];
    let (log, rover) = slowly(Some(("slope", slope)), noise);
    diagnose_drive(&log, &rover, &Registry::builtin(), &Settings::of(&rover)).unwrap()
}

/// However large the cause, it comes first and without a needless second one, explains the same to the noise, and leaves the same soil.
#[test]
fn a_larger_cause_is_found_as_a_smaller_one_is() {
    let (small, large) = (on_a_slope(0.01), on_a_slope(0.04));
    let far = large.waterfall.refitted.unwrap();
    assert!(far > 3.0, "{far}");
    let after = |d: &Diagnosis| d.waterfall.after.unwrap();
    for (d, slope) in [(&small, 0.01), (&large, 0.04)] {
        // A level accelerometer that is off looks much the same.
        let alike = |name: &String| name == "slope" || name == "accel-bias";
        assert!(
            d.causes[0].name == "slope" && d.set.iter().all(alike),
            "{:?}",
            d.set
        );
        let (h, fit) = d.accepted.as_ref().unwrap();
        let found = h.parameters(fit.x.as_slice()).last().copied().unwrap();
        assert!((found - slope).abs() < 0.002, "{found} for {slope}");
    }
    assert!(
        (after(&small) - after(&large)).abs() < 0.02,
        "{} {}",
        after(&small),
        after(&large)
    );
    let soil = |d: &Diagnosis| {
        let (h, fit) = d.accepted.as_ref().unwrap();
        fit.x.rows(0, h.soil_len()).into_owned()
    };
    let moved = (soil(&small) - soil(&large)).amax();
    assert!(moved < 0.5, "{moved} prior sd");
}

/// A ground speed by satellites, five times a second, is read too rarely for windows of .2 s.
#[test]
fn a_rarely_read_ground_speed_makes_windows_longer() {
    let (mut rover, registry, scenario) = example();
    let mut log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    let read = log.ground_speed.unwrap();
    let rarely = read
        .iter()
        .enumerate()
        .map(|(k, v)| v.filter(|_| k % 20 == 0));
    log.ground_speed = Some(rarely.collect());
    let diagnosed =
        |rover: &_| diagnose_drive(&log, rover, &registry, &Settings::of(rover)).unwrap();
    let d = diagnosed(&rover);
    assert_eq!(
        d.causes[0].name, "torque-scale",
        "{} {:?}",
        d.verdict, d.reason
    );
    assert!(
        d.heed.iter().any(|h| h.contains("windows of 0.6 s")),
        "{:?}",
        d.heed
    );
    // What the rover file says stands.
    rover.gap.window_given = true;
    assert_eq!(diagnosed(&rover).verdict, "unidentifiable");
}

/// Telemetry of ten rows a second has two in a window of .2 s, which show no line.
#[test]
fn a_log_of_few_rows_a_second_makes_windows_longer() {
    let (rover, registry, mut scenario) = example();
    scenario.rate = 10.0;
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    let d = diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
    let named = &d.causes[0].name;
    assert_eq!(named, "torque-scale", "{} {:?}", d.verdict, d.reason);
    let note = "windows of 0.3 s, as rows come too rarely";
    assert!(d.heed.iter().any(|h| h.contains(note)), "{:?}", d.heed);
}
