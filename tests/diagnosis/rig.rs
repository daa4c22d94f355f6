//! Rig logs with one known cause, or none.

use terra::data::{RigLog, Rover, parse_rover};
use terra::gap::{Diagnosis, Settings, diagnose_rig};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_rig};

use crate::{probability, rig, rig_with, total};

/// Three loads, six slips, two repeats on dry sand, with an effect.
fn log(rover: &Rover, effect: &str, seed: u64) -> RigLog {
    log_on(rover, "terrain = \"dry_sand\"", effect, seed)
}

/// The same on a terrain.
fn log_on(rover: &Rover, terrain: &str, effect: &str, seed: u64) -> RigLog {
    let text = format!(
        r#"
        seed = {seed}
        rover = "rig.toml"
        {terrain}
        [[trial]]
        slip = [0.05, 0.1, 0.2, 0.35, 0.55, 0.8]
        normal_load_N = [150.0, 245.0, 400.0]
        repeats = 2
        travel_speed_m_s = 0.05
        condition = "smooth"
        {effect}
        "#
    );
    let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    let simulated = simulate_rig(&scenario, rover, &Registry::builtin());
    simulated.unwrap().log
}

fn diagnosed(rover: &Rover, log: &RigLog) -> Diagnosis {
    let (d, _) = diagnose_rig(log, rover, &Registry::builtin(), &Settings::of(rover)).unwrap();
    assert!(
        (total(&d) - 1.0).abs() < 1e-9,
        "probabilities sum to {}",
        total(&d)
    );
    d
}

fn diagnose(effect: &str, seed: u64) -> Diagnosis {
    diagnosed(&rig(), &log(&rig(), effect, seed))
}

fn with(name: &str, magnitude: f64) -> String {
    format!("[[effect]]\nname = \"{name}\"\nmagnitude = {magnitude}\n")
}

#[test]
fn nothing_missing_is_found_to_be_nothing() {
    for seed in 1..=2 {
        let d = diagnose("", seed);
        assert_eq!(
            d.verdict, "none",
            "seed {seed}: {:?}, {:?}",
            d.set, d.reason
        );
        assert!(d.accepted_names.is_empty());
    }
}

/// A pull that grows with the cube of slip, by 5 N at a load of 50 N and of 90 N, has no name: a law of slightly another form
/// and noise do not make it nothing.
#[test]
fn a_smooth_error_of_the_law_is_not_nothing() {
    let rover = r#"
        [wheel]
        radius_m = 0.17
        width_m = 0.12
        [terrain]
        model = "wong-reece"
        start = "dry_sand"
        [noise]
        drawbar_pull_N = 0.4
        torque_N_m = 0.08
        sinkage_m = 0.0007
        slip = 0.004
        normal_load_N = 0.4
        "#;
    let rover = parse_rover(rover, "rig.toml").unwrap();
    let text = r#"
        seed = 5
        rover = "rig.toml"
        terrain = "dry_sand"
        [[trial]]
        slip = [0.03, 0.08, 0.12, 0.2, 0.3, 0.4, 0.5, 0.6]
        normal_load_N = [50.0, 90.0]
        repeats = 3
        travel_speed_m_s = 0.06
        condition = "smooth"
        "#;
    let scenario = Scenario::parse(text, "scenario.toml").unwrap();
    let simulated = simulate_rig(&scenario, &rover, &Registry::builtin());
    let mut log = simulated.unwrap().log;
    assert_eq!(diagnosed(&rover, &log).verdict, "none");
    for row in &mut log.rows {
        let pull = row.drawbar_pull.as_mut().unwrap();
        pull.value += 25.0 * row.slip.value.powi(3);
    }
    let d = diagnosed(&rover, &log);
    assert!(d.probability_none < 0.1, "{}", d.probability_none);
    assert_eq!(d.set.first().map(String::as_str), Some("unknown"));
}

/// Rows that scatter as the ground's stated roughness says misfit by noise alone.
#[test]
fn the_ground_s_roughness_is_noise() {
    let rough = rig_with("roughness_N = 4.0\nroughness_N_m = 0.8\n");
    let log = log(&rough, "", 6);
    let d = diagnosed(&rough, &log);
    let misfit = d.waterfall.refitted.unwrap();
    assert_eq!(d.verdict, "none", "{:?}", d.set);
    assert!((0.6..1.3).contains(&misfit), "{misfit}");
    let ignored = diagnosed(&rig(), &log).waterfall.refitted.unwrap();
    assert!(ignored > 3.0, "{ignored}");
}

/// Soil pushed ahead so strongly that no soil of the nominal law comes near: that says nothing against the cause. Nor does a re-fit
/// that has no end, of which it is told.
#[test]
fn a_gap_that_no_soil_follows_at_all_is_diagnosed() {
    let d = diagnose(&with("bulldozing", 3.5), 4);
    let misfit = d.waterfall.refitted.unwrap();
    assert!(misfit > 100.0, "{misfit}");
    assert_eq!((d.verdict, d.set), ("named", vec!["bulldozing".to_owned()]));
    assert!((d.waterfall.after.unwrap() - 1.0).abs() < 0.5);
    let d = diagnose(&with("bulldozing", 8.0), 4);
    let note = "the re-fit of the nominal model did not converge";
    assert!(d.data.notes.iter().any(|n| n == note), "{:?}", d.data.notes);
    assert!(d.set[0].starts_with("bulldozing"), "{:?}", d.set);
}

/// Effects with a signature of their own at three loads are named, and their size is found.
#[test]
fn causes_with_a_signature_of_their_own_are_named() {
    for (name, magnitude, seed) in [("slip-sinkage", 0.3, 4), ("bulldozing", 0.5, 5)] {
        let d = diagnose(&with(name, magnitude), seed);
        assert_eq!(d.causes[0].name, name, "{:?}", d.set);
        assert!(
            probability(&d, name) > 0.8,
            "{name}: {}",
            probability(&d, name)
        );
        let cause = &d.causes[0];
        let k = cause.weighed.plain.x.len() - 1;
        let sd = terra::model::Registry::builtin()
            .effect(name)
            .unwrap()
            .params()[0]
            .prior_sd;
        let found = cause.weighed.plain.x[k] * sd;
        assert!(
            (found / magnitude - 1.0).abs() < 0.35,
            "{name}: {found} for {magnitude}"
        );
    }
}

/// Nothing is missing on soil that has less strength than the rover file starts from, by more than its prior believes: less
/// friction under the rim would do the same, and of that the log says nothing. It is no only answer.
#[test]
fn a_soil_far_from_the_start_is_no_cause() {
    let weak = "terrain = { k_eq = 1.5e6, sinkage_exponent = 1.1, cohesion = 500.0, friction_angle = 0.26, shear_modulus = 0.025, c1 = 0.38, c2 = 0.41 }";
    let d = diagnosed(&rig(), &log_on(&rig(), weak, "", 3));
    assert!(d.causes[0].log_evidence_gain > 4.0);
    assert_ne!(d.verdict, "named", "{:?}", d.set);
    assert!(d.set.iter().any(|answer| answer == "none"), "{:?}", d.set);
    let why = d.reason.as_deref().unwrap_or_default();
    assert!(
        why.contains("a soil farther from the rover file's"),
        "{why}"
    );
    assert!((total(&d) - 1.0).abs() < 1e-9);
}

/// An instrument's error is exact in form: the load cell's offset is told from every soil.
#[test]
fn an_offset_of_the_load_cell_is_named_and_closes_the_gap() {
    let d = diagnose(&with("drawbar-bias", 6.0), 6);
    assert_eq!(d.causes[0].name, "drawbar-bias", "{:?}", d.set);
    let closed = d.held_out.unwrap().closed.unwrap();
    assert!(
        closed.mean > 0.8 && closed.lo <= closed.mean && closed.mean <= closed.hi,
        "{closed:?}"
    );
}
