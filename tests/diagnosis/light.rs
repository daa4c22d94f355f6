//! A light rover on rough ground: what the ground pushes, it gives way to within hundredths of a second.
//!
//! Its wheels hold the ground so firmly, for its mass, that a push ends in another slip and torque and not in an acceleration. A
//! diagnosis that takes slip as independent of the push finds the ground too weak, and names a cause that makes up for it: of this
//! scenario a mass error of .35 ± .07 at P .94.

use std::fmt::Write as _;

use terra::data::{DriveLog, Rover, parse_rover};
use terra::gap::{
    Diagnosis, DriveWindows, GapError, Named, Settings, by_roomier_windows, diagnose_drive,
    diagnose_windows,
};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_drive};

use crate::vehicle::effect;

/// Eight kilograms on four wheels of 8 cm, on soil that the rover file starts from.
const ROVER: &str = r#"
    [vehicle]
    mass_kg = 8.0
    yaw_inertia_kg_m2 = 0.22
    track_m = 0.34
    wheelbase_m = 0.3
    cg_to_front_axle_m = 0.15
    cg_height_m = 0.1
    yaw_damping_N_m_s = 0.1
    [wheel]
    radius_m = 0.08
    width_m = 0.05
    inertia_kg_m2 = 0.006
    damping_N_m_s = 0.01
    [terrain]
    model = "wong-reece"
    start = "north_gower"
    [noise]
    wheel_speed_rad_s = 0.02
    wheel_torque_N_m = 0.016
    ground_speed_m_s = 0.02
    yaw_rate_rad_s = 0.005
    accel_x_m_s2 = 0.05
    roughness_N = 0.157
"#;

/// Wheel speeds of left and right \[rad/s\], four seconds each.
const LEGS: [(f64, f64); 20] = [
    (2.82, 2.82),
    (4.94, 3.52),
    (3.78, 3.78),
    (2.79, 2.03),
    (5.27, 5.27),
    (3.34, 3.34),
    (2.54, 2.85),
    (2.40, 2.40),
    (3.79, 3.79),
    (5.13, 5.13),
    (5.96, 5.96),
    (6.36, 3.52),
    (7.45, 4.38),
    (4.47, 4.47),
    (5.68, 6.67),
    (4.23, 2.96),
    (5.86, 5.86),
    (5.79, 3.39),
    (4.27, 4.27),
    (6.00, 4.40),
];

fn driven(missing: Option<(&str, f64)>, seed: u64) -> Diagnosis {
    let (log, rover) = drive(missing, seed);
    diagnose_drive(&log, &rover, &Registry::builtin(), &Settings::of(&rover)).unwrap()
}

fn drive(missing: Option<(&str, f64)>, seed: u64) -> (DriveLog, Rover) {
    let rover = parse_rover(ROVER, "rover.toml").unwrap();
    let mut text = format!(
        "seed = {seed}\nrover = \"rover.toml\"\nrate_hz = 100.0\nterrain = \"north_gower\"\n"
    );
    for (k, (left, right)) in LEGS.iter().enumerate() {
        write!(
            text,
            "[[segment]]\nname = \"leg {k}\"\nduration_s = 4.0\nwheel_speed_rad_s = {{ fl = {left}, fr = {right}, rl = {left}, rr = {right} }}\n"
        )
        .unwrap();
        if k == 0 {
            text.push_str("start = { ground_speed_m_s = 0.3, wheel_speed_rad_s = 4.0 }\n");
        }
    }
    let mut scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    scenario.effects = missing.map(effect).into_iter().collect();
    let log = simulate_drive(&scenario, &rover, &Registry::builtin())
        .unwrap()
        .log;
    (log, rover)
}

#[test]
fn pushes_of_rough_ground_are_no_cause() {
    for seed in [1, 3, 5] {
        let d = driven(None, seed);
        assert_eq!(d.verdict, "none", "{seed}: {:?} {:?}", d.set, d.reason);
        // The soil is the one that was driven on.
        let (null, fit) = d.null.as_ref().unwrap();
        for (name, x) in null.soil.names().iter().zip(fit.x.iter()) {
            assert!(x.abs() < 3.0, "{seed}: {name} {x} prior sd off");
        }
    }
}

/// And what is there is found, beside them.
#[test]
fn a_cause_is_found_on_rough_ground() {
    let d = driven(Some(("tow-load", 8.0)), 2);
    assert_eq!(d.causes[0].name, "tow-load", "{} {:?}", d.verdict, d.set);
}

/// Where two readings of the ground speed in a window leave a cause unknown, windows of three are asked, and believed where they name
/// one; three in a window are enough, and so is a window that the rover file gives.
#[test]
fn two_readings_in_a_window_are_looked_at_again() {
    let (log, rover) = drive(Some(("cg-offset", 0.1)), 2);
    let registry = Registry::builtin();
    let read_every = |rows: usize| {
        let mut log = log.clone();
        let each = log.ground_speed.iter().flat_map(|s| s.iter());
        let thinned = each.enumerate().map(|(k, v)| v.filter(|_| k % rows == 0));
        log.ground_speed = Some(thinned.collect());
        log
    };
    let asking = |effects: &[&str], log: &DriveLog, rover: &Rover| {
        let settings = Settings {
            effects: Some(effects.iter().map(|&e| e.to_owned()).collect()),
            combine: 1,
            ..Settings::of(rover)
        };
        let windows = DriveWindows::of(log, rover, settings.windows).unwrap();
        let named = Named {
            name: "log.csv",
            log: &windows,
        };
        let d = diagnose_windows(&[named], None, rover, &registry, &settings).unwrap();
        (d, windows)
    };
    let again = |rows: usize, window: Option<f64>, effects: &[&str]| {
        let log = read_every(rows);
        let mut rover = rover.clone();
        rover.gap.window_given = window.is_some();
        rover.gap.window = window.unwrap_or(rover.gap.window);
        // The cause is not asked at first.
        let (found, windows) = asking(&["accel-bias"], &log, &rover);
        assert_eq!(found.verdict, "unknown", "{:?}", found.set);
        let mut asked = None;
        let d = by_roomier_windows(found, [&windows], &rover, |wide| {
            asked = Some(wide.gap.window);
            Ok::<_, GapError>(asking(effects, &log, wide).0)
        });
        (d.unwrap(), asked)
    };
    let cause = ["accel-bias", "cg-offset"];
    let (d, asked) = again(10, None, &cause);
    assert_eq!((asked, &*d.set[0]), (Some(0.3), "cg-offset"), "{:?}", d.set);
    assert!(
        d.heed
            .iter()
            .any(|h| h.starts_with("windows of 0.3 s: those of 0.2 s")),
        "{:?}",
        d.heed
    );
    let (d, asked) = again(10, None, &["accel-bias"]);
    assert_eq!((asked, d.verdict), (Some(0.3), "unknown"));
    assert!(
        d.heed
            .iter()
            .all(|h| !h.starts_with("windows of 0.3 s: those")),
        "{:?}",
        d.heed
    );
    for (rows, window) in [(1, None), (10, Some(0.2))] {
        let (d, asked) = again(rows, window, &cause);
        assert_eq!((asked, d.verdict), (None, "unknown"));
    }
}
