//! How a filter is run.

use crate::error::FilterError;

/// Order of work in an update. With independent channels both give the same belief.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpdateForm {
    /// All channels at once, P ← (I-KC) P (I-KC)ᵀ + K R Kᵀ.
    #[default]
    Joseph,
    /// One channel after the other, without a matrix inverse; needs a diagonal R.
    Sequential,
}

/// How much a channel far from its prediction may say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RobustLaw {
    /// The innovation counts in full up to `threshold` standard deviations, and as much as that beyond.
    Huber {
        /// In standard deviations.
        threshold: f64,
    },
    /// Noise with heavy tails: the variance is multiplied by (dof + e²)/(dof + 1) where that exceeds 1, so that a
    /// gross outlier has no say at all.
    StudentT {
        /// Degrees of freedom of the tail.
        dof: f64,
    },
}

/// Robust update of each channel.
///
/// A gate that only rejects locks a filter out: after a dropout every sample lies outside the gate of a prediction that
/// has gone astray. Hence a weight instead of a gate, and after `reject_timeout` of unbroken rejection the covariance of
/// the states behind the channel goes back to the prior and the sample counts in full: a visible, counted event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robust {
    /// Weight of an innovation.
    pub law: RobustLaw,
    /// Time of unbroken rejection after which the covariance is reset \[s\].
    pub reject_timeout: f64,
}

impl Default for Robust {
    /// Tails light enough that a force that really changes fast (a start, a torque step) is followed as closely as by the
    /// plain filter; a timeout longer than the half second for which sensors are known to stick.
    fn default() -> Self {
        Robust {
            law: RobustLaw::StudentT { dof: 10.0 },
            reject_timeout: 0.6,
        }
    }
}

impl Robust {
    /// Factor on S_ii for an innovation of `e` standard deviations.
    pub(crate) fn inflation(&self, e: f64) -> f64 {
        match self.law {
            RobustLaw::Huber { threshold } => (e.abs() / threshold).max(1.0),
            RobustLaw::StudentT { dof } => ((dof + e * e) / (dof + 1.0)).max(1.0),
        }
    }
}

/// Spread of the unscented filter's points: weights follow from n + λ = α² (n + κ), centre weight of the covariance + 1 - α² + β.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unscented {
    /// α > 0.
    pub alpha: f64,
    /// β.
    pub beta: f64,
    /// κ > -n.
    pub kappa: f64,
}

impl Default for Unscented {
    /// All weights positive, so that every covariance is positive semi-definite whatever the model does.
    fn default() -> Self {
        Unscented {
            alpha: 1.0,
            beta: 0.0,
            kappa: 3.0,
        }
    }
}

/// Samples of the particle filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particles {
    /// How many.
    pub count: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// States that can be carried exactly are: on a linear state space all of them.
    pub marginalise: bool,
}

impl Default for Particles {
    fn default() -> Self {
        Particles {
            count: 500,
            seed: 1,
            marginalise: true,
        }
    }
}

/// Settings of a filter; the default is the plain filter of the textbooks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterConfig {
    /// Joint or one channel after the other.
    pub form: UpdateForm,
    /// Robust update; `None` (default) gives every channel its nominal weight.
    pub robust: Option<Robust>,
    /// Standard deviations at which [`Innovation::ratio`](crate::Innovation::ratio) is 1.
    pub gate: f64,
    /// Longest Runge-Kutta step of a nonlinear state space \[s\].
    pub max_step: f64,
    /// Most iterations of the iterated filter.
    pub max_iterations: usize,
    /// Points of the unscented filter.
    pub unscented: Unscented,
    /// Samples of the particle filter.
    pub particles: Particles,
}

impl Default for FilterConfig {
    fn default() -> Self {
        FilterConfig {
            form: UpdateForm::Joseph,
            robust: None,
            gate: 5.0,
            max_step: 0.02,
            max_iterations: 30,
            unscented: Unscented::default(),
            particles: Particles::default(),
        }
    }
}

impl FilterConfig {
    pub(crate) fn check(&self, states: usize) -> Result<(), FilterError> {
        let positive = |key, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(FilterError::Config {
                    key,
                    value,
                    expected: "a positive number",
                })
            }
        };
        positive("gate", self.gate)?;
        positive("max_step", self.max_step)?;
        positive("max_iterations", self.max_iterations as f64)?;
        positive("alpha", self.unscented.alpha)?;
        positive(
            "kappa + number of states",
            self.unscented.kappa + states as f64,
        )?;
        if let Some(robust) = self.robust {
            positive("reject_timeout", robust.reject_timeout)?;
            match robust.law {
                RobustLaw::Huber { threshold } => positive("threshold", threshold)?,
                RobustLaw::StudentT { dof } => positive("dof", dof)?,
            }
        }
        Ok(())
    }
}
