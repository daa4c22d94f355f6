//! The filters: one file each, over one shared frame.

mod account;
mod block;
mod dense;
mod ekf;
mod factored;
mod group;
mod iekf;
mod kf;
mod lane;
mod lane_filter;
mod lanes;
mod moments;
mod particle;
mod sigma;

pub use account::Score;
pub use block::BlockFilter;
pub use dense::DenseFilter;
pub use ekf::Extended;
pub use factored::{Factor, Factored, SquareRoot, UnitDiagonal};
pub use iekf::Iterated;
pub use kf::Linear;
pub use lane_filter::LaneFilter;
pub use particle::Particle;
pub use sigma::SigmaPoint;

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::config::{FilterConfig, UpdateForm};
use crate::discretise::Steps;
use crate::error::FilterError;
use crate::gaussian::{Gaussian, check_covariance};
use crate::measurement::Measurement;
use crate::state_space::AnyStateSpace;

/// A state space with its noise, checked once.
#[derive(Clone)]
pub struct Model {
    pub(crate) space: Arc<dyn AnyStateSpace>,
    pub(crate) q: DMatrix<f64>,
    pub(crate) r: DMatrix<f64>,
    pub(crate) prior: Gaussian,
    pub(crate) config: FilterConfig,
    /// Exact discretisations; `None` for a nonlinear state space.
    pub(crate) steps: Option<Steps>,
}

impl Model {
    pub(crate) fn new(
        space: Arc<dyn AnyStateSpace>,
        config: FilterConfig,
    ) -> Result<Self, FilterError> {
        let dims = space.dims();
        config.check(dims.state)?;
        let size = |what, expected: usize, found: usize| {
            if expected == found {
                Ok(())
            } else {
                Err(FilterError::Size {
                    what,
                    expected,
                    found,
                })
            }
        };
        let (q, r, prior) = (
            space.process_noise(),
            space.measurement_noise(),
            space.prior(),
        );
        size("process noise", dims.state, q.nrows())?;
        size("measurement noise", dims.measurement, r.nrows())?;
        size("prior", dims.state, prior.dim())?;
        size("state names", dims.state, space.state_names().len())?;
        size(
            "measurement names",
            dims.measurement,
            space.measurement_names().len(),
        )?;
        check_covariance("process noise", &q)?;
        check_covariance("measurement noise", &r)?;
        let prior = Gaussian::new(prior.mean, prior.covariance)?;
        if config.form == UpdateForm::Sequential {
            for i in 0..dims.measurement {
                for j in 0..i {
                    if r[(i, j)] != 0.0 {
                        return Err(FilterError::CorrelatedNoise {
                            first: space.measurement_names()[j].to_owned(),
                            second: space.measurement_names()[i].to_owned(),
                        });
                    }
                }
            }
        }
        let steps = if space.is_linear() {
            Some(Steps::new(space.system_matrices()?.0, q.clone()))
        } else {
            None
        };
        Ok(Model {
            space,
            q,
            r,
            prior,
            config,
            steps,
        })
    }

    /// Input and step of a prediction.
    pub(crate) fn check_step(&self, u: &[f64], dt: f64, time: f64) -> Result<(), FilterError> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(FilterError::TimeStep { dt, time });
        }
        let expected = self.space.dims().input;
        if u.len() != expected {
            return Err(FilterError::Size {
                what: "input",
                expected,
                found: u.len(),
            });
        }
        crate::gaussian::check_finite("input", u)
    }

    /// Variances that may be added to a belief.
    pub(crate) fn check_widening(&self, variance: &[f64]) -> Result<(), FilterError> {
        let expected = self.space.dims().state;
        if variance.len() != expected {
            return Err(FilterError::Size {
                what: "added variance",
                expected,
                found: variance.len(),
            });
        }
        match variance.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            Some(&value) => Err(FilterError::NotACovariance {
                what: "added variance",
                reason: "negative or not finite",
                value,
            }),
            None => Ok(()),
        }
    }

    /// The error of a reading `deviations` standard deviations off.
    pub(crate) fn implausible(&self, row: usize, z: &Measurement, deviations: f64) -> FilterError {
        FilterError::Implausible {
            channel: self.channel(row),
            value: z.get(row).unwrap_or(f64::MAX),
            deviations,
        }
    }

    /// The name of a channel.
    pub(crate) fn channel(&self, row: usize) -> String {
        self.space
            .measurement_names()
            .get(row)
            .map_or_else(|| row.to_string(), |n| (*n).to_owned())
    }
}
