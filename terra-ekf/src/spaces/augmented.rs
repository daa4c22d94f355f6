//! Extra constants of a state space, estimated along with its states: an unknown slope, the bias or scale of a sensor, the
//! scale of an input. Works around any state space; what the data can tell of them, the observability rank says.
//!
//! # Equation
//! State \[x; e\], e' white of the walk given (0 for a constant). Slope: x_s' gains -g sin e. Bias: z_c + e. Scale of a
//! channel: (1 + e) z_c. Scale of inputs: f(x, u₀) + (1 + e)(f(x, u) - f(x, u₀)), u₀ = u with those inputs zero, exact
//! where f is affine in them.
//!
//! # Reference
//! A. H. Jazwinski, *Stochastic Processes and Filtering Theory*, Academic Press (1970), section 8.4 (state augmentation).

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::{Dual8, Scalar};

use super::longitudinal_robot::{GRAVITY, V, Z_AX, Z_V};
use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::state_space::{AnyStateSpace, Dims, StateSpaceAt};
use crate::structure::Blocks;

/// What an extra state does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// Slope of the ground \[rad\], nose-up positive, that pulls at this speed state.
    Slope(usize),
    /// Added to this channel, in its unit.
    ChannelBias(usize),
    /// Relative error of this channel \[1\].
    ChannelScale(usize),
    /// Relative error of these inputs \[1\].
    InputScale(Vec<usize>),
}

/// One extra state.
#[derive(Clone, Debug, PartialEq)]
pub struct Extra {
    /// Name, with its unit.
    pub name: &'static str,
    /// What it does.
    pub role: Role,
    /// 1-sigma before the first sample.
    pub prior_sd: f64,
    /// Spectral density of its walk, its unit squared per second; 0 for a constant.
    pub walk: f64,
}

impl Extra {
    /// Unknown slope under the [`LongitudinalRobot`](super::LongitudinalRobot), 1-sigma .1 rad.
    pub fn pitch() -> Self {
        Extra {
            name: "pitch_rad",
            role: Role::Slope(V),
            prior_sd: 0.1,
            walk: 0.0,
        }
    }
    /// Bias of its accelerometer, 1-sigma .2 m/s².
    pub fn accel_bias() -> Self {
        Extra {
            name: "accel_bias_m_s2",
            role: Role::ChannelBias(Z_AX),
            prior_sd: 0.2,
            walk: 0.0,
        }
    }
    /// Relative error of its four torques, 1-sigma .1.
    pub fn torque_scale() -> Self {
        Extra {
            name: "torque_scale",
            role: Role::InputScale(vec![0, 1, 2, 3]),
            prior_sd: 0.1,
            walk: 0.0,
        }
    }
    /// Relative error of its ground speed, 1-sigma .05.
    pub fn speed_scale() -> Self {
        Extra {
            name: "speed_scale",
            role: Role::ChannelScale(Z_V),
            prior_sd: 0.05,
            walk: 0.0,
        }
    }
}

/// f(x, u) of the state space inside.
type InnerRate<'a, T> = dyn Fn(&[T], &[f64], &mut [T]) -> Result<(), FilterError> + 'a;

/// A state space with extra states behind its own.
#[derive(Clone)]
pub struct Augmented {
    inner: Arc<dyn AnyStateSpace>,
    extras: Vec<Extra>,
    names: Vec<&'static str>,
}

impl Augmented {
    /// Adds extra states.
    ///
    /// # Errors
    /// [`FilterError::Size`] for a state, channel or input the state space does not have, [`FilterError::Config`] for a
    /// spread or walk that is none.
    pub fn new(inner: Arc<dyn AnyStateSpace>, extras: Vec<Extra>) -> Result<Self, FilterError> {
        let dims = inner.dims();
        for extra in &extras {
            let (what, limit, used) = match &extra.role {
                Role::Slope(s) => ("state of a slope", dims.state, *s),
                Role::ChannelBias(c) => ("channel of a bias", dims.measurement, *c),
                Role::ChannelScale(c) => ("channel of a scale", dims.measurement, *c),
                Role::InputScale(inputs) => (
                    "inputs of a scale",
                    dims.input,
                    inputs.iter().copied().max().unwrap_or(0),
                ),
            };
            if used >= limit {
                return Err(FilterError::Size {
                    what,
                    expected: limit,
                    found: used,
                });
            }
            for (key, value, legal) in [
                ("prior_sd", extra.prior_sd, extra.prior_sd > 0.0),
                ("walk", extra.walk, extra.walk >= 0.0),
            ] {
                if !(legal && value < 1e100) {
                    return Err(FilterError::Config {
                        key,
                        value,
                        expected: "a number that is not negative, and a spread above zero",
                    });
                }
            }
        }
        let own = inner.state_names().iter().copied();
        let names = own.chain(extras.iter().map(|e| e.name)).collect();
        Ok(Augmented {
            inner,
            extras,
            names,
        })
    }

    /// Index of the first extra state.
    pub fn first_extra(&self) -> usize {
        self.inner.dims().state
    }

    fn rate_with<T: Scalar>(
        &self,
        inner: &InnerRate<'_, T>,
        x: &[T],
        u: &[f64],
        rate: &mut [T],
    ) -> Result<(), FilterError> {
        let n = self.inner.dims().state;
        let (own, extra) = x.split_at(n);
        inner(own, u, &mut rate[..n])?;
        rate[n..].fill(T::zero());
        for (e, kind) in extra.iter().zip(&self.extras) {
            match &kind.role {
                Role::Slope(s) => rate[*s] -= e.sin_cos().0 * GRAVITY,
                Role::InputScale(inputs) => {
                    let mut without = u.to_vec();
                    for &k in inputs {
                        without[k] = 0.0;
                    }
                    let (mut with, mut rest) = (vec![T::zero(); n], vec![T::zero(); n]);
                    inner(own, u, &mut with)?;
                    inner(own, &without, &mut rest)?;
                    for k in 0..n {
                        rate[k] += (with[k] - rest[k]) * *e;
                    }
                }
                Role::ChannelBias(_) | Role::ChannelScale(_) => {}
            }
        }
        Ok(())
    }

    fn measure_with<T: Scalar>(&self, x: &[T], z: &mut [T]) {
        let n = self.inner.dims().state;
        for (e, kind) in x[n..].iter().zip(&self.extras) {
            match kind.role {
                Role::ChannelBias(c) => z[c] += *e,
                Role::ChannelScale(c) => z[c] *= *e + 1.0,
                Role::Slope(_) | Role::InputScale(_) => {}
            }
        }
    }
}

macro_rules! at {
    ($scalar:ty) => {
        impl StateSpaceAt<$scalar> for Augmented {
            fn rate_at(
                &self,
                x: &[$scalar],
                u: &[f64],
                rate: &mut [$scalar],
            ) -> Result<(), FilterError> {
                let inner = |x: &[$scalar], u: &[f64], rate: &mut [$scalar]| {
                    StateSpaceAt::<$scalar>::rate_at(&*self.inner, x, u, rate)
                };
                self.rate_with(&inner, x, u, rate)
            }
            fn measure_at(&self, x: &[$scalar], z: &mut [$scalar]) -> Result<(), FilterError> {
                let n = self.inner.dims().state;
                StateSpaceAt::<$scalar>::measure_at(&*self.inner, &x[..n], z)?;
                self.measure_with(x, z);
                Ok(())
            }
        }
    };
}
at!(f64);
at!(Dual8);

/// A diagonal block behind a matrix.
fn behind(m: DMatrix<f64>, diagonal: impl Iterator<Item = f64>) -> DMatrix<f64> {
    let n = m.nrows();
    let more: Vec<f64> = diagonal.collect();
    let mut out = DMatrix::zeros(n + more.len(), n + more.len());
    out.view_mut((0, 0), (n, n)).copy_from(&m);
    for (k, v) in more.into_iter().enumerate() {
        out[(n + k, n + k)] = v;
    }
    out
}

impl AnyStateSpace for Augmented {
    fn name(&self) -> &'static str {
        self.inner.name()
    }
    fn summary(&self) -> &'static str {
        self.inner.summary()
    }
    fn reference(&self) -> &'static str {
        self.inner.reference()
    }
    fn dims(&self) -> Dims {
        let dims = self.inner.dims();
        Dims {
            state: dims.state + self.extras.len(),
            ..dims
        }
    }
    fn state_names(&self) -> &[&'static str] {
        &self.names
    }
    fn input_names(&self) -> &[&'static str] {
        self.inner.input_names()
    }
    fn measurement_names(&self) -> &[&'static str] {
        self.inner.measurement_names()
    }
    fn process_noise(&self) -> DMatrix<f64> {
        behind(
            self.inner.process_noise(),
            self.extras.iter().map(|e| e.walk),
        )
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        self.inner.measurement_noise()
    }
    fn prior(&self) -> Gaussian {
        let prior = self.inner.prior();
        let n = prior.dim();
        let mut mean = DVector::zeros(n + self.extras.len());
        mean.rows_mut(0, n).copy_from(&prior.mean);
        let spread = self.extras.iter().map(|e| e.prior_sd * e.prior_sd);
        Gaussian {
            mean,
            covariance: behind(prior.covariance, spread),
        }
    }
    /// A bias keeps a linear state space linear; slopes and scales multiply or bend.
    fn is_linear(&self) -> bool {
        let bias = |e: &Extra| matches!(e.role, Role::ChannelBias(_));
        self.inner.is_linear() && self.extras.iter().all(bias)
    }
    /// A scale of an input multiplies it with a state.
    fn affine_input(&self) -> bool {
        self.is_linear() && self.inner.affine_input()
    }
    fn blocks(&self) -> Blocks {
        Blocks::Dense
    }
}
