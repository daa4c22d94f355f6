//! Same input, same bytes: whatever the threads, the locale, or how often.

use std::fs;

use crate::support::{contents, example, finish, folder, logs, terra, terra_in};

/// Every command that writes, on 1, 2 and 8 threads.
#[test]
fn threads_change_nothing() {
    let mut seen = vec![];
    for threads in [1, 2, 8] {
        let folder = folder(&format!("threads_{threads}"));
        for (name, bytes) in contents(logs()) {
            fs::write(folder.join(name), bytes).unwrap();
        }
        let mut said = String::new();
        for line in [
            "simulate ramp.toml --out again.csv --truth again_truth.csv",
            "estimate drive.csv --rover rover.toml --smooth --out estimate.csv",
            "identify drive.csv --rover rover.toml --history --json identify.json --html identify.html",
            "gap rig.csv --rover rig.toml --effects slip-sinkage,rear-contact --combine 1 --json gap.json --html gap.html",
            "wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0:1:0.05 --csv wheel.csv --stress",
        ] {
            said.push_str(
                &terra(&folder, &format!("{line} --threads {threads}"))
                    .ok()
                    .out,
            );
        }
        seen.push((contents(&folder), said));
    }
    let (files, said) = &seen[0];
    assert!(
        files["again.csv"] == files["drive.csv"],
        "one seed, two logs"
    );
    assert!(files.len() == 8 + 9, "{:?}", files.keys());
    for (others, other_said) in &seen[1..] {
        for (name, bytes) in files {
            assert!(bytes == &others[name], "{name} depends on the threads");
        }
        assert_eq!(said, other_said);
    }
}

/// The seed decides the noise and nothing else.
#[test]
fn the_seed_decides() {
    let folder = folder("seeds");
    for (name, seed) in [("a", 7), ("b", 7), ("c", 8)] {
        let scenario = example("paper/lean_clay.toml");
        let line = format!(
            "simulate {} --out {name}.csv --truth {name}_truth.csv --seed {seed}",
            scenario.display()
        );
        terra(&folder, &line).ok();
    }
    let files = contents(&folder);
    assert!(files["a.csv"] == files["b.csv"], "one seed, two logs");
    assert!(files["a.csv"] != files["c.csv"], "two seeds, one log");
    assert!(
        files["a_truth.csv"] == files["c_truth.csv"],
        "the truth has noise"
    );
}

/// A locale with decimal commas changes neither what is read nor what is written.
#[test]
fn a_comma_locale_changes_nothing() {
    for line in [
        "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.1:0.3:0.1",
        "estimate drive.csv --rover rover.toml",
        "identify rig.csv --rover rig.toml",
    ] {
        let plain = terra(logs(), line).ok().out;
        let comma = finish(
            terra_in(logs())
                .args(line.split_whitespace())
                .env("LC_ALL", "de_DE.UTF-8")
                .env("LANG", "de_DE.UTF-8"),
        );
        assert_eq!(plain, comma.ok().out, "{line}");
    }
}

/// Byte order mark, Windows line ends, quoted cells and extra columns are the same log.
#[test]
fn dressed_up_logs_are_the_same_log() {
    let folder = folder("dressed");
    let plain = fs::read_to_string(logs().join("drive.csv")).unwrap();
    fs::copy(logs().join("rover.toml"), folder.join("rover.toml")).unwrap();
    let quoted = |line: &str| {
        line.split(',')
            .map(|c| format!("\"{c}\""))
            .collect::<Vec<_>>()
            .join(",")
            + "\n"
    };
    let variants = [
        ("mark.csv", format!("\u{feff}{plain}")),
        ("windows.csv", plain.replace('\n', "\r\n")),
        ("quoted.csv", plain.lines().map(quoted).collect()),
        (
            "extra.csv",
            plain.lines().map(|l| format!("{l},note\n")).collect(),
        ),
        ("cut_end.csv", plain.trim_end().to_owned()),
    ];
    let expected = terra(logs(), "estimate drive.csv --rover rover.toml")
        .ok()
        .out;
    for (name, content) in variants {
        fs::write(folder.join(name), content).unwrap();
        let done = terra(&folder, &format!("estimate {name} --rover rover.toml")).ok();
        assert!(done.out == expected, "{name}");
    }
}
