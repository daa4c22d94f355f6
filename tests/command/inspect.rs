//! `terra inspect`: a clean log raises nothing, and each mistake of a logger is named.

use std::fs;

use serde_json::Value;

use crate::support::{Csv, folder, json, list, logs, number, terra, text};

fn codes(found: &Value) -> Vec<&str> {
    list(&found["suspicions"])
        .iter()
        .map(|s| text(&s["code"]))
        .collect()
}

/// Time, both sides' speeds, yaw rate and the rest of a drive that turns left and right on hard ground: v is the rim
/// speed, r = R (right - left)/track with R = .2 m and track .5 m.
fn weave() -> Csv {
    let header = "time_s,wheel_speed_fl_rad_s,wheel_speed_fr_rad_s,wheel_speed_rl_rad_s,wheel_speed_rr_rad_s,\
                  wheel_torque_fl_N_m,wheel_torque_fr_N_m,wheel_torque_rl_N_m,wheel_torque_rr_N_m,\
                  ground_speed_m_s,yaw_rate_rad_s,pitch_rad";
    let mut out = format!("{header}\n");
    for k in 0..200 {
        let t = f64::from(k) * 0.02;
        let mean = 5.0 + (0.7 * t).sin();
        let turn = (3.0 * t).sin();
        let (left, right) = (mean - turn, mean + turn);
        let torque = 2.0 + (1.3 * t).cos();
        out.push_str(&format!(
            "{t},{left},{right},{left},{right},{torque},{torque},{torque},{torque},{},{},{}\n",
            0.2 * mean,
            0.2 * 2.0 * turn / 0.5,
            0.1 * t.sin()
        ));
    }
    Csv::parse(&out)
}

const ROVER: &str = "[vehicle]\nmass_kg = 40.0\nyaw_inertia_kg_m2 = 2.0\ntrack_m = 0.5\nwheelbase_m = 0.5\n\
    cg_to_front_axle_m = 0.25\ncg_height_m = 0.2\nyaw_damping_N_m_s = 0.0\n[wheel]\nradius_m = 0.2\nwidth_m = 0.1\n\
    inertia_kg_m2 = 0.1\ndamping_N_m_s = 0.0\n[terrain]\nmodel = \"wong-reece\"\n";

/// The log with one column multiplied.
fn scaled(columns: &[&str], factor: f64) -> Csv {
    let mut csv = weave();
    for column in columns {
        let k = csv.header.iter().position(|h| h == column).unwrap();
        for row in &mut csv.rows {
            row[k] = (row[k].parse::<f64>().unwrap() * factor).to_string();
        }
    }
    csv
}

fn inspect(name: &str, csv: &Csv, rover: bool) -> Value {
    let to = folder(name);
    fs::write(to.join("rover.toml"), ROVER).unwrap();
    csv.write(&to.join("log.csv"));
    let with = if rover { "--rover rover.toml" } else { "" };
    terra(&to, &format!("inspect log.csv {with} --json found.json")).ok();
    json(&to.join("found.json"))
}

const WHEELS: [&str; 4] = [
    "wheel_speed_fl_rad_s",
    "wheel_speed_fr_rad_s",
    "wheel_speed_rl_rad_s",
    "wheel_speed_rr_rad_s",
];

#[test]
fn a_clean_log_raises_nothing() {
    let found = inspect("inspect_clean", &weave(), true);
    assert_eq!(codes(&found), Vec::<&str>::new());
    assert_eq!(number(&found["rows"]), 200.0);
    let group = &list(&found["groups"])[0];
    assert!((number(&group["step_s"]) - 0.02).abs() < 1e-9);
    assert!(list(&group["gaps"]).is_empty());
    // Without a rover nothing is known of the load; nothing else changes.
    let found = inspect("inspect_clean_alone", &weave(), false);
    assert_eq!(codes(&found), ["load-missing"]);
}

#[test]
fn each_mistake_of_a_logger_is_named() {
    let rpm = 30.0 / std::f64::consts::PI;
    let deg = 180.0 / std::f64::consts::PI;
    let yaw = ["yaw_rate_rad_s"];
    let cases: [(&str, &[&str], f64, &str); 6] = [
        ("rpm", &WHEELS, rpm, "rpm"),
        ("yaw_deg", &yaw, deg, "degrees"),
        ("swapped", &yaw, -1.0, "sides-swapped"),
        ("kmh", &["ground_speed_m_s"], 3.6, "km-h"),
        ("torque", &["wheel_torque_rl_N_m"], -1.0, "torque-sign"),
        ("pitch_deg", &["pitch_rad"], deg, "degrees"),
    ];
    for (name, columns, factor, code) in cases {
        let found = inspect(&format!("inspect_{name}"), &scaled(columns, factor), true);
        assert_eq!(codes(&found), [code], "{name}: {found}");
    }
    let found = inspect(
        "inspect_wheel",
        &scaled(&["wheel_torque_rl_N_m"], -1.0),
        true,
    );
    let message = text(&list(&found["suspicions"])[0]["message"]);
    assert!(message.contains("torque of rl works against"), "{message}");
}

/// A minute on rolling ground, forward, turning and back, with accelerometer and pitch: a = dv/dt + g sin(pitch), and the noise of
/// usual sensors.
fn tour() -> Csv {
    let header = "time_s,wheel_speed_fl_rad_s,wheel_speed_fr_rad_s,wheel_speed_rl_rad_s,wheel_speed_rr_rad_s,\
                  wheel_torque_fl_N_m,wheel_torque_fr_N_m,wheel_torque_rl_N_m,wheel_torque_rr_N_m,\
                  ground_speed_m_s,yaw_rate_rad_s,accel_x_m_s2,pitch_rad";
    let mut out = format!("{header}\n");
    // Chatter of amplitude one that repeats in no window.
    let noise = |k: f64, of: f64| ((k * 12.9898 + of * 78.233).sin() * 43758.5453).fract();
    for row in 0..3000 {
        let k = f64::from(row);
        let t = k * 0.02;
        // Forward for forty seconds, then back.
        let speed = if t < 40.0 {
            0.8 + 0.4 * (0.9 * t).sin()
        } else {
            -0.6 + 0.3 * (0.9 * t).cos()
        };
        let change = if t < 40.0 {
            0.36 * (0.9 * t).cos()
        } else {
            -0.27 * (0.9 * t).sin()
        };
        let pitch = 0.08 * (0.35 * t).sin();
        let turn = (0.5 * t).sin();
        let (left, right) = (speed / 0.2 - turn, speed / 0.2 + turn);
        let torque = (3.0 + (1.3 * t).cos()) * speed.signum();
        out.push_str(&format!(
            "{t},{left},{right},{left},{right},{torque},{torque},{torque},{torque},{},{},{},{pitch}\n",
            speed + 0.03 * noise(k, 1.0),
            0.2 * 2.0 * turn / 0.5 + 0.01 * noise(k, 2.0),
            change + 9.81 * pitch.sin() + 0.2 * noise(k, 3.0),
        ));
    }
    Csv::parse(&out)
}

#[test]
fn what_the_motion_says_of_signs_and_units_is_named() {
    let accel = "accel_x_m_s2";
    let speed = "ground_speed_m_s";
    let torques = |factor: f64| {
        let all = ["fl", "fr", "rl", "rr"].map(|w| format!("wheel_torque_{w}_N_m"));
        all.iter()
            .fold(tour(), |log, column| log.with(column, |t| t * factor))
    };
    // One row in fifty without a ground speed; and a spike of a receiver in as many.
    let every_fiftieth = |value: &str| {
        let mut log = tour();
        let k = log.at(speed);
        let rows = log.rows.iter_mut().skip(9).step_by(50);
        rows.for_each(|row| row[k] = value.to_owned());
        log
    };
    let unsigned = ["fl", "fr", "rl", "rr"].iter().fold(tour(), |log, w| {
        log.with(&format!("wheel_torque_{w}_N_m"), f64::abs)
    });
    let cases: [(&str, Csv, &[&str]); 17] = [
        ("zeros", every_fiftieth("0"), &["zeros"]),
        ("spikes", every_fiftieth("999"), &[]),
        ("unsigned_torque", unsigned, &["unsigned-torque"]),
        ("clean", tour(), &[]),
        ("accel_sign", tour().with(accel, |a| -a), &["accel-sign"]),
        (
            "accel_g",
            tour().with(accel, |a| a / 9.80665),
            &["accel-unit"],
        ),
        (
            "pitch_sign",
            tour().with("pitch_rad", |p| -p),
            &["pitch-sign"],
        ),
        ("no_pitch", tour().without("pitch_rad"), &["pitch-missing"]),
        (
            "front",
            tour().swapped(WHEELS[0], WHEELS[1]),
            &["axle-swapped"],
        ),
        (
            "rear",
            tour().swapped(WHEELS[2], WHEELS[3]),
            &["axle-swapped"],
        ),
        ("one_sign", tour().with(WHEELS[1], |w| -w), &["speed-sign"]),
        ("all_sign", tour().with(speed, |v| -v), &["speed-sign"]),
        (
            "unsigned",
            tour().with(speed, f64::abs),
            &["unsigned-speed"],
        ),
        ("mm_s", tour().with(speed, |v| v * 1000.0), &["speed-unit"]),
        ("ms", tour().with("time_s", |t| t * 1000.0), &["time-unit"]),
        ("n_cm", torques(100.0), &["torque-unit"]),
        ("at_motor", torques(1.0 / 50.0), &["torque-unit"]),
    ];
    for (name, log, wanted) in cases {
        let found = inspect(&format!("inspect_tour_{name}"), &log, true);
        assert_eq!(codes(&found), wanted, "{name}: {found}");
    }
    // Flat ground needs no pitch: what is left is noise.
    let flat = {
        let (a, p) = (tour().at(accel), tour().at("pitch_rad"));
        let mut log = tour();
        for row in &mut log.rows {
            let number = |k: usize| row[k].parse::<f64>().unwrap();
            row[a] = (number(a) - 9.81 * number(p).sin()).to_string();
        }
        log.without("pitch_rad")
    };
    assert_eq!(
        codes(&inspect("inspect_tour_flat", &flat, true)),
        Vec::<&str>::new()
    );
}

/// A fifth of the vehicle is a payload; five hundred vehicles are grams.
#[test]
fn a_payload_in_grams_is_named() {
    let loaded = |payload: &str| {
        let mut log = tour();
        log.header.push("payload_kg".to_owned());
        log.rows
            .iter_mut()
            .for_each(|row| row.push(payload.to_owned()));
        inspect("inspect_payload", &log, true)
    };
    assert_eq!(codes(&loaded("8")), Vec::<&str>::new());
    assert_eq!(codes(&loaded("8000")), ["payload-unit"]);
}

/// A rover file in millimetres is not a log in degrees.
#[test]
fn a_track_in_millimetres_is_named() {
    let to = folder("inspect_track");
    fs::write(
        to.join("rover.toml"),
        ROVER.replace("track_m = 0.5", "track_m = 500.0"),
    )
    .unwrap();
    tour().write(&to.join("log.csv"));
    terra(&to, "inspect log.csv --rover rover.toml --json found.json").ok();
    assert_eq!(codes(&json(&to.join("found.json"))), ["track-unit"]);
}

#[test]
fn stuck_channels_gaps_and_missing_cells_are_counted() {
    let mut csv = weave();
    let column = |csv: &Csv, name: &str| csv.header.iter().position(|h| h == name).unwrap();
    let (yaw, fr) = (column(&csv, "yaw_rate_rad_s"), column(&csv, WHEELS[1]));
    for row in &mut csv.rows[50..120] {
        row[fr] = "5.5".to_owned();
    }
    csv.rows[10][yaw] = String::new();
    csv.rows[11][yaw] = "1e999".to_owned();
    csv.rows[12][yaw] = "NA".to_owned();
    csv.rows.drain(150..175);
    let found = inspect("inspect_stuck", &csv, true);
    assert_eq!(codes(&found), ["gap", "stuck"], "{found}");
    let stuck = text(&list(&found["suspicions"])[1]["message"]);
    assert!(
        stuck.starts_with("wheel_speed_fr_rad_s is exactly 5.5 for 70 rows from 1 s"),
        "{stuck}"
    );
    let gap = &list(&list(&found["groups"])[0]["gaps"])[0];
    assert!((number(&gap["length_s"]) - 26.0 * 0.02).abs() < 1e-9);
    let channel = list(&found["channels"])
        .iter()
        .find(|c| c["name"] == "yaw_rate_rad_s")
        .unwrap();
    assert_eq!(number(&channel["missing"]), 2.0);
    assert_eq!(number(&channel["not_finite"]), 1.0);
}

/// A ground speed of a fifth of the rate, held in between: told with how long; the same with the cells in between empty is as it
/// should be, and so are wheels whose encoders count coarsely.
#[test]
fn a_held_sensor_is_told_from_one_with_empty_cells() {
    let mut held = weave();
    let column = |csv: &Csv, name: &str| csv.header.iter().position(|h| h == name).unwrap();
    let speed = column(&held, "ground_speed_m_s");
    let mut blank = held.clone();
    for row in 0..held.rows.len() {
        held.rows[row][speed] = held.rows[row - row % 5][speed].clone();
        if row % 5 != 0 {
            blank.rows[row][speed] = String::new();
        }
    }
    let found = inspect("inspect_held", &held, true);
    assert_eq!(codes(&found), ["held"], "{found}");
    let message = text(&list(&found["suspicions"])[0]["message"]);
    assert!(
        message.starts_with("ground_speed_m_s changes every 5 rows only"),
        "{message}"
    );
    let found = inspect("inspect_blank", &blank, true);
    assert!(codes(&found).is_empty(), "{found}");
    let mut coarse = weave();
    for name in WHEELS {
        let wheel = column(&coarse, name);
        for row in &mut coarse.rows {
            let value: f64 = row[wheel].parse().unwrap();
            row[wheel] = ((value * 20.0).round() / 20.0).to_string();
        }
    }
    let found = inspect("inspect_coarse", &coarse, true);
    assert!(codes(&found).is_empty(), "{found}");
}

/// Samples stamped on arrival: every second one late by 40 % of the step.
#[test]
fn an_uneven_clock_is_named() {
    let mut csv = weave();
    for (k, row) in csv.rows.iter_mut().enumerate().filter(|(k, _)| k % 2 == 1) {
        row[0] = (k as f64 * 0.02 + 0.008).to_string();
    }
    let found = inspect("inspect_uneven", &csv, true);
    assert_eq!(codes(&found), ["uneven-clock"]);
}

/// Simulated logs of the shipped examples, at slips from 1 to .05, hold no mistake.
#[test]
fn simulated_logs_raise_nothing() {
    for (log, rover) in [("drive.csv", "rover.toml"), ("rig.csv", "rig.toml")] {
        let done = terra(logs(), &format!("inspect {log} --rover {rover}")).ok();
        assert!(done.out.contains("Nothing looks wrong."), "{}", done.out);
    }
    // The rig log needs no rig file.
    terra(logs(), "inspect rig.csv").ok();
}

#[test]
fn a_rig_log_with_flipped_torque_and_millimetres() {
    let to = folder("inspect_rig");
    let mut log = "slip,normal_load_N,drawbar_pull_N,torque_N_m,sinkage_m\n".to_owned();
    for k in 1..9 {
        log.push_str(&format!("0.{k},80,{},-{k}.5,{}\n", 2 * k, 10 + k));
    }
    fs::write(to.join("rig.csv"), log).unwrap();
    terra(&to, "inspect rig.csv --json found.json").ok();
    let found = json(&to.join("found.json"));
    assert_eq!(text(&found["kind"]), "rig");
    let mut codes = codes(&found);
    codes.sort_unstable();
    assert_eq!(codes, ["millimetres", "torque-sign"]);
}

#[test]
fn broken_input_ends_with_its_place_and_status() {
    let to = folder("inspect_broken");
    let mut csv = weave();
    csv.rows[4][9] = "fast".to_owned();
    csv.write(&to.join("bad.csv"));
    let done = terra(&to, "inspect bad.csv");
    assert_eq!(done.code, 3);
    assert!(
        done.err
            .contains("bad.csv:6:10: column 'ground_speed_m_s': found 'fast', expected a number"),
        "{}",
        done.err
    );
    fs::write(to.join("other.csv"), "t,v\n1,2\n").unwrap();
    let done = terra(&to, "inspect other.csv");
    assert_eq!(done.code, 3);
    assert!(
        done.err.contains("other.csv:1") && done.err.contains("--rover FILE with [columns]"),
        "{}",
        done.err
    );
    let wheel = "wheel_speed_rad_s,travel_speed_m_s,normal_load_N,torque_N_m\n1,0.1,80,2\n";
    fs::write(to.join("wheel.csv"), wheel).unwrap();
    let done = terra(&to, "inspect wheel.csv");
    assert_eq!(done.code, 2);
    assert!(done.err.contains("wheel's radius"), "{}", done.err);
    weave().write(&to.join("good.csv"));
    assert_eq!(terra(&to, "inspect good.csv --rover none.toml").code, 2);
    assert_eq!(terra(&to, "inspect none.csv").code, 3);
    assert_eq!(
        terra(&to, "inspect good.csv --json no_such/found.json").code,
        4
    );
}
