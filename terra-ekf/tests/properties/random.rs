//! F1 to F6 on state spaces drawn at random: what holds for linear filters holds for all of them.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use terra_ekf::{
    AnyStateSpace, Dims, FILTERS, FilterConfig, FilterError, Gaussian, Measurement, Robust,
    StateSpace, discretise,
};
use terra_model::Scalar;

use crate::common::{distance, filter};

const NAMES: [&str; 4] = ["a", "b", "c", "d"];

/// x' = A x + u in each state, z = C x.
#[derive(Clone, Debug)]
struct Drawn {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    q: DMatrix<f64>,
    r: Vec<f64>,
    p: DMatrix<f64>,
}

impl StateSpace for Drawn {
    fn name(&self) -> &'static str {
        "drawn"
    }
    fn summary(&self) -> &'static str {
        "a linear state space drawn at random"
    }
    fn reference(&self) -> &'static str {
        "none"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: self.a.nrows(),
            input: 0,
            measurement: self.r.len(),
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &NAMES[..self.a.nrows()]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &[]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &NAMES[..self.r.len()]
    }
    fn rate<T: Scalar>(&self, x: &[T], _: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
        for (i, r) in rate.iter_mut().enumerate() {
            *r = x
                .iter()
                .enumerate()
                .fold(T::zero(), |sum, (j, x)| sum + *x * self.a[(i, j)]);
        }
        Ok(())
    }
    fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
        for (i, z) in z.iter_mut().enumerate() {
            *z = x
                .iter()
                .enumerate()
                .fold(T::zero(), |sum, (j, x)| sum + *x * self.c[(i, j)]);
        }
        Ok(())
    }
    fn process_noise(&self) -> DMatrix<f64> {
        self.q.clone()
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_column_slice(&self.r))
    }
    fn prior(&self) -> Gaussian {
        Gaussian {
            mean: DVector::from_element(self.a.nrows(), 0.5),
            covariance: self.p.clone(),
        }
    }
    fn linear(&self) -> bool {
        true
    }
}

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0f64..1.0, rows * columns)
        .prop_map(move |v| DMatrix::from_vec(rows, columns, v))
}

/// A space, a log of five samples with gaps, and the steps between them.
fn drawn() -> impl Strategy<Value = (Drawn, Vec<Vec<Option<f64>>>, Vec<f64>)> {
    (1usize..=4, 1usize..=3).prop_flat_map(|(n, m)| {
        let row = prop::collection::vec(prop::option::weighted(0.8, -3.0f64..3.0), m);
        (
            matrix(n, n),
            matrix(m, n),
            matrix(n, n),
            prop::collection::vec(0.05f64..2.0, m),
            matrix(n, n),
            prop::collection::vec(row, 5),
            prop::collection::vec(0.01f64..0.6, 5),
        )
            .prop_map(move |(a, c, b, r, p, rows, dt)| {
                let identity = DMatrix::identity(n, n);
                let space = Drawn {
                    q: &b * b.transpose(),
                    p: &p * p.transpose() + identity * 0.1,
                    a,
                    c,
                    r,
                };
                (space, rows, dt)
            })
    })
}

fn any(space: &Drawn) -> Arc<dyn AnyStateSpace> {
    Arc::new(space.clone())
}

/// Smallest eigenvalue of a symmetric matrix.
fn least(m: &DMatrix<f64>) -> f64 {
    m.clone().symmetric_eigen().eigenvalues.min()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// F1 and F3: every filter is the Kalman filter; covariances stay positive semi-definite and an update never
    /// raises them.
    #[test]
    fn f1_and_f3_every_filter_is_the_kalman_filter((space, rows, dt) in drawn()) {
        let shared = any(&space);
        for entry in FILTERS {
            let mut oracle = filter("kf", &shared, FilterConfig::default());
            let mut other = filter(entry.name, &shared, FilterConfig::default());
            for (z, dt) in rows.iter().zip(&dt) {
                for f in [&mut oracle, &mut other] {
                    f.predict(&[], *dt).unwrap();
                    f.update(&Measurement::new(z)).unwrap();
                    let (before, after) = (&f.predicted().covariance, &f.belief().covariance);
                    let scale = before.amax();
                    prop_assert!(least(after) > -1e-12 * scale);
                    prop_assert!(least(&(before - after)) > -1e-10 * scale, "{}", entry.name);
                }
                prop_assert!(distance(&*oracle, &*other) < 1e-8, "{}: {}", entry.name, distance(&*oracle, &*other));
            }
        }
    }

    /// F4: a missing row is a row of infinite variance.
    #[test]
    fn f4_a_missing_row_is_infinite_variance((space, rows, dt) in drawn()) {
        let run = |space: &Drawn, hide: bool| {
            let mut f = filter("kf", &any(space), FilterConfig::default());
            for (z, dt) in rows.iter().zip(&dt) {
                f.predict(&[], *dt).unwrap();
                let mut z = z.clone();
                z[0] = if hide { None } else { Some(1.0) };
                f.update(&Measurement::new(&z)).unwrap();
            }
            f.belief().clone()
        };
        let mut deaf = space.clone();
        deaf.r[0] = 1e12;
        let (a, b) = (run(&space, true), run(&deaf, false));
        let scale = a.covariance.amax();
        prop_assert!((a.mean - b.mean).amax() < 1e-8 * (1.0 + scale));
        prop_assert!((a.covariance - b.covariance).amax() < 1e-8 * scale * (1.0 + scale));
    }

    /// F5: another sensor never raises any variance, in Loewner's order.
    #[test]
    fn f5_another_sensor_never_hurts((space, rows, dt) in drawn()) {
        let mut less = filter("kf", &any(&space), FilterConfig::default());
        let mut more = filter("kf", &any(&space), FilterConfig::default());
        for (z, dt) in rows.iter().zip(&dt) {
            let mut hidden = z.clone();
            hidden[0] = None;
            less.predict(&[], *dt).unwrap();
            more.predict(&[], *dt).unwrap();
            less.update(&Measurement::new(&hidden)).unwrap();
            more.update(&Measurement::new(z)).unwrap();
            let (p, q) = (&less.belief().covariance, &more.belief().covariance);
            prop_assert!(least(&(p - q)) > -1e-10 * p.amax());
        }
    }

    /// F6: without process noise the estimate after every sample is prior-weighted least squares over all so far.
    #[test]
    fn f6_without_process_noise_it_is_batch_least_squares((space, rows, dt) in drawn()) {
        let mut still = space.clone();
        still.q.fill(0.0);
        let mut f = filter("kf", &any(&still), FilterConfig::default());
        let n = still.a.nrows();
        let start = StateSpace::prior(&still);
        let mut information = start.covariance.clone().try_inverse().unwrap();
        let mut vector = &information * &start.mean;
        let mut moved = DMatrix::identity(n, n);
        for (z, dt) in rows.iter().zip(&dt) {
            f.predict(&[], *dt).unwrap();
            f.update(&Measurement::new(z)).unwrap();
            moved = discretise(&still.a, &still.q, *dt).unwrap().a * moved;
            for (i, z) in z.iter().enumerate() {
                let Some(z) = z else { continue };
                let row = still.c.row(i) * &moved;
                information += row.transpose() * &row / still.r[i];
                vector += row.transpose() * (*z / still.r[i]);
            }
            let covariance = information.clone().try_inverse().unwrap();
            let x = &moved * (&covariance * &vector);
            let p = &moved * covariance * moved.transpose();
            prop_assert!((&f.belief().mean - &x).amax() < 1e-8 * (1.0 + x.amax()));
            prop_assert!((&f.belief().covariance - &p).amax() < 1e-8 * p.amax());
        }
    }
}

/// F5's stored counterexample: a robust update is not linear. A second sensor that strays moves the mean, the first then
/// looks like an outlier and loses its say: the variance rises from 1 to more than 4.
#[test]
fn f5_fails_for_a_robust_update() {
    let space = Drawn {
        a: DMatrix::zeros(1, 1),
        c: DMatrix::from_element(2, 1, 1.0),
        q: DMatrix::zeros(1, 1),
        r: vec![1.0, 100.0],
        p: DMatrix::from_element(1, 1, 100.0),
    };
    let config = FilterConfig {
        robust: Some(Robust::default()),
        ..FilterConfig::default()
    };
    let variance = |stray: Option<f64>| {
        let mut f = filter("kf", &any(&space), config);
        f.update(&Measurement::new(&[None, stray])).unwrap();
        f.update(&Measurement::new(&[Some(0.5), None])).unwrap();
        f.belief().covariance[(0, 0)]
    };
    assert!(variance(None) < 1.0, "{}", variance(None));
    assert!(variance(Some(30.5)) > 4.0, "{}", variance(Some(30.5)));
}
