use terra_sim::{
    Command, DriveRun, DriveSegment, EffectSetting, Integrator, Motor, Profile, Scenario,
    StartMotion, paper,
};

use crate::support::{adaptive, constant_drive, drive, quiet_ramp};

fn run(scenario: &Scenario) -> DriveRun {
    drive(scenario, &paper::light_rover(), Integrator::default())
}

/// Limit, lag and efficiency of the motors, against closed forms.
#[test]
fn motors_are_not_perfect() {
    let torque = |motor: Motor| {
        let mut scenario = constant_drive(50.0, 50.0, 0.2);
        scenario.world.motor = motor;
        run(&scenario).truth
    };
    let nominal = Motor::default();
    let limited = torque(Motor {
        torque_limit: 4.0,
        no_load_speed: 10.0,
        ..nominal
    });
    for i in 0..limited.len() {
        let w = limited.wheel_speed[0][i];
        let expected = (4.0 * (1.0 - w / 10.0)).min(5.0);
        assert!((limited.wheel_torque[0][i] - expected).abs() < 1e-12);
    }
    let slow = torque(Motor {
        lag: 0.05,
        ..nominal
    });
    for (t, found) in slow.time.iter().zip(&slow.wheel_torque[2]) {
        assert!((found - 5.0 * (1.0 - (-t / 0.05).exp())).abs() < 1e-5);
    }
    let geared = torque(Motor {
        efficiency: 0.8,
        ..nominal
    });
    assert!((geared.wheel_torque[1][0] - 4.0).abs() < 1e-9);
    // T - T_c tanh(w/.1) - b w at the wheel, while the current is that of the motor's own torque.
    let rubbing = torque(Motor {
        coulomb: 1.2,
        viscous: 0.3,
        torque_constant: 2.5,
        ..nominal
    });
    let current = rubbing.motor_current.as_ref().unwrap();
    for (i, w) in rubbing.wheel_speed[3].iter().enumerate() {
        let expected = 5.0 - 1.2 * (w / 0.1).tanh() - 0.3 * w;
        assert!((rubbing.wheel_torque[3][i] - expected).abs() < 1e-12);
        assert_eq!(current[3][i], 2.0);
    }
    assert!(geared.motor_current.is_none());
}

/// Gears with play lose torque after a reversal: the wheel turns back later than the log's torque says.
#[test]
fn play_in_the_gears_costs_torque_at_a_reversal() {
    let mut scenario = quiet_ramp("upland_sandy_loam");
    let profile = Profile {
        from: 30.0,
        to: -30.0,
    };
    let mut segment = DriveSegment::new("reversal", 0.4, Command::Torque([profile; 4]));
    segment.start = Some(StartMotion {
        ground_speed: 1.0,
        wheel_speed: [4.5; 4],
    });
    scenario.segments = vec![segment];
    let nominal = run(&scenario).truth;
    scenario.effects = vec![EffectSetting::new("gearbox-backlash", 0.3)];
    let played = run(&scenario).truth;
    assert_eq!(nominal.wheel_torque, played.wheel_torque);
    let last = nominal.len() - 1;
    assert!((played.wheel_speed[0][last] - nominal.wheel_speed[0][last]).abs() > 0.05);
}

/// From 4 rad/s to a stop, or to the same speed in reverse, with motors that are often at their limit.
fn at_the_limit(to: f64, lag: f64) -> Scenario {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.world.motor.torque_limit = 14.0;
    scenario.world.motor.no_load_speed = 8.0;
    scenario.world.motor.lag = lag;
    let speeds = |from: f64, to: f64| Command::WheelSpeed([Profile { from, to }; 4]);
    let mut change = DriveSegment::new("change", 1.0, speeds(4.0, to));
    change.start = Some(StartMotion {
        ground_speed: 0.9,
        wheel_speed: [4.0; 4],
    });
    scenario.segments = vec![change, DriveSegment::new("hold", 1.0, speeds(to, to))];
    scenario
}

/// A controller at the motor's limit and gears with play are smooth enough for both integrators, which share no formula:
/// they end at the same speeds within a thousandth of the sensors' noise.
#[test]
fn limits_and_play_do_not_stop_the_integrators() {
    let mut cases = vec![at_the_limit(0.0, 0.0), at_the_limit(-4.0, 0.1)];
    let mut played = at_the_limit(-4.0, 0.1);
    played.effects = vec![EffectSetting::new("gearbox-backlash", 0.3)];
    cases.push(played);
    for scenario in cases {
        let fixed = drive(&scenario, &paper::light_rover(), Integrator::default()).truth;
        let free = drive(&scenario, &paper::light_rover(), adaptive()).truth;
        let last = fixed.len() - 1;
        let apart = (fixed.ground_speed[last] - free.ground_speed[last]).abs();
        assert!(apart < 2e-5, "{apart:e} m/s");
        for q in 0..4 {
            let limit = fixed.wheel_torque[q].iter().all(|t| t.abs() <= 14.0);
            assert!(limit, "wheel {q}");
        }
    }
}
