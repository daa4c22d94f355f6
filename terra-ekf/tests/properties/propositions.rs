//! F3 to F6: what holds for every linear filter, with the counterexamples that must keep failing.

use nalgebra::{DMatrix, DVector};
use terra_ekf::{FILTERS, Filter, FilterConfig, Measurement, Passage, discretise, smooth};

use crate::common::{Run, Truth, filter, input, rng, robot};

/// Smallest eigenvalue of D^(-1/2) M D^(-1/2), D the diagonal of `scale`: a Loewner order free of units.
fn least(m: &DMatrix<f64>, scale: &DMatrix<f64>) -> f64 {
    let n = m.nrows();
    let d = DMatrix::from_fn(n, n, |i, j| {
        m[(i, j)] / (scale[(i, i)] * scale[(j, j)]).sqrt()
    });
    d.symmetric_eigenvalues().min()
}

fn step(f: &mut dyn Filter, k: usize) {
    if k > 0 {
        let u = input(f.space(), k - 1);
        f.predict(&u, 0.01).unwrap();
    }
}

/// F3: P symmetric and positive semi-definite at each step, an update never raises P, smoothing never raises it either.
#[test]
fn f3_covariances_stay_covariances_and_smoothing_never_raises_them() {
    let space = robot();
    let run = Truth::new(&space, 0.01).run(150, &mut rng(10, 0));
    for entry in FILTERS {
        let mut f = filter(entry.name, &space, FilterConfig::default());
        let mut passages = Vec::new();
        for (k, z) in run.z.iter().enumerate() {
            step(&mut *f, k);
            f.update(&Measurement::full(z)).unwrap();
            let (p, before) = (&f.belief().covariance, &f.predicted().covariance);
            assert_eq!(p, &p.transpose());
            assert!(least(p, p) > -1e-14, "{}: {:e}", entry.name, least(p, p));
            assert!(
                least(&(before - p), before) > -1e-12,
                "{} step {k}",
                entry.name
            );
            passages.push(Passage::of(&*f));
        }
        for (s, p) in smooth(&passages).unwrap().iter().zip(&passages) {
            let filtered = &p.filtered.covariance;
            assert!(
                least(&(filtered - &s.covariance), filtered) > -1e-9,
                "{}",
                entry.name
            );
            assert!(least(&s.covariance, filtered) > -1e-9);
        }
    }
}

/// The smoother equals the posterior of the whole trajectory given all samples, by brute force.
#[test]
fn smoother_equals_the_joint_posterior() {
    let space: std::sync::Arc<dyn terra_ekf::AnyStateSpace> =
        std::sync::Arc::new(terra_ekf::spaces::SingleWheelRig::default());
    let steps = 6;
    let run = Truth::new(&space, 0.05).run(steps, &mut rng(11, 0));
    let mut f = filter("kf", &space, FilterConfig::default());
    let mut passages = Vec::new();
    let (a, c) = space.system_matrices().unwrap();
    let d = discretise(&a, &space.process_noise(), 0.05).unwrap();
    let (n, m) = (6, 3);
    // The joint prior of all states, grown step by step, and their prior mean.
    let mut mean = DVector::zeros(n * steps);
    let mut p = DMatrix::zeros(n * steps, n * steps);
    p.view_mut((0, 0), (n, n))
        .copy_from(&space.prior().covariance);
    for k in 0..steps {
        if k > 0 {
            let u = input(&*space, k - 1);
            f.predict(&u, 0.05).unwrap();
            let drive = DVector::from_vec(space.rate_value(&[0.0; 6], &u).unwrap());
            let next = &d.a * mean.rows(n * (k - 1), n) + &d.gamma * drive;
            mean.rows_mut(n * k, n).copy_from(&next);
            let row = &d.a * p.view((n * (k - 1), 0), (n, n * k));
            p.view_mut((n * k, 0), (n, n * k)).copy_from(&row);
            p.view_mut((0, n * k), (n * k, n))
                .copy_from(&row.transpose());
            let corner = row.columns(n * (k - 1), n) * d.a.transpose() + &d.q;
            p.view_mut((n * k, n * k), (n, n)).copy_from(&corner);
        }
        f.update(&Measurement::full(&run.z[k])).unwrap();
        passages.push(Passage::of(&*f));
    }
    let mut h = DMatrix::zeros(m * steps, n * steps);
    let mut r = DMatrix::zeros(m * steps, m * steps);
    let mut z = DVector::zeros(m * steps);
    for k in 0..steps {
        h.view_mut((m * k, n * k), (m, n)).copy_from(&c);
        r.view_mut((m * k, m * k), (m, m))
            .copy_from(&space.measurement_noise());
        z.rows_mut(m * k, m).copy_from_slice(&run.z[k]);
    }
    let s = &h * &p * h.transpose() + r;
    let gain = s.cholesky().unwrap().solve(&(&h * &p)).transpose();
    let posterior = &mean + &gain * (z - &h * &mean);
    let spread = &p - &gain * &h * &p;
    for (k, s) in smooth(&passages).unwrap().iter().enumerate() {
        for i in 0..n {
            let sd = spread[(n * k + i, n * k + i)].sqrt();
            assert!(
                (s.mean[i] - posterior[n * k + i]).abs()
                    < 1e-7 * sd.max(posterior[n * k + i].abs())
            );
            assert!((s.sd(i).unwrap() - sd).abs() < 1e-6 * sd);
        }
    }
}

fn final_belief(
    name: &str,
    run: &Run,
    z: impl Fn(usize, &[f64]) -> Measurement,
) -> (DVector<f64>, DMatrix<f64>) {
    let space = robot();
    let mut f = filter(name, &space, FilterConfig::default());
    for (k, sample) in run.z.iter().enumerate() {
        step(&mut *f, k);
        f.update(&z(k, sample)).unwrap();
    }
    (f.belief().mean.clone(), f.belief().covariance.clone())
}

/// F4: a missing row is a row of infinite variance; NaN is missing; a NaN used as a number must fail.
#[test]
fn f4_missing_is_infinite_variance() {
    use terra_ekf::spaces::longitudinal_robot::*;
    let space = robot();
    let run = Truth::new(&space, 0.01).run(60, &mut rng(12, 0));
    let drop_v = |z: &[f64]| {
        z.iter()
            .enumerate()
            .map(|(i, v)| Some(*v).filter(|_| i != Z_V))
            .collect::<Vec<_>>()
    };
    for entry in FILTERS {
        let (dropped, p) = final_belief(entry.name, &run, |_, z| Measurement::new(&drop_v(z)));
        let (nan, _) = final_belief(entry.name, &run, |_, z| {
            let mut z = z.to_vec();
            z[Z_V] = f64::NAN;
            Measurement::full(&z)
        });
        assert_eq!(dropped, nan, "{}", entry.name);

        // Variance 1e8 times the state's own, in that row only.
        let vehicle = *LongitudinalRobot::light().unwrap().vehicle();
        let sensors = SensorNoise {
            ground_speed: 1e4,
            ..SensorNoise::default()
        };
        let blind = LongitudinalRobot::new(
            vehicle,
            sensors,
            ProcessNoise::default(),
            PriorSpread::default(),
        )
        .unwrap();
        let blind: std::sync::Arc<dyn terra_ekf::AnyStateSpace> = std::sync::Arc::new(blind);
        let mut f = filter(entry.name, &blind, FilterConfig::default());
        for (k, z) in run.z.iter().enumerate() {
            step(&mut *f, k);
            f.update(&Measurement::full(z)).unwrap();
        }
        for i in 0..18 {
            assert!(
                (f.belief().mean[i] - dropped[i]).abs() < 1e-5 * p[(i, i)].sqrt(),
                "{}",
                entry.name
            );
        }
    }
    // Expected failure: zero in the place of the missing speed is another number, not a missing one.
    let (dropped, p) = final_belief("kf", &run, |_, z| Measurement::new(&drop_v(z)));
    let (zeroed, _) = final_belief("kf", &run, |_, z| {
        let mut z = z.to_vec();
        z[Z_V] = 0.0;
        Measurement::full(&z)
    });
    assert!((zeroed[V] - dropped[V]).abs() > p[(V, V)].sqrt());
}

/// F5: another sensor never raises any variance.
#[test]
fn f5_another_sensor_never_raises_a_variance() {
    let space = robot();
    let run = Truth::new(&space, 0.01).run(40, &mut rng(13, 0));
    let (_, all) = final_belief("kf", &run, |_, z| Measurement::full(z));
    for lost in 0..7 {
        let (_, fewer) = final_belief("kf", &run, |_, z| {
            let z: Vec<_> = z
                .iter()
                .enumerate()
                .map(|(i, v)| Some(*v).filter(|_| i != lost))
                .collect();
            Measurement::new(&z)
        });
        assert!(least(&(&fewer - &all), &fewer) > -1e-12, "channel {lost}");
    }
}

/// F6: without process noise the filter is prior-weighted least squares over all samples so far, for every k; with
/// process noise it must differ.
#[test]
fn f6_without_process_noise_it_is_least_squares() {
    use terra_ekf::spaces::longitudinal_robot::*;
    let vehicle = *LongitudinalRobot::light().unwrap().vehicle();
    let still = ProcessNoise {
        speed: 0.0,
        yaw_rate: 0.0,
        wheel_speed: 0.0,
        torque_walk: 0.0,
        force_walk: [0.0; 2],
    };
    let space = |process| -> std::sync::Arc<dyn terra_ekf::AnyStateSpace> {
        std::sync::Arc::new(
            LongitudinalRobot::new(
                vehicle,
                SensorNoise::default(),
                process,
                PriorSpread::default(),
            )
            .unwrap(),
        )
    };
    let run = Truth::new(&space(ProcessNoise::default()), 0.01).run(40, &mut rng(14, 0));
    for (process, equal) in [(still, true), (ProcessNoise::default(), false)] {
        let space = space(process);
        let mut f = filter("kf", &space, FilterConfig::default());
        let (a, c) = space.system_matrices().unwrap();
        let d = discretise(&a, &DMatrix::zeros(18, 18), 0.01).unwrap();
        // Unknown: x_0 in prior standard deviations. x_k = phi x_0 + push.
        let prior = space.prior();
        let scale = DMatrix::from_diagonal(&prior.covariance.diagonal().map(f64::sqrt));
        let (mut phi, mut push) = (DMatrix::identity(18, 18), DVector::zeros(18));
        let mut rows = vec![(DMatrix::identity(18, 18), DVector::zeros(18))];
        let noise =
            DMatrix::from_diagonal(&space.measurement_noise().diagonal().map(|v| 1.0 / v.sqrt()));
        let mut worst = 0.0f64;
        for (k, z) in run.z.iter().enumerate() {
            step(&mut *f, k);
            if k > 0 {
                let drive = space
                    .rate_value(&[0.0; 18], &input(&*space, k - 1))
                    .unwrap();
                phi = &d.a * phi;
                push = &d.a * push + &d.gamma * DVector::from_vec(drive);
            }
            f.update(&Measurement::full(z)).unwrap();
            rows.push((
                &noise * &c * &phi * &scale,
                &noise * (DVector::from_row_slice(z) - &c * &push),
            ));
            let count = rows.iter().map(|r| r.1.len()).sum();
            let (mut big, mut rhs) = (DMatrix::zeros(count, 18), DVector::zeros(count));
            let mut at = 0;
            for (m, v) in &rows {
                big.rows_mut(at, m.nrows()).copy_from(m);
                rhs.rows_mut(at, v.len()).copy_from(v);
                at += v.len();
            }
            let qr = big.qr();
            let x0 = qr
                .r()
                .solve_upper_triangular(&(qr.q().transpose() * rhs))
                .unwrap();
            let batch = &phi * (&scale * x0) + &push;
            for i in 0..18 {
                worst =
                    worst.max((f.belief().mean[i] - batch[i]).abs() / f.belief().sd(i).unwrap());
            }
        }
        assert_eq!(worst < 1e-7, equal, "{worst:e}");
    }
}
