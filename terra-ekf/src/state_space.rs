//! The trait a state space's author writes, and its erased form.

use nalgebra::DMatrix;
use terra_model::{Dual8, Scalar, jacobian};

use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::structure::Blocks;

/// Sizes of a state space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dims {
    /// n.
    pub state: usize,
    /// Number of known inputs.
    pub input: usize,
    /// m.
    pub measurement: usize,
}

/// What an author writes: how a state moves and what sensors see of it.
///
/// # Equation
/// x' = f(x, u) + white noise of spectral density Q, z = h(x) + noise of covariance R.
///
/// `rate` and `measure` are generic in [`Scalar`] (a [`Real`](terra_model::Real) at which erased terrain models can be
/// called too), which gives every filter exact Jacobians.
pub trait StateSpace: Send + Sync + 'static {
    /// Kebab-case name.
    fn name(&self) -> &'static str;
    /// One line: what it describes.
    fn summary(&self) -> &'static str;
    /// Where the equations come from.
    fn reference(&self) -> &'static str;
    /// Sizes.
    fn dims(&self) -> Dims;
    /// Name of each state, with its unit.
    fn state_names(&self) -> &'static [&'static str];
    /// Name of each input, with its unit.
    fn input_names(&self) -> &'static [&'static str];
    /// Name of each measured channel, with its unit.
    fn measurement_names(&self) -> &'static [&'static str];

    /// f(x, u): writes x' (n) for the state `x` (n) and input `u`.
    ///
    /// # Errors
    /// Whatever the model inside raises.
    fn rate<T: Scalar>(&self, x: &[T], u: &[f64], rate: &mut [T]) -> Result<(), FilterError>;

    /// h(x): writes z (m) for the state `x` (n).
    ///
    /// # Errors
    /// Whatever the model inside raises.
    fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError>;

    /// Q (n x n): spectral density of the process noise, unit of x² per second.
    fn process_noise(&self) -> DMatrix<f64>;
    /// R (m x m): covariance of the measurement noise, unit of z².
    fn measurement_noise(&self) -> DMatrix<f64>;
    /// Belief before the first sample.
    fn prior(&self) -> Gaussian;

    /// True when f is affine in x with constant coefficients and h is linear: gains then depend on no data.
    fn linear(&self) -> bool {
        false
    }
    /// True when f is affine in u too, with coefficients that no x changes: f(x, u) = f(x, 0) + B u. A fast filter then need
    /// not ask for f at every step.
    fn affine_input(&self) -> bool {
        false
    }
    /// Which states are independent of each other.
    fn blocks(&self) -> Blocks {
        Blocks::Dense
    }
}

/// A state space at one scalar: generic methods are not object safe, so the scalar moves to the trait.
pub trait StateSpaceAt<T: Scalar>: Send + Sync {
    /// See [`StateSpace::rate`].
    ///
    /// # Errors
    /// As there.
    fn rate_at(&self, x: &[T], u: &[f64], rate: &mut [T]) -> Result<(), FilterError>;
    /// See [`StateSpace::measure`].
    ///
    /// # Errors
    /// As there.
    fn measure_at(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError>;
}

impl<S: StateSpace, T: Scalar> StateSpaceAt<T> for S {
    fn rate_at(&self, x: &[T], u: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
        self.rate(x, u, rate)
    }
    fn measure_at(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
        self.measure(x, z)
    }
}

/// Any state space, known only by name.
pub trait AnyStateSpace: StateSpaceAt<f64> + StateSpaceAt<Dual8> {
    /// See [`StateSpace::name`].
    fn name(&self) -> &'static str;
    /// See [`StateSpace::summary`].
    fn summary(&self) -> &'static str;
    /// See [`StateSpace::reference`].
    fn reference(&self) -> &'static str;
    /// See [`StateSpace::dims`].
    fn dims(&self) -> Dims;
    /// See [`StateSpace::state_names`].
    fn state_names(&self) -> &[&'static str];
    /// See [`StateSpace::input_names`].
    fn input_names(&self) -> &[&'static str];
    /// See [`StateSpace::measurement_names`].
    fn measurement_names(&self) -> &[&'static str];
    /// See [`StateSpace::process_noise`].
    fn process_noise(&self) -> DMatrix<f64>;
    /// See [`StateSpace::measurement_noise`].
    fn measurement_noise(&self) -> DMatrix<f64>;
    /// See [`StateSpace::prior`].
    fn prior(&self) -> Gaussian;
    /// See [`StateSpace::linear`].
    fn is_linear(&self) -> bool;
    /// See [`StateSpace::affine_input`].
    fn affine_input(&self) -> bool;
    /// See [`StateSpace::blocks`].
    fn blocks(&self) -> Blocks;
}

impl<S: StateSpace> AnyStateSpace for S {
    fn name(&self) -> &'static str {
        StateSpace::name(self)
    }
    fn summary(&self) -> &'static str {
        StateSpace::summary(self)
    }
    fn reference(&self) -> &'static str {
        StateSpace::reference(self)
    }
    fn dims(&self) -> Dims {
        StateSpace::dims(self)
    }
    fn state_names(&self) -> &[&'static str] {
        StateSpace::state_names(self)
    }
    fn input_names(&self) -> &[&'static str] {
        StateSpace::input_names(self)
    }
    fn measurement_names(&self) -> &[&'static str] {
        StateSpace::measurement_names(self)
    }
    fn process_noise(&self) -> DMatrix<f64> {
        StateSpace::process_noise(self)
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        StateSpace::measurement_noise(self)
    }
    fn prior(&self) -> Gaussian {
        StateSpace::prior(self)
    }
    fn is_linear(&self) -> bool {
        self.linear()
    }
    fn affine_input(&self) -> bool {
        StateSpace::affine_input(self)
    }
    fn blocks(&self) -> Blocks {
        StateSpace::blocks(self)
    }
}

impl dyn AnyStateSpace + '_ {
    /// f(x, u) as a vector (n).
    ///
    /// # Errors
    /// See [`StateSpace::rate`].
    pub fn rate_value(&self, x: &[f64], u: &[f64]) -> Result<Vec<f64>, FilterError> {
        let mut rate = vec![0.0; self.dims().state];
        StateSpaceAt::<f64>::rate_at(self, x, u, &mut rate)?;
        Ok(rate)
    }

    /// h(x) as a vector (m).
    ///
    /// # Errors
    /// See [`StateSpace::measure`].
    pub fn measure_value(&self, x: &[f64]) -> Result<Vec<f64>, FilterError> {
        let mut z = vec![0.0; self.dims().measurement];
        StateSpaceAt::<f64>::measure_at(self, x, &mut z)?;
        Ok(z)
    }

    /// f(x, u) and its exact Jacobian in x (n x n).
    ///
    /// # Errors
    /// See [`StateSpace::rate`].
    pub fn rate_jacobian(
        &self,
        x: &[f64],
        u: &[f64],
    ) -> Result<(Vec<f64>, DMatrix<f64>), FilterError> {
        jacobian(x, |dual| {
            let mut rate = vec![Dual8::from(0.0); self.dims().state];
            StateSpaceAt::<Dual8>::rate_at(self, dual, u, &mut rate)?;
            Ok(rate)
        })
    }

    /// h(x) and its exact Jacobian in x (m x n).
    ///
    /// # Errors
    /// See [`StateSpace::measure`].
    pub fn measure_jacobian(&self, x: &[f64]) -> Result<(Vec<f64>, DMatrix<f64>), FilterError> {
        jacobian(x, |dual| {
            let mut z = vec![Dual8::from(0.0); self.dims().measurement];
            StateSpaceAt::<Dual8>::measure_at(self, dual, &mut z)?;
            Ok(z)
        })
    }

    /// A (n x n) and C (m x n) of a linear state space; of another, its Jacobians at the prior mean and zero input.
    ///
    /// # Errors
    /// See [`StateSpace::rate`].
    pub fn system_matrices(&self) -> Result<(DMatrix<f64>, DMatrix<f64>), FilterError> {
        let x = self.prior().mean;
        let u = vec![0.0; self.dims().input];
        Ok((
            self.rate_jacobian(x.as_slice(), &u)?.1,
            self.measure_jacobian(x.as_slice())?.1,
        ))
    }

    /// Rank of the observability matrix of the channels listed; of a nonlinear state space, linearised at the prior mean
    /// without input.
    ///
    /// # Equation
    /// rank \[C; CA; ...; CA^(n-1)\], computed by growing an orthonormal basis of its row space one power of A at a
    /// time: the plain stack spans so many orders of magnitude that its singular values decide nothing.
    ///
    /// # Errors
    /// See [`StateSpace::rate`].
    pub fn observability_rank(&self, channels: &[usize]) -> Result<usize, FilterError> {
        let (a, c) = self.system_matrices()?;
        Ok(rank(a, &c, channels))
    }

    /// The same for the linearisation at a state and an input: what one moment of driving tells. A drive over several
    /// states may tell more: at one moment a sensor's scale looks like an offset.
    ///
    /// # Errors
    /// See [`StateSpace::rate`].
    pub fn observability_rank_at(
        &self,
        x: &[f64],
        u: &[f64],
        channels: &[usize],
    ) -> Result<usize, FilterError> {
        let (_, a) = self.rate_jacobian(x, u)?;
        let (_, c) = self.measure_jacobian(x)?;
        Ok(rank(a, &c, channels))
    }
}

/// Dimension of the row space of \[C; CA; ...\] over the rows `channels` of C.
fn rank(mut a: DMatrix<f64>, c: &DMatrix<f64>, channels: &[usize]) -> usize {
    let n = a.nrows();
    // Time is measured in units in which A is of order one; that changes no rank.
    let scale = a.amax();
    if scale > 0.0 {
        a /= scale;
    }
    let mut basis: Vec<nalgebra::RowDVector<f64>> = Vec::new();
    let mut fresh: Vec<nalgebra::RowDVector<f64>> = channels
        .iter()
        .filter(|&&i| i < c.nrows())
        .map(|&i| c.row(i).into_owned())
        .collect();
    while !fresh.is_empty() && basis.len() < n {
        let mut next = Vec::new();
        for row in fresh {
            let length = row.norm();
            if length == 0.0 {
                continue;
            }
            let mut rest = row / length;
            // Twice is enough to be orthogonal to rounding.
            for _ in 0..2 {
                for b in &basis {
                    let along = rest.dot(b);
                    rest -= b * along;
                }
            }
            let left = rest.norm();
            if left > 1e-9 {
                rest /= left;
                next.push(&rest * &a);
                basis.push(rest);
            }
        }
        fresh = next;
    }
    basis.len()
}
