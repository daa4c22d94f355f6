//! A catalogue of the user's own beside the built-in one: what its file names is what counts, also under a name that both
//! know, and its sources are cited.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{example, folder, json, list, terra, text};

/// A soil much softer than the built-in `dry_sand`, under that name and under one of its own; the second without a source.
const OWN: &str = "id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2,conf,source_note\n\
                   dry_sand,mine,Ours,0.9,2.0,310.0,0.6,24,0.03,0.2,0.3,user,\"shear box, May\"\n\
                   bench,mine,Ours,0.9,2.0,310.0,0.6,24,0.03,0.2,0.3,user,NA\n";

/// The same soil by value: kN and degrees as the catalogue's columns say.
fn by_value() -> String {
    let [k_c, k_phi, cohesion] = [2.0, 310.0, 0.6].map(|kilo: f64| kilo * 1e3);
    let phi = 24.0 * PI / 180.0;
    format!(
        "{{ k_c = {k_c:?}, k_phi = {k_phi:?}, sinkage_exponent = 0.9, cohesion = {cohesion:?}, friction_angle = {phi:?}, \
         shear_modulus = 0.03, c1 = 0.2, c2 = 0.3 }}"
    )
}

/// A rig on the soft soil: its log, the catalogue, and a rover file that starts at `start`.
fn place(name: &str) -> PathBuf {
    let at = folder(name);
    fs::write(at.join("own.csv"), OWN).unwrap();
    rover(&at, "\"dry_sand\"", "");
    let scenario = fs::read_to_string(example("rig/slip_sinkage.toml")).unwrap();
    let (without, _) = scenario.split_once("[[effect]]").unwrap();
    let soft = without.replace("\"dry_sand\"", &by_value());
    fs::write(at.join("trials.toml"), soft).unwrap();
    terra(&at, "simulate trials.toml --out rig.csv").ok();
    at
}

fn rover(at: &Path, start: &str, hypotheses: &str) {
    let rig = fs::read_to_string(example("rig/rig.toml")).unwrap();
    let line = "start = \"dry_sand\"\n";
    assert!(rig.contains(line));
    let said = rig.replace(line, &format!("start = {start}\n{hypotheses}"));
    fs::write(at.join("rig.toml"), said).unwrap();
}

/// What the diagnosis says of the soil: its misfit as given and re-fitted, and where the fit ended.
fn verdict(at: &Path) -> [Value; 2] {
    terra(
        at,
        "gap rig.csv --rover rig.toml --effects slip-sinkage --combine 1 --json out.json",
    )
    .ok();
    let found = json(&at.join("out.json"));
    ["gap", "terrain"].map(|part| found[part].clone())
}

#[test]
fn a_start_is_the_row_of_the_file_that_hypotheses_names() {
    let at = place("own_start");
    rover(&at, &by_value(), "hypotheses = \"own.csv\"\n");
    let expected = verdict(&at);
    for start in ["\"dry_sand\"", "\"bench\""] {
        rover(&at, start, "hypotheses = \"own.csv\"\n");
        assert_eq!(verdict(&at), expected, "{start}");
    }
    // Without the file the name is the built-in soil's, which the log is not from.
    rover(&at, "\"dry_sand\"", "");
    assert_ne!(verdict(&at), expected);
    // What neither has, and a row that lacks what the model needs, are named by their place.
    let own = OWN.replace("24,0.03", "24,NA");
    fs::write(at.join("own.csv"), own).unwrap();
    for (start, word) in [("\"bunch\"", "bench"), ("\"dry_sand\"", "shear_modulus")] {
        rover(&at, start, "hypotheses = \"own.csv\"\n");
        let done = terra(&at, "cite rig.toml");
        assert_eq!(done.code, 2, "{}", done.out);
        let text = fs::read_to_string(at.join("rig.toml")).unwrap();
        let line = 1 + text.lines().position(|l| l.starts_with("start")).unwrap();
        assert!(
            done.err.contains(&format!("rig.toml:{line}:9")) && done.err.contains(word),
            "{}",
            done.err
        );
    }
}

#[test]
fn the_sources_of_the_users_rows_are_cited() {
    let at = place("own_cited");
    let cited = |start: &str| -> Vec<(String, String, String)> {
        rover(&at, start, "hypotheses = \"own.csv\"\n");
        let found: Value =
            serde_json::from_str(&terra(&at, "cite rig.toml --json").ok().out).unwrap();
        list(&found["references"])
            .iter()
            .map(|r| ["kind", "name", "reference"].map(|k| text(&r[k]).to_owned()))
            .map(|[kind, name, reference]| (kind, name, reference))
            .filter(|(kind, ..)| kind.starts_with("soil"))
            .collect()
    };
    let all = cited("\"dry_sand\"");
    let has = |kind: &str, name: &str, word: &str| {
        all.iter()
            .any(|(k, n, r)| k == kind && n == name && r.contains(word))
    };
    assert!(has("soil", "dry_sand", "shear box, May"), "{all:?}");
    assert!(has("soils", "own.csv", "shear box, May"), "{all:?}");
    // A row without a source is not passed over in silence, and nothing of the built-in soil of that name is cited.
    assert!(has("soils", "own.csv", "source_note"), "{all:?}");
    assert_eq!(all.len(), 3, "{all:?}");
    assert!(all.iter().all(|r| !r.2.contains("Wong")), "{all:?}");
    let bench = cited("\"bench\"");
    let start = bench.iter().find(|(kind, ..)| kind == "soil").unwrap();
    assert!(
        start.1 == "bench" && start.2.contains("source_note"),
        "{start:?}"
    );
}
