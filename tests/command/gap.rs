//! `terra gap` of several logs, against a simulator, and `terra gap --watch`.

use std::fs;
use std::path::Path;

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::support::{Csv, example, folder, list, logs, terra, text};

fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|b| format!("{b:02x}")).collect()
}

/// The rig's log cut in two between trials, both halves with the header.
fn halves(name: &str) -> std::path::PathBuf {
    let at = folder(name);
    let whole = fs::read_to_string(logs().join("rig.csv")).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let (header, rows) = lines.split_first().unwrap();
    let (a, b) = rows.split_at(rows.len() / 2);
    for (file, part) in [("a.csv", a), ("b.csv", b)] {
        fs::write(at.join(file), format!("{header}\n{}\n", part.join("\n"))).unwrap();
    }
    fs::copy(logs().join("rig.toml"), at.join("rig.toml")).unwrap();
    fs::copy(logs().join("drive.csv"), at.join("drive.csv")).unwrap();
    at
}

const ASKED: &str = "--rover rig.toml --effects slip-sinkage,drawbar-bias --combine 1";

/// One verdict from two files, whichever is named first; its fingerprint is that of both fingerprints.
#[test]
fn two_logs_are_one_diagnosis_in_any_order() {
    let at = halves("gap_several");
    let there = terra(&at, &format!("gap a.csv b.csv {ASKED} --json one.json")).ok();
    terra(&at, &format!("gap b.csv a.csv {ASKED} --json two.json")).ok();
    let bytes = |name: &str| fs::read(at.join(name)).unwrap();
    assert_eq!(bytes("one.json"), bytes("two.json"));
    let v = read(&at.join("one.json"));
    assert_eq!(v["schema"], "terra-gap/1");
    assert_eq!(v["logs"]["names"], serde_json::json!(["a.csv", "b.csv"]));
    assert_eq!(v["logs"]["soil"], "shared");
    assert!(
        there.out.contains("logs: a.csv, b.csv; one soil for all"),
        "{}",
        there.out
    );
    let mut each = [sha256(&bytes("a.csv")), sha256(&bytes("b.csv"))];
    each.sort();
    let both = sha256(format!("{}\n{}\n", each[0], each[1]).as_bytes());
    assert_eq!(v["provenance"]["log_sha256"], both.as_str());
    let own = terra(
        &at,
        &format!("gap a.csv b.csv {ASKED} --soil own --json own.json"),
    )
    .ok();
    assert!(
        own.out.contains("a soil of its own for each"),
        "{}",
        own.out
    );
    let v = read(&at.join("own.json"));
    let soil = v["terrain"]["parameters"].as_object().unwrap();
    assert!(soil.contains_key("a.csv/cohesion") && soil.contains_key("b.csv/cohesion"));
}

#[test]
fn logs_that_do_not_go_together_are_refused_by_name() {
    let at = halves("gap_mixture");
    let rover = example("paper/rover.toml");
    let rover = rover.display();
    for (line, words) in [
        (format!("gap a.csv a.csv {ASKED}"), "a.csv is given twice"),
        (format!("gap a.csv none.csv {ASKED}"), "none.csv"),
        (
            format!("gap drive.csv a.csv --rover {rover} --watch"),
            "one log",
        ),
        (
            format!("gap a.csv --rover {rover} --watch --sim drive.csv"),
            "--sim",
        ),
        (
            format!("gap drive.csv --rover {rover} --watch --figures pictures"),
            "--figures",
        ),
        (
            format!("gap drive.csv --rover {rover} --track t.csv"),
            "--watch",
        ),
    ] {
        let done = terra(&at, &line);
        assert!(done.code != 0, "{line}");
        assert!(done.err.contains(words), "{line}: {}", done.err);
    }
}

/// Other soil under another wheel law is fitted with dozens of coefficients of the law's form: the verdict has them all, the
/// report has the soil and one sentence.
#[test]
fn a_report_of_other_soil_is_of_the_soil() {
    let at = folder("gap_other_soil");
    terra(&at, "init single-wheel-rig --out rig.toml").ok();
    for (name, soil) in [("sim", "dry_sand"), ("real", "lean_clay_22")] {
        let scenario = format!(
            "seed = 5\nrover = \"rig.toml\"\nterrain = \"{soil}\"\nmodel = \"linear-stress\"\n[[trial]]\nslip = [0.05, 0.1, 0.2, 0.35, 0.55, 0.8]\n\
             normal_load_N = [100.0, 160.0, 250.0]\nrepeats = 2\ntravel_speed_m_s = 0.05\ncondition = \"smooth\"\n"
        );
        fs::write(at.join(format!("{name}.toml")), scenario).unwrap();
        terra(&at, &format!("simulate {name}.toml --out {name}.csv")).ok();
    }
    let line = "gap --sim sim.csv real.csv --rover rig.toml --json gap.json --html gap.html";
    terra(&at, line).ok();
    let v = read(&at.join("gap.json"));
    assert_eq!(v["causes"][0]["effect"], "soil-change", "{}", v["causes"]);
    let parameters = v["terrain"]["parameters"].as_object().unwrap();
    assert!(parameters.contains_key("pull_0.08") && parameters.contains_key("cohesion"));
    let html = fs::read_to_string(at.join("gap.html")).unwrap();
    assert!(html.contains("<div>cohesion") && !html.contains("<div>pull_0.08"));
    assert!(html.contains("of its 48 coefficients"));
}

/// What is wrong with a simulator's log is told of that file, and is an error of data.
#[test]
fn a_simulators_log_that_says_too_little_is_named() {
    let at = folder("gap_short_simulator");
    fs::copy(example("rig/rig.toml"), at.join("rig.toml")).unwrap();
    fs::copy(example("rig/slip_sinkage.toml"), at.join("real.toml")).unwrap();
    terra(&at, "simulate real.toml --out real.csv").ok();
    let text = fs::read_to_string(at.join("real.csv")).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with('#')).take(3);
    let short: Vec<&str> = rows.collect();
    fs::write(at.join("sim.csv"), short.join("\n") + "\n").unwrap();
    let done = terra(&at, "gap --sim sim.csv real.csv --rover rig.toml");
    assert_eq!(done.code, 3, "{}", done.err);
    let words = "sim.csv: as the simulator's log: ";
    assert!(done.err.contains(words), "{}", done.err);
    assert!(!done.err.contains("real.csv"), "{}", done.err);
}

/// The patrol of the book: sand gives way to clay after 48 m. The event is there and nowhere else, JSON and track say the same,
/// and no number of threads changes a byte.
#[test]
fn a_watch_flags_the_patrol_where_the_soil_changes() {
    let at = folder("gap_watch");
    for file in ["rover.toml", "patrol.toml"] {
        fs::copy(example(&format!("drive/{file}")), at.join(file)).unwrap();
    }
    terra(&at, "simulate patrol.toml --out patrol.csv").ok();
    let line = "gap patrol.csv --rover rover.toml --watch --baseline 30";
    let done = terra(
        &at,
        &format!("{line} --json watch.json --track track.csv --threads 1"),
    )
    .ok();
    assert!(done.out.contains("looks like (no verdict)"), "{}", done.out);
    let v = read(&at.join("watch.json"));
    assert_eq!(v["schema"], "terra-gap-watch/1");
    assert_eq!(v["verdict"], "gap");
    assert_eq!(v["false_alarms_per_log"], 0.05);
    let events = v["events"].as_array().unwrap();
    let place = events[0]["onset"]["path_m"].as_f64().unwrap();
    assert!((47.0..51.0).contains(&place), "{place}");
    assert!(events[0]["delay_s"].as_f64().unwrap() < 5.0);
    assert_eq!(events[0]["nearest"][0]["effect"], "soil-change");
    let track = fs::read_to_string(at.join("track.csv")).unwrap();
    let mut rows = track.lines();
    assert!(
        rows.next()
            .unwrap()
            .starts_with("time_s,path_m,segment,window,open,score_5")
    );
    // Before the change nothing is open; from the flag on it is.
    let flagged = events[0]["flagged"]["window"].as_u64().unwrap();
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        let (window, open) = (cells[3].parse::<u64>().unwrap(), cells[4] == "1");
        assert!(window >= flagged || !open, "{row}");
        assert!(window != flagged || open, "{row}");
    }
    terra(
        &at,
        &format!("{line} --json again.json --track again.csv --threads 3"),
    )
    .ok();
    for (a, b) in [("watch.json", "again.json"), ("track.csv", "again.csv")] {
        assert_eq!(fs::read(at.join(a)).unwrap(), fs::read(at.join(b)).unwrap());
    }
    let unasked = terra(
        &at,
        "gap patrol.csv --rover rover.toml --watch --false-alarms 2",
    );
    assert_eq!(unasked.code, 2, "{}", unasked.err);
    let short = terra(
        &at,
        "gap patrol.csv --rover rover.toml --watch --baseline 2",
    )
    .ok();
    assert!(short.out.contains("unidentifiable"), "{}", short.out);
    let misspelt = terra(
        &at,
        "gap patrol.csv --rover rover.toml --watch --baseline 30s",
    );
    assert_eq!(misspelt.code, 3, "{}", misspelt.err);
    for words in ["patrol.csv", "'30s'", "faster 1", "--baseline 30"] {
        assert!(misspelt.err.contains(words), "{}", misspelt.err);
    }
}

/// An outside simulator whose wheel law is not the nominal one: what both its log and the real one have is no gap, what only the
/// real one has is named.
#[test]
fn another_simulators_law_is_not_read_as_an_effect() {
    let at = folder("gap_sim");
    let own = fs::read_to_string(example("rig/rig.toml")).unwrap();
    fs::write(at.join("rig.toml"), &own).unwrap();
    fs::write(
        at.join("other.toml"),
        own.replace("wong-reece", "linear-stress"),
    )
    .unwrap();
    let scenario = fs::read_to_string(example("rig/slip_sinkage.toml")).unwrap();
    let (bare, _) = scenario.split_once("[[effect]]").unwrap();
    for (name, text, seed) in [
        ("sim", bare, 77),
        ("same", bare, 78),
        ("more", &scenario, 79),
    ] {
        let text = text.replace("seed = 1\n", &format!("seed = {seed}\n"));
        fs::write(at.join(format!("{name}.toml")), text).unwrap();
        terra(&at, &format!("simulate {name}.toml --out {name}.csv")).ok();
    }
    let said = |log: &str| {
        terra(
            &at,
            &format!("gap --sim sim.csv {log}.csv --rover other.toml --json {log}.json"),
        )
        .ok();
        read(&at.join(format!("{log}.json")))
    };
    let (same, more) = (said("same"), said("more"));
    assert_eq!(same["verdict"], "none");
    assert_eq!(same["calibration"]["design"], "contrast");
    assert!(same["baseline"]["chi2_per_dof"].as_f64().unwrap() < 1.3);
    assert_eq!(more["causes"][0]["effect"], "slip-sinkage");
    assert!(more["causes"][0]["probability"].as_f64().unwrap() > 0.8);
}

/// A wrong unit, a sign or a wrong rover file is told where the verdict is read, and of a clean log nothing is.
#[test]
fn what_looks_wrong_in_a_log_is_told_with_the_verdict() {
    let to = folder("gap_misread");
    let rover = fs::read_to_string(example("drive/rover.toml")).unwrap();
    fs::write(to.join("rover.toml"), &rover).unwrap();
    fs::copy(example("drive/rich.toml"), to.join("rich.toml")).unwrap();
    terra(&to, "simulate rich.toml --out clean.csv").ok();
    let log = || Csv::read(&to.join("clean.csv"));
    log()
        .with("accel_x_m_s2", |a| a / 9.80665)
        .write(&to.join("in_g.csv"));
    let track = "track_m = 0.6\n";
    assert!(rover.contains(track));
    fs::write(
        to.join("mm.toml"),
        rover.replace(track, "track_m = 600.0\n"),
    )
    .unwrap();
    let heed = |line: &str| -> Vec<String> {
        let said = terra(&to, line).ok().out;
        let heed = said.lines().filter_map(|l| l.strip_prefix("heed: "));
        heed.map(str::to_owned).collect()
    };
    let told = |heed: &[String], what: &str| heed.iter().any(|line| line.contains(what));
    let clean = heed("gap clean.csv --rover rover.toml");
    for what in ["accelerometer", "left out", "sign", "track"] {
        assert!(!told(&clean, what), "{what}: {clean:?}");
    }
    let in_g = heed("gap in_g.csv --rover rover.toml --json in_g.json --html in_g.html");
    assert!(told(&in_g, "accelerometer in g?"), "{in_g:?}");
    let notes = read(&to.join("in_g.json"));
    let noted = list(&notes["data"]["notes"])
        .iter()
        .any(|n| text(n).contains("accelerometer in g?"));
    assert!(noted, "{notes}");
    let page = fs::read_to_string(to.join("in_g.html")).unwrap();
    assert!(page.contains("Before believing it") && page.contains("accelerometer in g?"));
    let mm = heed("gap clean.csv --rover mm.toml");
    // It drives straight, which tells nothing of a track; but noise of the yaw rate then turns wheels against the motion.
    assert!(told(&mm, "are left out:"), "{mm:?}");
}

/// On one ramp forwards an offset of the torque and dry friction in the drivetrain are one and the same, and the summary says so, once.
#[test]
fn what_looks_alike_is_told() {
    let to = folder("gap_alike");
    fs::copy(example("drive/rover.toml"), to.join("rover.toml")).unwrap();
    fs::write(
        to.join("ramp.toml"),
        "seed = 3\nrover = \"rover.toml\"\nrate_hz = 100.0\nterrain = \"dry_sand\"\n[[segment]]\nname = \"ramp\"\n\
         duration_s = 6.0\nstart = { ground_speed_m_s = 0.3, wheel_speed_rad_s = 1.3 }\ntorque_N_m = { from = 6.0, to = 26.0 }\n\
         [[effect]]\nname = \"torque-bias\"\nmagnitude = 3.0\n",
    )
    .unwrap();
    terra(&to, "simulate ramp.toml --out ramp.csv").ok();
    let said = terra(&to, "gap ramp.csv --rover rover.toml").ok().out;
    let both = |line: &&str| {
        line.starts_with("alike: ")
            && line.contains("torque-bias")
            && line.contains("drivetrain-coulomb-friction")
    };
    assert_eq!(said.lines().filter(both).count(), 1, "{said}");
}
