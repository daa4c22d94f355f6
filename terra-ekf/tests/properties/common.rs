//! Data with known truth: the linear model itself, simulated with the noise the filter believes in.

use std::sync::Arc;

use chacha20::ChaCha8Rng;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use terra_ekf::{AnyStateSpace, Filter, FilterConfig, Gaussian, Measurement, Registry, discretise};

pub(crate) fn rng(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

pub(crate) fn normal(rng: &mut ChaCha8Rng, n: usize) -> DVector<f64> {
    DVector::from_iterator(n, (0..n).map(|_| StandardNormal.sample(rng)))
}

pub(crate) fn robot() -> Arc<dyn AnyStateSpace> {
    Registry::builtin()
        .state_space("longitudinal-robot")
        .unwrap()
}

pub(crate) fn filter(
    name: &str,
    space: &Arc<dyn AnyStateSpace>,
    config: FilterConfig,
) -> Box<dyn Filter> {
    Registry::builtin()
        .filter(name, space.clone(), config)
        .unwrap()
}

/// Torques that vary smoothly, so that inputs are part of every comparison.
pub(crate) fn input(space: &dyn AnyStateSpace, k: usize) -> Vec<f64> {
    (0..space.dims().input)
        .map(|q| 20.0 + 10.0 * (0.05 * k as f64 + q as f64).sin())
        .collect()
}

/// One run of a linear state space under its own noise: states and measurements at steps 0..n.
pub(crate) struct Run {
    pub(crate) x: Vec<DVector<f64>>,
    pub(crate) z: Vec<Vec<f64>>,
}

/// A generator of runs, with factors that let the truth differ from what the filter believes.
pub(crate) struct Truth {
    space: Arc<dyn AnyStateSpace>,
    a: DMatrix<f64>,
    gamma: DMatrix<f64>,
    c: DMatrix<f64>,
    process: DMatrix<f64>,
    sensor: DMatrix<f64>,
    start: DMatrix<f64>,
}

impl Truth {
    pub(crate) fn new(space: &Arc<dyn AnyStateSpace>, dt: f64) -> Self {
        let (a, c) = space.system_matrices().unwrap();
        let d = discretise(&a, &space.process_noise(), dt).unwrap();
        let root = |m: DMatrix<f64>| {
            // A semi-definite matrix has no Cholesky factor; its symmetric square root always exists.
            let e = m.symmetric_eigen();
            let half = DMatrix::from_diagonal(&e.eigenvalues.map(|v| v.max(0.0).sqrt()));
            &e.eigenvectors * half
        };
        // Scaled before the decomposition: entries of q span ten orders of magnitude.
        let scale = d.q.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
        let inverse = DMatrix::from_diagonal(&scale.map(|v| 1.0 / v));
        let process = DMatrix::from_diagonal(&scale) * root(&inverse * &d.q * &inverse);
        Truth {
            space: space.clone(),
            a: d.a,
            gamma: d.gamma,
            c,
            process,
            sensor: root(space.measurement_noise()),
            start: root(space.prior().covariance),
        }
    }

    pub(crate) fn run(&self, steps: usize, rng: &mut ChaCha8Rng) -> Run {
        let (n, m) = (self.a.nrows(), self.c.nrows());
        let mut x = &self.start * normal(rng, n) + self.space.prior().mean;
        let mut run = Run {
            x: Vec::new(),
            z: Vec::new(),
        };
        let origin = vec![0.0; n];
        for k in 0..steps {
            if k > 0 {
                let drive = self
                    .space
                    .rate_value(&origin, &input(&*self.space, k - 1))
                    .unwrap();
                x = &self.a * x
                    + &self.gamma * DVector::from_vec(drive)
                    + &self.process * normal(rng, n);
            }
            let z = &self.c * &x + &self.sensor * normal(rng, m);
            run.z.push(z.as_slice().to_vec());
            run.x.push(x.clone());
        }
        run
    }
}

/// Largest difference of two beliefs, each entry against the standard deviations it belongs to.
pub(crate) fn distance(a: &dyn Filter, b: &dyn Filter) -> f64 {
    distance_of(a.belief(), b.belief())
}

pub(crate) fn distance_of(a: &Gaussian, b: &Gaussian) -> f64 {
    let mut worst = 0.0f64;
    for i in 0..a.dim() {
        let si = a.sd(i).unwrap();
        worst = worst.max((a.mean[i] - b.mean[i]).abs() / si.max(a.mean[i].abs()));
        for j in 0..a.dim() {
            let sj = a.sd(j).unwrap();
            worst = worst.max((a.covariance[(i, j)] - b.covariance[(i, j)]).abs() / (si * sj));
        }
    }
    worst
}

/// Runs two filters side by side over one log; the largest distance on the way. The innovations are small differences
/// of large numbers, so they must agree to 1e-7 only.
pub(crate) fn compare(
    a: &mut dyn Filter,
    b: &mut dyn Filter,
    run: &Run,
    z: impl Fn(usize, &[f64]) -> Measurement,
) -> f64 {
    let mut worst = 0.0f64;
    for k in 0..run.z.len() {
        if k > 0 {
            let u = input(a.space(), k - 1);
            a.predict(&u, 0.01).unwrap();
            b.predict(&u, 0.01).unwrap();
        }
        let sample = z(k, &run.z[k]);
        let ia = a.update(&sample).unwrap();
        let ib = b.update(&sample).unwrap();
        assert_eq!(ia.dof, ib.dof);
        assert!(
            (ia.nis - ib.nis).abs() <= 1e-7 * ia.nis.max(1.0),
            "nis {} and {} at {k}",
            ia.nis,
            ib.nis
        );
        worst = worst.max(distance(a, b));
    }
    worst
}
