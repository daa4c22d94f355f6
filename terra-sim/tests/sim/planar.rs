use terra_sim::integrate::{DormandPrince, Rk4};
use terra_sim::{
    Command, DriveSegment, DriveTruth, EffectSetting, GRAVITY, Integrator, Profile, Scenario,
    SideSlip, StartMotion, paper,
};

use crate::support::{adaptive, constant_drive, drive, quiet_ramp, simpson};

/// Wheel speeds left and right under speed control, from straight motion at 1 m/s.
fn turn(left: f64, right: f64, side_slip: SideSlip) -> Scenario {
    let [l, r] = [left, right].map(|w| Profile { from: 4.0, to: w });
    let mut segment = DriveSegment::new("turn", 0.4, Command::WheelSpeed([l, r, l, r]));
    segment.start = Some(StartMotion {
        ground_speed: 1.0,
        wheel_speed: [4.0; 4],
    });
    let mut scenario = quiet_ramp("upland_sandy_loam");
    scenario.segments = vec![segment];
    scenario.world.side_slip = side_slip;
    scenario
}

fn rk4(step: f64) -> Integrator {
    Integrator::Rk4(Rk4 { step })
}

fn truth(scenario: &Scenario) -> DriveTruth {
    drive(scenario, &paper::light_rover(), Integrator::default()).truth
}

/// Straight on level ground a vehicle that may slide sideways does what a held one does, to the last bit.
#[test]
fn straight_driving_is_the_same_held_and_free() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments[0].duration = 0.3;
    let held = truth(&scenario);
    scenario.world.side_slip = SideSlip::Free;
    let free = truth(&scenario);
    assert_eq!(held, free);
    assert!(held.ground_speed[29] > 0.0 && held.position[0][29] > 0.0);
}

/// Work of the motors = kinetic energy + heat in soil (along and across), bearings and scrub, to 1e-6 of the work; and
/// in the fixed frame m ΔV = ∫ ΣF dt, I Δr = ∫ ΣM dt, to 1e-6 of the impulses' size.
#[test]
fn energy_and_momentum_are_balanced_while_sliding() {
    let mut scenario = turn(3.0, 5.0, SideSlip::Free);
    scenario.segments[0].duration = 0.201;
    scenario.rate = 1000.0;
    let t = drive(&scenario, &paper::light_rover(), adaptive()).truth;
    let last = t.len() - 1;
    assert!(t.yaw_rate[last] > 0.02 && t.lateral_speed[last].abs() > 1e-4);
    let place = |q: usize| {
        (
            if q < 2 { 0.3 } else { -0.3 },
            if q.is_multiple_of(2) { 0.3 } else { -0.3 },
        )
    };
    let kinetic = |i: usize| {
        50.0 * (t.ground_speed[i].powi(2) + t.lateral_speed[i].powi(2))
            + 5.0 * t.yaw_rate[i].powi(2)
            + (0..4)
                .map(|q| 0.125 * t.wheel_speed[q][i].powi(2))
                .sum::<f64>()
    };
    let work = simpson(&t.time, |i| {
        (0..4)
            .map(|q| t.wheel_torque[q][i] * t.wheel_speed[q][i])
            .sum()
    });
    let heat = simpson(&t.time, |i| {
        let wheels: f64 = (0..4)
            .map(|q| {
                let (x, y) = place(q);
                let along = t.ground_speed[i] - y * t.yaw_rate[i];
                let across = t.lateral_speed[i] + x * t.yaw_rate[i];
                let w = t.wheel_speed[q][i];
                t.resistive_torque[q][i] * w + 0.1 * w * w
                    - t.drawbar_pull[q][i] * along
                    - t.lateral_force[q][i] * across
            })
            .sum();
        wheels + 8.0 * t.yaw_rate[i].powi(2)
    });
    let stored = kinetic(last) - kinetic(0);
    let scale = simpson(&t.time, |i| {
        (0..4)
            .map(|q| (t.wheel_torque[q][i] * t.wheel_speed[q][i]).abs())
            .sum()
    });
    assert!(
        (work - stored - heat).abs() < 1e-6 * scale,
        "{work} {stored} {heat}"
    );

    let fixed = |i: usize, a: f64, b: f64| {
        let (sin, cos) = t.heading[i].sin_cos();
        (a * cos - b * sin, a * sin + b * cos)
    };
    let force = |i: usize| {
        let sum = |c: &[Vec<f64>; 4]| (0..4).map(|q| c[q][i]).sum::<f64>();
        fixed(i, sum(&t.drawbar_pull), sum(&t.lateral_force))
    };
    let speed = |i: usize| fixed(i, t.ground_speed[i], t.lateral_speed[i]);
    let size = simpson(&t.time, |i| force(i).0.hypot(force(i).1));
    let (px, py) = (
        simpson(&t.time, |i| force(i).0),
        simpson(&t.time, |i| force(i).1),
    );
    assert!((100.0 * (speed(last).0 - speed(0).0) - px).abs() < 1e-6 * size);
    assert!((100.0 * (speed(last).1 - speed(0).1) - py).abs() < 1e-6 * size);
    let (x, y) = (
        simpson(&t.time, |i| speed(i).0),
        simpson(&t.time, |i| speed(i).1),
    );
    assert!((t.position[0][last] - x).abs() < 1e-8 && (t.position[1][last] - y).abs() < 1e-8);
    let moment = simpson(&t.time, |i| {
        (0..4)
            .map(|q| place(q).0 * t.lateral_force[q][i] - place(q).1 * t.drawbar_pull[q][i])
            .sum::<f64>()
            - 8.0 * t.yaw_rate[i]
    });
    assert!((10.0 * t.yaw_rate[last] - moment).abs() < 1e-6 * 0.3 * size);
}

/// Mirrored left for right: command, side slope, payload. Every number the same or its sign turned, to the last bit.
#[test]
fn sliding_mirrors_left_and_right() {
    let make = |left: f64, right: f64, side: f64| {
        let mut scenario = turn(left, right, SideSlip::Free);
        scenario.segments[0].duration = 0.15;
        scenario.segments[0].roll = Some(0.05 * side);
        scenario.segments[0].payload = Some(10.0);
        scenario.segments[0].payload_at = Some([0.1, 0.1 * side, 0.2]);
        truth(&scenario)
    };
    let (run, mirror) = (make(3.0, 5.0, 1.0), make(5.0, 3.0, -1.0));
    assert_eq!(run.ground_speed, mirror.ground_speed);
    for (a, b) in [
        (&run.yaw_rate, &mirror.yaw_rate),
        (&run.lateral_speed, &mirror.lateral_speed),
        (&run.position[1], &mirror.position[1]),
        (&run.lateral_force[0], &mirror.lateral_force[1]),
        (&run.accel_y, &mirror.accel_y),
    ] {
        assert!(a.iter().zip(b.iter()).all(|(a, b)| *a == -*b));
        assert!(a.last().unwrap().abs() > 1e-5);
    }
    assert_eq!(run.drawbar_pull[2], mirror.drawbar_pull[3]);
    assert_eq!(run.normal_load[0], mirror.normal_load[1]);
}

/// A vehicle that is the same front and rear drives backwards as it drives forwards, seen in a mirror across its path:
/// v, r and torques turn their sign, v_y does not, front and rear change places.
#[test]
fn sliding_in_reverse_is_the_mirror_image() {
    let forward = turn(3.0, 5.0, SideSlip::Free);
    let mut reverse = forward.clone();
    let back = |w: f64| Profile { from: -4.0, to: -w };
    reverse.segments[0].command = Command::WheelSpeed([back(3.0), back(5.0), back(3.0), back(5.0)]);
    reverse.segments[0].start = Some(StartMotion {
        ground_speed: -1.0,
        wheel_speed: [-4.0; 4],
    });
    let (a, b) = (truth(&forward), truth(&reverse));
    let close = |x: f64, y: f64| (x - y).abs() < 1e-9 * (1.0 + x.abs());
    for i in 0..a.len() {
        assert!(close(a.ground_speed[i], -b.ground_speed[i]));
        assert!(close(a.yaw_rate[i], -b.yaw_rate[i]));
        assert!(close(a.lateral_speed[i], b.lateral_speed[i]));
        assert!(close(a.normal_load[0][i], b.normal_load[2][i]));
        assert!(close(a.wheel_torque[1][i], -b.wheel_torque[3][i]));
    }
}

fn distance(a: &DriveTruth, b: &DriveTruth) -> f64 {
    let mut worst: f64 = 0.0;
    let pairs = [
        (&a.ground_speed, &b.ground_speed),
        (&a.lateral_speed, &b.lateral_speed),
        (&a.yaw_rate, &b.yaw_rate),
        (&a.wheel_speed[0], &b.wheel_speed[0]),
        (&a.wheel_speed[3], &b.wheel_speed[3]),
    ];
    for (a, b) in pairs {
        for (x, y) in a.iter().zip(b) {
            worst = worst.max((x - y).abs());
        }
    }
    worst
}

/// Fixed and adaptive steps meet; halving the fixed step divides its error by 2^4.
#[test]
fn steps_agree_while_sliding() {
    let mut scenario = turn(3.5, 4.5, SideSlip::Free);
    scenario.segments[0].duration = 0.2;
    scenario.rate = 25.0;
    // Off the conical point where slip and slip angle vanish together, which costs any method its order.
    scenario.segments[0].start = Some(StartMotion {
        ground_speed: 0.9,
        wheel_speed: [4.2, 4.6, 4.2, 4.6],
    });
    let tight = Integrator::DormandPrince(DormandPrince {
        relative: 1e-10,
        absolute: 1e-10,
        ..DormandPrince::default()
    });
    let at = |integrator| drive(&scenario, &paper::light_rover(), integrator).truth;
    let exact = at(tight);
    let fine = distance(&at(Integrator::default()), &exact);
    assert!(fine < 1e-6, "{fine:.2e}");
    let (coarse, half) = (
        distance(&at(rk4(4e-3)), &exact),
        distance(&at(rk4(2e-3)), &exact),
    );
    let order = (coarse / half).log2();
    assert!(
        (3.6..4.6).contains(&order),
        "{coarse:.2e} {half:.2e} {fine:.2e}"
    );
}

/// Held on hard ground with constant forces: r and ψ as integrals of M_res and I_zz say, a_y = v r, and the loads that
/// balance its moment: m h a_y = (t_w/2)(N_right - N_left).
#[test]
fn a_held_turn_on_constant_forces_has_its_closed_form() {
    let mut turning = constant_drive(-20.0, 20.0, 2.0);
    turning.segments[0].start = Some(StartMotion {
        ground_speed: 3.0,
        wheel_speed: [12.0; 4],
    });
    let t = drive(&turning, &paper::light_rover(), adaptive()).truth;
    let (steady, rate) = (0.3 * 80.0 / 8.0, 8.0 / 10.0);
    for (i, time) in t.time.iter().enumerate() {
        let grown = 1.0 - (-rate * time).exp();
        assert!((t.yaw_rate[i] - steady * grown).abs() < 1e-6);
        assert!((t.heading[i] - steady * (time - grown / rate)).abs() < 1e-6);
        assert!((t.ground_speed[i] - 3.0).abs() < 1e-9);
    }
    let mut scenario = constant_drive(10.0, 30.0, 1.0);
    scenario.segments[0].roll = Some(0.1);
    let t = truth(&scenario);
    for i in 0..t.len() {
        let a = t.ground_speed[i] * t.yaw_rate[i] + GRAVITY * 0.1f64.sin();
        assert!((t.accel_y[i] - a).abs() < 1e-12);
        let w = |q: usize| t.normal_load[q][i];
        let lean = 0.3 * (w(1) + w(3) - w(0) - w(2));
        assert!((lean - 100.0 * 0.22 * a).abs() < 1e-9);
        assert!((w(0) + w(1) + w(2) + w(3) - 100.0 * GRAVITY * 0.1f64.cos()).abs() < 1e-9);
    }
}

/// Of a vehicle that stays upright left and right wheels carry the same, on a slope aside and in a turn, and all of them its weight.
#[test]
fn an_upright_vehicle_leans_on_neither_side() {
    let mut scenario = constant_drive(10.0, 30.0, 1.0);
    scenario.segments[0].roll = Some(0.1);
    scenario.world.upright = true;
    let t = truth(&scenario);
    for i in 0..t.len() {
        let w = |q: usize| t.normal_load[q][i];
        assert_eq!([w(0), w(2)], [w(1), w(3)]);
        assert!((w(0) + w(1) + w(2) + w(3) - 100.0 * GRAVITY * 0.1f64.cos()).abs() < 1e-9);
    }
}

/// Payload off the centre: loads by the balance of moments about both axles and the middle.
#[test]
fn payload_off_the_centre_loads_its_corner() {
    let mut scenario = constant_drive(0.0, 0.0, 0.05);
    scenario.segments[0].payload = Some(20.0);
    scenario.segments[0].payload_at = Some([0.15, -0.2, 0.3]);
    let t = truth(&scenario);
    let w = |q: usize| t.normal_load[q][0];
    let total = 120.0 * GRAVITY;
    assert!((w(0) + w(1) + w(2) + w(3) - total).abs() < 1e-9);
    // About the rear axle: 100 g at .3 m, 20 g at .45 m.
    assert!((0.6 * (w(0) + w(1)) - GRAVITY * (100.0 * 0.3 + 20.0 * 0.45)).abs() < 1e-9);
    // About the middle line: 20 g at .2 m to the right.
    assert!((0.3 * (w(1) + w(3) - w(0) - w(2)) - GRAVITY * 20.0 * 0.2).abs() < 1e-9);
}

/// On a side slope a driving vehicle slides downhill until the soil holds it; a held one does not.
#[test]
fn a_side_slope_makes_a_free_vehicle_crab() {
    let mut scenario = turn(4.0, 4.0, SideSlip::Free);
    scenario.segments[0].duration = 1.0;
    scenario.segments[0].roll = Some(0.15);
    let free = truth(&scenario);
    let last = free.len() - 1;
    assert!(
        free.lateral_speed[last] < -1e-3,
        "left side up: to the right"
    );
    let held: f64 = (0..4).map(|q| free.lateral_force[q][last]).sum();
    let pull = 100.0 * GRAVITY * 0.15f64.sin();
    assert!((held - pull).abs() < 0.05 * pull, "{held} {pull}");
    scenario.world.side_slip = SideSlip::Held;
    assert!(truth(&scenario).lateral_speed.iter().all(|v| *v == 0.0));
}

/// The two effects of turning leave a moment against the turn: less yaw for the same wheel speeds.
#[test]
fn effects_of_turning_slow_the_turn() {
    let yaw = |effect: Option<(&str, f64)>| {
        let mut scenario = turn(3.0, 5.0, SideSlip::Held);
        scenario.effects = effect
            .iter()
            .map(|(n, e)| EffectSetting::new(*n, *e))
            .collect();
        *truth(&scenario).yaw_rate.last().unwrap()
    };
    let nominal = yaw(None);
    for effect in [
        ("skid-steer-lateral-slip", 1.0),
        ("lateral-bulldozing", 3.0),
    ] {
        let found = yaw(Some(effect));
        assert!(
            found > 0.0 && found < nominal - 1e-4,
            "{effect:?}: {found} {nominal}"
        );
    }
    let free = *truth(&turn(3.0, 5.0, SideSlip::Free))
        .yaw_rate
        .last()
        .unwrap();
    assert!(free > 0.0 && free < nominal);
}

/// Turning in place, then stopping, then standing on a side slope: no rule breaks down, wheels that are dragged against
/// their turning are flagged.
#[test]
fn turns_in_place_stops_and_stands() {
    let mut scenario = turn(-2.0, 2.0, SideSlip::Free);
    scenario.segments[0].start = None;
    let go = |name: &str, left: [f64; 2], right: [f64; 2]| {
        let p = |[from, to]: [f64; 2]| Profile { from, to };
        DriveSegment::new(
            name,
            0.5,
            Command::WheelSpeed([p(left), p(right), p(left), p(right)]),
        )
    };
    scenario.segments = vec![
        go("spin", [0.0, -3.0], [0.0, 3.0]),
        go("stop", [-3.0, 0.0], [3.0, 0.0]),
        go("one side only", [0.0, 0.5], [0.0, 4.0]),
    ];
    scenario.rate = 50.0;
    let t = truth(&scenario);
    let peak = t.yaw_rate.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    assert!(peak > 0.3, "{peak}");
    assert!(t.yaw_rate[49].abs() < 0.3 * peak);
    assert!(t.standstill.iter().any(|s| *s));
    assert!(t.ground_speed.iter().all(|v| v.is_finite()));
}
