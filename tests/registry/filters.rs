//! Any state space with any filter, by name.

use std::sync::Arc;

use nalgebra::DMatrix;
use terra::ekf::{
    AnyStateSpace, Dims, FilterConfig, FilterError, Gaussian, Measurement, Registry, SpaceEntry,
    StateSpace,
};
use terra::model::Scalar;

const DT: f64 = 0.01;
const STEPS: usize = 60;

/// A pendulum with a drag, seen from the side: nonlinear in motion and in measurement. A user's own, one entry to join.
struct Pendulum;

impl StateSpace for Pendulum {
    fn name(&self) -> &'static str {
        "pendulum"
    }
    fn summary(&self) -> &'static str {
        "a pendulum seen from the side"
    }
    fn reference(&self) -> &'static str {
        "textbook"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: 2,
            input: 1,
            measurement: 1,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &["angle_rad", "rate_rad_s"]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &["push_rad_s2"]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &["sideways_m"]
    }
    fn rate<T: Scalar>(&self, x: &[T], u: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
        rate[0] = x[1];
        rate[1] = x[0].sin_cos().0 * -9.81 - x[1] * 0.1 + T::from(u[0]);
        Ok(())
    }
    fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
        z[0] = x[0].sin_cos().0;
        Ok(())
    }
    fn process_noise(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&vec![0.0, 1e-3].into())
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::from_element(1, 1, 1e-4)
    }
    fn prior(&self) -> Gaussian {
        Gaussian::independent(&[0.3, 0.0], &[0.2, 0.3])
    }
}

fn registry() -> Registry {
    Registry::builtin().with_state_space(SpaceEntry {
        name: "pendulum",
        build: || Ok(Arc::new(Pendulum)),
    })
}

/// Noise-free samples of the space's own motion from its prior mean, by small explicit steps, every seventh one missing.
fn samples(space: &dyn AnyStateSpace) -> Vec<(Vec<f64>, Measurement)> {
    let mut x = space.prior().mean.as_slice().to_vec();
    let names = space.measurement_names().len();
    (0..STEPS)
        .map(|k| {
            let u = vec![0.5 * (0.1 * k as f64).sin(); space.dims().input];
            for _ in 0..20 {
                let rate = space.rate_value(&x, &u).unwrap();
                x.iter_mut()
                    .zip(&rate)
                    .for_each(|(x, r)| *x += DT / 20.0 * r);
            }
            let z = space.measure_value(&x).unwrap();
            let seen: Vec<Option<f64>> = z.iter().map(|z| (k % 7 != 3).then_some(*z)).collect();
            assert_eq!(seen.len(), names);
            (u, Measurement::new(&seen))
        })
        .collect()
}

/// Every pair runs over a log with gaps, or is refused because the filter takes linear spaces only. On a linear space the
/// filters are one and the same estimator (Kalman 1960), so their beliefs must agree to rounding.
#[test]
fn any_state_space_with_any_filter() {
    let registry = registry();
    let (mut ran, mut refused) = (0, 0);
    for entry in registry.state_spaces() {
        let space = registry.state_space(entry.name).unwrap();
        let log = samples(&*space);
        let mut beliefs: Vec<(&str, Gaussian)> = vec![];
        for filter in registry.filters() {
            let label = format!("{} x {}", entry.name, filter.name);
            let built = registry.filter(filter.name, Arc::clone(&space), FilterConfig::default());
            let mut running = match built {
                Ok(f) => f,
                Err(FilterError::NotLinear {
                    filter: f,
                    space: s,
                }) => {
                    assert!(filter.linear_only && !space.is_linear(), "{label}");
                    assert_eq!((f, s), (filter.name, entry.name));
                    refused += 1;
                    continue;
                }
                Err(e) => panic!("{label}: {e}"),
            };
            for (u, z) in &log {
                running
                    .predict(u, DT)
                    .unwrap_or_else(|e| panic!("{label}: {e}"));
                let innovation = running.update(z).unwrap_or_else(|e| panic!("{label}: {e}"));
                assert_eq!(innovation.dof, z.present().len(), "{label}");
            }
            let belief = running.belief().clone();
            // The check inside: finite, symmetric, positive semi-definite.
            let checked = Gaussian::new(belief.mean.clone(), belief.covariance.clone());
            checked.unwrap_or_else(|e| panic!("{label}: {e}"));
            beliefs.push((filter.name, belief));
            ran += 1;
        }
        if space.is_linear() {
            let (first, reference) = &beliefs[0];
            for (name, belief) in &beliefs[1..] {
                for i in 0..belief.dim() {
                    let sd = reference.sd(i).unwrap();
                    let off = (belief.mean[i] - reference.mean[i]).abs() / sd;
                    assert!(
                        off < 1e-6,
                        "{}: {name} and {first} are {off} sd apart in state {i}",
                        entry.name
                    );
                    let ratio = belief.sd(i).unwrap() / sd;
                    assert!(
                        (ratio - 1.0).abs() < 1e-6,
                        "{}: sd of {name} over {first}: {ratio}",
                        entry.name
                    );
                }
            }
        }
    }
    assert_eq!(
        ran + refused,
        registry.state_spaces().len() * registry.filters().len()
    );
    assert!(
        refused > 0 && ran > refused,
        "{ran} ran, {refused} were refused"
    );
}

/// An unknown name is answered with the nearest known one.
#[test]
fn a_slip_of_the_pen_is_helped() {
    let registry = registry();
    let space = registry.state_space("pendulum").unwrap();
    let error = registry
        .filter("ufk", space, FilterConfig::default())
        .err()
        .unwrap();
    assert!(error.to_string().contains("did you mean 'ukf'"), "{error}");
    let error = registry.state_space("pendlum").err().unwrap();
    assert!(
        error.to_string().contains("did you mean 'pendulum'"),
        "{error}"
    );
}
