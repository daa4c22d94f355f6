//! `terra cite`: each thing in use is there with its source, and nothing that is not in use.

use std::fs;

use serde_json::Value;

use crate::support::{folder, list, logs, terra, text};

fn cited(line: &str) -> Vec<(String, String, String)> {
    let done = terra(logs(), line).ok();
    let found: Value = serde_json::from_str(&done.out).unwrap();
    list(&found["references"])
        .iter()
        .map(|r| {
            let one = |key: &str| text(&r[key]).to_owned();
            (one("kind"), one("name"), one("reference"))
        })
        .collect()
}

/// The sources are those that `terra models` and `terra effects` give.
#[test]
fn a_scenario_owes_for_its_model_effects_and_soils() {
    let all = cited("cite trials.toml --json");
    let has = |kind: &str, name: &str| all.iter().find(|r| r.0 == kind && r.1 == name).cloned();
    let listed = |line: &str, name: &str| {
        let found: Value = serde_json::from_str(&terra(logs(), line).ok().out).unwrap();
        let one = list(&found).iter().find(|e| e["name"] == name).cloned();
        text(&one.unwrap()["reference"]).to_owned()
    };
    let model = has("model", "wong-reece").unwrap();
    assert_eq!(model.2, listed("models --json", "wong-reece"));
    let effect = has("effect", "slip-sinkage").unwrap();
    assert_eq!(effect.2, listed("effects --json", "slip-sinkage"));
    assert!(all.iter().any(|r| r.0 == "soil" && !r.2.is_empty()));
}

#[test]
fn a_rover_owes_for_its_model_and_hypotheses_only() {
    let all = cited("cite rover.toml --json");
    assert!(all.iter().all(|r| r.0 != "effect" && !r.2.is_empty()));
    // The 21 soils are one published table.
    let soils: Vec<_> = all.iter().filter(|r| r.0 == "soils").collect();
    assert!(soils.iter().all(|r| r.1 == "wong21"));
    assert_eq!(soils.len(), 1, "{soils:?}");
    assert!(soils[0].2.contains("Theory of Ground Vehicles"));
    let plain = terra(logs(), "cite rover.toml").ok();
    assert!(
        all.iter().all(|r| plain.out.contains(&r.2)),
        "{}",
        plain.out
    );
}

#[test]
fn broken_files_end_with_their_place() {
    let to = folder("cite_broken");
    assert_eq!(terra(&to, "cite none.toml").code, 2);
    let rover = "[wheel]\nradius_m = 0.1\nwidth_m = 0.1\n[terrain]\nmodel = \"wong-rece\"\n";
    fs::write(to.join("rig.toml"), rover).unwrap();
    let done = terra(&to, "cite rig.toml");
    assert_eq!(done.code, 2);
    assert!(done.err.contains("rig.toml:5:"), "{}", done.err);
    fs::write(to.join("s.toml"), "rover = \"none.toml\"\nspeed = 1\n").unwrap();
    assert_eq!(terra(&to, "cite s.toml").code, 2);
}
