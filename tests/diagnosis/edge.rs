//! Ground that becomes another one at a place.

use terra::data::Start;
use terra::gap::{Cause, Diagnosis, Settings, diagnose_drive};
use terra::model::Registry;
use terra::sim::{Patch, simulate_drive};

use crate::watch::{patrol, rover};

/// A patrol over sand that gives way to this soil at 32 m, along two metres.
fn sand_then(soil: &str, seed: u64) -> Diagnosis {
    let (rover, registry) = (rover(), Registry::builtin());
    let mut scenario = patrol(4, seed);
    let beyond = || Start::Id(soil.to_owned());
    scenario.world.patches = vec![Patch {
        from: 31.0,
        blend: 2.0,
        terrain: [beyond(), beyond(), beyond(), beyond()],
    }];
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap()
}

/// The value of a parameter of a cause.
fn of(cause: &Cause, name: &str) -> f64 {
    let all = cause.weighed.hypothesis.effects()[0].params().to_vec();
    let k = all.iter().position(|p| p.name == name).unwrap();
    let soil = cause.weighed.hypothesis.soil_len();
    cause.weighed.plain.x[soil + k] * all[k].prior_sd
}

/// No smooth factor along the path makes clay or loam of sand: what changes is the exponent of its sinkage above all (1.1 to .2 and to
/// .7), and the shear modulus (25 to 6 and 10 mm). Where it does is within a wheelbase of the middle of the change.
#[test]
fn another_soil_is_named_with_the_place_where_it_begins() {
    for (soil, seed, exponent) in [("lean_clay_22", 41, -0.9), ("sandy_loam_15", 42, -0.4)] {
        let d = sand_then(soil, seed);
        let cause = &d.causes[0];
        let told = format!("{soil}: {} {:?} {}", d.verdict, d.set, cause.form);
        assert_eq!(
            (cause.name.as_str(), cause.form.as_str()),
            ("terrain-drift", "edge"),
            "{told}"
        );
        assert!(cause.probability > 0.6, "{told} {}", cause.probability);
        let place = of(cause, "place");
        assert!((place - 32.0).abs() < 0.6, "{told} {place}");
        let n = of(cause, "sinkage_exponent");
        assert!((n - exponent).abs() < 0.35, "{told} {n}");
    }
}

/// A soil that hardly differs is followed by a smooth factor, and the same soil is none.
#[test]
fn the_same_soil_has_no_edge() {
    let d = sand_then("dry_sand", 43);
    assert_eq!(d.verdict, "none", "{:?} {:?}", d.set, d.reason);
    assert!(d.causes.iter().all(|c| c.form != "edge"));
}
