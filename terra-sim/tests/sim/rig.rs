use terra_data::{Condition, Noise, Rover, SoilSharing, WheelData};
use terra_model::{Contact, ForceLaw, Registry, catalogue};
use terra_sim::{EffectSetting, RigRun, Scenario, SimError, Trial, paper, simulate_rig};

/// A rig whose sensors are all declared.
pub(crate) fn rig() -> Rover {
    let noise = [
        ("drawbar_pull_N", 0.5),
        ("torque_N_m", 0.1),
        ("sinkage_m", 0.001),
        ("slip", 0.005),
        ("normal_load_N", 0.8),
    ];
    let mut rover = Rover {
        vehicle: None,
        noise: Noise(noise.map(|(k, v)| (k.to_owned(), v)).into()),
        ..paper::light_rover()
    };
    let large = WheelData {
        radius: 0.3,
        ..rover.wheel
    };
    rover.conditions.insert(
        "large".to_owned(),
        Condition {
            wheel: large,
            soil: SoilSharing::Shared,
        },
    );
    rover
}

fn trial(slip: &[f64], load: &[f64], repeats: u32) -> Trial {
    Trial {
        slip: slip.to_vec(),
        normal_load: load.to_vec(),
        repeats,
        travel_speed: 0.05,
        condition: String::new(),
        pass: 1,
        ramp: None,
    }
}

fn scenario(trials: Vec<Trial>, noise_scale: f64) -> Scenario {
    Scenario {
        segments: Vec::new(),
        trials,
        noise_scale,
        ..paper::torque_ramp("dry_sand", 3).unwrap()
    }
}

fn run(scenario: &Scenario) -> RigRun {
    simulate_rig(scenario, &rig(), &Registry::builtin()).unwrap()
}

/// Grid order, and every number of the quiet log is the model's own.
#[test]
fn quiet_trials_are_the_model() {
    let mut large = trial(&[0.2], &[245.25], 1);
    large.condition = "large".to_owned();
    let run = run(&scenario(
        vec![trial(&[-0.1, 0.2, 0.6], &[150.0, 245.25], 2), large],
        0.0,
    ));
    assert_eq!(run.log.rows.len(), 13);
    let law = Registry::builtin().law("wong-reece").unwrap();
    let p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    let order: Vec<(f64, f64)> = run
        .log
        .rows
        .iter()
        .map(|r| (r.slip.value, r.normal_load.value))
        .take(5)
        .collect();
    assert_eq!(
        order,
        [
            (-0.1, 150.0),
            (-0.1, 150.0),
            (-0.1, 245.25),
            (-0.1, 245.25),
            (0.2, 150.0)
        ]
    );
    assert_eq!(run.log.rows[0].trial, run.log.rows[1].trial);
    assert_ne!(run.log.rows[1].trial, run.log.rows[2].trial);
    for row in &run.log.rows {
        let radius = if row.condition == "large" { 0.3 } else { 0.254 };
        let f = law
            .forces(
                &p,
                &Contact::new(row.slip.value, row.normal_load.value, radius, 0.15),
            )
            .unwrap();
        assert_eq!(row.drawbar_pull.unwrap().value, f.drawbar_pull);
        assert_eq!(row.sinkage.unwrap().value, f.sinkage.unwrap());
        // The torque at the axle includes the bearing's damping at the wheel speed of that slip.
        let w = row.wheel_speed.unwrap();
        let slip = terra_model::slip_from_speeds(radius * w, row.travel_speed.unwrap())
            .unwrap()
            .0;
        assert!((slip - row.slip.value).abs() < 1e-12);
        assert!((row.torque.unwrap().value - f.resistive_torque - 0.1 * w).abs() < 1e-12);
    }
}

/// Reported minus true of each channel is chi-square with the declared sd.
#[test]
fn noise_is_on_every_channel_as_declared() {
    let run = run(&scenario(vec![trial(&[0.3], &[245.25], 4000)], 1.0));
    let rig = rig();
    let check = |key: &str, residual: Vec<f64>| {
        let sd = rig.noise.get(key).unwrap();
        let n = residual.len() as f64;
        let chi2: f64 = residual.iter().map(|r| (r / sd).powi(2)).sum();
        assert!(
            (chi2 - n).abs() < 4.5 * (2.0 * n).sqrt(),
            "{key}: {chi2} of {n}"
        );
        assert!(
            (residual.iter().sum::<f64>() / n).abs() < 4.5 * sd / n.sqrt(),
            "{key}"
        );
    };
    let (rows, truth) = (&run.log.rows, &run.truth);
    let residual = |f: &dyn Fn(usize) -> f64| (0..rows.len()).map(f).collect::<Vec<f64>>();
    check("slip", residual(&|i| rows[i].slip.value - truth.slip[i]));
    check(
        "normal_load_N",
        residual(&|i| rows[i].normal_load.value - truth.normal_load[i]),
    );
    check(
        "drawbar_pull_N",
        residual(&|i| rows[i].drawbar_pull.unwrap().value - truth.drawbar_pull[i]),
    );
    check(
        "torque_N_m",
        residual(&|i| rows[i].torque.unwrap().value - truth.torque[i]),
    );
    check(
        "sinkage_m",
        residual(&|i| rows[i].sinkage.unwrap().value - truth.sinkage.as_ref().unwrap()[i]),
    );
}

#[test]
fn slip_stays_a_slip_at_the_edges() {
    let run = run(&scenario(
        vec![trial(&[1.0, -1.0, 0.998], &[245.25], 200)],
        1.0,
    ));
    assert!(
        run.log
            .rows
            .iter()
            .all(|r| (-1.0..=1.0).contains(&r.slip.value))
    );
    let spinning = &run.log.rows[0];
    assert_eq!(
        (spinning.travel_speed, spinning.wheel_speed),
        (Some(0.0), None)
    );
}

/// W_true = (1 + e) W_rep; D_rep = (1 + e) D; D + e; z + e; T_true = (1 + e) T_rep.
#[test]
fn rig_effects_have_their_formula() {
    let grid = vec![trial(&[0.1, 0.5], &[150.0, 245.25], 1)];
    let with = |effects: &[(&str, f64)]| {
        let mut s = scenario(grid.clone(), 0.0);
        s.effects = effects
            .iter()
            .map(|(n, e)| EffectSetting::new(*n, *e))
            .collect();
        run(&s)
    };
    let nominal = with(&[]);
    let instruments = with(&[
        ("drawbar-gain", 0.1),
        ("drawbar-bias", 2.0),
        ("sinkage-bias", 0.002),
        ("torque-scale", 0.1),
    ]);
    assert_eq!(nominal.truth, instruments.truth);
    for (a, b) in nominal.log.rows.iter().zip(&instruments.log.rows) {
        let d = a.drawbar_pull.unwrap().value;
        assert!((b.drawbar_pull.unwrap().value - (1.1 * d + 2.0)).abs() < 1e-12);
        assert!((b.sinkage.unwrap().value - a.sinkage.unwrap().value - 0.002).abs() < 1e-15);
        assert!((1.1 * b.torque.unwrap().value - a.torque.unwrap().value).abs() < 1e-12);
    }
    let loaded = with(&[("load-error", 0.1)]);
    assert_eq!(loaded.log.rows[1].normal_load.value, 245.25);
    assert!((loaded.truth.normal_load[1] - 1.1 * 245.25).abs() < 1e-9);
    assert!(loaded.truth.sinkage.unwrap()[1] > nominal.truth.sinkage.as_ref().unwrap()[1]);
    let friction = with(&[("drivetrain-coulomb-friction", 2.0)]);
    let w = nominal.log.rows[2].wheel_speed.unwrap();
    let extra = friction.truth.torque[2] - nominal.truth.torque[2];
    assert!((extra - 2.0 * (10.0 * w).tanh()).abs() < 1e-12);
    let zero = with(&[
        ("slip-sinkage", 0.0),
        ("wheel-radius-error", 0.0),
        ("load-error", 0.0),
    ]);
    assert_eq!(zero.log.rows, nominal.log.rows);
}

/// v_rep = (1 + e) v + e', and the slip of the log is 1 - v_rep/(R ω); the wheel and what it does stay as they were. A speed that
/// would be reported negative is refused.
#[test]
fn an_error_of_the_travel_speed_is_in_speed_and_slip() {
    let with = |effects: &[(&str, f64)]| {
        let mut s = scenario(vec![trial(&[0.1, 0.5, 1.0], &[245.25], 1)], 0.0);
        s.effects = effects
            .iter()
            .map(|(n, e)| EffectSetting::new(*n, *e))
            .collect();
        simulate_rig(&s, &rig(), &Registry::builtin())
    };
    let nominal = with(&[]).unwrap();
    let off = with(&[("ground-speed-scale", -0.1), ("ground-speed-bias", 0.004)]).unwrap();
    assert_eq!(nominal.truth, off.truth);
    for (a, b) in nominal.log.rows.iter().zip(&off.log.rows).take(2) {
        let v = 0.9 * a.travel_speed.unwrap() + 0.004;
        assert!((b.travel_speed.unwrap() - v).abs() < 1e-12);
        assert_eq!(a.wheel_speed, b.wheel_speed);
        let slip = 1.0 - v / (rig().wheel.radius * b.wheel_speed.unwrap());
        assert!((b.slip.value - slip).abs() < 1e-12, "{}", b.slip.value);
    }
    // A wheel that spins in place has no speeds to be read.
    assert_eq!(nominal.log.rows[2], off.log.rows[2]);
    let error = with(&[("ground-speed-bias", -0.06)]).unwrap_err();
    assert!(
        error.to_string().contains("reported travel speed"),
        "{error}"
    );
}

#[test]
fn a_second_pass_meets_compacted_soil() {
    let mut second = trial(&[0.3], &[245.25], 1);
    second.pass = 2;
    let mut s = scenario(vec![trial(&[0.3], &[245.25], 1), second], 0.0);
    s.effects.push(EffectSetting::new("multipass", 0.8));
    let z = run(&s).truth.sinkage.unwrap();
    assert!(z[1] < 0.9 * z[0], "{z:?}");
}

#[test]
fn missing_noise_and_vehicle_effects_are_refused() {
    let s = scenario(vec![trial(&[0.3], &[245.25], 1)], 1.0);
    let mut blind = rig();
    blind.noise.0.remove("normal_load_N");
    let error = simulate_rig(&s, &blind, &Registry::builtin()).unwrap_err();
    assert_eq!(
        error,
        SimError::MissingNoise {
            key: "normal_load_N".to_owned()
        }
    );
    let mut towed = s;
    towed.effects.push(EffectSetting::new("tow-load", 10.0));
    let error = simulate_rig(&towed, &rig(), &Registry::builtin()).unwrap_err();
    assert!(matches!(error, SimError::EffectScope { kind: "rig", .. }));
}

#[test]
fn the_example_runs() {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/rig/slip_sinkage.toml");
    let scenario = Scenario::read(&path).unwrap();
    let run = run(&scenario);
    assert_eq!(run.log.rows.len(), 36);
    assert_eq!(run.truth.columns().len(), 7);
    assert_eq!(
        format!("{:?}", run.log.rows),
        format!("{:?}", self::run(&scenario).log.rows)
    );
}

#[test]
fn soil_that_gives_way_names_its_trial() {
    let mut s = scenario(vec![trial(&[0.1, 0.8], &[100.0, 245.25], 1)], 0.0);
    s.left = terra_data::Start::Id("snow_us_harrison_1".to_owned());
    match simulate_rig(&s, &rig(), &Registry::builtin()) {
        Err(SimError::Trial {
            slip, load, source, ..
        }) => {
            assert_eq!((slip, load), (0.8, 245.25));
            assert!(matches!(
                source,
                terra_model::ModelError::NoEquilibrium { .. }
            ));
        }
        other => panic!("{:?}", other.map(|r| r.truth)),
    }
}
