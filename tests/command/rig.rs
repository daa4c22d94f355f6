//! The testbed with slip-sinkage in the ground: scenario, log, soil, diagnosis.

use crate::support::{Csv, folder, json, list, logs, number, run, text};

/// The grid slip x load x repeat, in that order, with the channels the rig's noise names.
#[test]
fn simulate_gives_a_rig_log() {
    let log = Csv::read(&logs().join("rig.csv"));
    assert_eq!(log.rows.len(), 6 * 2 * 3);
    assert!(log.text("condition").iter().all(|c| *c == "smooth"));
    let (slip, load) = (log.full("slip"), log.full("normal_load_N"));
    let grid = [0.05, 0.1, 0.2, 0.4, 0.6, 0.8]
        .iter()
        .flat_map(|s| [150.0, 245.25].map(|w| (*s, w)));
    for (k, (s, w)) in grid.flat_map(|point| [point; 3]).enumerate() {
        // Five sd of .005 and of .5 N.
        assert!(
            (slip[k] - s).abs() < 0.025 && (load[k] - w).abs() < 2.5,
            "row {k}: {} {}",
            slip[k],
            load[k]
        );
    }
    let truth = Csv::read(&logs().join("rig_truth.csv"));
    for (channel, sd) in [
        ("drawbar_pull_N", 0.5),
        ("torque_N_m", 0.1),
        ("sinkage_m", 0.001),
    ] {
        assert_eq!(log.full(channel).len(), 36);
        // Roughness of .3 N adds to the load cell's noise.
        let off = log
            .full(channel)
            .iter()
            .zip(truth.full(channel))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(off > 0.0 && off < 6.0 * sd, "{channel}: {off}");
    }
}

/// The soil is right and the alarm says that no soil explains the digging.
#[test]
fn identify_raises_the_alarm() {
    let file = folder("identify_rig").join("identify.json");
    let done = run(
        logs(),
        [
            "identify",
            "rig.csv",
            "--rover",
            "rig.toml",
            "--json",
            file.to_str().unwrap(),
        ],
    )
    .ok();
    assert!(done.out.contains("ALARM"), "{}", done.out);
    let id = json(&file);
    assert_eq!(
        (text(&id["log_kind"]), text(&id["estimator"])),
        ("rig", "wheel")
    );
    assert!(id["filter"].is_null() && id["prewhiten_rho"].is_null());
    let g = &id["groups"][0];
    assert_eq!((text(&g["group"]), text(&g["map"])), ("all", "dry_sand"));
    assert_eq!(g["consistency"]["alarm"], true);
}

/// The effect of the scenario is named, its size is right, the gap closes on trials that were held out.
#[test]
fn gap_names_the_effect() {
    let folder = folder("gap_rig");
    let (verdict, report) = (folder.join("verdict.json"), folder.join("report.html"));
    let (json_to, html_to) = (verdict.to_str().unwrap(), report.to_str().unwrap());
    let few = "slip-sinkage,multipass,rear-contact,bulldozing,torque-scale,load-error";
    let line = [
        "gap",
        "rig.csv",
        "--rover",
        "rig.toml",
        "--effects",
        few,
        "--combine",
        "1",
        "--json",
        json_to,
        "--html",
        html_to,
    ];
    let done = run(logs(), line).ok();
    assert!(
        done.out.starts_with("verdict: named {slip-sinkage}"),
        "{}",
        done.out
    );
    check(&json(&verdict));
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(page.contains("slip-sinkage") && page.contains("</html>"));
    for outside in ["<script src", "<link ", "@import", "url(http"] {
        assert!(
            !page.contains(outside),
            "the page needs nothing from outside: {outside}"
        );
    }
}

/// The same against every effect and every pair.
#[test]
fn gap_names_the_effect_among_all() {
    let file = folder("gap_rig_all").join("verdict.json");
    run(
        logs(),
        [
            "gap",
            "rig.csv",
            "--rover",
            "rig.toml",
            "--json",
            file.to_str().unwrap(),
        ],
    )
    .ok();
    check(&json(&file));
}

fn check(v: &serde_json::Value) {
    assert_eq!(text(&v["schema"]), "terra-gap/1");
    assert_eq!(text(&v["verdict"]), "named", "{v:#}");
    assert_eq!(list(&v["set"]), ["slip-sinkage"]);
    assert_eq!(list(&v["accepted"]), ["slip-sinkage"]);
    assert!(list(&v["nearest"]).is_empty());
    let chi2 = &v["gap"]["chi2_per_dof"];
    let (given, refitted) = (
        number(&chi2["nominal_as_given"]),
        number(&chi2["nominal_refitted"]),
    );
    assert!(
        given > refitted && refitted > 2.0 && number(&chi2["noise_floor"]) == 1.0,
        "{chi2}"
    );
    for channel in ["drawbar_pull_N", "torque_N_m", "sinkage_m"] {
        assert!(number(&v["gap"]["rms"][channel]) > 0.0, "{channel}");
    }
    let place = &v["gap"]["where"][0];
    assert_eq!(
        text(&place["channel"]),
        "sinkage_m",
        "the wheel digs itself in"
    );
    assert!(number(&place["sigma"]) > 3.0 && number(&place["from"]) < number(&place["to"]));
    let causes = list(&v["causes"]);
    let sum: f64 = causes.iter().map(|c| number(&c["probability"])).sum();
    let total = sum + number(&v["probability_none"]) + number(&v["probability_unknown"]);
    assert!((total - 1.0).abs() < 1e-9, "{total}");
    assert!(
        causes
            .windows(2)
            .all(|c| number(&c[0]["probability"]) >= number(&c[1]["probability"])),
        "sorted"
    );
    let best = &causes[0];
    assert_eq!(
        (text(&best["effect"]), text(&best["form"])),
        ("slip-sinkage", "default")
    );
    assert!(
        number(&best["log_evidence_gain"]) > 5.0
            && (0.0..=1.0).contains(&number(&best["absorbed"]))
    );
    let magnitude = &best["parameters"]["magnitude"];
    let (mean, sd) = (number(&magnitude["mean"]), number(&magnitude["sd"]));
    assert!(
        (mean - 0.3).abs() < 4.0 * sd && sd < 0.1,
        "simulated .3, found {mean} +- {sd}"
    );
    let after = &v["after"];
    assert_eq!(list(&after["effects"]), ["slip-sinkage"]);
    assert_eq!(text(&after["held_out"]["by"]), "trial");
    let closed = &after["held_out"]["closed"];
    assert!(
        number(&closed["lo"]) <= number(&closed["mean"])
            && number(&closed["mean"]) <= number(&closed["hi"])
    );
    assert!(number(&closed["lo"]) > 0.5, "{closed}");
    let held_out = &after["held_out"]["chi2_per_dof"];
    assert!(number(&held_out["after"]) < number(&held_out["before"]));
    assert!(number(&after["in_sample"]["closed"]) > 0.5);
    assert!(after["remainder"]["where"].is_array());
    assert_eq!(text(&v["terrain"]["model"]), "wong-reece");
    let friction = &v["terrain"]["parameters"]["friction_angle"];
    assert!(
        (number(&friction["mean"]) - 28f64.to_radians()).abs() < 0.05,
        "dry sand has 28 degrees: {friction}"
    );
    assert!(v["next"].is_array());
    assert_eq!(text(&v["provenance"]["log_sha256"]).len(), 64);
}
