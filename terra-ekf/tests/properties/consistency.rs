//! F2: what a filter says of its own errors, on data of its own model; and the mutations that must fail.

use std::sync::Arc;

use terra_ekf::spaces::longitudinal_robot::{
    LongitudinalRobot, PriorSpread, ProcessNoise, SensorNoise,
};
use terra_ekf::{AnyStateSpace, Consistency, FilterConfig, Measurement, Verdict};

use crate::common::{Truth, filter, input, rng, robot};

/// A robot that believes its sensors are `r` times as variable, and its walks `q` times as strong, as they are.
fn believer(r: f64, q: f64) -> Arc<dyn AnyStateSpace> {
    let vehicle = *LongitudinalRobot::light().unwrap().vehicle();
    let (s, p) = (SensorNoise::default(), ProcessNoise::default());
    let sensors = SensorNoise {
        accel_x: s.accel_x * r.sqrt(),
        wheel_speed: s.wheel_speed * r.sqrt(),
        ground_speed: s.ground_speed * r.sqrt(),
        yaw_rate: s.yaw_rate * r.sqrt(),
    };
    let process = ProcessNoise {
        torque_walk: p.torque_walk * q,
        force_walk: [p.force_walk[0] * q; 2],
        ..p
    };
    Arc::new(LongitudinalRobot::new(vehicle, sensors, process, PriorSpread::default()).unwrap())
}

/// NIS and whiteness over `runs` runs of `steps` steps, and NEES at the end of each run.
fn measure(
    believed: &Arc<dyn AnyStateSpace>,
    runs: u64,
    steps: usize,
    name: &str,
) -> (Consistency, Consistency) {
    let truth = Truth::new(&robot(), 0.01);
    let (mut nis, mut nees) = (Consistency::new(), Consistency::new());
    let mut f = filter(name, believed, FilterConfig::default());
    for stream in 0..runs {
        let run = truth.run(steps, &mut rng(7, stream));
        f.restart(believed.prior()).unwrap();
        nis.new_run();
        for (k, z) in run.z.iter().enumerate() {
            if k > 0 {
                f.predict(&input(&**believed, k - 1), 0.01).unwrap();
            }
            nis.add(&f.update(&Measurement::full(z)).unwrap());
        }
        let error = &f.belief().mean - run.x.last().unwrap();
        let solved = f
            .belief()
            .covariance
            .clone()
            .cholesky()
            .unwrap()
            .solve(&error);
        nees.add_square(error.dot(&solved), 18);
    }
    (nis, nees)
}

fn check(runs: u64, steps: usize) {
    let (nis, nees) = measure(&robot(), runs, steps, "block");
    let (low, high) = nis.band(0.9995).unwrap();
    let mean = nis.mean().unwrap();
    assert!(
        low < mean && mean < high,
        "NIS/7 {mean} outside {low}..{high}"
    );
    assert!(
        nis.z().unwrap().abs() < 3.5 && nees.z().unwrap().abs() < 3.5,
        "{:?} {:?}",
        nis.z(),
        nees.z()
    );
    assert!(nis.lag1_z().unwrap().abs() < 3.0, "lag-1 {:?}", nis.lag1());
    assert_eq!(nis.verdict(3.5), Verdict::Consistent);
    // Expected failures: R believed 5 % too large or too small, walks believed at .3 of their strength.
    assert_eq!(
        measure(&believer(1.05, 1.0), runs, steps, "block")
            .0
            .verdict(3.5),
        Verdict::Underconfident
    );
    assert_eq!(
        measure(&believer(0.95, 1.0), runs, steps, "block")
            .0
            .verdict(3.5),
        Verdict::Overconfident
    );
    let walks = measure(&believer(1.0, 0.3), runs, steps, "block").0;
    assert_ne!(walks.verdict(3.5), Verdict::Consistent);
    assert!(
        walks.lag1().unwrap() > 0.0,
        "innovations of a filter that moves too slowly are correlated"
    );
}

#[test]
fn f2_matched_model_is_consistent_and_wrong_noise_is_not() {
    check(100, 100);
}

#[test]
#[ignore = "the full size, 300 runs of 200 steps: a few seconds"]
fn f2_matched_model_is_consistent_at_full_size() {
    check(300, 200);
    // Seen at this size only: R believed 2 % too large.
    assert_eq!(
        measure(&believer(1.02, 1.0), 300, 200, "block")
            .0
            .verdict(3.5),
        Verdict::Underconfident
    );
}
