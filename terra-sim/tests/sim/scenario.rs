use std::path::{Path, PathBuf};

use terra_data::{Rover, Start};
use terra_model::Registry;
use terra_sim::{Command, Profile, Scenario, SimError, paper, simulate_drive};

const DRIVE: &str = r#"seed = 7
rover = "rover.toml"
rate_hz = 50.0
terrain = { left = "dry_sand", right = { k_eq = 1.5e6, sinkage_exponent = 1.1, cohesion = 1040.0, friction_angle = 0.49, shear_modulus = 0.025, c1 = 0.38, c2 = 0.41 } }
noise_scale = 0.5
[[segment]]
name = "ramp"
duration_s = 2
torque_N_m = { from = 35.4, to = 9.0 }
start = { ground_speed_m_s = 0.0, wheel_speed_rad_s = 0.2 }
pitch_rad = 0.05
[[segment]]
duration_s = 1.0
wheel_speed_rad_s = { fl = 1.0, fr = { from = 1.0, to = 2.0 }, rl = 1.0, rr = 2.0 }
payload_kg = 20.0
pass = 2
[[effect]]
name = "slip-sinkage"
magnitude = 0.3
form = "default"
"#;

fn fails(text: &str) -> (usize, usize, String) {
    match Scenario::parse(text, "s.toml") {
        Err(SimError::Scenario(e)) => {
            assert!(
                e.to_string()
                    .starts_with(&format!("s.toml:{}:{}: ", e.line, e.column))
            );
            (e.line, e.column, e.message)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn reads_every_form_of_a_drive() {
    let s = Scenario::parse(DRIVE, "s.toml").unwrap();
    assert_eq!(
        (s.seed, s.rate, s.noise_scale, s.model.as_str()),
        (7, 50.0, 0.5, "wong-reece")
    );
    assert_eq!(s.left, Start::Id("dry_sand".to_owned()));
    let Start::Values(right) = &s.right else {
        panic!()
    };
    assert_eq!(right["k_eq"], 1.5e6);
    assert_eq!(
        s.segments[0].command,
        Command::Torque(
            [Profile {
                from: 35.4,
                to: 9.0
            }; 4]
        )
    );
    assert_eq!(s.segments[0].start.unwrap().wheel_speed, [0.2; 4]);
    assert_eq!(s.segments[0].pitch, Some(0.05));
    let Command::WheelSpeed(speeds) = s.segments[1].command else {
        panic!()
    };
    assert_eq!(speeds[1], Profile { from: 1.0, to: 2.0 });
    assert_eq!(
        (s.segments[1].name.as_str(), s.segments[1].pass),
        ("segment_2", Some(2))
    );
    assert_eq!(s.effects[0].magnitude, [0.3]);
    assert_eq!(
        s.rover_path(Path::new("a/b/s.toml")),
        PathBuf::from("a/b/rover.toml")
    );
}

/// The table with k_eq simulates like the soil it stands for: k_c/b + k_phi of the same wheel.
#[test]
fn k_eq_stands_for_both_moduli() {
    use terra_model::{Registry, catalogue};
    use terra_sim::simulate_drive;
    let soil = catalogue::find("dry_sand").unwrap();
    let mut scenario = crate::support::quiet_ramp("dry_sand");
    scenario.segments[0].duration = 0.1;
    let by_id = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap();
    let table = Start::Values(
        [
            ("k_eq", soil.k_eq(0.15)),
            ("sinkage_exponent", soil.sinkage_exponent),
            ("cohesion", soil.cohesion),
            ("friction_angle", soil.friction_angle),
            ("shear_modulus", soil.shear_modulus.unwrap()),
            ("c1", soil.c1.unwrap()),
            ("c2", soil.c2.unwrap()),
        ]
        .map(|(k, v)| (k.to_owned(), v))
        .into(),
    );
    (scenario.left, scenario.right) = (table.clone(), table);
    let by_table = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap();
    for (a, b) in by_id
        .truth
        .ground_speed
        .iter()
        .zip(&by_table.truth.ground_speed)
    {
        assert!((a - b).abs() < 1e-9);
    }
    let Start::Values(mut values) = scenario.left.clone() else {
        panic!()
    };
    values.insert("frictoin_angle".to_owned(), 0.4);
    scenario.left = Start::Values(values.clone());
    let error = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap_err();
    assert!(
        error.to_string().contains("did you mean 'friction_angle'"),
        "{error}"
    );
    values.remove("frictoin_angle");
    values.remove("c1");
    scenario.left = Start::Values(values);
    let error = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap_err();
    assert!(matches!(
        error,
        SimError::TerrainParameter {
            parameter: "c1",
            ..
        }
    ));
}

#[test]
fn every_mistake_has_its_place_and_its_word() {
    let check = |from: &str, to: &str, line: usize, column: usize, words: &str| {
        assert!(DRIVE.contains(from));
        let (l, c, message) = fails(&DRIVE.replacen(from, to, 1));
        assert!(
            (l, c) == (line, column) && message.contains(words),
            "{to}: {l}:{c}: {message}"
        );
    };
    check(
        "rate_hz",
        "rate_Hz",
        3,
        1,
        "unknown key 'rate_Hz', did you mean 'rate_hz'?",
    );
    check(
        "duration_s = 2",
        "duraton_s = 2",
        8,
        1,
        "did you mean 'duration_s'?",
    );
    check("from = 35.4", "form = 35.4", 9, 14, "missing key 'from'");
    check(
        "wheel_speed_rad_s = 0.2",
        "wheel_speed_rads = 0.2",
        10,
        35,
        "did you mean 'wheel_speed_rad_s'?",
    );
    check(
        "duration_s = 2\n",
        "duration_s = -2\n",
        8,
        14,
        "a duration above 0",
    );
    check(
        "duration_s = 2\n",
        "duration_s = \"2\"\n",
        8,
        14,
        "expected a finite number",
    );
    check(
        "magnitude = 0.3",
        "magnitude = nan",
        19,
        13,
        "finite number",
    );
    check("seed = 7", "seed = -7", 1, 8, "whole number");
    check("seed = 7\n", "\n", 1, 1, "missing key 'seed'");
    check("pass = 2", "pass = 0", 16, 8, "from 1");
    check(
        "payload_kg = 20.0",
        "start = { ground_speed_m_s = 1.0 }",
        15,
        9,
        "after reset",
    );
    check(
        "torque_N_m = { from = 35.4, to = 9.0 }",
        "pass = 1",
        6,
        1,
        "torque_N_m, wheel_speed_rad_s",
    );
    check("rate_hz = 50.0", "rate_hz = ", 3, 11, "");
    check("noise_scale", "seed", 5, 1, "");
}

#[test]
fn a_drive_or_a_rig_but_one_of_them() {
    let head = "seed = 1\nrover = \"r.toml\"\nrate_hz = 10\nterrain = \"dry_sand\"\n";
    assert!(fails(head).2.contains("[[segment]]"));
    let trial = "[[trial]]\nslip = [0.1, 1.5]\nnormal_load_N = 100\ntravel_speed_m_s = 0.05\n";
    let (line, column, message) = fails(&format!("{head}{trial}"));
    assert_eq!((line, column), (6, 14));
    assert!(message.contains("[-1, 1]"));
    let both = format!("{DRIVE}{}", trial.replace("1.5", "0.5"));
    assert!(fails(&both).2.contains("a drive or a rig"));
}

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples")
}

/// The files are the paper's torque ramps, digits rounded to 1e-4 N m.
#[test]
fn example_files_are_the_paper_module() {
    for (file, rover, soil) in [
        ("dry_sand.toml", paper::light_rover(), "dry_sand"),
        ("lean_clay.toml", paper::light_rover(), "lean_clay_22"),
        ("heavy_dry_sand.toml", paper::heavy_rover(), "dry_sand"),
    ] {
        let mut read = Scenario::read(&examples().join("paper").join(file)).unwrap();
        let mut made = paper::torque_ramp_of(&rover, soil, 1).unwrap();
        made.rover = read.rover.clone();
        let (Command::Torque(a), Command::Torque(b)) =
            (read.segments[0].command, made.segments[0].command)
        else {
            panic!()
        };
        for (a, b) in a.iter().zip(&b) {
            assert!(
                (a.from - b.from).abs() < 1e-4 && (a.to - b.to).abs() < 1e-4,
                "{file}: {b:?}"
            );
        }
        read.segments[0].command = made.segments[0].command;
        assert_eq!(read, made, "{file}");
    }
}

#[test]
fn an_unreadable_file_is_named() {
    let error = Scenario::read(Path::new("no/such/scenario.toml")).unwrap_err();
    assert!(error.to_string().contains("no/such/scenario.toml"));
}

/// 40 kB of lists that multiply to 10^8 trials: refused before room is made for them, at the table.
#[test]
fn lists_that_multiply_beyond_a_log_are_refused() {
    let ones = format!("[{}1]", "1,".repeat(9_999));
    let text = format!(
        "seed = 1\nrover = \"rig.toml\"\nterrain = \"dry_sand\"\n[[trial]]\nslip = 0.1\nnormal_load_N = 100\npass = {ones}\ntravel_speed_m_s = {ones}\n"
    );
    let (line, _, message) = fails(&text);
    assert_eq!(line, 4);
    assert!(message.contains("100000000 trials"), "{message}");
    let few = text.replace(&ones, "[1, 1, 1]");
    assert_eq!(Scenario::parse(&few, "s.toml").unwrap().trials.len(), 9);
}

#[cfg(unix)]
#[test]
fn a_device_that_never_ends_is_no_scenario() {
    let e = Scenario::read(Path::new("/dev/zero")).unwrap_err();
    assert!(e.to_string().contains("longer than 1048576 bytes"), "{e}");
}

/// A slip of the pen in a duration would run for weeks, whatever the rate of the log.
#[test]
fn a_drive_of_years_is_refused() {
    let mut scenario = paper::torque_ramp("dry_sand", 1).unwrap();
    scenario.segments[0].duration = 1e8;
    scenario.rate = 1e-3;
    let e = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap_err();
    assert!(e.to_string().contains("duration_s"), "{e}");
}

/// A rig rover refuses segments, a vehicle refuses trials.
#[test]
fn rover_and_scenario_must_be_of_one_kind() {
    let drive = Scenario::parse(DRIVE, "s.toml").unwrap();
    let rig = Rover {
        vehicle: None,
        ..paper::light_rover()
    };
    let registry = crate::support::registry();
    assert!(matches!(
        terra_sim::simulate_drive(&drive, &rig, &registry),
        Err(SimError::NotADrive { .. })
    ));
    assert!(matches!(
        terra_sim::simulate_rig(&drive, &rig, &registry),
        Err(SimError::NotARig { .. })
    ));
    assert!(matches!(
        terra_sim::simulate_rig(&drive, &paper::light_rover(), &registry),
        Err(SimError::NotARig { .. })
    ));
}
