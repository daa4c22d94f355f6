use terra_sim::integrate::{DormandPrince, Rk4};
use terra_sim::{DriveTruth, EffectSetting, GRAVITY, Integrator, paper};

use crate::support::{adaptive, constant_drive, drive, quiet_ramp};

/// Constant force: v = F t/m, x = F t²/(2 m), a = F/m; wheels: I_w ω' = T - T_r - b_w ω.
#[test]
fn constant_force_gives_uniform_acceleration() {
    let run = drive(
        &constant_drive(50.0, 50.0, 1.0),
        &paper::light_rover(),
        Integrator::default(),
    );
    for (i, t) in run.truth.time.iter().enumerate() {
        let a = 200.0 / 100.0;
        assert!((run.truth.ground_speed[i] - a * t).abs() < 1e-12);
        assert!((run.truth.distance[i] - 0.5 * a * t * t).abs() < 1e-12);
        assert!((run.truth.accel_x[i] - a).abs() < 1e-12);
        let (steady, rate) = ((5.0 - 3.0) / 0.1, 0.1 / 0.25);
        let w = steady + (1.0 - steady) * (-rate * t).exp();
        assert!((run.truth.wheel_speed[3][i] - w).abs() < 1e-10);
        assert_eq!(run.truth.yaw_rate[i], 0.0);
    }
}

/// Unequal sides: r = (t_w/2)(F_right - F_left)/M_res (1 - e^(-M_res t/I_zz)).
#[test]
fn unequal_sides_turn_the_vehicle() {
    let run = drive(
        &constant_drive(40.0, 60.0, 3.0),
        &paper::light_rover(),
        Integrator::default(),
    );
    let steady = 0.3 * (120.0 - 80.0) / 8.0;
    for (i, t) in run.truth.time.iter().enumerate() {
        let r = steady * (1.0 - (-8.0 / 10.0 * t).exp());
        assert!(
            (run.truth.yaw_rate[i] - r).abs() < 1e-10,
            "{t}: {} {r}",
            run.truth.yaw_rate[i]
        );
    }
}

/// On a slope v' = F/m - g sin(pitch) while the accelerometer reads F/m; static loads by cos(pitch) and moments.
#[test]
fn slope_tow_and_payload_enter_where_they_belong() {
    let mut scenario = constant_drive(100.0, 100.0, 0.5);
    let pitch = 0.1f64;
    scenario.segments[0].pitch = Some(pitch);
    scenario.segments[0].payload = Some(25.0);
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    let a = 400.0 / 125.0;
    let last = run.truth.len() - 1;
    let t = run.truth.time[last];
    assert!((run.truth.accel_x[last] - a).abs() < 1e-10);
    assert!((run.truth.ground_speed[last] - (a - GRAVITY * pitch.sin()) * t).abs() < 1e-10);
    let total: f64 = (0..4).map(|q| run.truth.normal_load[q][last]).sum();
    assert!((total - 125.0 * GRAVITY * pitch.cos()).abs() < 1e-9);
    let rear_minus_front = run.truth.normal_load[2][last] - run.truth.normal_load[0][last];
    assert!((rear_minus_front - 125.0 * 0.22 * a / 0.6).abs() < 1e-7);
    assert_eq!(run.log.pitch.unwrap().get(3), Some(pitch));
    assert_eq!(run.log.payload.unwrap().get(3), Some(25.0));

    scenario.segments[0].tow_load = 30.0;
    let towed = drive(&scenario, &paper::light_rover(), adaptive());
    assert!(
        (towed.truth.accel_x[last] - (400.0 - 30.0) / 125.0).abs() < 1e-6,
        "beyond .05 m/s the tow is full"
    );
}

/// A vehicle at rest without torque stays at rest on level ground and reads no specific force.
#[test]
fn rest_is_rest() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments[0].duration = 0.2;
    scenario.segments[0].start = None;
    scenario.segments[0].command =
        terra_sim::Command::Torque([terra_sim::Profile::constant(0.0); 4]);
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    assert!(
        run.truth
            .ground_speed
            .iter()
            .chain(&run.truth.accel_x)
            .all(|v| *v == 0.0)
    );
    assert!(run.truth.standstill.iter().all(|s| *s));
}

fn distance(a: &DriveTruth, b: &DriveTruth) -> f64 {
    let mut worst: f64 = 0.0;
    for i in 0..a.len() {
        worst = worst.max((a.ground_speed[i] - b.ground_speed[i]).abs());
        for q in 0..4 {
            worst = worst.max((a.wheel_speed[q][i] - b.wheel_speed[q][i]).abs());
        }
    }
    worst
}

/// Halving the step of RK4 divides the error by 2^4 on the smooth part of the motion.
#[test]
fn rk4_has_order_four_on_the_robot() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments[0].start = Some(terra_sim::StartMotion {
        ground_speed: 1.0,
        wheel_speed: [6.0; 4],
    });
    scenario.segments[0].duration = 0.4;
    scenario.rate = 25.0;
    let at = |step: f64| {
        drive(
            &scenario,
            &paper::light_rover(),
            Integrator::Rk4(Rk4 { step }),
        )
        .truth
    };
    let fine = at(0.00125);
    let (coarse, half) = (distance(&at(0.02), &fine), distance(&at(0.01), &fine));
    let order = (coarse / half).log2();
    assert!(
        (3.6..4.6).contains(&order),
        "order {order}: {coarse:.2e} {half:.2e}"
    );
}

/// On smooth motion to 1e-6. At the start of the ramp load transfer stalls the rear wheels for a moment, and the
/// standstill rules have kinks there, which cost a fixed step its order: 5e-5, a thousandth of the sensors' noise.
#[test]
fn both_integrators_agree() {
    let tight = DormandPrince {
        relative: 1e-10,
        absolute: 1e-10,
        ..DormandPrince::default()
    };
    for terrain in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
        let mut scenario = quiet_ramp(terrain);
        let compare = |scenario: &terra_sim::Scenario| {
            let fixed = drive(scenario, &paper::light_rover(), Integrator::default());
            let free = drive(
                scenario,
                &paper::light_rover(),
                Integrator::DormandPrince(tight),
            );
            distance(&fixed.truth, &free.truth)
        };
        let ramp = compare(&scenario);
        scenario.segments[0].start = Some(terra_sim::StartMotion {
            ground_speed: 1.0,
            wheel_speed: [6.0; 4],
        });
        let smooth = compare(&scenario);
        assert!(
            smooth < 1e-6 && ramp < 5e-5,
            "{terrain}: {smooth:.2e} {ramp:.2e}"
        );
    }
}

/// Soils swapped left for right mirror the run to the last bit.
#[test]
fn left_and_right_are_mirror_images() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments[0].duration = 0.3;
    scenario.right = terra_data::Start::Id("sandy_loam_15".to_owned());
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    std::mem::swap(&mut scenario.left, &mut scenario.right);
    let mirror = drive(&scenario, &paper::light_rover(), Integrator::default());
    assert_eq!(run.truth.ground_speed, mirror.truth.ground_speed);
    for (a, b) in run.truth.yaw_rate.iter().zip(&mirror.truth.yaw_rate) {
        assert_eq!(*a, -*b);
    }
    assert!(run.truth.yaw_rate.last().unwrap().abs() > 1e-3);
    assert_eq!(run.truth.drawbar_pull[0], mirror.truth.drawbar_pull[1]);
    assert_eq!(
        run.truth.resistive_torque[3],
        mirror.truth.resistive_torque[2]
    );
}

/// The speed controller reaches its reference, forward and in reverse, and the wheel leads in reverse as well.
#[test]
fn wheel_speed_control_tracks_forward_and_reverse() {
    use terra_sim::{Command, DriveSegment, Profile};
    let mut scenario = quiet_ramp("upland_sandy_loam");
    let go = |name: &str, w: f64, seconds: f64| {
        DriveSegment::new(
            name,
            seconds,
            Command::WheelSpeed([Profile::constant(w); 4]),
        )
    };
    let ramp = |name: &str, from: f64, to: f64| {
        DriveSegment::new(name, 1.0, Command::WheelSpeed([Profile { from, to }; 4]))
    };
    scenario.segments = vec![
        ramp("up", 0.0, 2.0),
        go("on", 2.0, 1.5),
        ramp("down", 2.0, -2.0),
        go("back", -2.0, 1.5),
    ];
    scenario.rate = 20.0;
    let run = drive(&scenario, &paper::light_rover(), adaptive());
    let end_of = |s: usize| run.truth.segments[s].rows.end - 1;
    assert!((run.truth.wheel_speed[0][end_of(1)] - 2.0).abs() < 2e-3);
    assert!((run.truth.wheel_speed[2][end_of(3)] + 2.0).abs() < 2e-3);
    // Self-propelled on this soil: slip .0054 (D = 0).
    assert!(
        (run.truth.slip[0][end_of(1)] - 0.0054).abs() < 5e-4,
        "{}",
        run.truth.slip[0][end_of(1)]
    );
    assert!(
        (run.truth.slip[0][end_of(3)] - 0.0054).abs() < 5e-4,
        "{}",
        run.truth.slip[0][end_of(3)]
    );
    assert!(run.truth.ground_speed[end_of(3)] < -0.5);
}

#[test]
fn delay_and_reset_keep_time_running() {
    let mut scenario = constant_drive(50.0, 50.0, 0.2);
    let mut again = scenario.segments[0].clone();
    again.reset = true;
    again.name = "again".to_owned();
    scenario.segments.push(again);
    scenario
        .effects
        .push(EffectSetting::new("ground-speed-delay", 0.05));
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    let v = run.log.ground_speed.unwrap();
    // v = 2 t, late by .05 s; before the start the sensor shows the start.
    for (i, t) in run.truth.time.iter().enumerate() {
        let since = if i < 20 { *t } else { t - 0.2 };
        assert!(
            (v.get(i).unwrap() - 2.0 * (since - 0.05).max(0.0)).abs() < 1e-9,
            "{i} {t}"
        );
    }
    assert_eq!(run.truth.distance[20], 0.0);
    assert_eq!(run.log.segments[1].rows, 20..40);
}

/// v = 2 t behind a filter of .05 s: v_reported = 2 (t - .05 (1 - exp(-t/.05))), which begins anew with a reset.
#[test]
fn a_filter_follows_and_a_reset_settles_it() {
    let mut scenario = constant_drive(50.0, 50.0, 0.2);
    let mut again = scenario.segments[0].clone();
    again.reset = true;
    again.name = "again".to_owned();
    scenario.segments.push(again);
    scenario.effects.push(EffectSetting {
        form: Some("first-order".to_owned()),
        ..EffectSetting::new("ground-speed-delay", 0.05)
    });
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    let v = run.log.ground_speed.unwrap();
    for (i, t) in run.truth.time.iter().enumerate() {
        let since = if i < 20 { *t } else { t - 0.2 };
        let expected = 2.0 * (since - 0.05 * (1.0 - (-since / 0.05).exp()));
        assert!((v.get(i).unwrap() - expected).abs() < 1e-9, "{i} {t}");
    }
}

/// With its centre of mass 2 m up and .3 m behind the front axle, a pull of 4 m/s² and more lifts the front wheels:
/// g l_r = 2.9 m²/s² against h a = 8 m²/s².
#[test]
fn a_wheel_that_lifts_is_a_typed_error() {
    let mut rover = paper::light_rover();
    let vehicle = rover.vehicle.unwrap();
    rover.vehicle = Some(terra_data::VehicleData {
        cg_height: 2.0,
        ..vehicle
    });
    let result = terra_sim::simulate_drive(
        &constant_drive(200.0, 200.0, 0.1),
        &rover,
        &crate::support::registry(),
    );
    match result {
        Err(terra_sim::SimError::WheelLift { wheel, load, .. }) => assert!(wheel < 2 && load < 0.0),
        other => panic!("{:?}", other.map(|r| r.truth.len())),
    }
}

#[test]
fn a_step_that_is_no_step_is_refused() {
    for step in [0.0, -1e-3, f64::NAN] {
        let result = terra_sim::simulate_drive_with(
            &quiet_ramp("dry_sand"),
            &paper::light_rover(),
            &crate::support::registry(),
            Integrator::Rk4(Rk4 { step }),
        );
        assert!(matches!(result, Err(terra_sim::SimError::Value { .. })));
    }
}
