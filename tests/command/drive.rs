//! The paper's drive on lean clay: scenario, log, forces, soil, diagnosis.

use std::collections::BTreeSet;

use crate::support::{Csv, folder, json, list, logs, number, run, terra, text};

const WHEELS: [&str; 4] = ["fl", "fr", "rl", "rr"];

/// The log has the columns of a drive log and what the scenario asked for.
#[test]
fn simulate_gives_a_drive_log_and_its_truth() {
    let log = Csv::read(&logs().join("drive.csv"));
    assert_eq!(log.rows.len(), 200, "2 s at 100 Hz");
    let time = log.full("time_s");
    assert!(time.windows(2).all(|t| t[1] > t[0]));
    assert!(log.text("segment").iter().all(|s| *s == "ramp"));
    for w in WHEELS {
        assert_eq!(log.full(&format!("wheel_speed_{w}_rad_s")).len(), 200);
        // The ramp of the scenario, from 21.0042 to 1.1885 N m, with a noise of .1 N m.
        let torque = log.full(&format!("wheel_torque_{w}_N_m"));
        let off = |k: usize| torque[k] - (21.0042 + (1.1885 - 21.0042) * time[k] / 2.0);
        assert!((0..200).all(|k| off(k).abs() < 0.6), "{w}");
    }
    let truth = Csv::read(&logs().join("drive_truth.csv"));
    assert_eq!(truth.full("time_s"), time);
    for w in WHEELS {
        for column in [
            format!("drawbar_pull_{w}_N"),
            format!("resistive_torque_{w}_N_m"),
            format!("sinkage_{w}_m"),
            format!("slip_{w}"),
            format!("normal_load_{w}_N"),
        ] {
            assert_eq!(truth.full(&column).len(), 200, "{column}");
        }
    }
}

/// Rows 41 to 160 of a log are the log that holds only these.
#[test]
fn identify_weighs_the_rows_asked_for() {
    let out = folder("identify_rows");
    let whole = std::fs::read_to_string(logs().join("drive.csv")).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let part = [&lines[..1], &lines[41..161]].concat().join("\n") + "\n";
    std::fs::write(out.join("part.csv"), part).unwrap();
    std::fs::copy(logs().join("rover.toml"), out.join("rover.toml")).unwrap();
    std::fs::copy(logs().join("drive.csv"), out.join("drive.csv")).unwrap();
    let said = |log: &str, rows: &str| {
        let line = format!("identify {log} --rover rover.toml --json out.json{rows}");
        terra(&out, &line).ok();
        json(&out.join("out.json"))
    };
    let (cut, part) = (said("drive.csv", " --rows 41-160"), said("part.csv", ""));
    assert_eq!(cut["samples"], part["samples"]);
    assert_eq!(cut["groups"], part["groups"]);
    assert!(number(&cut["samples"]["used"]) < 120.0);
}

/// The page draws values of the table, those of the figures' files among them, extremes included.
#[test]
fn the_page_of_an_estimate_draws_the_table() {
    let out = folder("estimate_page");
    let file = |name: &str| out.join(name).to_str().unwrap().to_owned();
    let (table, page, figures) = (file("table.csv"), file("page.html"), file("figures"));
    let line = ["estimate", "drive.csv", "--rover", "rover.toml", "--out"];
    let more = [&*table, "--html", &page, "--figures", &figures];
    run(logs(), line.into_iter().chain(more)).ok();
    let table = Csv::read(&out.join("table.csv"));
    let drawn = Csv::read(&out.join("figures/slip-front-left-over-time.csv"));
    let all: BTreeSet<(&str, &str, &str)> = table
        .text("time_s")
        .into_iter()
        .zip(table.text("slip_fl"))
        .zip(table.text("slip_fl_sd"))
        .map(|((t, s), sd)| (t, s, sd))
        .collect();
    let rows = drawn.text("time_s").into_iter();
    for ((t, s), sd) in rows
        .zip(drawn.text("slip_fl"))
        .zip(drawn.text("slip_fl_sd"))
    {
        assert!(all.contains(&(t, s, sd)), "{t} {s} {sd}");
    }
    let most = |csv: &Csv| {
        let values = csv.numbers("slip_fl").into_iter().flatten();
        values.fold(f64::NEG_INFINITY, f64::max)
    };
    assert_eq!(most(&drawn), most(&table));
    let page = std::fs::read_to_string(page).unwrap();
    // Two sides, four wheels three times, speed and yaw rate.
    assert_eq!(page.matches("class=\"numbers\"").count(), 16);
}

/// The table of the contract, its pairs, and honest spreads: what the filter says of the forces holds the simulated truth.
#[test]
fn estimate_has_the_contracts_columns_and_holds_the_truth() {
    let out = folder("estimate");
    for filter in ["block", "ekf"] {
        let file = out.join(format!("{filter}.csv"));
        let done = run(
            logs(),
            [
                "estimate",
                "drive.csv",
                "--rover",
                "rover.toml",
                "--filter",
                filter,
                "--out",
                file.to_str().unwrap(),
            ],
        );
        assert_eq!(done.ok().out, "", "the table goes to the file");
        let table = Csv::read(&file);
        assert_eq!(
            table.header[..5],
            ["time_s", "segment", "flag", "nis", "nis_dof"]
        );
        let mut expected: BTreeSet<String> = table.header[..5].iter().cloned().collect();
        let mut pair = |stem: String, unit: &str| {
            expected.extend([format!("{stem}{unit}"), format!("{stem}_sd{unit}")])
        };
        pair("ground_speed".into(), "_m_s");
        pair("yaw_rate".into(), "_rad_s");
        for w in WHEELS {
            pair(format!("wheel_speed_{w}"), "_rad_s");
            pair(format!("resistive_torque_{w}"), "_N_m");
            pair(format!("slip_{w}"), "");
            pair(format!("normal_load_{w}"), "_N");
        }
        pair("side_force_left".into(), "_N");
        pair("side_force_right".into(), "_N");
        expected.extend(WHEELS.map(|w| format!("drawbar_pull_{w}_share_N")));
        assert_eq!(
            table.header.iter().cloned().collect::<BTreeSet<_>>(),
            expected
        );
        assert_eq!(table.header.len(), expected.len(), "a column twice");

        let log = Csv::read(&logs().join("drive.csv"));
        assert_eq!(
            table.full("time_s"),
            log.full("time_s"),
            "one row a log row, same order"
        );
        let flags = table.text("flag");
        assert!(
            flags[..20].iter().all(|f| *f == "starting") && flags[20..].iter().all(|f| *f == "ok"),
            "{flags:?}"
        );

        let truth = Csv::read(&logs().join("drive_truth.csv"));
        for (side, wheels) in [("left", ["fl", "rl"]), ("right", ["fr", "rr"])] {
            let [front, rear] = wheels.map(|w| truth.full(&format!("drawbar_pull_{w}_N")));
            let force = table.full(&format!("side_force_{side}_N"));
            let sd = table.full(&format!("side_force_{side}_sd_N"));
            let far = (20..200)
                .filter(|&k| (force[k] - front[k] - rear[k]).abs() > 3.0 * sd[k])
                .count();
            assert!(far <= 9, "{filter}, {side}: {far} of 180 beyond 3 sd");
            let rms = ((20..200)
                .map(|k| (force[k] - front[k] - rear[k]).powi(2))
                .sum::<f64>()
                / 180.0)
                .sqrt();
            assert!(rms < 20.0, "{filter}, {side}: {rms} N rms of up to 150 N");
        }
    }
}

/// Smoothing uses the whole log, so it cannot know less.
#[test]
fn smoothed_spreads_are_no_wider() {
    let plain = Csv::parse(
        &terra(logs(), "estimate drive.csv --rover rover.toml")
            .ok()
            .out,
    );
    let smooth = Csv::parse(
        &terra(logs(), "estimate drive.csv --rover rover.toml --smooth")
            .ok()
            .out,
    );
    assert_eq!(plain.header, smooth.header);
    for column in [
        "side_force_left_sd_N",
        "resistive_torque_rl_sd_N_m",
        "ground_speed_sd_m_s",
    ] {
        let (plain, smooth) = (plain.full(column), smooth.full(column));
        let wider = (20..200)
            .filter(|&k| smooth[k] > plain[k] * (1.0 + 1e-9))
            .count();
        assert_eq!(wider, 0, "{column}");
    }
    assert_eq!(plain.text("nis"), smooth.text("nis"), "nis is the filter's");
}

/// The soil of the scenario wins under both sides, and the file has every field of the contract.
#[test]
fn identify_finds_the_soil() {
    let file = folder("identify_drive").join("identify.json");
    let path = file.to_str().unwrap();
    let done = run(
        logs(),
        [
            "identify",
            "drive.csv",
            "--rover",
            "rover.toml",
            "--history",
            "--json",
            path,
        ],
    )
    .ok();
    assert!(done.out.contains("lean_clay_22"), "{}", done.out);
    let id = json(&file);
    assert_eq!(text(&id["schema"]), "terra-identify/1");
    assert_eq!(
        (
            text(&id["log_kind"]),
            text(&id["filter"]),
            text(&id["estimator"])
        ),
        ("drive", "block", "side-sum")
    );
    assert_eq!(text(&id["choice"]["kind"]), "none");
    assert!(id["choice"]["value"].is_null());
    let samples = |key: &str| id["samples"][key].as_u64().unwrap();
    assert_eq!(samples("rows"), 200);
    assert_eq!(
        samples("rows"),
        samples("used") + samples("waiting") + samples("rejected"),
        "rows in = rows accounted for"
    );
    assert_eq!(samples("missing"), 0);
    let groups: Vec<_> = list(&id["groups"])
        .iter()
        .map(|g| text(&g["group"]))
        .collect();
    assert_eq!(groups, ["left", "right"]);
    for g in list(&id["groups"]) {
        assert_eq!(text(&g["map"]), "lean_clay_22");
        let posterior: Vec<f64> = list(&g["posterior"])
            .iter()
            .map(|p| number(&p["probability"]))
            .collect();
        assert_eq!(posterior.len(), 21, "every hypothesis of wong21");
        assert!(posterior.windows(2).all(|p| p[0] >= p[1]), "sorted");
        assert!((posterior.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!(posterior[0] > 0.95);
        for p in list(&g["posterior"]) {
            assert_eq!(text(&p["model"]), "wong-reece");
            assert!(number(&p["log_likelihood"]).is_finite() && p["infeasible_samples"].is_u64());
        }
        assert!(g["known_to"].is_array());
        let friction = &g["parameter_mean"]["parameters"]["friction_angle"];
        assert!(
            (number(&friction["mean"]) - 20f64.to_radians()).abs() < 0.05,
            "{friction}"
        );
        assert_eq!(text(&friction["unit"]), "rad");
        let refined = &g["refined"];
        assert_eq!(text(&refined["start"]), "lean_clay_22");
        assert_eq!(refined["converged"], true);
        assert!(number(&refined["chi2_per_dof"]) > 0.0);
        assert!(number(&refined["parameters"]["k_eq"]["sd"]) > 0.0);
        assert!(
            list(&refined["undetermined"])
                .iter()
                .any(|u| text(u).contains("k_c, k_phi"))
        );
        assert!(!list(&refined["directions"]).is_empty());
        for prediction in [&g["force_prediction"], &refined["force_prediction"]] {
            let slips: BTreeSet<String> = list(prediction)
                .iter()
                .map(|p| p["slip"].to_string())
                .collect();
            assert_eq!(slips.len(), 10, "slips .05 .1 .2 .. .9");
            assert_eq!(
                list(prediction).len() % 10,
                0,
                "each slip at the same loads"
            );
            for p in list(prediction) {
                assert_eq!(text(&p["status"]), "ok");
                assert!(
                    number(&p["normal_load_N"]) > 0.0 && number(&p["torque_N_m"]["mean"]) > 0.0
                );
                assert!(
                    number(&p["drawbar_pull_N"]["sd"]) >= 0.0
                        && number(&p["sinkage_m"]["mean"]) > 0.0
                );
            }
        }
        let consistency = &g["consistency"];
        assert!(
            number(&consistency["nis_per_dof"]) > 0.0 && number(&consistency["lag1"]).abs() < 1.0
        );
        assert_eq!(consistency["alarm"], false, "{consistency}");
        let history = &g["history"];
        assert_eq!(list(&history["step"])[0], 1);
        assert_eq!(list(&history["step"]).len(), samples("used") as usize);
        assert_eq!(list(&history["time_s"]).len(), samples("used") as usize);
        for row in list(&history["probability"]) {
            assert_eq!(list(row).len(), list(&history["ids"]).len());
            assert!((list(row).iter().map(number).sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }
    provenance(&id["provenance"]);
}

fn provenance(p: &serde_json::Value) {
    assert_eq!(text(&p["terra"]), env!("CARGO_PKG_VERSION"));
    for key in ["log_sha256", "rover_sha256"] {
        let digest = text(&p[key]);
        assert!(
            digest.len() == 64 && digest.bytes().all(|b| b.is_ascii_hexdigit()),
            "{key}: {digest}"
        );
    }
}

/// One group when both sides are joined; no refinement and no history unless asked for.
#[test]
fn identify_joined_and_plain() {
    let file = folder("identify_joined").join("identify.json");
    let path = file.to_str().unwrap();
    run(
        logs(),
        [
            "identify",
            "drive.csv",
            "--rover",
            "rover.toml",
            "--join",
            "--no-refine",
            "--json",
            path,
        ],
    )
    .ok();
    let id = json(&file);
    assert_eq!(list(&id["groups"]).len(), 1);
    let g = &id["groups"][0];
    assert_eq!(
        (text(&g["group"]), text(&g["map"])),
        ("all", "lean_clay_22")
    );
    assert!(
        g["refined"].is_null() && !text(&g["reasons"]["refined"]).is_empty(),
        "a missing number has its reason"
    );
    assert!(g.get("history").is_none());
}

/// Nothing is missing from a log that the nominal model made.
#[test]
fn gap_finds_nothing_where_nothing_is_missing() {
    let file = folder("gap_drive").join("verdict.json");
    let path = file.to_str().unwrap();
    let asked = [
        "gap",
        "drive.csv",
        "--rover",
        "rover.toml",
        "--effects",
        "slip-sinkage,torque-scale",
        "--json",
        path,
    ];
    run(logs(), asked).ok();
    let verdict = json(&file);
    assert_eq!(text(&verdict["verdict"]), "none", "{verdict:#}");
    // A single short ramp tells so little that a calibrated set holds runners-up too.
    assert_eq!(list(&verdict["set"])[0], "none");
    assert!(list(&verdict["accepted"]).is_empty() && verdict["after"].is_null());
}

/// A drive log without its torques.
fn without_torques(log: &str) -> String {
    let line = |line: &str| {
        let cells: Vec<_> = line.split(',').collect();
        [&cells[..6], &cells[10..]].concat().join(",") + "\n"
    };
    log.lines().map(line).collect()
}

/// A rover file that names the soil to start from.
fn started(rover: &str) -> String {
    let start = "[terrain]\nstart = \"lean_clay_22\"\n";
    rover.replace("[terrain]\n", start)
}

/// A page of a drive without torques shows the noise of the channels that it has, and no others.
#[test]
fn a_page_without_torques_has_no_row_of_theirs() {
    let folder = folder("gap_felt");
    let log = std::fs::read_to_string(logs().join("drive.csv")).unwrap();
    std::fs::write(folder.join("felt.csv"), without_torques(&log)).unwrap();
    let rover = std::fs::read_to_string(logs().join("rover.toml")).unwrap();
    std::fs::write(folder.join("rover.toml"), started(&rover)).unwrap();
    terra(&folder, "gap felt.csv --rover rover.toml --html page.html").ok();
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    let table = page.split("Sensor noise, 1 sd").nth(1).unwrap();
    let table = table.split("</table>").next().unwrap();
    assert!(!table.contains("Wheel torque"), "{table}");
    let row = table.split("Accel x").nth(1).unwrap();
    let cells: Vec<&str> = row
        .split(['<', '>'])
        .filter(|cell| cell.starts_with(|c: char| c.is_ascii_digit()))
        .collect();
    let noise: f64 = cells[1].split_whitespace().next().unwrap().parse().unwrap();
    assert!(noise > 0.0, "{cells:?}");
}

/// What a log cannot tell is a verdict with its reason, not a failure: too short, or by its motion alone where it never turns, start
/// given or not.
#[test]
fn gap_says_what_a_poor_log_cannot_tell() {
    let folder = folder("gap_poor");
    let log = std::fs::read_to_string(logs().join("drive.csv")).unwrap();
    let short: Vec<_> = log.lines().take(13).collect();
    std::fs::write(folder.join("short.csv"), short.join("\n") + "\n").unwrap();
    std::fs::write(folder.join("no_torque.csv"), without_torques(&log)).unwrap();
    let rover = std::fs::read_to_string(logs().join("rover.toml")).unwrap();
    std::fs::write(folder.join("rover.toml"), &rover).unwrap();
    std::fs::write(folder.join("start.toml"), started(&rover)).unwrap();
    // Where torques are logged motion is not all that there is.
    std::fs::write(folder.join("drive.csv"), &log).unwrap();
    let refused = terra(&folder, "gap drive.csv --rover rover.toml --motion-only");
    assert_eq!(refused.code, 2, "{}", refused.err);
    assert!(
        refused.err.contains("without wheel torques"),
        "{}",
        refused.err
    );
    for (log, options, why) in [
        ("short.csv", "", "usable values"),
        ("no_torque.csv", "--motion-only", "no turning"),
    ] {
        for rover in ["rover.toml", "start.toml"] {
            let line = format!("gap {log} --rover {rover} {options} --json verdict.json");
            terra(&folder, &format!("{line} --html report.html")).ok();
            let verdict = json(&folder.join("verdict.json"));
            assert_eq!(
                text(&verdict["verdict"]),
                "unidentifiable",
                "{log} with {rover}"
            );
            assert!(
                text(&verdict["reason"]).contains(why),
                "{}",
                verdict["reason"]
            );
            assert!(
                std::fs::read_to_string(folder.join("report.html"))
                    .unwrap()
                    .contains("</html>")
            );
        }
    }
}
