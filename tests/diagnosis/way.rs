//! A ground that changes along a way that the log does not tell, or by passes that count otherwise.

use terra::gap::{Diagnosis, Settings, diagnose_drive};
use terra::sim::{Scenario, simulate_drive};

use crate::vehicle::{effect, example};

/// Change of the soil along 8 m, in the effect's own unit.
const DRIFT: f64 = 0.4;

/// One way of some 25 m on which the operator counts passes on, although no track is driven twice: a pass of its own begins a run,
/// whose path would count from its beginning. `told`: the log has its `distance_m`.
fn diagnosis(told: bool) -> Diagnosis {
    let (rover, registry, _) = example();
    let sensor = if told {
        "[sensor]\ndistance_m = { noise = 0.01 }"
    } else {
        ""
    };
    let text = format!(
        r#"
        seed = 5
        rover = "rover.toml"
        rate_hz = 100.0
        terrain = "dry_sand"
        [[effect]]
        name = "terrain-drift"
        magnitude = {DRIFT}
        [[segment]]
        name = "steps"
        duration_s = 6.0
        wheel_speed_rad_s = {{ from = 3.0, to = 6.0 }}
        start = {{ ground_speed_m_s = 0.7, wheel_speed_rad_s = 3.0 }}
        [[segment]]
        name = "brake"
        duration_s = 4.0
        wheel_speed_rad_s = {{ from = 6.0, to = 2.5 }}
        pass = 2
        [[segment]]
        name = "turn"
        duration_s = 5.0
        wheel_speed_rad_s = {{ fl = 3.2, fr = 4.8, rl = 3.2, rr = 4.8 }}
        pass = 3
        [[segment]]
        name = "axles"
        duration_s = 5.0
        wheel_speed_rad_s = {{ fl = 5.5, fr = 5.5, rl = 3.5, rr = 3.5 }}
        pass = 4
        [[segment]]
        name = "faster"
        duration_s = 5.0
        wheel_speed_rad_s = {{ from = 3.0, to = 7.0 }}
        pass = 5
        {sensor}
        "#
    );
    let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    assert_eq!(log.distance.is_some(), told);
    diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap()
}

/// The drift is named with its size, along the path that the log tells and without it; there the path is said to have been taken for
/// another than it looked like.
#[test]
fn a_drift_is_found_along_a_way_that_is_not_told() {
    for told in [true, false] {
        let d = diagnosis(told);
        assert_eq!(d.verdict, "named", "{:?} {:?}", d.set, d.heed);
        let first = &d.causes[0];
        assert_eq!(first.name, "terrain-drift");
        let k = first.weighed.hypothesis.soil_len();
        let found = DRIFT * first.weighed.fit.x[k];
        assert!((found - DRIFT).abs() < 0.1 * DRIFT, "{found}");
        let heeded = d.heed.iter().any(|h| h.contains("distance_m"));
        assert_eq!(heeded, !told, "{:?}", d.heed);
        let path = d.data.observations.last().unwrap().factors["path"];
        assert!((15.0..40.0).contains(&path), "{path}");
    }
}

/// A rut in which an earlier pass of the vehicle counts for both of its axles, or as one pass as the nominal law has it: either way it
/// comes first with its size, and what was taken otherwise is said.
#[test]
fn a_rut_is_found_whichever_way_its_passes_count() {
    const STIFFER: f64 = 1.6;
    let (rover, registry, mut scenario) = example();
    scenario.effects = vec![effect(("multipass", STIFFER))];
    let rut = scenario.segments.iter().position(|s| s.name == "own rut");
    for (pass, by_axles) in [(2, false), (3, true)] {
        scenario.segments[rut.unwrap()].pass = Some(pass);
        let mut log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
        let told = log.pass.take().unwrap();
        let told = told.iter().map(|pass| pass.map(|pass| pass.min(2.0)));
        log.pass = Some(told.collect());
        let d = diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
        let first = &d.causes[0];
        assert_eq!(first.name, "multipass", "{:?} {:?}", d.set, d.heed);
        let h = &first.weighed.hypothesis;
        let sd = h.effects()[0].params()[0].prior_sd;
        let found = sd * first.weighed.fit.x[h.soil_len()];
        assert!((found / STIFFER - 1.0).abs() < 0.2, "{found}");
        let heeded = d.heed.iter().any(|h| h.contains("each axle"));
        assert_eq!(heeded, by_axles, "{:?}", d.heed);
    }
}
