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

/// The table of an estimate is the same whether it is written as the log is read, or from a log held for a report: in
/// segments that come back, with pauses, missing cells and a channel lost for long.
#[test]
fn an_estimate_on_the_way_is_the_one_of_the_whole() {
    let folder = folder("on_the_way");
    fs::copy(logs().join("rover.toml"), folder.join("rover.toml")).unwrap();
    let plain = fs::read_to_string(logs().join("drive.csv")).unwrap();
    let header: Vec<&str> = plain.lines().next().unwrap().split(',').collect();
    let at = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let (time, segment) = (at("time_s"), at("segment"));
    let (speed, torque) = (at("ground_speed_m_s"), at("wheel_torque_rl_N_m"));
    // Longer than the blocks that are read, and than the rows that the filter sees ahead.
    let mut log = header.join(",") + "\n";
    for (k, line) in (0..15).flat_map(|_| plain.lines().skip(1)).enumerate() {
        let mut row: Vec<String> = line.split(',').map(str::to_owned).collect();
        row[time] = (0.01 * (k + 300 * (k / 800)) as f64).to_string();
        row[segment] = ["out", "\"back, again\"", "out"][k / 1000].to_owned();
        if k % 90 < 8 {
            row[torque].clear();
        }
        if (700..1200).contains(&k) || k % 41 == 0 || (2400..2900).contains(&k) {
            row[speed] = "nan".to_owned();
        }
        log.push_str(&(row.join(",") + "\n"));
    }
    fs::write(folder.join("log.csv"), log).unwrap();
    let line = "estimate log.csv --rover rover.toml";
    let printed = terra(&folder, line).ok().out;
    assert_eq!(printed.lines().count(), 3001);
    terra(&folder, &format!("{line} --out on_the_way.csv")).ok();
    terra(&folder, &format!("{line} --out whole.csv --html page.html")).ok();
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("on_the_way.csv") == printed);
    assert!(read("whole.csv") == printed);
}
