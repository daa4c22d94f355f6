use std::collections::BTreeMap;

use terra_data::Start;
use terra_model::{Registry, Scope};
use terra_sim::{
    Command, DriveRun, DriveSegment, EffectSetting, Integrator, Patch, Profile, Scenario,
    SensorSettings, SideSlip, StartMotion, form_variants, off_library, paper, simulate_drive,
    simulate_rig,
};

use crate::support::{constant, constant_drive, drive, quiet_ramp};

fn run(scenario: &Scenario) -> DriveRun {
    drive(scenario, &paper::light_rover(), Integrator::default())
}

fn with_sensor(channel: &str, settings: SensorSettings) -> DriveRun {
    let mut scenario = constant_drive(50.0, 50.0, 0.4);
    scenario.world.sensors = BTreeMap::from([(channel.to_owned(), settings)]);
    run(&scenario)
}

/// v = 2 t on constant forces, seen through each fault in turn.
#[test]
fn each_fault_of_a_sensor_does_what_its_name_says() {
    let nominal = SensorSettings::default();
    let reading = |settings: SensorSettings| {
        let run = with_sensor("ground_speed_m_s", settings);
        let v: Vec<Option<f64>> = run.log.ground_speed.unwrap().iter().collect();
        (run.truth.time, v)
    };
    let bent = reading(SensorSettings {
        scale: 1.1,
        bias: -0.2,
        delay: 0.05,
        ..nominal
    });
    for (t, v) in bent.0.iter().zip(&bent.1) {
        let late = (t - 0.05).max(0.0);
        assert!((v.unwrap() - (1.1 * 2.0 * late - 0.2)).abs() < 1e-9);
    }
    let coarse = reading(SensorSettings {
        step: 0.25,
        max: 0.5,
        ..nominal
    });
    for (t, v) in coarse.0.iter().zip(&coarse.1) {
        let expected = (2.0 * t).min(0.5);
        let v = v.unwrap();
        assert!((v / 0.25).fract() == 0.0 && (v - expected).abs() <= 0.125 + 1e-9 && v <= 0.5);
    }
    // 25 Hz in a 100 Hz log: every fourth row, the first included.
    let slow = reading(SensorSettings {
        rate: Some(25.0),
        ..nominal
    });
    for (i, v) in slow.1.iter().enumerate() {
        assert_eq!(v.is_some(), i % 4 == 0, "{i}");
    }
    let lost = reading(SensorSettings {
        dropout: 0.3,
        outliers: 0.2,
        outlier_size: 5.0,
        ..nominal
    });
    let missing = lost.1.iter().filter(|v| v.is_none()).count();
    // 40 rows: 12 expected, sd 2.9.
    assert!((2..=24).contains(&missing), "{missing}");
    let off = lost.0.iter().zip(&lost.1).filter(|(t, v)| {
        v.is_some_and(|v| {
            let away = (v - 2.0 * **t).abs();
            assert!(away < 1e-9 || (away - 5.0).abs() < 1e-9);
            away > 1.0
        })
    });
    assert!((1..=18).contains(&off.count()));
}

/// A table for one wheel leaves the others alone, and a default table changes no byte.
#[test]
fn sensors_are_independent() {
    let biased = with_sensor(
        "wheel_speed_rr_rad_s",
        SensorSettings {
            bias: 1.0,
            ..SensorSettings::default()
        },
    );
    let nominal = run(&constant_drive(50.0, 50.0, 0.4));
    assert_eq!(biased.truth, nominal.truth);
    for q in 0..3 {
        assert_eq!(biased.log.wheel_speed[q], nominal.log.wheel_speed[q]);
    }
    let (a, b) = (&biased.log.wheel_speed[3], &nominal.log.wheel_speed[3]);
    assert!((a.get(7).unwrap() - b.get(7).unwrap() - 1.0).abs() < 1e-12);
    let plain = with_sensor("yaw_rate_rad_s", SensorSettings::default());
    assert_eq!(format!("{:?}", plain.log), format!("{:?}", nominal.log));
    let extra = with_sensor("accel_y_m_s2", SensorSettings::default());
    assert!(extra.log.accel_y.is_some() && nominal.log.accel_y.is_none());
}

/// Pull 50 N a wheel up to x = .5 m, 100 N behind: each wheel meets the change where it stands, .3 m from the middle.
#[test]
fn soils_change_under_each_wheel_where_it_stands() {
    let mut scenario = constant_drive(50.0, 50.0, 1.2);
    let stiff = constant(100.0, 3.0);
    scenario.world.patches = vec![Patch {
        from: 0.5,
        blend: 0.1,
        terrain: [0; 4].map(|_| stiff.clone()),
    }];
    let t = run(&scenario).truth;
    for i in 0..t.len() {
        for q in 0..4 {
            let x = t.distance[i] + if q < 2 { 0.3 } else { -0.3 };
            let share = ((x - 0.5) / 0.1).clamp(0.0, 1.0);
            let expected = 50.0 + 50.0 * share * share * (3.0 - 2.0 * share);
            assert!((t.drawbar_pull[q][i] - expected).abs() < 1e-9);
        }
    }
    assert!(t.distance[t.len() - 1] > 1.0);
}

/// With ruts remembered, a rear wheel runs on virgin soil until it reaches its front wheel's track; driving back over
/// the same ground meets two passes more. Multipass then shows as less sinkage.
#[test]
fn ruts_are_met_again() {
    let mut scenario = quiet_ramp("dry_sand");
    let speed = |name: &str, from: f64, to: f64, seconds: f64| {
        DriveSegment::new(
            name,
            seconds,
            Command::WheelSpeed([Profile { from, to }; 4]),
        )
    };
    let mut out = speed("out", 5.0, 5.0, 0.9);
    out.start = Some(StartMotion {
        ground_speed: 1.1,
        wheel_speed: [5.0; 4],
    });
    scenario.segments = vec![out];
    scenario.rate = 50.0;
    scenario.effects = vec![EffectSetting::new("multipass", 1.0)];
    scenario.world.ruts = true;
    let t = run(&scenario).truth;
    let z = t.sinkage.unwrap();
    let late = t.time.len() - 1;
    assert!(t.distance[late] > 0.7);
    // Before and after .6 m of path.
    assert!((z[2][5] - z[0][5]).abs() < 0.15 * z[0][5]);
    assert!(
        z[2][late] < 0.8 * z[0][late],
        "{} {}",
        z[2][late],
        z[0][late]
    );
    // Without memory the rear wheels are in a rut from the start.
    scenario.world.ruts = false;
    let z = run(&scenario).truth.sinkage.unwrap();
    assert!(z[2][5] < 0.8 * z[0][5]);
}

/// Every off-library effect and every form variant, in the middle of its range, changes a quiet log somewhere, and at
/// zero nothing at all.
#[test]
fn what_only_the_truth_has_shows() {
    let base = || {
        let [l, r] = [5.0, -0.5].map(|w| Profile { from: 3.0, to: w });
        let back = Profile {
            from: -1.0,
            to: -3.0,
        };
        let mut turn = DriveSegment::new("turn", 0.12, Command::WheelSpeed([l, r, l, r]));
        turn.start = Some(StartMotion {
            ground_speed: 0.7,
            wheel_speed: [3.0; 4],
        });
        let mut reverse = DriveSegment::new("reverse", 0.1, Command::WheelSpeed([back; 4]));
        reverse.reset = true;
        reverse.start = Some(StartMotion {
            ground_speed: -0.2,
            wheel_speed: [-1.0; 4],
        });
        let mut scenario = quiet_ramp("dry_sand");
        scenario.segments = vec![turn, reverse];
        scenario.world.side_slip = SideSlip::Held;
        scenario
    };
    let nominal = format!("{:?}", run(&base()).log);
    let of = |name: &str, form: &str, e: f64| {
        let mut scenario = base();
        let mut setting = EffectSetting::new(name, e);
        setting.form = Some(form.to_owned());
        scenario.effects = vec![setting];
        format!("{:?}", run(&scenario).log)
    };
    let mut shown = 0;
    for row in off_library().iter().chain(form_variants()) {
        if row.scope == Scope::Rig {
            continue;
        }
        assert_eq!(of(row.name, row.form, 0.0), nominal, "{}", row.name);
        let middle = 0.5 * (row.magnitude.0 + row.magnitude.1);
        assert_ne!(
            of(row.name, row.form, middle),
            nominal,
            "{} {}",
            row.name,
            row.form
        );
        shown += 1;
    }
    assert!(shown >= 30 && off_library().len() >= 8);
}

/// A form of the truth is not that of the library, and unknown names say what is near.
#[test]
fn forms_are_asked_for_by_name() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments[0].duration = 0.02;
    let mut setting = EffectSetting::new("slip-sinkage", 0.5);
    setting.form = Some("sinkage-facter".to_owned());
    scenario.effects = vec![setting];
    assert!(simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).is_err());
    scenario.effects = vec![EffectSetting::new("gearbox-backlesh", 0.5)];
    let error = simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap_err();
    assert!(error.to_string().contains("gearbox-backlash"), "{error}");
    scenario.effects = vec![EffectSetting::new("gearbox-backlash", 1e3)];
    assert!(simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).is_err());
}

const EXTRAS: &str = r#"seed = 1
rover = "rover.toml"
rate_hz = 50.0
terrain = { fl = "dry_sand", fr = "dry_sand", rl = "lean_clay_22", rr = "dry_sand" }
side_slip = "free"
rut_memory = true
[motor]
torque_limit_N_m = 40.0
lag_s = 0.02
[sensor.wheel_torque_N_m]
bias = 0.5
dropout = 0.1
[[patch]]
from_m = 2.0
blend_m = 0.5
terrain = { left = "lean_clay_22", right = "dry_sand" }
[[segment]]
duration_s = 1.0
torque_N_m = 10.0
roll_rad = 0.1
payload_kg = 5.0
payload_at_m = { left = 0.1 }
"#;

#[test]
fn the_world_is_read_from_a_file() {
    let s = Scenario::parse(EXTRAS, "s.toml").unwrap();
    assert_eq!(s.world.side_slip, SideSlip::Free);
    assert!(s.world.ruts);
    assert_eq!(
        (s.world.motor.torque_limit, s.world.motor.lag),
        (40.0, 0.02)
    );
    assert_eq!(s.world.sensors["wheel_torque_N_m"].bias, 0.5);
    assert_eq!(
        s.world.wheels.unwrap()[2],
        Start::Id("lean_clay_22".to_owned())
    );
    assert_eq!(s.world.patches[0].from, 2.0);
    assert_eq!(s.segments[0].payload_at, Some([0.0, 0.1, 0.0]));
    for (from, to, line, word) in [
        ("\"free\"", "\"loose\"", 5, "held or free"),
        ("lag_s", "lag_z", 9, "lag_s"),
        (
            "[sensor.wheel_torque_N_m]",
            "[sensor.wheel_torqe_N_m]",
            10,
            "wheel_torque_N_m",
        ),
        ("dropout = 0.1", "dropout = 1.5", 12, "share"),
        ("blend_m = 0.5", "blend_m = -0.5", 15, "from 0"),
        ("roll_rad = 0.1", "roll_rad = 3.0", 20, "angle"),
    ] {
        let error = Scenario::parse(&EXTRAS.replace(from, to), "s.toml").unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with(&format!("s.toml:{line}:")) && text.contains(word),
            "{text}"
        );
    }
}

/// A ramp runs through its slips in time, once a load and repeat, and its wheel moves along the bed: 2 m along it lies
/// between two crusts, where steady trials, which all stand at the beginning, are still on the first.
#[test]
fn a_ramp_of_slip_takes_time_and_path() {
    let parse = |ramp: &str| {
        let text = format!(
            "seed = 1\nrover = \"rig.toml\"\nterrain = \"dry_sand\"\nnoise_scale = 0.0\n[[trial]]\n\
             slip = {{ from = 0.1, to = 0.5, steps = 5 }}\nnormal_load_N = [150.0, 245.0]\n\
             travel_speed_m_s = 0.2\nrepeats = 2\n{ramp}"
        );
        Scenario::parse(&text, "s.toml").unwrap()
    };
    let mut rig = paper::light_rover();
    rig.vehicle = None;
    rig.noise.0.insert("drawbar_pull_N".to_owned(), 0.5);
    rig.noise.0.insert("slip".to_owned(), 0.01);
    let run = |scenario: &Scenario| simulate_rig(scenario, &rig, &Registry::builtin()).unwrap();
    let (mut ramp, mut steady) = (parse("ramp_s = 20.0"), parse(""));
    let rows = run(&ramp).log.rows;
    assert_eq!(rows.len(), 2 * 2 * 5);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row.time, Some(5.0 * (i % 5) as f64));
        assert_eq!(row.trial, format!("trial_{:03}", i / 5 + 1));
        assert_eq!(row.normal_load.value, if i < 10 { 150.0 } else { 245.0 });
    }
    let pull = |scenario: &Scenario, slip: f64| {
        let truth = run(scenario).truth;
        let at =
            |i: &usize| (truth.slip[*i] - slip).abs() < 1e-12 && truth.normal_load[*i] == 245.0;
        truth.drawbar_pull[(0..truth.slip.len()).find(at).unwrap()]
    };
    // Without drift a ramp is its steady trials, one after the other.
    assert_eq!(pull(&ramp, 0.5), pull(&steady, 0.5));
    for scenario in [&mut ramp, &mut steady] {
        scenario.effects = vec![EffectSetting::new("moisture-crust", 1.0)];
    }
    assert_eq!(pull(&ramp, 0.1), pull(&steady, 0.1));
    assert!((pull(&ramp, 0.3) - pull(&steady, 0.3)).abs() > 0.1);
}

/// Speeds and passes multiply a programme; a load that is not held scatters as declared, and the log follows it.
#[test]
fn rig_programmes_and_loads_that_wander() {
    let text = r#"seed = 1
rover = "rig.toml"
terrain = "dry_sand"
load_hold = 0.05
noise_scale = 0.0
[[trial]]
slip = { from = 0.1, to = 0.5, steps = 3 }
normal_load_N = [150.0, 245.0]
travel_speed_m_s = [0.05, 0.1]
pass = [1, 2]
repeats = 20
"#;
    let scenario = Scenario::parse(text, "s.toml").unwrap();
    assert_eq!(scenario.trials.len(), 4);
    assert_eq!(scenario.trials[1].pass, 2);
    assert_eq!(scenario.trials[2].travel_speed, 0.1);
    assert_eq!(scenario.trials[0].slip, vec![0.1, 0.30000000000000004, 0.5]);
    let mut rig = paper::light_rover();
    rig.vehicle = None;
    rig.noise.0.insert("drawbar_pull_N".to_owned(), 0.5);
    rig.noise.0.insert("slip".to_owned(), 0.01);
    let run = simulate_rig(&scenario, &rig, &Registry::builtin()).unwrap();
    assert_eq!(run.log.rows.len(), 4 * 6 * 20);
    let (mut sum, mut squares) = (0.0, 0.0);
    for (i, row) in run.log.rows.iter().enumerate() {
        let wanted = if (i / 20) % 2 == 0 { 150.0 } else { 245.0 };
        assert_eq!(row.normal_load.value, run.truth.normal_load[i]);
        let off = row.normal_load.value / wanted - 1.0;
        sum += off;
        squares += off * off;
    }
    let n = run.log.rows.len() as f64;
    // sd of the mean .05/sqrt(480) = .0023; of the sd .0016.
    assert!((sum / n).abs() < 0.012 && ((squares / n).sqrt() - 0.05).abs() < 0.009);
}

/// The scenario in the examples runs; its bent encoders change the log and not the truth of motion.
#[test]
fn the_planar_example_runs() {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drive/planar.toml");
    let mut scenario = Scenario::read(&path).unwrap();
    scenario.segments[0].duration = 0.2;
    scenario.segments[1].duration = 0.2;
    scenario.noise_scale = 0.0;
    let bent = run(&scenario);
    assert_eq!(bent.log.len(), 40);
    scenario.effects.clear();
    let straight = run(&scenario);
    assert!((bent.truth.wheel_speed[0][30] - straight.truth.wheel_speed[0][30]).abs() < 1e-6);
    assert_ne!(bent.log.wheel_speed[0], straight.log.wheel_speed[0]);
    let current = bent
        .truth
        .columns()
        .into_iter()
        .find(|c| c.name == "motor_current_fl_A");
    assert_eq!(current.unwrap().values.len(), 40);
}
