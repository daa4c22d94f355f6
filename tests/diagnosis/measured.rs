//! Measured single-wheel tests.

use std::path::PathBuf;

use terra::data::{read_rig_log, read_rover};
use terra::gap::{HoldOut, Settings, diagnose_rig};
use terra::model::Registry;

/// Carnegie Mellon University, smooth wheel on dry sand: the wheel sinks more with slip than any soil of the model lets
/// it, and pull and sinkage alone leave the form open.
#[test]
fn the_soil_bin_of_carnegie_mellon() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let data =
        std::env::var_os("TERRA_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let file = data.join("cmu_single_wheel/smooth_straight.csv");
    if !file.exists() {
        println!("SKIPPED: {} is not there; set TERRA_DATA", file.display());
        return;
    }
    let rover = read_rover(root.join("examples/cmu/rig.toml")).unwrap();
    let log = read_rig_log(&file, &rover).unwrap();
    let settings = Settings {
        hold_out: Some(HoldOut::Slip),
        ..Settings::of(&rover)
    };
    let (d, _) = diagnose_rig(&log, &rover, &Registry::builtin(), &settings).unwrap();
    assert_eq!(d.verdict, "unknown", "{:?}", d.set);
    assert!(!d.nearest.is_empty());
    assert!(
        d.nearest.iter().all(|n| n.contains("slip-sinkage")),
        "{:?}",
        d.nearest
    );
    let closed = d.held_out.unwrap().closed.unwrap();
    assert!(closed.lo > 0.4 && closed.hi < 0.9, "{closed:?}");
    let sinkage = d.places.iter().find(|p| p.channel == "sinkage_m").unwrap();
    assert!(sinkage.sigma > 3.0);
    assert_eq!(
        d.data.dropped.get("slip outside [gap] slip_range"),
        Some(&12)
    );
}
