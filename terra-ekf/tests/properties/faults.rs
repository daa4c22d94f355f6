//! Torques that go missing, readings no robot has, stuck sensors, payload and slope, clocks out of order, swapped sides.

use terra_ekf::spaces::longitudinal_robot::{F, LongitudinalRobot, T, V};
use terra_ekf::{
    Dropped, FILTERS, FilterConfig, FilterError, Flag, ForceConfig, InputState, Measurement,
    RobotLog, Robust, Step, Tally, TorqueTally, estimate_forces, rejected, wheel_estimates,
};

use crate::common::{Truth, distance, filter, input, rng, robot};
use crate::driving::{Drive, drive, sensors};

/// A log that can be spoiled.
#[derive(Clone)]
struct Log {
    time: Vec<f64>,
    torque: [Vec<Option<f64>>; 4],
    z: [Vec<Option<f64>>; 7],
    pitch: Vec<Option<f64>>,
    payload: Vec<Option<f64>>,
}

impl Log {
    fn run(&self, config: &ForceConfig) -> Result<Vec<Step>, FilterError> {
        let rows = 0..self.time.len();
        estimate_forces(
            &RobotLog {
                time: &self.time,
                segments: &[rows],
                torque: self.torque.each_ref().map(Vec::as_slice),
                channels: self.z.each_ref().map(Vec::as_slice),
                pitch: &self.pitch,
                payload: &self.payload,
            },
            config,
        )
    }

    /// Moves a whole row.
    fn reorder(&mut self, order: &[usize]) {
        let pick = |v: &mut Vec<Option<f64>>| {
            if !v.is_empty() {
                *v = order.iter().map(|&k| v[k]).collect();
            }
        };
        self.time = order.iter().map(|&k| self.time[k]).collect();
        self.torque.iter_mut().for_each(pick);
        self.z.iter_mut().for_each(pick);
    }
}

fn robust() -> ForceConfig {
    ForceConfig::new(LongitudinalRobot::light().unwrap())
}

fn ramp(seed: u64) -> (Drive, Log) {
    let mut rng = rng(seed, 0);
    let d = drive("upland_sandy_loam", &mut rng);
    let log = Log {
        time: d.time.clone(),
        torque: std::array::from_fn(|_| d.torque.iter().map(|t| Some(*t)).collect()),
        z: sensors(&d, &mut rng),
        pitch: Vec::new(),
        payload: Vec::new(),
    };
    (d, log)
}

/// A noise-free log of constants.
fn constant(rows: usize, torque: f64, z: [f64; 7]) -> Log {
    Log {
        time: (0..rows).map(|k| 0.01 * k as f64).collect(),
        torque: std::array::from_fn(|_| vec![Some(torque); rows]),
        z: z.map(|v| vec![Some(v); rows]),
        pitch: Vec::new(),
        payload: Vec::new(),
    }
}

#[test]
fn a_torque_is_held_for_five_samples_then_given_up_then_taken_up_again() {
    for entry in FILTERS {
        let config = ForceConfig {
            filter: entry.name.to_owned(),
            ..robust()
        };
        let (d, whole) = ramp(45);
        let mut short = whole.clone();
        short.torque[0][50..55].fill(None);
        let steps = short.run(&config).unwrap();
        assert_eq!(steps[54].flag, Flag::Degraded(vec!["torque_fl"]));
        assert_eq!(steps[54].torque[0], steps[49].torque[0]);
        assert_eq!(steps[55].flag, Flag::Ok);

        let mut long = whole.clone();
        long.torque[0][50..100].fill(None);
        let steps = long.run(&config).unwrap();
        for s in &steps[50..100] {
            assert_eq!(s.flag, Flag::Degraded(vec!["torque_fl"]), "row {}", s.row);
        }
        assert_eq!(steps[54].torque_state[0], InputState::Held);
        assert_eq!(steps[55].torque_state[0], InputState::Unknown);
        assert_eq!(steps[100].flag, Flag::Reset(vec!["torque_fl"]));
        assert_eq!(steps[101].flag, Flag::Ok);
        // Nothing is learnt of the resistance meanwhile: its spread grows as that of a free second-order walk, whose
        // variance after the 45 samples is at least q t³/3 = 1e3 x .45³/3.
        let sd = |k: usize| steps[k].belief.sd(T[0]).unwrap();
        assert!((56..100).all(|k| sd(k) > sd(k - 1)), "{}", entry.name);
        assert!(sd(99) > (1e3f64 * 0.45f64.powi(3) / 3.0).sqrt());
        // The truth stays inside what is claimed, and a fifth of a second later the resistance is known again.
        let off = |k: usize| (steps[k].belief.mean[T[0]] - d.resist[0][k]).abs();
        assert!((55..100).all(|k| off(k) < 4.0 * sd(k)));
        assert!((120..200).all(|k| off(k) < 3.5), "{}", entry.name);
        // The other wheels and the forces hardly know: no robust weight may have changed on the way.
        let clean = whole.run(&config).unwrap();
        for k in [60, 99, 110, 199] {
            for i in [T[1], T[3], F[0], V] {
                let apart = (steps[k].belief.mean[i] - clean[k].belief.mean[i]).abs();
                assert!(apart < 1e-6 * clean[k].belief.sd(i).unwrap(), "{i} at {k}");
            }
        }
        let tally = TorqueTally::of(&steps)[0];
        assert_eq!(
            (tally.used, tally.held, tally.unknown, tally.resets),
            (150, 5, 45, 1)
        );
    }
}

#[test]
fn a_torque_that_is_missing_from_the_start_or_for_good_is_survived() {
    let (_, mut log) = ramp(46);
    log.torque[1][..30].fill(None);
    let steps = log.run(&robust()).unwrap();
    assert_eq!(steps[25].flag, Flag::Degraded(vec!["torque_fr"]));
    assert_eq!(steps[30].flag, Flag::Reset(vec!["torque_fr"]));
    log.torque[1].fill(None);
    let steps = log.run(&robust()).unwrap();
    assert_eq!(steps[100].flag.to_string(), "not_observable:torque_fr");
    assert!(steps[199].belief.sd(T[1]).unwrap() > 100.0);
    assert!(steps[199].belief.sd(T[0]).unwrap() < 2.0);
}

/// A reading no robot has is a missing one that is counted as rejected, wherever it comes, with every filter.
#[test]
fn absurd_readings_are_dropped_counted_and_listed() {
    for entry in FILTERS {
        let config = ForceConfig {
            filter: entry.name.to_owned(),
            ..robust()
        };
        let (_, log) = ramp(47);
        for (row, channel, value) in [
            (0, 5, 1e300),
            (80, 5, 1e300),
            (80, 5, -1e308),
            (90, 0, 1e12),
            (90, 6, 1e5),
        ] {
            let (mut bad, mut hole) = (log.clone(), log.clone());
            bad.z[channel][row] = Some(value);
            hole.z[channel][row] = None;
            let (bad, hole) = (bad.run(&config).unwrap(), hole.run(&config).unwrap());
            for (a, b) in bad.iter().zip(&hole) {
                assert_eq!((&a.belief, &a.flag, a.nis), (&b.belief, &b.flag, b.nis));
            }
            let tally = Tally::of(&bad)[channel];
            assert!(tally.rejected >= 1 && tally.missing == 0);
            assert_eq!(Tally::of(&hole)[channel].missing, 1);
            let list = rejected(&bad, 5.0);
            assert!(
                list.iter()
                    .any(|r| r.row == row && r.dropped == Some(Dropped::Implausible))
            );
        }
        let (mut bad, mut hole) = (log.clone(), log);
        bad.torque[2][70] = Some(1e300);
        hole.torque[2][70] = None;
        let (bad, hole) = (bad.run(&config).unwrap(), hole.run(&config).unwrap());
        assert_eq!(bad[199].belief, hole[199].belief);
    }
}

/// The filters themselves, without the log's sense of what a robot can do: robust ones leave the channel out, plain ones
/// say which reading it is and keep their belief.
#[test]
fn filters_survive_absurd_readings_alone() {
    let space = robot();
    let run = Truth::new(&space, 0.01).run(5, &mut rng(48, 0));
    let robust = FilterConfig {
        robust: Some(Robust::default()),
        ..FilterConfig::default()
    };
    for entry in FILTERS {
        for value in [1e300, -1e308, 1e160] {
            let mut plain = filter(entry.name, &space, FilterConfig::default());
            let mut f = filter(entry.name, &space, robust);
            let mut hole = filter(entry.name, &space, robust);
            for (k, z) in run.z.iter().enumerate() {
                let mut seen: Vec<Option<f64>> = z.iter().map(|v| Some(*v)).collect();
                for f in [&mut plain, &mut f, &mut hole] {
                    f.predict(&input(&*space, k), 0.01).unwrap();
                }
                seen[5] = Some(value);
                let before = plain.belief().clone();
                let error = plain.update(&Measurement::new(&seen)).unwrap_err();
                assert!(
                    matches!(&error, FilterError::Implausible { channel, .. } if channel == "v")
                );
                assert_eq!(&before, plain.belief());
                let told = f.update(&Measurement::new(&seen)).unwrap();
                assert_eq!((told.dropped.as_slice(), told.dof), ([5].as_slice(), 6));
                assert!(told.nis.is_finite() && told.ratio.get(5).unwrap().is_finite());
                seen[5] = None;
                hole.update(&Measurement::new(&seen)).unwrap();
                // `block` leaves such samples to another path: equal to rounding.
                assert!(distance(&*f, &*hole) < 1e-10, "{}", entry.name);
            }
        }
    }
}

/// Each sensor stuck for half a second while the robot speeds up: found by the fifth equal reading, dropped, counted,
/// and no force further off than if the readings were missing.
#[test]
fn stuck_sensors_are_found_and_left_out() {
    for channel in 0..7 {
        let (_, log) = ramp(49);
        let (mut stuck, mut hole) = (log.clone(), log);
        for k in 80..130 {
            stuck.z[channel][k] = stuck.z[channel][80];
            hole.z[channel][k] = hole.z[channel][k].filter(|_| k < 84);
        }
        let steps = stuck.run(&robust()).unwrap();
        let tally = Tally::of(&steps)[channel];
        assert!(
            tally.stuck >= 45 && tally.resets == 0,
            "{channel}: {tally:?}"
        );
        for s in &steps[85..130] {
            assert!(
                matches!(&s.flag, Flag::Degraded(names) if names.len() == 1),
                "{:?}",
                s.flag
            );
        }
        assert!(steps[130].dropped.is_empty());
        let hole = hole.run(&robust()).unwrap();
        // Four wrong readings before it is found are all that differs; half a second later they are forgotten.
        for i in 0..18 {
            let apart = (steps[180].belief.mean[i] - hole[180].belief.mean[i]).abs();
            let sd = hole[180].belief.sd(i).unwrap();
            assert!(
                apart < 0.5 * sd,
                "channel {channel}, state {i}: {apart} of {sd}"
            );
        }
    }
    let (_, log) = ramp(49);
    assert!(
        Tally::of(&log.run(&robust()).unwrap())
            .iter()
            .all(|t| t.stuck == 0)
    );
    // Noise-free and constant is no fault.
    let still = constant(100, 0.0, [0.0, 1.0, 1.0, 1.0, 1.0, 0.254, 0.0]);
    assert!(
        Tally::of(&still.run(&robust()).unwrap())
            .iter()
            .all(|t| t.stuck == 0)
    );
}

/// 100 kg and 20 kg of payload at .5 m/s²: the ground pushes 60 N and carries 120 g. The payload is known to change at
/// row 200 to nothing: 50 N and 100 g.
#[test]
fn payload_is_part_of_the_mass() {
    let mut log = constant(400, 0.0, [0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    log.z[5] = log.time.iter().map(|t| Some(0.5 * t)).collect();
    log.payload = (0..400)
        .map(|k| Some(if k < 200 { 20.0 } else { 0.0 }))
        .collect();
    log.payload[100] = None;
    for (smooth, name) in [(false, "block"), (true, "block"), (false, "kf")] {
        let config = ForceConfig {
            smooth,
            filter: name.to_owned(),
            ..robust()
        };
        let steps = log.run(&config).unwrap();
        for (k, force, mass) in [(100, 60.0, 120.0), (199, 60.0, 120.0), (399, 50.0, 100.0)] {
            let s = &steps[k];
            let sum = s.belief.mean[F[0]] + s.belief.mean[F[1]];
            assert!((sum - force).abs() < 0.05, "{sum} at {k}");
            let wheels = wheel_estimates(&s.belief, &s.vehicle).unwrap();
            let load: f64 = wheels.iter().map(|w| w.normal_load.value).sum();
            assert!((load - mass * 9.81).abs() < 1e-9, "{load} at {k}");
        }
    }
    log.payload[300] = Some(-100.0);
    assert!(matches!(
        log.run(&robust()),
        Err(FilterError::AtRow { row: 300, .. })
    ));
}

/// At rest on a slope the ground holds m g sin(pitch), the accelerometer reads g sin(pitch), the wheels carry
/// m g cos(pitch) with the load moved back. A slope that changes under a steady speed changes the force with it.
#[test]
fn pitch_is_gravity_along_the_way() {
    let (slope, g) = (0.2f64, 9.81);
    let mut log = constant(300, 0.0, [g * slope.sin(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    log.pitch = vec![Some(slope); 300];
    let steps = log.run(&robust()).unwrap();
    let s = &steps[299];
    assert_eq!(s.flag, Flag::Ok);
    let sum = s.belief.mean[F[0]] + s.belief.mean[F[1]];
    assert!((sum - 100.0 * g * slope.sin()).abs() < 0.01, "{sum}");
    assert!(s.belief.mean[V].abs() < 1e-4);
    let wheels = wheel_estimates(&s.belief, &s.vehicle).unwrap();
    let load: f64 = wheels.iter().map(|w| w.normal_load.value).sum();
    assert!((load - 981.0 * slope.cos()).abs() < 1e-9);
    // Moments about the rear contact: N_f L = m g (cos l_r - sin h).
    let front = 981.0 * (0.3 * slope.cos() - 0.22 * slope.sin()) / 0.6;
    let got = wheels[0].normal_load.value + wheels[1].normal_load.value;
    assert!((got - front).abs() < 0.01, "{got} and {front}");
    // Ignored, the slope is a force that speeds the robot up: the filter believes it moves.
    log.pitch.clear();
    let flat = log.run(&robust()).unwrap();
    assert!(flat[299].belief.mean[V] > 5.0 * flat[299].belief.sd(V).unwrap());
    // A pitch that is missing is held, and says so.
    log.pitch = vec![Some(slope); 300];
    log.pitch[200] = None;
    let steps = log.run(&robust()).unwrap();
    assert_eq!(steps[200].flag, Flag::Degraded(vec!["pitch"]));
    assert_eq!(steps[200].vehicle.pitch, slope);
}

/// Rows that come up to .2 s late: once they are in, the belief is that of the log in order, filtered and smoothed.
#[test]
fn late_rows_are_put_in_their_place() {
    let (_, log) = ramp(50);
    let mut order: Vec<usize> = (0..200).collect();
    order[60..75].rotate_left(1);
    order[100..121].rotate_left(1);
    order.swap(150, 152);
    let mut late = log.clone();
    late.reorder(&order);
    for smooth in [false, true] {
        let config = ForceConfig { smooth, ..robust() };
        let (a, b) = (log.run(&config).unwrap(), late.run(&config).unwrap());
        for k in 0..200 {
            let in_order = order[k..].iter().all(|&later| later > order[k]);
            if order[k] == k && in_order || smooth {
                let (x, y) = (&a[order[k]].belief, &b[k].belief);
                for i in 0..18 {
                    let apart = (x.mean[i] - y.mean[i]).abs();
                    assert!(
                        apart < 1e-9 * x.sd(i).unwrap().max(x.mean[i].abs()),
                        "row {k} state {i}"
                    );
                }
            }
        }
        for k in [74, 120] {
            assert_eq!(b[k].flag, Flag::Degraded(vec!["time"]), "{k}");
        }
    }
}

/// The same row twice says nothing new; another sample at the same instant does; a clock that goes back an hour starts
/// the filter anew; rows left out are a longer step.
#[test]
fn odd_clocks_are_flagged_and_survived() {
    let (_, log) = ramp(51);
    let mut order: Vec<usize> = (0..200).collect();
    order.insert(80, 79);
    let mut twice = log.clone();
    twice.reorder(&order);
    let (a, b) = (log.run(&robust()).unwrap(), twice.run(&robust()).unwrap());
    assert_eq!(b[80].flag, Flag::Degraded(vec!["time"]));
    assert!((0..7).all(|i| b[80].dropped.contains(&(i, Dropped::Duplicate))));
    assert_eq!(a[199].belief, b[200].belief);

    let mut again = twice.clone();
    for channel in &mut again.z {
        channel[80] = channel[81];
    }
    let c = again.run(&crate::driving::plain()).unwrap();
    assert_eq!((c[80].dof, c[80].time), (7, c[79].time));
    // Two independent samples of .02 m/s: the precisions add.
    let before = c[79].belief.sd(V).unwrap();
    let expected = 1.0 / (before.powi(-2) + 0.02f64.powi(-2)).sqrt();
    assert!((c[80].belief.sd(V).unwrap() / expected - 1.0).abs() < 0.01);

    let mut back = log.clone();
    back.time[120..].iter_mut().for_each(|t| *t -= 3600.0);
    let d = back.run(&robust()).unwrap();
    assert_eq!(d[120].flag, Flag::Reset(vec![]));
    assert_eq!(
        (d[121].flag.clone(), d[145].flag.clone()),
        (Flag::Starting, Flag::Ok)
    );

    let mut gap = log.clone();
    gap.reorder(
        &(0..200)
            .filter(|k| !(100..110).contains(k))
            .collect::<Vec<_>>(),
    );
    let e = gap.run(&robust()).unwrap();
    assert_eq!(e[100].flag, Flag::Degraded(vec!["time"]));
    assert_eq!(e[101].flag, Flag::Ok);

    // Jitter of a third of a step is no fault.
    let mut jitter = log;
    for (k, t) in jitter.time.iter_mut().enumerate() {
        *t += 0.003 * ((k as f64 * 0.618).fract() - 0.5);
    }
    let f = jitter.run(&robust()).unwrap();
    assert!(f[20..].iter().all(|s| s.flag == Flag::Ok));
}

/// A robot that turns left and right: w_right - w_left = r t_w/R without slip.
#[test]
fn swapped_sides_are_flagged_where_turning_tells() {
    let mut log = constant(200, 0.0, [0.0; 7]);
    for k in 0..200 {
        let noise = |i: usize| ((k * 7 + i) as f64 * 0.618_033_988_7).fract() - 0.5;
        let r = 0.4 * (0.05 * k as f64).sin();
        let half = 0.3 * r / 0.254;
        for (i, w) in [2.0 - half, 2.0 + half, 2.0 - half, 2.0 + half]
            .into_iter()
            .enumerate()
        {
            log.z[1 + i][k] = Some(w + 0.1 * noise(i));
        }
        log.z[5][k] = Some(0.5 + 0.04 * noise(5));
        log.z[6][k] = Some(r + 0.01 * noise(6));
    }
    let says = |log: &Log| {
        let steps = log.run(&robust()).unwrap();
        steps[20..]
            .iter()
            .filter(|s| matches!(&s.flag, Flag::Degraded(n) if n.contains(&"sides")))
            .count()
    };
    assert_eq!(says(&log), 0);
    let mut swapped = log.clone();
    swapped.z.swap(1, 2);
    swapped.z.swap(3, 4);
    assert_eq!(says(&swapped), 180);
    // Straight on, nobody can tell.
    assert_eq!(says(&ramp(52).1), 0);
}

/// Reverse is the mirror image: all readings and torques negated give the same belief negated. A start at rest with
/// noise alone finds no force.
#[test]
fn reverse_is_the_mirror_image_and_rest_is_no_force() {
    let (_, log) = ramp(53);
    let mut back = log.clone();
    let negate = |v: &mut Vec<Option<f64>>| v.iter_mut().flatten().for_each(|x| *x = -*x);
    back.torque.iter_mut().for_each(negate);
    back.z.iter_mut().for_each(negate);
    let (a, b) = (log.run(&robust()).unwrap(), back.run(&robust()).unwrap());
    for (a, b) in a.iter().zip(&b) {
        assert!((&a.belief.mean + &b.belief.mean).amax() < 1e-9 * (1.0 + a.belief.mean.amax()));
        assert_eq!(a.flag, b.flag);
    }
    let mut rest = constant(200, 0.0, [0.0; 7]);
    let sd = [0.05, 0.05, 0.05, 0.05, 0.05, 0.02, 0.005];
    let mut rng = rng(54, 0);
    for (channel, sd) in rest.z.iter_mut().zip(sd) {
        let noise = crate::common::normal(&mut rng, 200);
        *channel = noise.iter().map(|e| Some(sd * e)).collect();
    }
    for s in &rest.run(&robust()).unwrap()[20..] {
        assert_eq!(s.flag, Flag::Ok);
        for i in F {
            assert!(s.belief.mean[i].abs() < 4.5 * s.belief.sd(i).unwrap());
        }
    }
}
