//! Conditions of a rig's log: soils of their own, lugs that only some of them have, and what differs between them.

use terra::data::{RigLog, Rover, SoilSharing};
use terra::gap::{Diagnosis, Named, Settings, diagnose_rig, diagnose_rigs};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_rig};

use crate::rig_with;

/// Two loads, six slips, two repeats of one condition.
fn part(condition: &str, terrain: &str, effect: &str, seed: u64) -> RigLog {
    let text = format!(
        r#"
        seed = {seed}
        rover = "rig.toml"
        terrain = "{terrain}"
        [[trial]]
        slip = [0.05, 0.1, 0.2, 0.35, 0.55, 0.8]
        normal_load_N = [150.0, 300.0]
        repeats = 2
        travel_speed_m_s = 0.05
        condition = "{condition}"
        {effect}
        "#
    );
    let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    let simulated = simulate_rig(&scenario, &rig_with(""), &Registry::builtin());
    simulated.unwrap().log
}

fn joined(mut a: RigLog, b: RigLog) -> RigLog {
    for mut row in b.rows {
        row.trial = format!("b{}", row.trial);
        a.rows.push(row);
    }
    a
}

fn diagnosed(rover: &Rover, log: &RigLog) -> Diagnosis {
    let found = diagnose_rig(log, rover, &Registry::builtin(), &Settings::of(rover));
    found.unwrap().0
}

const LUGS: &str = "[[effect]]\nname = \"grousers\"\nmagnitude = 0.012\n";

/// Sand and loam in one log are two soils where the rover file says so: the same as two logs with a soil each.
#[test]
fn a_condition_has_a_soil_of_its_own_where_that_is_said() {
    let (sand, loam) = (
        part("bin", "dry_sand", "", 1),
        part("field", "sandy_loam_15", "", 2),
    );
    let whole = joined(sand.clone(), loam.clone());
    let apart = diagnosed(&rig_with("[condition.field]\nsoil = \"own\""), &whole);
    assert_eq!(apart.verdict, "none", "{:?} {:?}", apart.set, apart.reason);
    // Stresses too are those of the row's own soil, where the law is handed the parameters of both.
    let (rover, registry) = (
        rig_with("[condition.field]\nsoil = \"own\""),
        Registry::builtin(),
    );
    let (d, predictor) = diagnose_rig(&whole, &rover, &registry, &Settings::of(&rover)).unwrap();
    let (h, fit) = d.null.as_ref().unwrap();
    let p = h.parameters(fit.x.as_slice());
    let largest = |row| {
        let found = predictor.stresses(&h.law, &p, row, [0.2, 150.0], 9);
        found.unwrap().unwrap().max_normal.normal_stress
    };
    let last = whole.rows.len() - 1;
    assert!((largest(0) / largest(last) - 1.0).abs() > 0.02);
    let together = diagnosed(&rig_with(""), &whole);
    assert_ne!(together.verdict, "none", "{:?}", together.set);
    let rover = rig_with("");
    let settings = Settings {
        soil: SoilSharing::Own,
        ..Settings::of(&rover)
    };
    let logs = [("field", &loam), ("shared", &sand)].map(|(name, log)| Named { name, log });
    let two = diagnose_rigs(&logs, &rover, &Registry::builtin(), &settings)
        .unwrap()
        .0;
    let soils = |d: &Diagnosis| {
        let (hypothesis, fit) = d.null.as_ref().unwrap();
        (hypothesis.soil.names(), fit.x.clone())
    };
    let ((names, x), (of_two, y)) = (soils(&apart), soils(&two));
    assert_eq!(names, of_two);
    assert!((x - y).amax() < 1e-3);
}

/// A smooth wheel has no lugs, so what only the other one shows is theirs: by what the rover file declares, or the condition's name.
#[test]
fn lugs_are_asked_for_where_a_wheel_has_them() {
    for (other, declared) in [
        (
            "plain",
            "[condition.lugged]\nwheel = { grouser_height_m = 0.012, grouser_count = 24 }",
        ),
        ("smooth", ""),
    ] {
        let plain = part(other, "dry_sand", "", 3);
        let log = joined(plain, part("lugged", "dry_sand", LUGS, 4));
        let d = diagnosed(&rig_with(declared), &log);
        assert_eq!(d.set, ["grousers"], "{other}: {:?}", d.reason);
        let weighed = &d.causes[0].weighed;
        let height = weighed.hypothesis.parameters(weighed.plain.x.as_slice());
        let height = height.last().unwrap();
        assert!((height - 0.012).abs() < 0.002, "{other}: {height}");
    }
}

/// Where nobody says what differs between two conditions, that something does is no noise: no smooth function of slip follows it.
#[test]
fn conditions_that_differ_are_not_nothing() {
    let rover = rig_with("[condition.elsewhere]\nsoil = \"shared\"");
    let log = joined(part("a", "dry_sand", "", 5), part("b", "dry_sand", LUGS, 6));
    let d = diagnosed(&rover, &log);
    assert!(
        d.verdict == "unknown" || d.set.iter().any(|s| s == "unknown"),
        "{:?}",
        d.set
    );
    assert!(d.probability_none < 0.1, "{}", d.probability_none);
    let heed = "[condition] elsewhere of the rover file is in no row: the log's are a, b";
    assert!(d.heed.iter().any(|h| h == heed), "{:?}", d.heed);
    // The same soil and wheel under two names are nothing.
    let log = joined(part("a", "dry_sand", "", 5), part("b", "dry_sand", "", 7));
    assert_eq!(diagnosed(&rig_with(""), &log).verdict, "none");
}

/// A sensor that always says the same is told, whatever the verdict makes of it; one that reads anything else is not.
#[test]
fn a_sensor_that_is_stuck_is_told() {
    let mut log = part("a", "dry_sand", "", 9);
    let told = |log: &RigLog| {
        let d = diagnosed(&rig_with(""), log);
        d.heed
            .iter()
            .any(|h| h.starts_with("sinkage_m is 0.02 m in all 24 rows"))
    };
    assert!(!told(&log));
    for row in &mut log.rows {
        row.sinkage.as_mut().unwrap().value = 0.02;
    }
    assert!(told(&log));
}

/// Rows that are left out are told, and a noise of zero is refused by its line.
#[test]
fn rows_that_cannot_count_are_told() {
    let mut log = part("a", "dry_sand", "", 8);
    log.rows[3].normal_load.value = 0.0;
    let d = diagnosed(&rig_with(""), &log);
    let heed = "rows left out: 1 no load on the wheel";
    assert!(d.heed.iter().any(|h| h == heed), "{:?}", d.heed);
    log.rows[5].drawbar_pull.as_mut().unwrap().sd = Some(0.0);
    let rover = rig_with("");
    let e = diagnose_rig(&log, &rover, &Registry::builtin(), &Settings::of(&rover));
    let e = e.err().unwrap();
    let line = log.rows[5].line;
    let wanted = format!("line {line}: drawbar_pull_sd_N is 0, expected a noise above 0");
    assert!(e.to_string().contains(&wanted), "{e}");
}
