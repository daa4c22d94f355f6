//! A drive log whose torque sensor is off by 12 %.

use std::path::Path;

use terra::data::read_rover;
use terra::gap::{Settings, diagnose_drive};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_drive};

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
    let found = d.causes[0].weighed.fit.x[d.causes[0].weighed.fit.x.len() - 1] * 0.12;
    assert!((found - 0.12).abs() < 0.04, "{found}");
    // The predictor and the simulator share nothing: what is left is noise.
    let after = d.waterfall.after.unwrap();
    assert!((0.8..1.2).contains(&after), "{after}");
}
