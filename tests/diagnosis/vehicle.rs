//! A drive log whose torque sensor is off by 12 %.

use std::path::Path;

use terra::data::read_rover;
use terra::gap::{Settings, diagnose_drive};
use terra::model::Registry;
use terra::sim::{EffectSetting, Scenario, simulate_drive};

use crate::{probability, total};

/// The example of the book: eight manoeuvres, 34 candidate effects.
#[test]
fn a_torque_sensor_that_is_off_is_named() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drive");
    let (rover, registry) = (
        read_rover(folder.join("rover.toml")).unwrap(),
        Registry::builtin(),
    );
    let scenario = Scenario::read(&folder.join("rich.toml")).unwrap();
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    let d = diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
    assert!((total(&d) - 1.0).abs() < 1e-9);
    assert_eq!(
        (d.verdict, d.causes[0].name.as_str()),
        ("named", "torque-scale"),
        "{:?}",
        d.set
    );
    assert!(probability(&d, "torque-scale") > 0.9);
    let first = &d.causes[0].weighed;
    let found = first.fit.x[first.hypothesis.soil_len()] * 0.12;
    assert!((found - 0.12).abs() < 0.04, "{found}");
    // The predictor and the simulator share nothing: what is left is noise.
    let after = d.waterfall.after.unwrap();
    assert!((0.8..1.2).contains(&after), "{after}");
}

/// Air resistance in a headwind, which the library's formula has no place for: the cause is named all the same, and no second
/// one is blamed for the difference.
#[test]
fn the_right_cause_is_named_by_another_formula() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drive");
    let (rover, registry) = (
        read_rover(folder.join("rover.toml")).unwrap(),
        Registry::builtin(),
    );
    let mut scenario = Scenario::read(&folder.join("rich.toml")).unwrap();
    scenario.effects = vec![EffectSetting {
        name: "aero-drag".to_owned(),
        magnitude: vec![10.0],
        form: Some("headwind".to_owned()),
    }];
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    let d = diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
    let first = &d.causes[0];
    assert_eq!(
        (first.name.as_str(), first.form.as_str()),
        ("aero-drag", "free"),
        "{:?}",
        d.set
    );
    assert!(first.probability > 0.5, "{}", first.probability);
    let after = first.weighed.chi2_per_value();
    assert!((0.8..1.2).contains(&after), "{after}");
}
