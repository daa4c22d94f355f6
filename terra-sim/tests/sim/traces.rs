use terra_model::{Effect, Registry, Scope, Touch};
use terra_sim::{
    Command, DriveSegment, EffectSetting, Integrator, Profile, Scenario, SideSlip, StartMotion,
    paper,
};

use crate::support::{drive, quiet_ramp};

const CHANNELS: [&str; 5] = [
    "ground speed",
    "yaw rate",
    "accel x",
    "wheel speed",
    "torque",
];

/// Straight, or turning, from motion at .9 m/s; quiet.
fn scenario(left: f64, right: f64, side_slip: SideSlip) -> Scenario {
    let [l, r] = [left, right].map(|w| Profile { from: 4.0, to: w });
    let mut segment = DriveSegment::new("run", 0.12, Command::WheelSpeed([l, r, l, r]));
    segment.start = Some(StartMotion {
        ground_speed: 0.9,
        wheel_speed: [4.0; 4],
    });
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments = vec![segment];
    scenario.world.side_slip = side_slip;
    scenario
}

/// The logged numbers, channel by channel.
fn channels(scenario: &Scenario) -> [Vec<Option<f64>>; 5] {
    let log = drive(scenario, &paper::light_rover(), Integrator::default()).log;
    let all = |series: &[terra_data::Series]| series.iter().flat_map(|s| s.iter()).collect();
    [
        all(&[log.ground_speed.unwrap()]),
        all(&[log.yaw_rate.unwrap()]),
        all(&[log.accel_x.unwrap()]),
        all(&log.wheel_speed),
        all(&log.wheel_torque.unwrap()),
    ]
}

fn changed(base: &Scenario, effect: &str, e: f64) -> Vec<&'static str> {
    let mut other = base.clone();
    other.effects = vec![EffectSetting::new(effect, e)];
    let (a, b) = (channels(base), channels(&other));
    // Forces come from a table without force effects and from the model with them; the two agree to 1e-7.
    let differ = |x: &Option<f64>, y: &Option<f64>| match (x, y) {
        (Some(x), Some(y)) => (x - y).abs() > 1e-6 * (1.0 + x.abs()),
        _ => x != y,
    };
    (0..5)
        .filter(|&k| a[k].iter().zip(&b[k]).any(|(x, y)| differ(x, y)))
        .map(|k| CHANNELS[k])
        .collect()
}

/// Over the registry, each effect at its prior's size: an instrument changes its own channel and no other; what acts
/// sideways changes nothing on a straight run and the yaw rate in a turn; contrast between the sides is the only one to
/// turn a vehicle that drives straight; everything else is seen in motion or torque.
#[test]
fn each_effect_shows_in_its_channels_and_in_no_other() {
    let straight = scenario(5.5, 5.5, SideSlip::Held);
    let turn = scenario(3.2, 5.0, SideSlip::Held);
    let sideways = [
        "track-width-error",
        terra_model::effects::LateralBulldozing::NAME,
        terra_model::effects::SkidSteerLateralSlip::NAME,
    ];
    let mut seen = 0;
    for effect in Registry::builtin().effects() {
        if effect.scope() == Scope::Rig {
            continue;
        }
        let (name, e) = (effect.name(), effect.params()[0].prior_sd);
        let mut base = straight.clone();
        if name == "layered-soil" {
            // The light robot does not reach the layer.
            assert!(changed(&base, name, e).is_empty());
            base.segments[0].payload = Some(150.0);
        }
        let found = changed(&base, name, e);
        seen += 1;
        if effect.touches() == [Touch::Sensor] {
            let own = ["torque", "ground speed", "accel x", "yaw rate"]
                .into_iter()
                .find(|c| name.starts_with(&c.replace(" x", "").replace(' ', "-")))
                .unwrap();
            assert_eq!(found, [own], "{name}");
        } else if sideways.contains(&name) {
            assert!(found.is_empty(), "{name}: {found:?}");
            assert!(changed(&turn, name, e).contains(&"yaw rate"), "{name}");
        } else {
            assert!(found.len() >= 2, "{name}: {found:?}");
            assert_eq!(
                found.contains(&"yaw rate"),
                name == "lateral-contrast",
                "{name}"
            );
        }
    }
    assert!(seen >= 30);
}

/// Zero magnitude is the nominal world bit for bit in a sliding turn on a slope as well.
#[test]
fn effects_at_zero_leave_a_sliding_turn_alone() {
    let mut base = scenario(3.5, 4.5, SideSlip::Free);
    base.segments[0].duration = 0.05;
    base.segments[0].pitch = Some(0.05);
    base.segments[0].roll = Some(-0.05);
    let nominal = channels(&base);
    base.effects = Registry::builtin()
        .effects()
        .iter()
        .filter(|e| e.scope() != Scope::Rig)
        .map(|e| EffectSetting::new(e.name(), 0.0))
        .collect();
    assert!(base.effects.len() >= 30);
    assert_eq!(channels(&base), nominal);
}
