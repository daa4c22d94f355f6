//! The particle filter within the Monte Carlo error that theory gives it.

use std::sync::Arc;

use nalgebra::DMatrix;
use terra_ekf::{
    AnyStateSpace, Dims, FilterConfig, FilterError, Gaussian, Measurement, Particles, Registry,
    StateSpace,
};
use terra_model::Scalar;

use crate::common::{Truth, filter, input, rng};

fn config(count: usize, seed: u64) -> FilterConfig {
    FilterConfig {
        particles: Particles {
            count,
            seed,
            marginalise: false,
        },
        ..FilterConfig::default()
    }
}

/// A point on a line whose distance from the origin is measured: which side it is on is not.
struct Distance;

impl StateSpace for Distance {
    fn name(&self) -> &'static str {
        "distance"
    }
    fn summary(&self) -> &'static str {
        "the square of a number"
    }
    fn reference(&self) -> &'static str {
        "none"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: 1,
            input: 0,
            measurement: 1,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &["x"]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &[]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &["x2"]
    }
    fn rate<T: Scalar>(&self, _: &[T], _: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
        rate.fill(T::zero());
        Ok(())
    }
    fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
        z[0] = x[0] * x[0];
        Ok(())
    }
    fn process_noise(&self) -> DMatrix<f64> {
        DMatrix::zeros(1, 1)
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::from_element(1, 1, 0.25)
    }
    fn prior(&self) -> Gaussian {
        Gaussian::independent(&[0.3], &[1.0])
    }
}

/// Both modes of a posterior no Gaussian has, against quadrature. Self-normalised importance sampling has the variance
/// ∫ p (L/Z)² (f - f̄)² / N; the mean and the second moment lie within 4 of its roots.
#[test]
fn both_modes_are_found() {
    let z = 2.0;
    let n = 20_000;
    let space: Arc<dyn AnyStateSpace> = Arc::new(Distance);
    let mut f = filter("particle", &space, config(n, 3));
    f.update(&Measurement::full(&[z])).unwrap();
    let prior = |x: f64| (-0.5 * (x - 0.3f64).powi(2)).exp() / std::f64::consts::TAU.sqrt();
    let like = |x: f64| (-0.5 * (z - x * x).powi(2) / 0.25).exp();
    let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
        (0..40_000)
            .map(|k| f(-6.0 + 12.0 * (f64::from(k) + 0.5) / 40_000.0) * 12.0 / 40_000.0)
            .sum()
    };
    let evidence = integral(&|x| prior(x) * like(x));
    let moment = |g: &dyn Fn(f64) -> f64| {
        let mean = integral(&|x| prior(x) * like(x) * g(x)) / evidence;
        let error = integral(&|x| prior(x) * (like(x) / evidence).powi(2) * (g(x) - mean).powi(2));
        (mean, (error / n as f64).sqrt())
    };
    let (mean, error) = moment(&|x| x);
    let (second, second_error) = moment(&|x| (x - mean).powi(2));
    let found = f.belief();
    assert!(
        (found.mean[0] - mean).abs() < 4.0 * error,
        "{} {mean} {error}",
        found.mean[0]
    );
    let variance = found.covariance[(0, 0)];
    assert!(
        (variance - second).abs() < 4.0 * second_error,
        "{variance} {second} {second_error}"
    );
    // A Gaussian filter sits on one side: its variance is a tenth of this.
    let mut one = filter("ekf", &space, FilterConfig::default());
    one.update(&Measurement::full(&[z])).unwrap();
    assert!(second > 1.0);
}

/// With nothing marginalised the mean of independent runs lies within the error of that mean of the Kalman filter, and
/// that error falls as 1/√N.
#[test]
fn samples_tend_to_the_kalman_filter() {
    let space = Registry::builtin().state_space("single-wheel-rig").unwrap();
    let run = Truth::new(&space, 0.01).run(6, &mut rng(11, 0));
    let drive = |name: &str, config: FilterConfig| {
        let mut f = filter(name, &space, config);
        for k in 0..run.z.len() {
            if k > 0 {
                f.predict(&input(&*space, k - 1), 0.01).unwrap();
            }
            f.update(&Measurement::full(&run.z[k])).unwrap();
        }
        f.belief().clone()
    };
    let oracle = drive("kf", FilterConfig::default());
    const RUNS: usize = 24;
    let spread = |count: usize| {
        let runs: Vec<Gaussian> = (0..RUNS)
            .map(|s| drive("particle", config(count, s as u64)))
            .collect();
        let mut sum = 0.0;
        for i in 0..oracle.dim() {
            let sd = oracle.sd(i).unwrap();
            let off: Vec<f64> = runs
                .iter()
                .map(|r| (r.mean[i] - oracle.mean[i]) / sd)
                .collect();
            let mean = off.iter().sum::<f64>() / RUNS as f64;
            let variance = off.iter().map(|o| (o - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64;
            // Student's t with 23 degrees of freedom: 4.7 has a chance of 1e-4.
            assert!(
                mean.abs() < 4.7 * (variance / RUNS as f64).sqrt(),
                "{count}: state {i} off by {mean} sd"
            );
            sum += variance;
        }
        (sum / oracle.dim() as f64).sqrt()
    };
    let (few, many) = (spread(1000), spread(4000));
    // Theory 2; each spread is known to about 7 % (6 states, 23 degrees of freedom).
    assert!((1.5..2.7).contains(&(few / many)), "{few} {many}");
    assert!(many < 0.3, "{many}");
}

/// Same seed, same belief; marginalised on a linear space it is the Kalman filter (F1 runs over all filters).
#[test]
fn draws_are_repeatable_and_few_particles_are_refused() {
    let space: Arc<dyn AnyStateSpace> = Arc::new(Distance);
    let end = |seed| {
        let mut f = filter("particle", &space, config(50, seed));
        for _ in 0..5 {
            f.predict(&[], 0.1).unwrap();
            f.update(&Measurement::full(&[1.0])).unwrap();
        }
        f.belief().clone()
    };
    assert_eq!(end(1), end(1));
    assert_ne!(end(1), end(2));
    assert!(
        Registry::builtin()
            .filter("particle", space, config(1, 1))
            .is_err()
    );
}
