//! A filter of one's own: a Kalman filter that forgets, for soil that changes faster than the walk of its states says.

// An example may print, and may stop where it is wrong.
#![allow(clippy::print_stdout)]

use std::sync::Arc;

use nalgebra::DMatrix;
use terra::ekf::{
    AnyStateSpace, Coupling, Filter, FilterConfig, FilterEntry, FilterError, Gaussian, Innovation,
    Measurement, Registry,
};

/// Variances grow by exp(dt / MEMORY) on the way from sample to sample, so an old sample weighs less than a new one
/// (H. W. Sorenson and J. E. Sacks, Information Sciences 3 (1971)). All the rest is the extended filter within.
struct Fading {
    inner: Box<dyn Filter>,
}

/// Time in which an old sample's weight falls to 1/e [s].
const MEMORY: f64 = 0.5;

impl Filter for Fading {
    fn name(&self) -> &'static str {
        "fading"
    }
    fn space(&self) -> &dyn AnyStateSpace {
        self.inner.space()
    }
    fn predict(&mut self, u: &[f64], dt: f64) -> Result<(), FilterError> {
        self.inner.predict(u, dt)?;
        let growth = (dt / MEMORY).exp_m1();
        let variance = self.inner.belief().covariance.diagonal() * growth;
        self.inner.widen(variance.as_slice())
    }
    fn update(&mut self, z: &Measurement) -> Result<Innovation, FilterError> {
        self.inner.update(z)
    }
    fn widen(&mut self, variance: &[f64]) -> Result<(), FilterError> {
        self.inner.widen(variance)
    }
    fn boxed_clone(&self) -> Box<dyn Filter> {
        let inner = self.inner.boxed_clone();
        Box::new(Fading { inner })
    }
    fn belief(&self) -> &Gaussian {
        self.inner.belief()
    }
    fn predicted(&self) -> &Gaussian {
        self.inner.predicted()
    }
    fn cross_covariance(&self) -> &DMatrix<f64> {
        self.inner.cross_covariance()
    }
    fn restart(&mut self, belief: Gaussian) -> Result<(), FilterError> {
        self.inner.restart(belief)
    }
    fn resets(&self) -> &[usize] {
        self.inner.resets()
    }
    fn couplings(&self) -> &[Coupling] {
        self.inner.couplings()
    }
}

fn registry() -> Registry {
    Registry::builtin().with_filter(FilterEntry {
        name: "fading",
        summary: "extended Kalman filter that forgets old samples",
        reference: "H. W. Sorenson and J. E. Sacks, Information Sciences 3 (1971)",
        linear_only: false,
        build: |space: Arc<dyn AnyStateSpace>, config: FilterConfig| {
            let inner = Registry::builtin().filter("ekf", space, config)?;
            Ok(Box::new(Fading { inner }))
        },
    })
}

/// Standard deviation of the first state, and its mean, after a second at one reading and a tenth of one at another.
fn after_a_jump(name: &str) -> Result<(f64, f64), FilterError> {
    let registry = registry();
    let space = registry.state_space("longitudinal-robot")?;
    let mut filter = registry.filter(name, Arc::clone(&space), FilterConfig::default())?;
    let dims = space.dims();
    for k in 0..110 {
        let speed = if k < 100 { 0.0 } else { 0.5 };
        let reading: Vec<f64> = space
            .measurement_names()
            .iter()
            .map(|channel| if *channel == "v" { speed } else { 0.0 })
            .collect();
        filter.predict(&vec![0.0; dims.input], 0.01)?;
        filter.update(&Measurement::full(&reading))?;
    }
    let belief = filter.belief();
    let v = space
        .state_names()
        .iter()
        .position(|s| *s == "ground_speed_m_s");
    let v = v.unwrap_or(0);
    Ok((belief.sd(v).unwrap_or(f64::NAN), belief.mean[v]))
}

fn main() -> Result<(), FilterError> {
    for name in ["ekf", "fading"] {
        let (sd, speed) = after_a_jump(name)?;
        println!("{name}: {speed:.3} ± {sd:.3} m/s a tenth of a second after a jump to 0.5");
    }
    Ok(())
}

/// What forgets is less sure and nearer to the new reading.
#[test]
fn it_forgets() -> Result<(), FilterError> {
    let (usual_sd, usual) = after_a_jump("ekf")?;
    let (sd, speed) = after_a_jump("fading")?;
    assert!(sd > usual_sd, "{sd} {usual_sd}");
    assert!(usual < speed && speed < 0.5, "{usual} {speed}");
    Ok(())
}
