use terra_data::Noise;
use terra_sim::{Integrator, Scenario, SimError, paper, simulate_drive};

use crate::support::{adaptive, constant_drive, drive, registry};

/// A long straight drive on constant forces: thousands of samples at little cost.
fn long() -> Scenario {
    Scenario {
        noise_scale: 1.0,
        ..constant_drive(1.0, 1.0, 40.0)
    }
}

/// The sum of squares of n white samples of the declared sd is chi-square: n ± sqrt(2 n); within 4.5 of them, and the
/// mean within 4.5 sd/sqrt(n).
#[test]
fn noise_has_the_declared_sd() {
    let rover = paper::light_rover();
    let run = drive(&long(), &rover, adaptive());
    let check = |key: &str, log: &terra_data::Series, truth: &[f64]| {
        let sd = rover.noise.get(key).unwrap();
        let n = truth.len() as f64;
        let z: Vec<f64> = log
            .iter()
            .zip(truth)
            .map(|(a, b)| (a.unwrap() - b) / sd)
            .collect();
        let chi2: f64 = z.iter().map(|z| z * z).sum();
        let mean: f64 = z.iter().sum::<f64>() / n;
        let lag: f64 = z.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        assert!(
            (chi2 - n).abs() < 4.5 * (2.0 * n).sqrt(),
            "{key}: {chi2} of {n}"
        );
        assert!(
            mean.abs() < 4.5 / n.sqrt() && lag.abs() < 4.5 / n.sqrt(),
            "{key}: {mean} {lag}"
        );
    };
    let truth = &run.truth;
    for q in 0..4 {
        check(
            "wheel_speed_rad_s",
            &run.log.wheel_speed[q],
            &truth.wheel_speed[q],
        );
    }
    check(
        "ground_speed_m_s",
        run.log.ground_speed.as_ref().unwrap(),
        &truth.ground_speed,
    );
    check(
        "yaw_rate_rad_s",
        run.log.yaw_rate.as_ref().unwrap(),
        &truth.yaw_rate,
    );
    check(
        "accel_x_m_s2",
        run.log.accel_x.as_ref().unwrap(),
        &truth.accel_x,
    );
}

#[test]
fn noise_scale_scales_and_seeds_decide() {
    let rover = paper::light_rover();
    let run = |seed: u64, scale: f64| {
        let scenario = Scenario {
            seed,
            noise_scale: scale,
            ..constant_drive(1.0, 1.0, 1.0)
        };
        let run = drive(&scenario, &rover, adaptive());
        let v = run.log.ground_speed.unwrap();
        (0..100)
            .map(|i| v.get(i).unwrap() - run.truth.ground_speed[i])
            .collect::<Vec<f64>>()
    };
    let (one, two) = (run(1, 1.0), run(1, 2.0));
    assert!(
        one.iter()
            .zip(&two)
            .all(|(a, b)| (2.0 * a - b).abs() < 1e-12)
    );
    assert!(run(1, 0.0).iter().all(|e| *e == 0.0));
    assert_eq!(one, run(1, 1.0));
    assert_ne!(one, run(2, 1.0));
}

/// Same seed, same bytes, of everything in the log and the truth.
#[test]
fn same_seed_same_bytes() {
    let mut scenario = paper::torque_ramp("lean_clay_22", 9).unwrap();
    scenario.segments[0].duration = 0.3;
    let mut rover = paper::light_rover();
    rover.noise.0.insert("roughness_N".to_owned(), 2.0);
    let text = |scenario: &Scenario| {
        let run = drive(scenario, &rover, Integrator::default());
        format!("{:?} {:?}", run.log, run.truth)
    };
    let first = text(&scenario);
    assert_eq!(first, text(&scenario));
    scenario.run = 1;
    assert_ne!(first, text(&scenario));
}

/// No run knows of another: eight at once, in threads of their own, give the bytes of one alone.
#[test]
fn threads_change_no_byte() {
    let mut scenario = paper::torque_ramp("dry_sand", 4).unwrap();
    scenario.segments[0].duration = 0.4;
    let text = |run: u64| {
        let mut scenario = scenario.clone();
        scenario.run = run;
        let run = drive(&scenario, &paper::light_rover(), adaptive());
        format!("{:?} {:?}", run.log, run.truth)
    };
    let alone: Vec<String> = (0..8).map(text).collect();
    let together: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|run| scope.spawn(move || text(run))).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    assert!(alone == together);
    assert_ne!(alone[0], alone[1]);
}

/// Roughness shakes force, speed and acceleration, with the declared sd at the wheel.
#[test]
fn roughness_reaches_the_wheels() {
    let mut rover = paper::light_rover();
    rover.noise.0.insert("roughness_N".to_owned(), 2.0);
    let run = drive(&long(), &rover, adaptive());
    let shake: Vec<f64> = run.truth.drawbar_pull[1][50..]
        .iter()
        .map(|d| d - 1.0)
        .collect();
    let variance = shake.iter().map(|s| s * s).sum::<f64>() / shake.len() as f64;
    // 48 waves over 40 s: the mean square of the sum is sd² up to beats of neighbouring waves.
    assert!((variance / 4.0 - 1.0).abs() < 0.25, "{variance}");
    let lag = |k: usize| {
        shake.windows(k + 1).map(|w| w[0] * w[k]).sum::<f64>() / (shake.len() - k) as f64 / variance
    };
    assert!(
        lag(1) > 0.85 && lag(5).abs() < 0.35,
        "{} {}",
        lag(1),
        lag(5)
    );
}

#[test]
fn a_missing_sd_is_named() {
    let mut rover = paper::light_rover();
    rover.noise = Noise(
        rover
            .noise
            .0
            .into_iter()
            .filter(|(k, _)| k != "yaw_rate_rad_s")
            .collect(),
    );
    let error = simulate_drive(&long(), &rover, &registry()).unwrap_err();
    assert_eq!(
        error,
        SimError::MissingNoise {
            key: "yaw_rate_rad_s".to_owned()
        }
    );
    let quiet = Scenario {
        noise_scale: 0.0,
        ..constant_drive(1.0, 1.0, 0.5)
    };
    assert!(simulate_drive(&quiet, &rover, &registry()).is_ok());
}
