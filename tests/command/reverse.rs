//! A vehicle that drives backwards is the same vehicle turned round.

use serde_json::Value;

use crate::support::{folder, json, list, logs, number, terra, text};

/// The log of the same drive with the body's axes turned by 180 degrees about the vertical: front left is rear right, what
/// went forward goes backward, and the yaw rate stays.
fn turned_round(log: &str) -> String {
    let header = log.lines().next().unwrap();
    let names: Vec<&str> = header.split(',').collect();
    let other = |name: &str| {
        let pairs = [
            ("_fl_", "_rr_"),
            ("_fr_", "_rl_"),
            ("_rl_", "_fr_"),
            ("_rr_", "_fl_"),
        ];
        let pair = pairs.iter().find(|(wheel, _)| name.contains(wheel));
        pair.map_or(name.to_owned(), |(from, to)| name.replace(from, to))
    };
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &&str| {
            let from = other(name);
            let value = cells[names.iter().position(|n| *n == from).unwrap()];
            match *name {
                "time_s" | "segment" | "yaw_rate_rad_s" => value.to_owned(),
                _ => (-value.parse::<f64>().unwrap()).to_string(),
            }
        };
        names.iter().map(cell).collect::<Vec<_>>().join(",") + "\n"
    };
    format!(
        "{header}\n{}",
        log.lines().skip(1).map(row).collect::<String>()
    )
}

fn group<'a>(id: &'a Value, name: &str) -> &'a Value {
    list(&id["groups"])
        .iter()
        .find(|g| text(&g["group"]) == name)
        .unwrap()
}

/// With its centre of mass in the middle the robot is its own mirror image, so that every likelihood must be the same.
#[test]
fn a_drive_in_reverse_finds_the_same_soil() {
    let folder = folder("reverse");
    let log = std::fs::read_to_string(logs().join("drive.csv")).unwrap();
    std::fs::write(folder.join("forward.csv"), &log).unwrap();
    std::fs::write(folder.join("reverse.csv"), turned_round(&log)).unwrap();
    std::fs::copy(logs().join("rover.toml"), folder.join("rover.toml")).unwrap();
    let [forward, reverse] = ["forward", "reverse"].map(|name| {
        terra(
            &folder,
            &format!("identify {name}.csv --rover rover.toml --no-refine --json {name}.json"),
        )
        .ok();
        json(&folder.join(format!("{name}.json")))
    });
    for (side, mirror) in [("left", "right"), ("right", "left")] {
        let (there, back) = (group(&forward, side), group(&reverse, mirror));
        assert_eq!(text(&back["map"]), "lean_clay_22");
        for (p, q) in list(&there["posterior"])
            .iter()
            .zip(list(&back["posterior"]))
        {
            assert_eq!(p["id"], q["id"], "the same order");
            let (p, q) = (number(&p["log_likelihood"]), number(&q["log_likelihood"]));
            assert!(
                (p - q).abs() <= 1e-6 * p.abs(),
                "{side}: {p} forward, {q} in reverse"
            );
        }
    }
}
