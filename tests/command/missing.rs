//! What a log lacks is missing, never zero; what it cannot mean is left out and counted.

use crate::support::{Csv, folder, json, list, logs, terra, text};

/// The simulated log with other cells, line and column from 1.
fn with_cells(log: &str, cells: &[(usize, usize, &str)]) -> String {
    let original = std::fs::read_to_string(logs().join(log)).unwrap();
    let mut rows: Vec<Vec<&str>> = original.lines().map(|l| l.split(',').collect()).collect();
    for (line, column, to) in cells {
        rows[line - 1][column - 1] = to;
    }
    rows.iter().map(|r| r.join(",") + "\n").collect()
}

/// Empty, nan, NA and a number that is none are missing samples: flagged in their rows, counted in the sums, and the soil
/// is found all the same.
#[test]
fn missing_cells_are_flagged_and_counted() {
    let folder = folder("missing");
    let yaw_rate = 12;
    let cells = [
        (50, yaw_rate, ""),
        (60, yaw_rate, "nan"),
        (70, yaw_rate, "NA"),
        (80, yaw_rate, "1e999"),
    ];
    std::fs::write(folder.join("drive.csv"), with_cells("drive.csv", &cells)).unwrap();
    std::fs::copy(logs().join("rover.toml"), folder.join("rover.toml")).unwrap();
    let table = Csv::parse(
        &terra(&folder, "estimate drive.csv --rover rover.toml")
            .ok()
            .out,
    );
    let (flag, dof) = (table.text("flag"), table.full("nis_dof"));
    for row in 20..200 {
        let missing = cells.iter().any(|(line, ..)| *line == row + 2);
        assert_eq!(
            flag[row].starts_with("degraded:"),
            missing,
            "row {row}: {}",
            flag[row]
        );
        assert_eq!(dof[row], if missing { 6.0 } else { 7.0 }, "row {row}");
    }
    terra(
        &folder,
        "identify drive.csv --rover rover.toml --json out.json",
    )
    .ok();
    let id = json(&folder.join("out.json"));
    assert_eq!(id["samples"]["missing"], 4);
    assert_eq!(id["samples"]["rows"], 200);
    assert!(
        list(&id["groups"])
            .iter()
            .all(|g| text(&g["map"]) == "lean_clay_22")
    );
}

/// A slip beyond [-1, 1] and a load below zero are no contacts: their rows are left out and counted, the others used.
#[test]
fn impossible_rows_are_left_out_and_counted() {
    let folder = folder("impossible");
    let (slip, load) = (4, 5);
    let log = with_cells("rig.csv", &[(4, slip, "5.2"), (8, load, "-150")]);
    std::fs::write(folder.join("rig.csv"), log).unwrap();
    std::fs::copy(logs().join("rig.toml"), folder.join("rig.toml")).unwrap();
    terra(
        &folder,
        "identify rig.csv --rover rig.toml --no-refine --json out.json",
    )
    .ok();
    let id = json(&folder.join("out.json"));
    let samples = |key: &str| id["samples"][key].as_u64().unwrap();
    assert_eq!(
        (samples("rows"), samples("used"), samples("rejected")),
        (36, 34, 2),
        "{}",
        id["samples"]
    );
}
