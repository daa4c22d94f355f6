//! Soils for other simulators, and the pages for a shell and for `man`.

use std::fs;

use serde_json::Value;
use terra::model::{Contact, ForceLaw, Registry, catalogue};

use crate::support::{Csv, folder, logs, terra};

/// The line is the law's own, at every slip of its range: asked of the law again, not of the fit.
#[test]
fn slip_compliance_holds_where_it_says() {
    let at = folder("export");
    terra(
        &at,
        "export slip-compliance dry_sand --radius_m 0.254 --width_m 0.15 --load_N 150,245.25,1e9 --tolerance 0.05 --out table.csv",
    )
    .ok();
    let table = fs::read_to_string(at.join("table.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[2][6], "no-compliance");
    let law = Registry::builtin().law("wong-reece").unwrap();
    let p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    for row in &rows[..2] {
        assert_eq!(row[6], "ok");
        let n: Vec<f64> = row[..6].iter().map(|c| c.parse().unwrap()).collect();
        let (load, compliance, resistance, slip_to, worst) = (n[0], n[1], n[2], n[4], n[5]);
        let pull = |s: f64| {
            law.forces(&p, &Contact::new(s, load, 0.254, 0.15))
                .unwrap()
                .drawbar_pull
                / load
        };
        assert!((pull(0.0) + resistance).abs() < 1e-12);
        assert!(slip_to > 0.0 && compliance > 0.0);
        for k in 0..=(slip_to * 100.0).round() as usize {
            let s = k as f64 / 100.0;
            let line = s / compliance - resistance;
            assert!((pull(s) - line).abs() <= worst + 1e-12, "slip {s}");
        }
        assert!(worst <= 0.05 * (pull(slip_to) - pull(0.0)) * 1.0001);
    }
}

/// The refined soil of an identification, as Chrono's JSON: read back, it gives the forces that identify predicts.
#[test]
fn a_refined_soil_goes_to_chrono_and_back() {
    let at = folder("export_refined");
    let rig = logs().join("rig.csv");
    let rover = logs().join("rig.toml");
    let line = format!(
        "identify {} --rover {} --json identify.json",
        rig.display(),
        rover.display()
    );
    terra(&at, &line).ok();
    terra(&at, "export scm-json identify.json --out soil.json").ok();
    let found: Value =
        serde_json::from_str(&fs::read_to_string(at.join("identify.json")).unwrap()).unwrap();
    let soil: Value =
        serde_json::from_str(&fs::read_to_string(at.join("soil.json")).unwrap()).unwrap();
    let refined = &found["groups"][0]["refined"]["parameters"];
    assert_eq!(soil["Mohr cohesive limit"], refined["cohesion"]["mean"]);
    assert_eq!(
        soil["Bekker n exponent"],
        refined["sinkage_exponent"]["mean"]
    );
    assert_eq!(soil["Bekker Kphi"], refined["k_eq"]["mean"]);
    assert_eq!(soil["Bekker Kc"], 0.0);

    terra(&at, "import scm-json soil.json --out soils.csv").ok();
    let csv = Csv::read(&at.join("soils.csv"));
    let degrees = refined["friction_angle"]["mean"]
        .as_f64()
        .unwrap()
        .to_degrees();
    assert!((csv.numbers("phi_deg")[0].unwrap() - degrees).abs() < 1e-9);
    let bad = terra(
        &at,
        "export scm-json identify.json --group left --out soil2.json",
    );
    assert_eq!(bad.code, 2);
    assert!(bad.err.contains("all"), "{}", bad.err);
}

#[test]
fn manual_pages() {
    let at = folder("man");
    let all = terra(&at, "man").ok().out;
    assert!(
        all.starts_with(".ie") || all.starts_with(".TH"),
        "{}",
        &all[..60]
    );
    for command in ["identify", "gap", "completions"] {
        assert!(all.contains(command), "{command}");
    }
    let one = terra(&at, "man gap").ok().out;
    assert!(one.contains("calibrate") && !one.contains("slip\\-compliance"));
    assert_eq!(terra(&at, "man gpa").code, 2);
}
