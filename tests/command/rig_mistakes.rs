//! Mistakes of a testbed's log or rover file: `inspect` names each, and `gap` says nothing of the ground where slip and speeds
//! contradict each other by one rule.

use std::fs;

use crate::support::{Csv, folder, json, list, terra, text};

const RADIUS: f64 = 0.15;

/// A sound log: pull and torque of a wheel on sand rise with slip to .3 and .5 of the load, v = R w (1 - slip), and what sensors
/// scatter.
fn sound() -> Csv {
    let mut out = "slip,normal_load_N,drawbar_pull_N,torque_N_m,sinkage_m,travel_speed_m_s,wheel_speed_rad_s\n".to_owned();
    let scatter = |k: f64, of: f64| ((k * 12.9898 + of * 78.233).sin() * 43758.5453).fract();
    for row in 0..24 {
        let k = f64::from(row);
        let load = if row % 2 == 0 { 80.0 } else { 160.0 };
        let slip = 0.05 + 0.03 * k;
        let sheared = 1.0 - (-slip / 0.15_f64).exp();
        out.push_str(&format!(
            "{},{},{},{},{},{},0.4\n",
            slip + 0.002 * scatter(k, 1.0),
            load + scatter(k, 2.0),
            load * (0.38 * sheared - 0.08) + 0.3 * scatter(k, 3.0),
            load * RADIUS * (0.05 + 0.45 * sheared) + 0.05 * scatter(k, 4.0),
            load * 1.5e-4 * (1.0 + slip) + 2e-4 * scatter(k, 5.0),
            RADIUS * 0.4 * (1.0 - slip)
        ));
    }
    Csv::parse(&out)
}

fn rover(radius: f64, width: f64) -> String {
    format!(
        "[wheel]\nradius_m = {radius}\nwidth_m = {width}\n[terrain]\nmodel = \"wong-reece\"\nstart = \"dry_sand\"\n[noise]\n\
         slip = 0.002\nnormal_load_N = 1.0\ndrawbar_pull_N = 0.3\ntorque_N_m = 0.05\nsinkage_m = 0.0002\n"
    )
}

/// A name, the log, the wheel's radius and width, and the questions.
type Mistake = (&'static str, Csv, f64, f64, &'static [&'static str]);

fn mistakes() -> Vec<Mistake> {
    let (r, b) = (RADIUS, 0.1);
    let rpm = 30.0 / std::f64::consts::PI;
    let times = |column: &str, by: f64| sound().with(column, |x| x * by);
    let mut copies = sound();
    for k in (0..24).step_by(2) {
        copies.rows[k + 1] = copies.rows[k].clone();
    }
    vec![
        ("sound", sound(), r, b, &[]),
        ("diameter", sound(), 2.0 * r, b, &["slip-scale"]),
        (
            "radius_mm",
            sound(),
            1000.0 * r,
            b,
            &["radius-unit", "slip-scale", "torque-unit"],
        ),
        ("width_mm", sound(), r, 100.0, &["width-unit"]),
        (
            "rpm",
            times("wheel_speed_rad_s", rpm),
            r,
            b,
            &["slip-scale"],
        ),
        (
            "mm_s",
            times("travel_speed_m_s", 1000.0),
            r,
            b,
            &["slip-scale"],
        ),
        ("slip_sign", times("slip", -1.0), r, b, &["slip-sign"]),
        (
            "over_travel",
            sound().with("slip", |s| (s / (1.0 - s)).min(0.99)),
            r,
            b,
            &["slip-convention"],
        ),
        (
            "pull_sign",
            times("drawbar_pull_N", -1.0),
            r,
            b,
            &["pull-sign"],
        ),
        (
            "torque_sign",
            times("torque_N_m", -1.0),
            r,
            b,
            &["torque-sign"],
        ),
        (
            "sinkage_sign",
            times("sinkage_m", -1.0),
            r,
            b,
            &["sinkage-sign"],
        ),
        (
            "load_kg",
            times("normal_load_N", 1.0 / 9.81),
            r,
            b,
            &["load-unit"],
        ),
        (
            "load_g",
            times("normal_load_N", 102.0),
            r,
            b,
            &["load-unit"],
        ),
        (
            "pull_kn",
            times("drawbar_pull_N", 0.001),
            r,
            b,
            &["pull-unit"],
        ),
        (
            "torque_n_mm",
            times("torque_N_m", 1000.0),
            r,
            b,
            &["torque-unit"],
        ),
        (
            "torque_kn_m",
            times("torque_N_m", 0.001),
            r,
            b,
            &["torque-unit"],
        ),
        ("copies", copies, r, b, &["copies"]),
    ]
}

#[test]
fn each_mistake_of_a_testbed_is_asked_after_and_no_other() {
    for (name, log, radius, width, expected) in mistakes() {
        let to = folder(&format!("rig_mistakes_{name}"));
        log.write(&to.join("rig.csv"));
        fs::write(to.join("rig.toml"), rover(radius, width)).unwrap();
        terra(&to, "inspect rig.csv --rover rig.toml --json found.json");
        let found = json(&to.join("found.json"));
        let mut codes: Vec<&str> = list(&found["suspicions"])
            .iter()
            .map(|s| text(&s["code"]))
            .collect();
        codes.sort_unstable();
        assert_eq!(codes, expected, "{name}: {found}");
    }
}

/// A rolling radius over lugs is a few per cent off the wheel's: no unit is asked after, and the log is used.
#[test]
fn a_rolling_radius_is_no_mistake() {
    let to = folder("rig_rolling_radius");
    sound()
        .with("wheel_speed_rad_s", |w| w * 1.12)
        .write(&to.join("rig.csv"));
    fs::write(to.join("rig.toml"), rover(RADIUS, 0.1)).unwrap();
    let done = terra(&to, "inspect rig.csv --rover rig.toml");
    assert!(done.out.contains("Nothing looks wrong."), "{}", done.out);
    terra(&to, "gap rig.csv --rover rig.toml --json gap.json");
    let verdict = json(&to.join("gap.json"));
    assert_ne!(text(&verdict["verdict"]), "unidentifiable", "{verdict}");
}

/// By a wheel of twice the size anything may be named; what the log's own speeds say is told instead.
#[test]
fn slip_that_its_speeds_contradict_names_no_cause() {
    for (name, log, radius, width, codes) in mistakes() {
        if !codes.iter().any(|c| c.starts_with("slip-")) || name == "radius_mm" {
            continue;
        }
        let to = folder(&format!("rig_contradicted_{name}"));
        log.write(&to.join("rig.csv"));
        fs::write(to.join("rig.toml"), rover(radius, width)).unwrap();
        terra(&to, "gap rig.csv --rover rig.toml --json gap.json");
        let verdict = json(&to.join("gap.json"));
        assert_eq!(text(&verdict["verdict"]), "unidentifiable", "{name}");
        let reason = text(&verdict["reason"]);
        assert!(reason.contains("speeds"), "{name}: {reason}");
    }
}

/// What misleads is told with the verdict.
#[test]
fn a_flipped_pull_is_told_with_the_verdict() {
    let to = folder("rig_flipped_pull");
    sound()
        .with("drawbar_pull_N", |d| -d)
        .write(&to.join("rig.csv"));
    fs::write(to.join("rig.toml"), rover(RADIUS, 0.1)).unwrap();
    terra(&to, "gap rig.csv --rover rig.toml --json gap.json");
    let verdict = json(&to.join("gap.json"));
    let notes = list(&verdict["data"]["notes"]).iter().map(text);
    let asks = notes.filter(|h| h.contains("sign flipped")).count();
    assert_eq!(asks, 1, "{verdict}");
}
