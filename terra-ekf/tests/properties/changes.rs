//! Forces that change at once, as where one soil ends and another begins, against sensors that only seem to say so.

use terra_ekf::spaces::longitudinal_robot::{F, LongitudinalRobot, T};
use terra_ekf::{FILTERS, Flag, ForceConfig, RobotLog, Step, estimate_forces};

use crate::common::{normal, rng};

const ROWS: usize = 200;
/// Row from which the second soil bears the robot.
const CHANGE: usize = 100;
const DT: f64 = 0.01;
/// Mass, inertia and damping of the light robot.
const MASS: f64 = 100.0;
const INERTIA: f64 = 0.25;
const DAMPING: f64 = 0.1;

type Channels = [Vec<Option<f64>>; 7];

/// A robot that rolls at 1 m/s on forces that balance, then is pushed by `push` in all while each wheel is resisted by
/// `drag` more: v' = push/m, w' = -drag/I_w. Sensor noise as the filter believes. Returns torques and readings.
fn drive(push: f64, drag: f64, seed: u64) -> (Vec<Option<f64>>, Channels) {
    let mut rng = rng(seed, 0);
    let (mut v, mut w) = (1.0, 6.0);
    let mut z: Channels = Default::default();
    for k in 0..ROWS {
        let after = k >= CHANGE;
        let a = if after { push / MASS } else { 0.0 };
        let clean = [a, w, w, w, w, v, 0.0];
        let sd = [0.05, 0.05, 0.05, 0.05, 0.05, 0.02, 0.005];
        let noise = normal(&mut rng, 7);
        for (i, z) in z.iter_mut().enumerate() {
            z.push(Some(clean[i] + sd[i] * noise[i]));
        }
        if k + 1 >= CHANGE {
            v += DT * push / MASS;
            w -= DT * drag / INERTIA;
        }
    }
    // 10 N m of resistance and what the bearings take. The wheel slows down under the same torque.
    (vec![Some(10.0 + DAMPING * 6.0); ROWS], z)
}

fn run(torque: &[Option<f64>], z: &Channels, filter: &str) -> Vec<Step> {
    let time: Vec<f64> = (0..ROWS).map(|k| DT * k as f64).collect();
    let config = ForceConfig {
        filter: filter.to_owned(),
        ..ForceConfig::new(LongitudinalRobot::light().unwrap())
    };
    let rows = 0..ROWS;
    let log = RobotLog {
        time: &time,
        segments: &[rows],
        torque: [torque; 4],
        channels: z.each_ref().map(Vec::as_slice),
        pitch: &[],
        payload: &[],
    };
    estimate_forces(&log, &config).unwrap()
}

fn push(step: &Step) -> f64 {
    step.belief.mean[F[0]] + step.belief.mean[F[1]]
}

fn resets(steps: &[Step]) -> usize {
    let reset = |s: &&Step| matches!(s.flag, Flag::Reset(_));
    steps.iter().filter(reset).count()
}

/// 50 N to 300 N of push, up or down: a quarter of a second later the force is no more than 20 N off, and stays so. At
/// 1 m/s² the speed needs .06 s to move by three times its noise, so that it bears witness. A channel that waited for its
/// timeout would take .6 s.
#[test]
fn a_force_that_changes_at_once_is_followed_at_once() {
    for (case, size) in [50.0, 100.0, 200.0, 300.0, -50.0, -100.0, -200.0]
        .into_iter()
        .enumerate()
    {
        for seed in 0..4 {
            let (torque, z) = drive(size, 0.5, 100 * case as u64 + seed);
            let steps = run(&torque, &z, "block");
            for step in &steps[CHANGE + 25..CHANGE + 60] {
                let off = push(step) - size;
                assert!(
                    off.abs() < 20.0,
                    "{size} N, draw {seed}, {}: {off}",
                    step.row
                );
            }
            assert_eq!(resets(&steps[..CHANGE]), 0);
        }
    }
}

/// All four wheels are resisted by 8 N m more from one row to the next.
#[test]
fn a_resistance_that_changes_at_once_is_followed_at_once() {
    for seed in 0..4 {
        let (torque, z) = drive(0.0, 8.0, seed);
        let steps = run(&torque, &z, "block");
        for step in &steps[CHANGE + 15..CHANGE + 25] {
            for state in T {
                let off = step.belief.mean[state] - 18.0;
                assert!(off.abs() < 3.0, "draw {seed}, {}: {off}", step.row);
            }
        }
    }
}

/// An accelerometer that is off by as much for .3 s says the same of itself, but the speed does not: no reset, and the
/// force follows by less than a fifth.
#[test]
fn an_accelerometer_that_is_off_alone_is_not_believed() {
    for off in [2.0, -2.0, 4.0] {
        for seed in 0..4 {
            let (torque, mut z) = drive(0.0, 0.0, 50 + seed);
            for z in &mut z[0][CHANGE..CHANGE + 30] {
                *z = z.map(|z| z + off);
            }
            let steps = run(&torque, &z, "block");
            assert_eq!(resets(&steps[..CHANGE + 30]), 0, "{off}, draw {seed}");
            for step in &steps[CHANGE + 12..] {
                assert!(push(step).abs() < 0.2 * MASS * 2.0, "{off}: {}", push(step));
            }
        }
    }
}

/// The rule is the same in all filters by name.
#[test]
fn all_filters_follow_alike() {
    let (torque, z) = drive(200.0, 8.0, 7);
    let reference = run(&torque, &z, "block");
    assert!(resets(&reference) > 0);
    for entry in FILTERS {
        let steps = run(&torque, &z, entry.name);
        for (a, b) in reference.iter().zip(&steps) {
            assert_eq!(a.flag, b.flag, "{} at {}", entry.name, a.row);
            let sd = a.belief.sd(F[0]).unwrap();
            let off = (a.belief.mean[F[0]] - b.belief.mean[F[0]]).abs();
            assert!(
                off < 1e-6 * sd.max(1.0),
                "{} at {}: {off}",
                entry.name,
                a.row
            );
        }
    }
}
