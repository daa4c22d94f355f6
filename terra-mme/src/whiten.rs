//! Residuals of a force filter repeat themselves from sample to sample; weighed as if independent they overstate
//! what is known. First-order prewhitening takes the repeated part out.
//!
//! # Equation
//! r~_k = r_k - ρ r_(k-1), S~ = S (1 - ρ²); over a gap of Δt ρ^(Δt/Δt0); the first of a group as it is.
//! Without it the variance of log-odds is too large by (1 + ρ)/(1 - ρ).

use crate::error::EstimatorError;
use crate::observation::ForceObservation;

/// Correlation of residuals from one sample to the next, and the interval it holds for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prewhitening {
    rho: f64,
    interval: f64,
}

impl Prewhitening {
    /// ρ in [0, 1) between samples `interval` apart \[s\].
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn new(rho: f64, interval: f64) -> Result<Self, EstimatorError> {
        let value = |what: &str, value, expected| EstimatorError::Value {
            what: what.to_owned(),
            value,
            expected,
        };
        if !(0.0..1.0).contains(&rho) {
            return Err(value("prewhitening rho", rho, "a correlation in [0, 1)"));
        }
        if !(interval.is_finite() && interval > 0.0) {
            return Err(value(
                "prewhitening interval",
                interval,
                "a finite time above 0 s",
            ));
        }
        Ok(Prewhitening { rho, interval })
    }

    /// ρ between samples one interval apart.
    pub fn rho(self) -> f64 {
        self.rho
    }

    /// ρ^(Δt/Δt0).
    pub fn over(self, dt: f64) -> f64 {
        self.rho.powf(dt / self.interval)
    }
}

/// Group, time and shape of the last observation: what decides whether the next may be whitened against it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock {
    last: Option<(usize, f64, nalgebra::DMatrix<f64>)>,
}

impl Clock {
    /// The correlation with the observation before: 0 at the start of a group, after a change of what is measured,
    /// and without prewhitening.
    ///
    /// # Errors
    /// [`EstimatorError::TimeOrder`] when time does not advance inside a group.
    pub(crate) fn correlation(
        &self,
        obs: &ForceObservation,
        whitening: Option<Prewhitening>,
    ) -> Result<f64, EstimatorError> {
        match &self.last {
            Some((group, time, map)) => correlation((*group, *time, map), obs, whitening),
            None => Ok(0.0),
        }
    }

    /// The same between two observations.
    ///
    /// # Errors
    /// As [`correlation`](Self::correlation).
    pub(crate) fn between(
        before: &ForceObservation,
        obs: &ForceObservation,
        whitening: Option<Prewhitening>,
    ) -> Result<f64, EstimatorError> {
        correlation((before.group, before.time, &before.map), obs, whitening)
    }

    /// True when the observation continues the group of the one before.
    pub(crate) fn follows(&self, obs: &ForceObservation) -> bool {
        self.last
            .as_ref()
            .is_some_and(|(group, ..)| *group == obs.group)
    }

    /// Moves on to the next observation.
    pub(crate) fn advance(&mut self, obs: &ForceObservation) {
        match &mut self.last {
            Some((group, time, map)) if equal(map, &obs.map) => {
                (*group, *time) = (obs.group, obs.time)
            }
            _ => self.last = Some((obs.group, obs.time, obs.map.clone())),
        }
    }
}

/// Without a branch a number: asked at every sample, and nearly always answered yes.
fn equal(a: &nalgebra::DMatrix<f64>, b: &nalgebra::DMatrix<f64>) -> bool {
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(true, |all, (a, b)| all & (a == b));
    a.shape() == b.shape() && same(a.as_slice(), b.as_slice())
}

fn correlation(
    (group, time, map): (usize, f64, &nalgebra::DMatrix<f64>),
    obs: &ForceObservation,
    whitening: Option<Prewhitening>,
) -> Result<f64, EstimatorError> {
    if group != obs.group {
        return Ok(0.0);
    }
    let dt = obs.time - time;
    if dt <= 0.0 {
        return Err(EstimatorError::TimeOrder {
            time: obs.time,
            previous: time,
        });
    }
    let same = |_: &Prewhitening| equal(map, &obs.map);
    Ok(whitening.filter(same).map_or(0.0, |w| w.over(dt)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_fades_over_a_gap_and_odd_numbers_are_refused() {
        let w = Prewhitening::new(0.8, 0.01).unwrap();
        assert!((w.over(0.01) - 0.8).abs() < 1e-15);
        assert!((w.over(0.03) - 0.512).abs() < 1e-12);
        for (rho, dt) in [
            (1.0, 0.01),
            (-0.1, 0.01),
            (f64::NAN, 0.01),
            (0.8, 0.0),
            (0.8, f64::INFINITY),
        ] {
            assert!(Prewhitening::new(rho, dt).is_err());
        }
    }
}
