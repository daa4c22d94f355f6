//! Rover files that are right: every value of the contract's example arrives.

use terra_data::{GroundSpeedSource, SoilSharing, Start, parse_rover};
use terra_model::SlipConvention;

use crate::support::{RIG, ROVER};

const EXAMPLE: &str = r#"
hypotheses = "wong21"
start = "dry_sand"
prior_sd = { cohesion = 0.5, k_eq = 0.4 }
prior_abs_sd = { cohesion = 500.0 }

[drivetrain]
torque_constant_N_m_A = 0.065
gear_ratio = 40.0
efficiency = 0.8

[condition.grousered]
wheel = { grouser_height_m = 0.01, grouser_count = 24 }
[condition.small]
wheel = { radius_m = 0.1 }
soil = "own"

[filter]
ground_speed = "none"
torque_walk_N2_m2_s3 = 2e3
start_wait_samples = 7

[gap]
window_s = 0.5
slip_range = [0, 0.8]
prior = { none = 0.3, unknown = 0.2 }

[noise]
wheel_speed_rad_s = 0.02
roughness_N = 0

[columns]
wheel_speed_fl_rad_s = { from = "wfl", unit = "rpm" }
slip = { from = "slip_pct", convention = "percent" }
"#;

#[test]
fn every_value_arrives() {
    let rover = parse_rover(&format!("{ROVER}{EXAMPLE}"), "rover.toml").unwrap();
    let vehicle = rover.vehicle.unwrap();
    assert_eq!(
        (
            vehicle.mass,
            vehicle.yaw_inertia,
            vehicle.track,
            vehicle.wheelbase
        ),
        (100.0, 10.0, 0.6, 0.6)
    );
    assert_eq!(
        (
            vehicle.cg_to_front_axle,
            vehicle.cg_height,
            vehicle.yaw_damping
        ),
        (0.3, 0.22, 8.0)
    );
    assert_eq!((rover.wheel.radius, rover.wheel.width), (0.254, 0.15));
    assert_eq!((rover.wheel.inertia, rover.wheel.damping), (0.25, 0.1));
    let drivetrain = rover.drivetrain.unwrap();
    assert_eq!(
        (
            drivetrain.torque_constant,
            drivetrain.gear_ratio,
            drivetrain.efficiency
        ),
        (0.065, 40.0, 0.8)
    );
    assert_eq!(rover.terrain.start, Some(Start::Id("dry_sand".to_owned())));
    assert_eq!(rover.terrain.prior_sd["k_eq"], 0.4);
    assert_eq!(rover.terrain.prior_abs_sd["cohesion"], 500.0);
    // A condition overrides what it names and keeps the rest.
    let grousered = rover.conditions["grousered"];
    assert_eq!(
        (grousered.wheel.radius, grousered.wheel.grouser_height),
        (0.254, 0.01)
    );
    assert_eq!(
        (grousered.wheel.grouser_count, grousered.soil),
        (24, SoilSharing::Shared)
    );
    let small = rover.conditions["small"];
    assert_eq!(
        (small.wheel.radius, small.wheel.width, small.soil),
        (0.1, 0.15, SoilSharing::Own)
    );
    assert_eq!(rover.filter.ground_speed, GroundSpeedSource::None);
    assert_eq!(
        (rover.filter.torque_walk, rover.filter.force_walk),
        (2e3, 1e4)
    );
    assert_eq!(rover.filter.start_wait, 7);
    assert_eq!((rover.gap.window, rover.gap.slip_range), (0.5, (0.0, 0.8)));
    assert_eq!((rover.gap.prior_none, rover.gap.prior_unknown), (0.3, 0.2));
    assert_eq!(rover.noise.get("wheel_speed_rad_s"), Some(0.02));
    assert_eq!(rover.noise.get("roughness_N"), Some(0.0));
    assert_eq!(rover.noise.get("slip"), None);
    assert_eq!(
        rover.columns["wheel_speed_fl_rad_s"].unit.as_deref(),
        Some("rpm")
    );
    assert_eq!(
        rover.columns["slip"].convention,
        Some(SlipConvention::Percent)
    );
}

#[test]
fn defaults_are_those_of_the_contract() {
    let rig = parse_rover(RIG, "rig.toml").unwrap();
    assert!(rig.is_rig());
    assert_eq!(rig.terrain.hypotheses, "wong21");
    assert_eq!(rig.terrain.start, None);
    assert_eq!((rig.filter.torque_walk, rig.filter.force_walk), (1e3, 1e4));
    assert_eq!(
        (rig.filter.start_wait, rig.filter.ground_speed),
        (20, GroundSpeedSource::Log)
    );
    assert_eq!((rig.gap.window, rig.gap.slip_range), (0.2, (-1.0, 1.0)));
    assert_eq!((rig.gap.prior_none, rig.gap.prior_unknown), (0.25, 0.10));
}

#[test]
fn a_start_table_takes_either_form_of_the_modulus() {
    let rest = "sinkage_exponent = 1.1, cohesion = 1040.0, friction_angle = 0.49, shear_modulus = 0.025, c1 = 0.38, c2 = 0.41";
    for (modulus, expected) in [
        ("k_eq = 1.5e6", vec![("k_eq", 1.5e6)]),
        (
            "k_c = 990, k_phi = 1528430",
            vec![("k_c", 990.0), ("k_phi", 1528430.0)],
        ),
    ] {
        let text = format!("{RIG}start = {{ {modulus}, {rest} }}\n");
        let rig = parse_rover(&text, "rig.toml").unwrap();
        let Some(Start::Values(values)) = rig.terrain.start else {
            panic!("a table is no id");
        };
        assert_eq!(values.len(), 6 + expected.len());
        for (name, value) in expected {
            assert_eq!(values[name], value);
        }
        assert_eq!(values["friction_angle"], 0.49);
    }
}

#[test]
fn crlf_and_a_byte_order_mark_change_nothing() {
    let plain = parse_rover(ROVER, "rover.toml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rover.toml");
    std::fs::write(&path, format!("\u{feff}{}", ROVER.replace('\n', "\r\n"))).unwrap();
    assert_eq!(terra_data::read_rover(&path).unwrap(), plain);
}
