//! The 18-state robot under a fixed log, with a textbook Kalman filter as the reference of all filters.
//!
//! # Equation
//! x = A x + Γ f(0, u),  P = A P Aᵀ + Q;  K = P Cᵀ S⁻¹,  S = C P Cᵀ + R,  x += K (z - C x),
//! P = (I - K C) P (I - K C)ᵀ + K R Kᵀ.
//!
//! # Reference
//! R. E. Kalman, J. Basic Engineering 82 (1960); the robot: L. E. Ray, SPIE (2008), eqs 1-7.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_ekf::{
    AnyStateSpace, Filter, FilterConfig, Gaussian, LaneFilter, Measurement, Registry, Robust,
    discretise,
};

use crate::error::{BenchError, check};

/// Step \[s\].
pub const DT: f64 = 0.01;
/// Samples of the log.
pub const SAMPLES: usize = 200;
/// Largest difference of a belief from the reference, in standard deviations.
const ALLOWED: f64 = 1e-9;

/// Inputs and samples of two seconds of driving.
#[derive(Clone)]
pub struct Log {
    space: Arc<dyn AnyStateSpace>,
    inputs: Vec<Vec<f64>>,
    samples: Vec<Measurement>,
    raw: Vec<DVector<f64>>,
}

/// The step as every textbook writes it: x = A x, P = A P Aᵀ + Q, z = C x + noise of R, and the samples.
#[derive(Clone, Debug)]
pub struct Textbook {
    /// A (18 x 18).
    pub a: DMatrix<f64>,
    /// Q (18 x 18).
    pub q: DMatrix<f64>,
    /// C (7 x 18).
    pub c: DMatrix<f64>,
    /// R (7 x 7).
    pub r: DMatrix<f64>,
    /// Where it starts.
    pub prior: Gaussian,
    /// z (7) of each sample.
    pub samples: Vec<DVector<f64>>,
}

/// A value in (-1, 1) without pattern, the same on every machine.
fn scatter(k: usize, channel: usize) -> f64 {
    let t = (k * 7 + channel + 1) as f64 * 0.618_033_988_749_894_9;
    2.0 * t.fract() - 1.0
}

impl Log {
    /// Speed that rises and falls, wheels at 10 to 30 % slip, readings scattered by the noise of the sensors.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn new() -> Result<Self, BenchError> {
        let space = Registry::builtin().state_space("longitudinal-robot")?;
        let noise = space.measurement_noise();
        let (mut inputs, mut samples, mut raw) = (vec![], vec![], vec![]);
        for k in 0..SAMPLES {
            let t = DT * k as f64;
            let (speed, accel) = (1.0 + 0.3 * (2.0 * t).sin(), 0.6 * (2.0 * t).cos());
            let slip = 0.2 + 0.1 * (3.0 * t).sin();
            let wheel = speed / (0.254 * (1.0 - slip));
            let clean = [accel, wheel, wheel, wheel, wheel, speed, 0.05 * t.sin()];
            let z: Vec<f64> = clean
                .iter()
                .enumerate()
                .map(|(c, z)| z + noise[(c, c)].sqrt() * scatter(k, c))
                .collect();
            samples.push(Measurement::full(&z));
            raw.push(DVector::from_vec(z));
            inputs.push(
                (0..4)
                    .map(|q| 20.0 + 10.0 * (5.0 * t + q as f64).sin())
                    .collect(),
            );
        }
        Ok(Log {
            space,
            inputs,
            samples,
            raw,
        })
    }

    /// The same readings without torques: the problem of filters that know no input.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn without_inputs() -> Result<Self, BenchError> {
        let mut log = Self::new()?;
        for u in &mut log.inputs {
            u.fill(0.0);
        }
        Ok(log)
    }

    /// The matrices of one step, for a filter that is not ours.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn textbook(&self) -> Result<Textbook, BenchError> {
        let (rate, c) = self.space.system_matrices()?;
        let d = discretise(&rate, &self.space.process_noise(), DT)?;
        Ok(Textbook {
            a: d.a,
            q: d.q,
            c,
            r: self.space.measurement_noise(),
            prior: self.space.prior(),
            samples: self.raw.clone(),
        })
    }

    /// A filter by name at the prior, `robust` with the default robust update.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn filter(&self, name: &str, robust: bool) -> Result<Box<dyn Filter>, BenchError> {
        let config = FilterConfig {
            robust: robust.then(Robust::default),
            ..FilterConfig::default()
        };
        Ok(Registry::builtin().filter(name, Arc::clone(&self.space), config)?)
    }

    /// The block filter that keeps no accounts, at the prior.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn lanes(&self) -> Result<LaneFilter, BenchError> {
        Ok(LaneFilter::new(Arc::clone(&self.space))?)
    }

    /// One prediction and one update of it with sample `k`, which wraps around; `scored` with NIS and likelihood.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn step_lanes(
        &self,
        filter: &mut LaneFilter,
        k: usize,
        scored: bool,
    ) -> Result<f64, BenchError> {
        let k = k % SAMPLES;
        filter.predict(&self.inputs[k], DT)?;
        if scored {
            return Ok(filter.update_scored(&self.samples[k])?.log_likelihood);
        }
        filter.update(&self.samples[k])?;
        Ok(0.0)
    }

    /// One prediction and one update with sample `k`, which wraps around.
    ///
    /// # Errors
    /// [`BenchError::Filter`].
    pub fn step(&self, filter: &mut dyn Filter, k: usize) -> Result<(), BenchError> {
        let k = k % SAMPLES;
        filter.predict(&self.inputs[k], DT)?;
        filter.update(&self.samples[k])?;
        Ok(())
    }

    /// The belief after `steps` steps of the textbook filter.
    ///
    /// # Errors
    /// [`BenchError::Filter`], [`BenchError::Singular`].
    pub fn reference(&self, steps: usize) -> Result<Gaussian, BenchError> {
        let (rate, c) = self.space.system_matrices()?;
        let d = discretise(&rate, &self.space.process_noise(), DT)?;
        let r = self.space.measurement_noise();
        let n = rate.nrows();
        let mut belief = self.space.prior();
        for step in 0..steps {
            let k = step % SAMPLES;
            let drive = DVector::from_vec(self.space.rate_value(&vec![0.0; n], &self.inputs[k])?);
            let mean = &d.a * &belief.mean + &d.gamma * drive;
            let p = &d.a * &belief.covariance * d.a.transpose() + &d.q;
            let s = &c * &p * c.transpose() + &r;
            let inverse = s.try_inverse().ok_or(BenchError::Singular { step })?;
            let gain = &p * c.transpose() * inverse;
            let keep = DMatrix::identity(n, n) - &gain * &c;
            belief = Gaussian {
                mean: &mean + &gain * (&self.raw[k] - &c * &mean),
                covariance: &keep * p * keep.transpose() + &gain * &r * gain.transpose(),
            };
        }
        Ok(belief)
    }
}

/// Compares a belief with the reference, each entry against the standard deviations it belongs to.
///
/// # Errors
/// [`BenchError::Wrong`].
pub fn check_belief(name: &str, found: &Gaussian, reference: &Gaussian) -> Result<(), BenchError> {
    let sd = reference.covariance.diagonal().map(f64::sqrt);
    for i in 0..sd.len() {
        let what = format!("state {i} of {name}");
        let (mean, right) = (found.mean[i], reference.mean[i]);
        check(&what, mean, right, sd[i].max(right.abs()), ALLOWED)?;
        for j in 0..=i {
            let what = format!("covariance of states {i} and {j} of {name}");
            let (p, right) = (found.covariance[(i, j)], reference.covariance[(i, j)]);
            check(&what, p, right, sd[i] * sd[j], ALLOWED)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(log: &Log, name: &str, steps: usize) -> Gaussian {
        let mut filter = log.filter(name, false).unwrap();
        for k in 0..steps {
            log.step(&mut *filter, k).unwrap();
        }
        filter.belief().clone()
    }

    #[test]
    fn block_kf_and_ekf_agree_with_the_textbook_filter() {
        let log = Log::new().unwrap();
        let steps = SAMPLES + 20;
        let reference = log.reference(steps).unwrap();
        for name in ["block", "kf", "ekf"] {
            check_belief(name, &run(&log, name, steps), &reference).unwrap();
        }
    }

    #[test]
    fn lanes_agree_with_the_textbook_filter() {
        let log = Log::new().unwrap();
        let mut filter = log.lanes().unwrap();
        for k in 0..SAMPLES + 20 {
            log.step_lanes(&mut filter, k, k % 2 == 0).unwrap();
        }
        let reference = log.reference(SAMPLES + 20).unwrap();
        check_belief("lanes", &filter.belief(), &reference).unwrap();
    }

    #[test]
    fn a_step_left_out_is_noticed() {
        let log = Log::new().unwrap();
        let reference = log.reference(50).unwrap();
        assert!(check_belief("block", &run(&log, "block", 49), &reference).is_err());
    }
}
