//! Sealed cases: nothing tells what is withheld, the commitment binds, the marking is what counting by hand gives.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::support::{contents, example, folder, json as read, list, number, terra, text};

fn made(folder: &Path, more: &str) -> String {
    terra(
        folder,
        &format!("challenge make --design rig --seed 7 --out blind --key key.json {more}"),
    )
    .ok()
    .out
}

fn sealed(folder: &Path) -> Vec<Value> {
    list(&read(&folder.join("key.json"))["cases"]).to_vec()
}

/// The same bytes on any number of threads, and nothing in names, columns, rows, sizes, order or times that tells one
/// kind of case from another.
#[test]
fn nothing_in_the_files_tells_the_answer() {
    let mut seen = vec![];
    for threads in [1, 2, 8] {
        let folder = folder(&format!("challenge_{threads}"));
        made(&folder, &format!("--cases 60 --threads {threads}"));
        seen.push((contents(&folder.join("blind")), contents(&folder)));
    }
    assert!(
        seen[0] == seen[1] && seen[0] == seen[2],
        "bytes depend on the threads"
    );

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command/challenge_2");
    let (files, _) = &seen[1];
    let cases = sealed(&folder);
    let names: BTreeSet<String> = (1..=60)
        .map(|k| format!("case_{k:03}.csv"))
        .chain(["COMMIT.txt", "rover.toml"].map(str::to_owned))
        .collect();
    assert_eq!(files.keys().cloned().collect::<BTreeSet<_>>(), names);

    let mut shapes = BTreeSet::new();
    let mut sizes: BTreeMap<bool, Vec<f64>> = BTreeMap::new();
    let mut words = BTreeSet::new();
    for case in &cases {
        let name = format!("{}.csv", text(&case["case"]));
        let log = String::from_utf8(files[&name].clone()).unwrap();
        let header = log.lines().next().unwrap().to_owned();
        // Text cells too: trial, condition and pass in their order.
        let groups: Vec<String> = log
            .lines()
            .map(|l| l.split(',').take(3).collect::<Vec<_>>().join(","))
            .collect();
        let empty = log.lines().map(|l| l.matches(",,").count()).sum::<usize>();
        shapes.insert((header, groups, empty));
        let with = text(&case["key"]["kind"]) != "none";
        sizes.entry(with).or_default().push(log.len() as f64);
        for effect in list(&case["key"]["effects"]) {
            words.insert(text(&effect["name"]).to_owned());
        }
        words.insert(text(&case["nonce"]).to_owned());
        words.insert(number(&case["key"]["seed"]).to_string());
    }
    assert_eq!(shapes.len(), 1, "columns, rows or groups differ");
    assert!(words.len() > 100, "{}", words.len());
    for (name, bytes) in files {
        let log = String::from_utf8(bytes.clone()).unwrap();
        for word in &words {
            assert!(!log.contains(word.as_str()), "{name} holds {word}");
        }
    }
    // Sizes differ by the digits of noise alone: the means of both groups within five standard errors.
    let stat = |x: &[f64]| {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        let variance = x.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let ((a, va), (b, vb)) = (stat(&sizes[&false]), stat(&sizes[&true]));
    assert!((a - b).abs() < 5.0 * (va + vb).sqrt(), "{a} {b}");
    let times: BTreeSet<_> = names
        .iter()
        .map(|n| {
            fs::metadata(folder.join("blind").join(n))
                .unwrap()
                .modified()
                .unwrap()
        })
        .collect();
    assert_eq!(times.len(), 1, "times differ");
    // The kinds lie in no order: both halves hold cases with and without effects, as one in 10^4 shuffles would not.
    let kinds: Vec<bool> = cases
        .iter()
        .map(|c| text(&c["key"]["kind"]) == "none")
        .collect();
    let (first, second) = kinds.split_at(30);
    for half in [first, second] {
        assert!(
            half.iter().any(|n| *n) && half.iter().any(|n| !*n),
            "{kinds:?}"
        );
    }
}

/// A drive's files as well: one shape of columns, rows and holes whatever the kind, no word of a key.
#[test]
fn nothing_in_a_drive_tells_the_answer() {
    let folder = folder("challenge_drive");
    let line = "challenge make --design ramp --seed 5 --out blind --key key.json --cases 40";
    terra(&folder, line).ok();
    let mut shapes = BTreeSet::new();
    let mut kinds = BTreeSet::new();
    let mut words = BTreeSet::new();
    let cases = sealed(&folder);
    for case in &cases {
        let name = format!("blind/{}.csv", text(&case["case"]));
        let log = fs::read_to_string(folder.join(name)).unwrap();
        let empty = |l: &str| l.split(',').filter(|cell| cell.is_empty()).count();
        let header = log.lines().next().unwrap().to_owned();
        let groups: BTreeSet<String> = log
            .lines()
            .map(|l| l.split(',').nth(1).unwrap().to_owned())
            .collect();
        let holes: usize = log.lines().map(empty).sum();
        shapes.insert((header, log.lines().count(), groups.len(), holes));
        kinds.insert(text(&case["key"]["kind"]).to_owned());
        for effect in list(&case["key"]["effects"]) {
            words.insert(text(&effect["name"]).to_owned());
        }
    }
    assert_eq!((kinds.len(), shapes.len()), (5, 1), "{kinds:?}");
    for bytes in contents(&folder.join("blind")).into_values() {
        let file = String::from_utf8(bytes).unwrap();
        assert!(words.iter().all(|word| !file.contains(word.as_str())));
    }
}

#[test]
fn a_key_inside_the_challenge_is_refused() {
    let folder = folder("challenge_inside");
    for key in ["blind/key.json", "./x/../blind/key.json"] {
        fs::create_dir_all(folder.join("x")).unwrap();
        let done = terra(
            &folder,
            &format!("challenge make --design rig --cases 2 --seed 1 --out blind --key {key}"),
        );
        assert_eq!(done.code, 2, "{}", done.err);
        assert!(done.err.contains("inside"), "{}", done.err);
        assert!(!folder.join("blind").exists());
    }
}

/// What cannot be drawn, and a folder that holds something else.
#[test]
fn what_cannot_be_made_is_said() {
    let folder = folder("challenge_bad");
    fs::create_dir_all(folder.join("mine")).unwrap();
    fs::write(folder.join("mine/thesis.txt"), "years of work").unwrap();
    for (line, code, word) in [
        ("--design ramps --cases 2 --out a", 2, "ramps"),
        ("--design rig --cases 2 --out a --kinds nones=1", 2, "nones"),
        ("--design rig --cases 0 --out a", 2, "0"),
        ("--design rig --cases 2 --out mine", 4, "thesis.txt"),
        ("--design absent.toml --cases 2 --out a", 2, "absent.toml"),
    ] {
        let done = terra(
            &folder,
            &format!("challenge make --seed 1 --key key.json {line}"),
        );
        assert_eq!(done.code, code, "{line}: {}", done.err);
        assert!(done.err.contains(word), "{line}: {}", done.err);
        assert!(
            !folder.join("key.json").exists() && !folder.join("a").exists(),
            "{line}"
        );
        assert!(!folder.join("a.partial").exists(), "{line}");
    }
    assert_eq!(contents(&folder.join("mine")).len(), 1);
}

/// A changed answer is found and its case named; an untouched key opens.
#[test]
fn the_commitment_binds() {
    let folder = folder("challenge_reveal");
    made(&folder, "--cases 12");
    let said = terra(&folder, "challenge reveal --key key.json blind")
        .ok()
        .out;
    assert!(said.contains("12 commitments hold"), "{said}");
    let key = read(&folder.join("key.json"));
    let spoil = |change: &dyn Fn(&mut Value)| {
        let mut other = key.clone();
        change(&mut other["cases"][4]);
        fs::write(folder.join("other.json"), other.to_string()).unwrap();
        let done = terra(&folder, "challenge reveal --key other.json blind");
        assert_eq!(done.code, 3, "{}", done.err);
        assert!(done.err.contains("case_005"), "{}", done.err);
    };
    spoil(&|c| c["key"]["seed"] = json!(1));
    spoil(&|c| {
        let other = if c["key"]["kind"] == "none" {
            "off-library"
        } else {
            "none"
        };
        c["key"]["kind"] = json!(other);
    });
    spoil(&|c| c["nonce"] = json!("00"));
    spoil(&|c| c["case"] = json!("case_005b"));
    fs::write(folder.join("torn.json"), &key.to_string()[..300]).unwrap();
    let done = terra(&folder, "challenge reveal --key torn.json blind");
    assert_eq!(done.code, 3, "{}", done.err);
    assert!(done.err.contains("torn.json:1:300"), "{}", done.err);
}

/// A soil of the user's own keeps all its digits in the key: what was committed to is what is read again.
#[test]
fn a_design_of_the_users_own_is_revealed() {
    let folder = folder("challenge_digits");
    fs::copy(example("rig/rig.toml"), folder.join("rig.toml")).unwrap();
    let scenario = fs::read_to_string(example("rig/slip_sinkage.toml")).unwrap();
    let (without, _) = scenario.split_once("[[effect]]").unwrap();
    let soil = "{ k_eq = 1528430.0, sinkage_exponent = 1.1, cohesion = 1040.0, friction_angle = 0.48183792520110524, \
                shear_modulus = 0.025, c1 = 0.18, c2 = 0.32 }";
    let own = without.replace("\"dry_sand\"", soil);
    assert!(own.contains("0.48183792520110524"));
    fs::write(folder.join("own.toml"), own).unwrap();
    terra(
        &folder,
        "challenge make --design own.toml --seed 3 --cases 2 --out blind --key key.json",
    )
    .ok();
    let said = terra(&folder, "challenge reveal --key key.json blind").ok();
    assert!(said.out.contains("2 commitments hold"), "{}", said.out);
}

/// A verdict with these causes; the rest of the probability is none's and unknown's.
fn verdict(says: &str, causes: &[(&str, f64)], none: f64, unknown: f64, set: &[&str]) -> Value {
    let causes: Vec<Value> = causes
        .iter()
        .map(|(effect, p)| {
            json!({"effect": effect, "probability": p, "log_evidence_gain": 10.0 * p, "absorbed": 0.5,
                "parameters": {}, "indistinguishable_from": []})
        })
        .collect();
    json!({"schema": "terra-gap/1", "verdict": says, "causes": causes, "probability_none": none,
        "probability_unknown": unknown, "set": set, "accepted": [], "after": null,
        "gap": {"chi2_per_dof": {"nominal_refitted": 1.0}}})
}

/// Eight cases counted by hand.
#[test]
fn marks_are_what_counting_by_hand_gives() {
    let folder = folder("challenge_score");
    let sealed = |kind: &str, names: &[&str]| {
        let effects: Vec<Value> = names
            .iter()
            .map(|n| json!({"name": n, "magnitude": 1.0, "form": "default"}))
            .collect();
        json!({"kind": kind, "effects": effects, "terrain": "dry_sand", "seed": 1})
    };
    let cases = [
        sealed("single", &["slope"]),
        sealed("single", &["slope"]),
        sealed("single", &["aero-drag"]),
        sealed("single", &["tow-load"]),
        sealed("none", &[]),
        sealed("none", &[]),
        sealed("off-library", &["stones"]),
        sealed("pair", &["tow-load", "slope"]),
    ];
    let answers = [
        // Right, in the set.
        Some(verdict("named", &[("slope", 0.95)], 0.0, 0.05, &["slope"])),
        // Second, in the set.
        Some(verdict(
            "ambiguous",
            &[("aero-drag", 0.5), ("slope", 0.45)],
            0.0,
            0.05,
            &["aero-drag", "slope"],
        )),
        // Wrong, not in the set.
        Some(verdict("named", &[("slope", 0.95)], 0.0, 0.05, &["slope"])),
        // No verdict: wrong.
        None,
        // No alarm, but not `none` either.
        Some(verdict(
            "ambiguous",
            &[("slope", 0.05)],
            0.95,
            0.0,
            &["none", "slope"],
        )),
        // An alarm.
        Some(verdict("named", &[("slope", 0.95)], 0.05, 0.0, &["slope"])),
        Some(verdict(
            "unknown",
            &[("slope", 0.05)],
            0.0,
            0.95,
            &["unknown"],
        )),
        Some(verdict(
            "named",
            &[("slope+tow-load", 0.95)],
            0.0,
            0.05,
            &["slope+tow-load"],
        )),
    ];
    let key: Vec<Value> = cases
        .iter()
        .enumerate()
        .map(|(k, key)| json!({"case": format!("case_{:03}", k + 1), "nonce": "00", "key": key}))
        .collect();
    let key = json!({"schema": "terra-challenge-key/1", "cases": key});
    fs::write(folder.join("key.json"), key.to_string()).unwrap();
    fs::create_dir_all(folder.join("said")).unwrap();
    for (k, answer) in answers.iter().enumerate() {
        if let Some(answer) = answer {
            fs::write(
                folder.join(format!("said/case_{:03}.json", k + 1)),
                answer.to_string(),
            )
            .unwrap();
        }
    }
    let said = terra(
        &folder,
        "challenge score --verdicts said --key key.json --json score.json",
    )
    .ok()
    .out;
    assert!(said.contains("1 of 8 cases have no verdict"), "{said}");
    let score = read(&folder.join("score.json"));
    let value = |name: &str| number(&score["metrics"][name]["value"]);
    for (name, right, n) in [
        ("top1", 1.0, 4.0),
        ("top3", 2.0, 4.0),
        ("false_alarm", 1.0, 2.0),
        // Six with an effect: all but the missing one claim something.
        ("power", 5.0, 6.0),
        ("false_notice", 2.0, 2.0),
        ("noticed", 5.0, 6.0),
        ("set_coverage", 5.0, 8.0),
        ("pair_both_in_three", 1.0, 1.0),
    ] {
        assert!(
            (value(name) - right / n).abs() < 1e-12,
            "{name}: {}",
            value(name)
        );
        assert_eq!(number(&score["metrics"][name]["n"]), n, "{name}");
        let (lo, hi) = (
            number(&score["metrics"][name]["lo"]),
            number(&score["metrics"][name]["hi"]),
        );
        assert!(lo <= value(name) && value(name) <= hi, "{name}");
    }
    // Bins: four at .95 and 1, of which four right claims of .95 among seven with p >= .9 and one missing (sure, wrong);
    // .95 six times: 4 right; 1.0 once, wrong; together 4 right of confidence 6.7; .5 once, wrong.
    assert!(
        (value("ece") - ((6.7 - 4.0) + 0.5) / 8.0).abs() < 1e-9,
        "{}",
        value("ece")
    );
    // Seven verdicts: one answer each, two in two of them.
    assert!((value("set_size") - 9.0 / 7.0).abs() < 1e-12);
    // The off-library case stands above all others, the missing one (counted as sure of unknown) excepted.
    assert!(
        (value("unknown_auroc") - 6.0 / 7.0).abs() < 1e-12,
        "{}",
        value("unknown_auroc")
    );
    for name in ["closed_error", "closed_coverage"] {
        assert!(score["metrics"][name]["value"].is_null());
        assert!(text(&score["metrics"][name]["reason"]).contains("design"));
    }
    let naive = |name: &str, metric: &str| number(&score["baselines"][name][metric]["value"]);
    assert_eq!(naive("always-none", "top1"), 0.0);
    assert_eq!(naive("always-none", "false_alarm"), 0.0);
    assert_eq!(naive("most-frequent-effect", "top1"), 0.5);
    assert_eq!(naive("always-unknown", "unknown_auroc"), 0.5);
    assert_eq!(list(&score["misses"]).len(), 4);

    fs::write(
        folder.join("said/case_002.json"),
        "{\"schema\": \"terra-gap/1\",\n \"verdict\": 3}",
    )
    .unwrap();
    let done = terra(&folder, "challenge score --verdicts said --key key.json");
    assert_eq!(done.code, 3, "{}", done.err);
    assert!(done.err.contains("case_002.json:2:"), "{}", done.err);
    let done = terra(&folder, "challenge score --verdicts absent --key key.json");
    assert_eq!(done.code, 3, "{}", done.err);
}

/// A true closing is found for a cause that is really there, and the verdict's interval is near it.
#[test]
fn the_true_closing_is_found() {
    let folder = folder("challenge_closing");
    fs::copy(
        crate::support::example("rig/rig.toml"),
        folder.join("rig.toml"),
    )
    .unwrap();
    let scenario = fs::read_to_string(crate::support::example("rig/slip_sinkage.toml")).unwrap();
    let (bare, _) = scenario.split_once("[[effect]]").unwrap();
    fs::write(folder.join("trials.toml"), bare).unwrap();
    // A key by hand: a large slip-sinkage on the start's own soil.
    let key = json!({"schema": "terra-challenge-key/1",
        "design": {"name": "own", "rover": fs::read_to_string(folder.join("rig.toml")).unwrap(), "scenario": bare},
        "cases": [{"case": "case_001", "nonce": "00", "key": {"kind": "single", "terrain": "dry_sand", "seed": 1,
            "effects": [{"name": "slip-sinkage", "magnitude": 0.3, "form": "default"}]}}]});
    fs::write(folder.join("key.json"), key.to_string()).unwrap();
    fs::write(folder.join("full.toml"), &scenario).unwrap();
    fs::create_dir_all(folder.join("said")).unwrap();
    terra(&folder, "simulate full.toml --out case_001.csv").ok();
    terra(&folder, "gap case_001.csv --rover rig.toml --effects slip-sinkage --combine 1 --json said/case_001.json").ok();
    terra(
        &folder,
        "challenge score --verdicts said --key key.json --json score.json",
    )
    .ok();
    let m = &read(&folder.join("score.json"))["metrics"];
    assert_eq!(number(&m["top1"]["value"]), 1.0);
    assert_eq!(number(&m["closed_error"]["n"]), 1.0);
    // Without noise the cause closes all but what the re-fit of the soil leaves; with it, the figure is within .2.
    assert!(number(&m["closed_error"]["value"]) < 0.2, "{m}");
}

/// A folder is diagnosed as its cases one by one are, on any number of threads; what is there is kept, what is of
/// another log is refused.
#[test]
fn a_whole_folder_is_diagnosed_as_its_cases_are() {
    let folder = folder("challenge_run");
    made(&folder, "--cases 2 --kinds none=1");
    terra(&folder, "challenge run blind --out one --threads 1").ok();
    let one = contents(&folder.join("one"));
    assert_eq!(
        one.keys().collect::<Vec<_>>(),
        ["case_001.json", "case_002.json"]
    );
    terra(
        &folder,
        "gap blind/case_002.csv --rover blind/rover.toml --json alone.json",
    )
    .ok();
    assert!(fs::read(folder.join("alone.json")).unwrap() == one["case_002.json"]);

    // Half done: the one that is there is kept, even with a mark that no diagnosis makes; the other is made.
    let mut marked = read(&folder.join("one/case_001.json"));
    marked["mark"] = json!("kept");
    fs::create_dir_all(folder.join("two")).unwrap();
    fs::write(folder.join("two/case_001.json"), marked.to_string()).unwrap();
    let said = terra(&folder, "challenge run blind --out two --threads 8")
        .ok()
        .out;
    assert!(said.contains("2 verdicts in two, 1 of them kept"), "{said}");
    let two = contents(&folder.join("two"));
    assert_eq!(two["case_001.json"], marked.to_string().into_bytes());
    assert!(two["case_002.json"] == one["case_002.json"]);

    // The verdict of another case.
    fs::write(folder.join("two/case_001.json"), &one["case_002.json"]).unwrap();
    let done = terra(&folder, "challenge run blind --out two");
    assert_eq!(done.code, 3, "{}", done.err);
    assert!(done.err.contains("case_001"), "{}", done.err);
    assert!(contents(&folder.join("two"))["case_001.json"] == one["case_002.json"]);
    fs::create_dir_all(folder.join("empty")).unwrap();
    let done = terra(&folder, "challenge run empty --out three");
    assert_eq!(done.code, 3, "{}", done.err);
}
