//! Rig logs with one known cause, or none.

use terra::gap::{Diagnosis, Settings, diagnose_rig};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_rig};

use crate::{probability, rig, total};

/// Three loads, six slips, two repeats on dry sand, with an effect.
fn diagnose(effect: &str, seed: u64) -> Diagnosis {
    let (rover, registry) = (rig(), Registry::builtin());
    let text = format!(
        r#"
        seed = {seed}
        rover = "rig.toml"
        terrain = "dry_sand"
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
    let log = simulate_rig(&scenario, &rover, &registry).unwrap().log;
    let (d, _) = diagnose_rig(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
    assert!(
        (total(&d) - 1.0).abs() < 1e-9,
        "probabilities sum to {}",
        total(&d)
    );
    d
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

/// Soil pushed ahead so strongly that the nominal law has no best soil: that says nothing against the cause.
#[test]
fn a_gap_that_no_soil_follows_at_all_is_diagnosed() {
    let d = diagnose(&with("bulldozing", 3.5), 4);
    let note = "the re-fit of the nominal model did not converge";
    assert!(d.data.notes.iter().any(|n| n == note), "{:?}", d.data.notes);
    assert_eq!((d.verdict, d.set), ("named", vec!["bulldozing".to_owned()]));
    assert!((d.waterfall.after.unwrap() - 1.0).abs() < 0.5);
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
