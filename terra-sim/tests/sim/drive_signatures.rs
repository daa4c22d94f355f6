//! What each effect that only a drive can show does to the log of a drive: its equation where the motion has a closed
//! form, its direction and the channels it leaves alone where it has not.

use terra_sim::{
    Command, DriveRun, DriveSegment, EffectSetting, Profile, Scenario, StartMotion, paper,
};

use crate::support::{adaptive, constant_drive, drive, quiet_ramp};

const MASS: f64 = 100.0;
const GRAVITY: f64 = 9.81;
const LENGTH: f64 = 0.6;

fn run(base: &Scenario, effects: &[(&str, f64)]) -> DriveRun {
    let mut scenario = base.clone();
    scenario.effects = effects
        .iter()
        .map(|(n, e)| EffectSetting::new(*n, *e))
        .collect();
    drive(&scenario, &paper::light_rover(), adaptive())
}

/// Wheel speeds of the left and the right side, held; from motion at .9 m/s.
fn held(left: [f64; 2], right: [f64; 2]) -> Scenario {
    let [l, r] = [left, right].map(|[from, to]| Profile { from, to });
    let mut segment = DriveSegment::new("run", 0.4, Command::WheelSpeed([l, r, l, r]));
    segment.start = Some(StartMotion {
        ground_speed: 0.9,
        wheel_speed: [left[0], right[0], left[0], right[0]],
    });
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments = vec![segment];
    scenario
}

fn straight() -> Scenario {
    held([4.0, 5.5], [4.0, 5.5])
}

fn turn() -> Scenario {
    held([4.0, 3.6], [4.0, 5.2])
}

fn torque(run: &DriveRun, wheel: usize) -> Vec<f64> {
    let series = &run.log.wheel_torque.as_ref().unwrap()[wheel];
    series.iter().map(Option::unwrap).collect()
}

fn speed(run: &DriveRun) -> Vec<f64> {
    let series = run.log.ground_speed.as_ref().unwrap();
    series.iter().map(Option::unwrap).collect()
}

fn accel(run: &DriveRun) -> Vec<f64> {
    let series = run.log.accel_x.as_ref().unwrap();
    series.iter().map(Option::unwrap).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() < tolerance, "{a} {b}");
}

/// A constant pull F a wheel: m v' = 4 F - e for a tow load, so v falls behind by e t/m, and the accelerometer with it;
/// uphill v falls behind by g sin e t, and the accelerometer, which reads specific force, does not.
#[test]
fn tow_and_slope_have_their_closed_forms() {
    let mut base = constant_drive(20.0, 20.0, 0.5);
    base.segments[0].start.as_mut().unwrap().ground_speed = 1.0;
    let (plain, towed, uphill) = (
        run(&base, &[]),
        run(&base, &[("tow-load", 40.0)]),
        run(&base, &[("slope", 0.03)]),
    );
    for (i, t) in plain.truth.time.iter().enumerate() {
        let lag = |other: &DriveRun| speed(&plain)[i] - speed(other)[i];
        close(lag(&towed), 40.0 / MASS * t, 1e-9);
        close(lag(&uphill), GRAVITY * 0.03f64.sin() * t, 1e-9);
        close(accel(&plain)[i] - accel(&towed)[i], 40.0 / MASS, 1e-9);
        close(accel(&plain)[i], accel(&uphill)[i], 1e-9);
    }
}

/// m v' = 4 F - e v²: v = V tanh(t 4F/(m V)) with V² = 4 F/e, from rest.
#[test]
fn drag_has_its_closed_form() {
    let base = constant_drive(20.0, 20.0, 1.0);
    let dragged = run(&base, &[("aero-drag", 80.0)]);
    let top = 1.0f64;
    for (t, v) in dragged.truth.time.iter().zip(speed(&dragged)) {
        close(v, top * (t * 80.0 / (MASS * top)).tanh(), 1e-6);
    }
}

/// I w' = T - T_r - b w - e tanh(w/.1) - e' w at a constant torque T on ground that resists with T_r: w nears its end by
/// exp(-(b + e') t/I). The ground never feels it: v is the same.
#[test]
fn drivetrain_friction_has_its_closed_form() {
    let (inertia, damping, torque, resistance) = (0.25, 0.1, 5.0, 3.0);
    let base = constant_drive(20.0, 20.0, 0.5);
    let plain = run(&base, &[]);
    for (name, e, [coulomb, viscous]) in [
        ("drivetrain-coulomb-friction", 1.5, [1.5, 0.0]),
        ("drivetrain-viscous-friction", 0.8, [0.0, 0.8]),
    ] {
        let slowed = run(&base, &[(name, e)]);
        let b = damping + viscous;
        let end = (torque - resistance - coulomb) / b;
        for (i, t) in slowed.truth.time.iter().enumerate() {
            let w = end + (1.0 - end) * (-b * t / inertia).exp();
            close(slowed.truth.wheel_speed[2][i], w, 1e-6);
        }
        for (a, b) in speed(&plain).iter().zip(speed(&slowed)) {
            close(*a, b, 1e-12);
        }
    }
}

/// A drooping torque sensor reads T (1 + e (T/60)²), and nothing else is touched.
#[test]
fn droop_is_in_the_torque_that_is_read() {
    let droop = run(&straight(), &[("torque-droop", 0.25)]);
    for q in 0..4 {
        for (read, t) in torque(&droop, q).iter().zip(&droop.truth.wheel_torque[q]) {
            close(*read, t * (1.0 + 0.25 * (t / 60.0).powi(2)), 1e-9);
        }
    }
    for (a, b) in speed(&droop).iter().zip(speed(&run(&straight(), &[]))) {
        close(*a, b, 1e-7);
    }
}

/// v + e; and v as it was e earlier, once the log is as old as that.
#[test]
fn ground_speed_errors_have_their_formula() {
    let base = straight();
    let plain = run(&base, &[]);
    let biased = run(&base, &[("ground-speed-bias", 0.05)]);
    let late = run(&base, &[("ground-speed-delay", 0.1)]);
    let v = speed(&plain);
    for (i, v) in v.iter().enumerate() {
        close(speed(&biased)[i], v + 0.05, 1e-9);
    }
    // Logged at 100 Hz, so .1 s is ten rows.
    for i in 11..v.len() {
        close(speed(&late)[i], v[i - 10], 1e-3);
    }
    close(torque(&late, 0)[30], torque(&plain, 0)[30], 1e-9);
}

/// k e^(e x/8 m) with x the path: nothing at the start, more the farther.
#[test]
fn drift_grows_with_the_path() {
    let mut base = straight();
    base.segments[0].duration = 2.0;
    let (plain, drift) = (run(&base, &[]), run(&base, &[("terrain-drift", 0.4)]));
    let change: Vec<f64> = torque(&plain, 0)
        .iter()
        .zip(torque(&drift, 0))
        .map(|(a, b)| (b - a).abs())
        .collect();
    close(change[0], 0.0, 1e-6);
    let n = change.len();
    assert!(change[n - 1] > 2.0 * change[n / 3], "{change:?}");
    // Sinkage goes as k to a negative power: stiffer ground, less of it.
    let z = |r: &DriveRun| *r.truth.sinkage.as_ref().unwrap()[0].last().unwrap();
    assert!(z(&drift) < z(&plain));
}

/// The right side is the stiffer: its wheels sink less, those of the left more, and the vehicle turns where both sides
/// are driven alike. Nothing of that under no contrast.
#[test]
fn contrast_is_left_against_right() {
    let base = straight();
    let (plain, contrast) = (run(&base, &[]), run(&base, &[("lateral-contrast", 0.5)]));
    let z = |r: &DriveRun, q: usize| mean(&r.truth.sinkage.as_ref().unwrap()[q]);
    for (left, right) in [(0, 1), (2, 3)] {
        assert!(z(&contrast, left) > z(&plain, left));
        assert!(z(&contrast, right) < z(&plain, right));
    }
    assert!(plain.truth.yaw_rate.iter().all(|r| *r == 0.0));
    assert!(contrast.truth.yaw_rate.last().unwrap().abs() > 1e-3);
    // In a mirror it is the other way round.
    let mirrored = run(&base, &[("lateral-contrast", -0.5)]);
    for (a, b) in contrast.truth.yaw_rate.iter().zip(&mirrored.truth.yaw_rate) {
        close(*a, -b, 1e-7);
    }
}

/// What acts sideways holds a turn back, and a straight run not at all.
#[test]
fn sideways_effects_hold_turns_back() {
    let (straight, turn) = (straight(), turn());
    let yaw = |r: &DriveRun| *r.truth.yaw_rate.last().unwrap();
    let plain = yaw(&run(&turn, &[]));
    assert!(plain > 0.05);
    for (name, e) in [
        ("lateral-bulldozing", 1.5),
        ("skid-steer-lateral-slip", 0.5),
    ] {
        let held_back = yaw(&run(&turn, &[(name, e)]));
        assert!(held_back > 0.0 && held_back < plain, "{name}: {held_back}");
        let (a, b) = (run(&straight, &[]), run(&straight, &[(name, e)]));
        for (a, b) in torque(&a, 0).iter().zip(torque(&b, 0)) {
            close(*a, b, 1e-5);
        }
    }
    // Thrust is shared with the side: less pull, D down.
    let pull = |r: &DriveRun| (0..4).map(|q| mean(&r.truth.drawbar_pull[q])).sum::<f64>();
    assert!(pull(&run(&turn, &[("skid-steer-lateral-slip", 0.5)])) < pull(&run(&turn, &[])));
}

/// The same wheels on a wider track: at a yaw rate r their ground speeds are v ± r tw/2, so each side's slip says tw;
/// straight ahead it says nothing.
#[test]
fn track_shows_in_turns_alone() {
    let (plain, wide) = (
        run(&turn(), &[]),
        run(&turn(), &[("track-width-error", 0.05)]),
    );
    for (run, track) in [(&plain, 0.6), (&wide, 0.63)] {
        let t = &run.truth;
        for i in 5..t.time.len() {
            for (q, side) in [(0, -1.0), (1, 1.0)] {
                // Slip s = 1 - v/(R w) of a driven wheel, s = R w/v - 1 of a braked one.
                let along = t.ground_speed[i] + side * t.yaw_rate[i] * track / 2.0;
                let rolled = 0.254 * t.wheel_speed[q][i];
                let slip = if rolled >= along {
                    1.0 - along / rolled
                } else {
                    rolled / along - 1.0
                };
                close(t.slip[q][i], slip, 1e-9);
            }
        }
    }
    let (a, b) = (
        run(&straight(), &[]),
        run(&straight(), &[("track-width-error", 0.05)]),
    );
    assert_eq!(torque(&a, 0), torque(&b, 0));
    assert_eq!(speed(&a), speed(&b));
}

/// N_front = m g (1/2 + e) - m a h/L, in total what the vehicle weighs; m (1 + e) presses and accelerates.
#[test]
fn centre_of_mass_and_mass_are_loads() {
    let base = straight();
    let (plain, forward, heavy) = (
        run(&base, &[]),
        run(&base, &[("cg-offset", 0.08)]),
        run(&base, &[("mass-error", 0.12)]),
    );
    let weight = MASS * GRAVITY;
    let axle = |r: &DriveRun, q: usize, i: usize| {
        r.truth.normal_load[q][i] + r.truth.normal_load[q + 1][i]
    };
    for i in 0..plain.truth.time.len() {
        let shifted = axle(&forward, 0, i);
        let transfer = MASS * forward.truth.accel_x[i] * 0.22 / LENGTH;
        close(shifted, weight * 0.58 - transfer, 1e-6 * weight);
        close(shifted + axle(&forward, 2, i), weight, 1e-6);
        close(axle(&heavy, 0, i) + axle(&heavy, 2, i), 1.12 * weight, 1e-6);
    }
    // The heavier axle sinks more and needs more torque.
    assert!(mean(&torque(&forward, 0)) > mean(&torque(&plain, 0)));
    assert!(mean(&torque(&forward, 2)) < mean(&torque(&plain, 2)));
    assert!(mean(&torque(&heavy, 0)) > mean(&torque(&plain, 0)));
}

/// s = 1 - v/(R (1 + e) w): at one v and w a larger wheel slips more, and at small slip it drives on faster.
#[test]
fn a_larger_wheel_slips_more_at_first_and_drives_faster() {
    let (plain, larger) = (
        run(&straight(), &[]),
        run(&straight(), &[("wheel-radius-error", 0.04)]),
    );
    close(plain.truth.slip[0][0], 1.0 - 0.9 / (0.254 * 4.0), 1e-12);
    close(
        larger.truth.slip[0][0],
        1.0 - 0.9 / (0.254 * 1.04 * 4.0),
        1e-12,
    );
    assert!(speed(&larger).last() > speed(&plain).last());
}

/// k (|v|/1 m/s)^e: at one slip, nothing at 1 m/s, stiffer above, softer below; the sinkage follows.
#[test]
fn rate_stiffening_turns_at_a_metre_a_second() {
    let sinkage = |v: f64, effects: &[(&str, f64)]| {
        let w = v / (0.254 * 0.9);
        let mut base = held([w, w], [w, w]);
        base.segments[0].start.as_mut().unwrap().ground_speed = v;
        run(&base, effects).truth.sinkage.unwrap()[0][0]
    };
    let e = [("rate-stiffening", 0.35)];
    let nominal = sinkage(1.0, &[]);
    close(sinkage(1.0, &e), nominal, 1e-7);
    close(sinkage(0.5, &[]), nominal, 1e-9);
    assert!(sinkage(0.5, &e) > nominal + 1e-4);
    assert!(sinkage(2.0, &e) < nominal - 1e-4);
}
