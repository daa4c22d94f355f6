//! Instruments and drivetrains of large wheels, whose errors are large in newtons and small beside the wheel.

use terra::data::{Rover, Start, parse_rover};
use terra::gap::{Diagnosis, Settings, diagnose_drive, diagnose_rig};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_drive, simulate_rig};

use crate::rig;
use crate::vehicle::{effect, example};

/// Vehicle of 1.5 t on wheels of .9 m.
fn lorry() -> Rover {
    let text = r#"
        [vehicle]
        mass_kg = 1500.0
        yaw_inertia_kg_m2 = 1200.0
        track_m = 1.6
        wheelbase_m = 1.9
        cg_to_front_axle_m = 0.95
        cg_height_m = 0.6
        yaw_damping_N_m_s = 300.0
        [wheel]
        radius_m = 0.45
        width_m = 0.28
        inertia_kg_m2 = 6.0
        damping_N_m_s = 2.0
        [terrain]
        model = "wong-reece"
        start = "upland_sandy_loam"
        [noise]
        wheel_speed_rad_s = 0.02
        wheel_torque_N_m = 8.0
        ground_speed_m_s = 0.05
        yaw_rate_rad_s = 0.01
        accel_x_m_s2 = 0.15
        roughness_N = 15.0
    "#;
    parse_rover(text, "rover.toml").unwrap()
}

/// The manoeuvres of the book's example but for its ramp of torque, with an effect.
fn drive(missing: Option<(&str, f64)>) -> Diagnosis {
    let (_, registry, mut scenario) = example();
    let rover = lorry();
    scenario.segments.retain(|s| s.name != "ramp");
    let ground = Start::Id("upland_sandy_loam".to_owned());
    (scenario.left, scenario.right) = (ground.clone(), ground);
    scenario.effects = missing.map(effect).into_iter().collect();
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap()
}

/// Each is some 4 % of what a wheel carries, or of that times its radius: an ordinary error of such a vehicle, and 20 to 40 times what
/// is ordinary on the robot of 100 kg that the library's priors were chosen for.
#[test]
fn what_a_lorry_s_drivetrain_takes_is_named() {
    for missing in [
        ("drivetrain-coulomb-friction", 80.0),
        ("torque-bias", -60.0),
        ("drivetrain-viscous-friction", 30.0),
    ] {
        let d = drive(Some(missing));
        assert_eq!(
            (d.verdict, d.causes[0].name.as_str()),
            ("named", missing.0),
            "{:?}",
            d.set
        );
    }
    assert_eq!(drive(None).verdict, "none");
}

/// A load cell of a rig that is off by a twentieth of the load.
#[test]
fn an_offset_of_a_large_rig_s_load_cell_is_named() {
    for load in [263.0, 800.0] {
        let offset = 0.05 * load;
        let text = format!(
            r#"
            seed = 12
            rover = "rig.toml"
            terrain = "dry_sand"
            [[trial]]
            slip = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6]
            normal_load_N = [{}, {load}]
            travel_speed_m_s = 0.05
            [[effect]]
            name = "drawbar-bias"
            magnitude = {offset}
            "#,
            0.7 * load
        );
        let (rover, registry) = (rig(), Registry::builtin());
        let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
        let log = simulate_rig(&scenario, &rover, &registry).unwrap().log;
        let (d, _) = diagnose_rig(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
        assert_eq!(
            (d.verdict, d.causes[0].name.as_str()),
            ("named", "drawbar-bias"),
            "{load} N: {:?}",
            d.set
        );
    }
}
