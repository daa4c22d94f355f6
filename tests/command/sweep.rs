//! Campaigns: the same bytes whatever the threads, the shards and the interruptions; bad plans are named by place.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{Csv, example, folder, list, number, terra};

const PLAN: &str = r#"command = "simulate"
scenario = "trials.toml"
runs = 3
seed = 5
[vary]
terrain = ["dry_sand", "lean_clay_22"]
"effect.0.magnitude" = [0.1, 0.4]
"#;

fn place(name: &str) -> PathBuf {
    let to = folder(name);
    fs::copy(example("rig/rig.toml"), to.join("rig.toml")).unwrap();
    fs::copy(example("rig/slip_sinkage.toml"), to.join("trials.toml")).unwrap();
    fs::write(to.join("plan.toml"), PLAN).unwrap();
    to
}

fn bytes(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap()
}

#[test]
fn threads_shards_and_interruptions_change_nothing() {
    let at = place("sweep");
    terra(&at, "sweep plan.toml --out one.jsonl --threads 1").ok();
    let one = bytes(&at, "one.jsonl");
    let lines: Vec<Value> = one
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    assert_eq!(lines.len(), 12);
    for (k, line) in lines.iter().enumerate() {
        assert_eq!(number(&line["run"]), k as f64);
        // Keys in the order of the alphabet, the last one first to change; three noise draws of each point.
        let e = [0.1, 0.4][k / 6];
        let soil = ["dry_sand", "lean_clay_22"][k / 3 % 2];
        assert_eq!(number(&line["vary"]["effect.0.magnitude"]), e);
        assert_eq!(line["vary"]["terrain"], soil);
    }
    let seeds: std::collections::BTreeSet<u64> =
        lines.iter().map(|l| l["seed"].as_u64().unwrap()).collect();
    assert_eq!(seeds.len(), 12, "a seed twice");

    // A line is what `terra simulate` makes of the same scenario and seed.
    let scenario = bytes(&at, "trials.toml")
        .replace("seed = 1", &format!("seed = {}", lines[11]["seed"]))
        .replace("dry_sand", "lean_clay_22")
        .replace("magnitude = 0.3", "magnitude = 0.4");
    fs::write(at.join("last.toml"), scenario).unwrap();
    terra(&at, "simulate last.toml --out last.csv").ok();
    let rows = bytes(&at, "last.csv").lines().count() - 1;
    assert_eq!(number(&lines[11]["result"]["rows"]), rows as f64);
    let bytes_of_log = fs::read(at.join("last.csv")).unwrap();
    let torque = Csv::parse(&String::from_utf8(bytes_of_log).unwrap()).full("torque_N_m");
    let mean = torque.iter().sum::<f64>() / torque.len() as f64;
    let told = number(&lines[11]["result"]["columns"]["torque_N_m"]["mean"]);
    assert!((told - mean).abs() < 1e-9 * mean.abs(), "{told} {mean}");

    terra(&at, "sweep plan.toml --out eight.jsonl --threads 8").ok();
    assert!(bytes(&at, "eight.jsonl") == one, "threads");
    for i in 1..=3 {
        terra(
            &at,
            &format!("sweep plan.toml --shard {i}/3 --out s{i}.jsonl"),
        )
        .ok();
    }
    terra(&at, "merge s3.jsonl s1.jsonl s2.jsonl --out merged.jsonl").ok();
    assert!(bytes(&at, "merged.jsonl") == one, "shards");
    assert!(terra(&at, "merge s3.jsonl s1.jsonl s2.jsonl").ok().out == one);

    // Torn at any byte, under either name.
    for (cut, name) in [
        (0, "torn.jsonl"),
        (100, "torn.jsonl.partial"),
        (one.len() / 2, "torn.jsonl.partial"),
        (one.len() - 1, "torn.jsonl"),
    ] {
        let _ = fs::remove_file(at.join("torn.jsonl"));
        fs::write(at.join(name), &one[..cut]).unwrap();
        terra(&at, "sweep plan.toml --out torn.jsonl").ok();
        assert!(bytes(&at, "torn.jsonl") == one, "cut at {cut}");
        assert!(!at.join("torn.jsonl.partial").exists());
    }
    let said = terra(&at, "sweep plan.toml --out torn.jsonl").ok().out;
    assert!(said.contains("0 of them now"), "{said}");
}

/// Numbers of all their digits are the same when the lines are read again, so that a file is known as its plan's own.
#[test]
fn numbers_of_seventeen_digits_are_gone_on_with() {
    let at = place("sweep_digits");
    let plan = PLAN.replace("[0.1, 0.4]", "[0.48183792520110524, 0.9073038322028689]");
    fs::write(at.join("plan.toml"), plan).unwrap();
    terra(&at, "sweep plan.toml --out whole.jsonl").ok();
    let said = terra(&at, "sweep plan.toml --out whole.jsonl").ok().out;
    assert!(said.contains("0 of them now"), "{said}");
}

/// `gap` and `identify` put their own JSON into the lines.
#[test]
fn a_line_holds_the_answer_of_its_command() {
    let at = place("sweep_commands");
    let small =
        bytes(&at, "trials.toml").replace("[0.05, 0.1, 0.2, 0.4, 0.6, 0.8]", "[0.1, 0.3, 0.6]");
    fs::write(at.join("trials.toml"), small).unwrap();
    for (command, schema, key) in [
        ("identify", "terra-identify/1", "groups"),
        ("gap", "terra-gap/1", "causes"),
    ] {
        let plan =
            format!("command = \"{command}\"\nscenario = \"trials.toml\"\nruns = 1\nseed = 1\n");
        fs::write(at.join("plan.toml"), plan).unwrap();
        terra(&at, &format!("sweep plan.toml --out {command}.jsonl")).ok();
        let line: Value = serde_json::from_str(&bytes(&at, &format!("{command}.jsonl"))).unwrap();
        assert_eq!(line["result"]["schema"], schema);
        assert!(!list(&line["result"][key]).is_empty());
    }
}

#[test]
fn bad_plans_are_named_by_their_place() {
    let at = place("sweep_bad");
    for (from, to, place, word) in [
        (
            "runs = 3",
            "rums = 3",
            "plan.toml:3:1",
            "did you mean 'runs'",
        ),
        ("runs = 3", "runs = 0", "plan.toml:3:8", "from 1"),
        ("runs = 3\n", "", "plan.toml:1:1", "'runs'"),
        (
            "\"simulate\"",
            "\"dream\"",
            "plan.toml:1:11",
            "identify, gap, simulate",
        ),
        ("seed = 5", "seed = -1", "plan.toml:4:8", "whole number"),
        (
            "[\"dry_sand\", \"lean_clay_22\"]",
            "\"dry_sand\"",
            "plan.toml:6:11",
            "list",
        ),
        (
            "lean_clay_22",
            "lean_clay_23",
            "plan.toml:6:11",
            "lean_clay_23",
        ),
        ("effect.0", "effect.4", "plan.toml:7:", "1 entries"),
        (
            "[0.1, 0.4]",
            "[0.1, \"x\"]",
            "plan.toml:7:",
            "finite number",
        ),
        ("seed = 5", "seed = ", "plan.toml:4:", ""),
        ("trials.toml", "absent.toml", "absent.toml", ""),
    ] {
        assert!(PLAN.contains(from), "{from}");
        fs::write(at.join("plan.toml"), PLAN.replacen(from, to, 1)).unwrap();
        let done = terra(&at, "sweep plan.toml --out out.jsonl");
        assert_eq!(done.code, 2, "{to}: {}", done.err);
        assert!(
            done.err.contains(place) && done.err.contains(word),
            "{to}: {}",
            done.err
        );
        assert!(
            !at.join("out.jsonl").exists() && !at.join("out.jsonl.partial").exists(),
            "{to}"
        );
    }
}

#[test]
fn files_of_other_plans_are_refused() {
    let at = place("sweep_other");
    fs::write(at.join("plan.toml"), PLAN.replace("runs = 3", "runs = 1")).unwrap();
    terra(&at, "sweep plan.toml --out a.jsonl").ok();
    let before = bytes(&at, "a.jsonl");
    fs::write(at.join("plan.toml"), PLAN.replace("seed = 5", "seed = 6")).unwrap();
    let done = terra(&at, "sweep plan.toml --out a.jsonl");
    assert_eq!(done.code, 3, "{}", done.err);
    assert!(
        done.err.contains("a.jsonl:1:1") && done.err.contains("another plan"),
        "{}",
        done.err
    );
    assert!(bytes(&at, "a.jsonl") == before);
    fs::write(at.join("junk.jsonl"), "{\"run\": 0}\nnot json\n").unwrap();
    fs::write(at.join("torn.jsonl"), "{\"run\": 0}").unwrap();
    fs::write(at.join("hole.jsonl"), "{\"run\": 0}\n{\"run\": 2}\n").unwrap();
    for (files, word) in [
        ("a.jsonl a.jsonl", "a.jsonl:1:1: run 0 is also in"),
        ("junk.jsonl", "junk.jsonl:2:"),
        ("torn.jsonl", "torn.jsonl:1:11"),
        ("hole.jsonl", "run 1"),
        ("absent.jsonl", "absent.jsonl"),
    ] {
        let done = terra(&at, &format!("merge {files}"));
        assert_eq!(done.code, 3, "{files}: {}", done.err);
        assert!(done.err.contains(word), "{files}: {}", done.err);
        assert_eq!(done.out, "");
    }
    for shard in ["0/2", "3/2", "x"] {
        let done = terra(
            &at,
            &format!("sweep plan.toml --shard {shard} --out b.jsonl"),
        );
        assert_eq!(done.code, 2, "{shard}: {}", done.err);
    }
}
