//! Short drives: one torque ramp, whose few windows the soil's seven parameters nearly follow by themselves.

use terra::data::Start;
use terra::gap::{Settings, diagnose_drive};
use terra::sim::{Scenario, simulate_drive};

use crate::vehicle::{effect, example};

/// Rear wheels in the ruts of the front ones, on soil that nobody told: re-fitted soil goes so far to meet them that there, by the
/// tangent, less of it would be better. The law itself says otherwise, and it is asked.
#[test]
fn a_second_pass_that_soil_stands_for_is_found_on_a_ramp() {
    let (mut rover, registry, _) = example();
    let text = r#"
        seed = 1
        rover = "rover.toml"
        rate_hz = 100.0
        [terrain]
        cohesion = 807.2
        friction_angle = 0.52
        k_c = 0.0
        k_phi = 1227260.0
        shear_modulus = 0.02655
        sinkage_exponent = 1.18
        c1 = 0.507
        c2 = 0.410
        [[segment]]
        name = "ramp"
        duration_s = 4.0
        torque_N_m = { from = 35.0, to = 8.0 }
        start = { ground_speed_m_s = 0.0, wheel_speed_rad_s = 0.2 }
    "#;
    rover.terrain.start = Some(Start::Id("dry_sand".to_owned()));
    for seed in 1..=4 {
        let mut scenario = Scenario::parse(text, "ramp.toml").unwrap();
        scenario.seed = seed;
        scenario.effects = vec![effect(("multipass", 1.4))];
        let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
        let d = diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
        assert_eq!(d.set, ["multipass"], "seed {seed}");
    }
}
