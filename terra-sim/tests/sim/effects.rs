use terra_data::{DriveLog, Series};
use terra_model::{Registry, Scope};
use terra_sim::{EffectSetting, Integrator, Scenario, SimError, paper, simulate_drive};

use crate::support::{drive, quiet_ramp};

fn short_ramp(effects: &[(&str, f64)]) -> Scenario {
    let mut scenario = paper::torque_ramp("dry_sand", 5).unwrap();
    scenario.segments[0].duration = 0.15;
    scenario.effects = effects
        .iter()
        .map(|(n, e)| EffectSetting::new(*n, *e))
        .collect();
    scenario
}

fn log(effects: &[(&str, f64)]) -> DriveLog {
    drive(
        &short_ramp(effects),
        &paper::light_rover(),
        Integrator::default(),
    )
    .log
}

/// The measured channels by name.
fn channels(log: &DriveLog) -> Vec<(&'static str, Vec<&Series>)> {
    vec![
        ("wheel speed", log.wheel_speed.iter().collect()),
        ("torque", log.wheel_torque.iter().flatten().collect()),
        ("ground speed", log.ground_speed.iter().collect()),
        ("yaw rate", log.yaw_rate.iter().collect()),
        ("accel x", log.accel_x.iter().collect()),
    ]
}

fn changed(effect: &str, magnitude: f64) -> Vec<&'static str> {
    let (nominal, other) = (log(&[]), log(&[(effect, magnitude)]));
    channels(&nominal)
        .into_iter()
        .zip(channels(&other))
        .filter(|((_, a), (_, b))| a != b)
        .map(|((name, _), _)| name)
        .collect()
}

#[test]
fn every_effect_at_zero_is_the_nominal_world_bit_for_bit() {
    let nominal = log(&[]);
    let names: Vec<(&str, f64)> = Registry::builtin()
        .effects()
        .iter()
        .filter(|e| e.scope() != Scope::Rig)
        .map(|e| (e.name(), 0.0))
        .collect();
    assert!(names.len() > 20);
    let all = log(&names);
    for ((name, a), (_, b)) in channels(&nominal).iter().zip(channels(&all)) {
        assert_eq!(a, &b, "{name}");
    }
}

#[test]
fn every_effect_at_its_prior_changes_something() {
    for effect in Registry::builtin()
        .effects()
        .iter()
        .filter(|e| e.scope() != Scope::Rig)
    {
        let size = effect.params()[0].prior_sd;
        let seen = changed(effect.name(), size);
        // These need a turn, and the ramp is straight; the layer lies deeper than the light robot sinks on dry sand.
        let silent = [
            "track-width-error",
            "skid-steer-lateral-slip",
            "lateral-bulldozing",
            "layered-soil",
        ];
        assert!(
            !seen.is_empty() || silent.contains(&effect.name()),
            "{}",
            effect.name()
        );
    }
}

#[test]
fn instrument_effects_change_their_own_channel_alone() {
    assert_eq!(changed("torque-scale", 0.1), ["torque"]);
    assert_eq!(changed("torque-bias", 1.0), ["torque"]);
    assert_eq!(changed("ground-speed-scale", 0.05), ["ground speed"]);
    assert_eq!(changed("ground-speed-bias", 0.05), ["ground speed"]);
    assert_eq!(changed("ground-speed-delay", 0.05), ["ground speed"]);
    assert_eq!(changed("accel-bias", 0.1), ["accel x"]);
    assert_eq!(changed("yaw-rate-bias", 0.01), ["yaw rate"]);
}

/// T_true = (1 + e) T_rep; v_rep = (1 + e) v; without noise, to rounding.
#[test]
fn instrument_effects_have_their_formula() {
    let mut scenario = Scenario {
        noise_scale: 0.0,
        ..short_ramp(&[("torque-scale", 0.1), ("ground-speed-scale", 0.05)])
    };
    scenario.effects.push(EffectSetting::new("accel-bias", 0.2));
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    for i in 0..run.truth.len() {
        let reported = run.log.wheel_torque.as_ref().unwrap()[1].get(i).unwrap();
        assert!((1.1 * reported - run.truth.wheel_torque[1][i]).abs() < 1e-12);
        let v = run.log.ground_speed.as_ref().unwrap().get(i).unwrap();
        assert!((v - 1.05 * run.truth.ground_speed[i]).abs() < 1e-12);
        let a = run.log.accel_x.as_ref().unwrap().get(i).unwrap();
        assert!((a - run.truth.accel_x[i] - 0.2).abs() < 1e-12);
    }
}

/// Physical effects in the direction their table gives.
#[test]
fn physical_effects_act_in_their_direction() {
    let at_end = |effects: &[(&str, f64)]| {
        let scenario = Scenario {
            noise_scale: 0.0,
            ..short_ramp(effects)
        };
        let truth = drive(&scenario, &paper::light_rover(), Integrator::default()).truth;
        let last = truth.len() - 1;
        let z = truth.sinkage.unwrap();
        (
            truth.ground_speed[last],
            z[0][last],
            z[2][last],
            truth.slip[0][last],
        )
    };
    let (v, front, rear, slip) = at_end(&[]);
    let dug = at_end(&[("slip-sinkage", 0.4)]);
    assert!(
        dug.0 < v && dug.1 > front,
        "the wheel digs in and pulls less"
    );
    assert!(at_end(&[("tow-load", 40.0)]).0 < v);
    assert!(at_end(&[("slope", 0.03)]).0 < v);
    assert!(
        at_end(&[("grousers", 0.02)]).3 < slip,
        "lugs take the same torque at less slip"
    );
    // Only the rear wheels run in a rut on a first pass.
    let rut = at_end(&[("multipass", 0.8)]);
    assert!(
        rut.2 < rear - 1e-3 && (rut.1 - front).abs() < 1e-3,
        "{rut:?} {front} {rear}"
    );
    let several = at_end(&[("slip-sinkage", 0.4), ("tow-load", 40.0)]);
    assert!(several.0 < dug.0);
}

/// Mass error on the file's mass; the payload comes on top of it.
#[test]
fn mass_error_scales_the_loads() {
    let mut scenario = Scenario {
        noise_scale: 0.0,
        ..short_ramp(&[("mass-error", 0.1)])
    };
    scenario.segments[0].payload = Some(20.0);
    let truth = drive(&scenario, &paper::light_rover(), Integrator::default()).truth;
    let total: f64 = (0..4).map(|q| truth.normal_load[q][3]).sum();
    assert!((total - 9.81 * (110.0 + 20.0)).abs() < 1e-9);
}

#[test]
fn wrong_effects_are_typed_errors() {
    let error = |name: &str, magnitude: f64| {
        let mut scenario = quiet_ramp("dry_sand");
        scenario.effects.push(EffectSetting::new(name, magnitude));
        simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin()).unwrap_err()
    };
    assert!(
        error("slip_sinkge", 0.1)
            .to_string()
            .contains("did you mean 'slip-sinkage'")
    );
    assert!(matches!(
        error("drawbar-gain", 0.1),
        SimError::EffectScope { kind: "drive", .. }
    ));
    assert!(matches!(
        error("grousers", -0.1),
        SimError::Magnitude { min: 0.0, .. }
    ));
    assert!(matches!(
        error("tow-load", f64::NAN),
        SimError::Magnitude { .. }
    ));
}

/// One form of an effect acts once, whatever it acts on and whatever its magnitude; the bare name is the default form.
#[test]
fn an_effect_named_twice_is_refused() {
    let named = |second: EffectSetting| {
        let mut scenario = quiet_ramp("dry_sand");
        let first = EffectSetting::new(second.name.clone(), 0.1);
        scenario.effects.extend([first, second]);
        simulate_drive(&scenario, &paper::light_rover(), &Registry::builtin())
    };
    let default = EffectSetting {
        form: Some("default".to_owned()),
        ..EffectSetting::new("slip-sinkage", 0.1)
    };
    for second in [
        EffectSetting::new("torque-bias", 0.2),
        EffectSetting::new("slip-sinkage", 0.0),
        default,
    ] {
        let said = named(second).unwrap_err().to_string();
        assert!(said.contains("twice"), "{said}");
    }
    let other = EffectSetting {
        form: Some("excavation".to_owned()),
        ..EffectSetting::new("slip-sinkage", 0.1)
    };
    assert!(named(other).is_ok());
}
