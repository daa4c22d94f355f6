//! From continuous to discrete time: Van Loan's method for linear systems, Runge-Kutta for the others.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::error::FilterError;
use crate::gaussian::{check_finite, symmetrise};
use crate::state_space::AnyStateSpace;

/// x_(k+1) = a x_k + gamma g + noise of covariance q, for x' = A x + g + white noise over a step of length dt.
#[derive(Clone, Debug)]
pub struct Discrete {
    /// Step \[s\].
    pub dt: f64,
    /// e^(A dt) (n x n).
    pub a: DMatrix<f64>,
    /// ∫ e^(A s) ds over the step (n x n).
    pub gamma: DMatrix<f64>,
    /// ∫ e^(A s) Q e^(Aᵀ s) ds over the step (n x n).
    pub q: DMatrix<f64>,
}

/// Exact discretisation of x' = A x + g + w, w white with spectral density Q.
///
/// # Equation
/// Van Loan: exp(\[-A Q; 0 Aᵀ\] h) = \[. G; 0 F\] gives a = Fᵀ, q = Fᵀ G, and exp(\[A I; 0 0\] h) gives gamma. The step is
/// halved until |A| h <= 1/2 and doubled back (q ← q + a q aᵀ), because e^(-A h) overflows over a long gap.
///
/// # Errors
/// [`FilterError::NotFinite`] when the result overflows.
///
/// # Reference
/// C. F. Van Loan, "Computing integrals involving the matrix exponential", IEEE Trans. Automatic Control 23 (1978).
pub fn discretise(a: &DMatrix<f64>, q: &DMatrix<f64>, dt: f64) -> Result<Discrete, FilterError> {
    let n = a.nrows();
    check_finite("rate Jacobian", a.as_slice())?;
    let size = (0..n).map(|i| a.row(i).abs().sum()).fold(0.0, f64::max) * dt;
    let halvings = if size > 0.5 {
        (2.0 * size).log2().ceil().min(60.0) as i32
    } else {
        0
    };
    let h = dt / 2f64.powi(halvings);

    let mut block = DMatrix::zeros(2 * n, 2 * n);
    block.view_mut((0, 0), (n, n)).copy_from(&(-a * h));
    block.view_mut((0, n), (n, n)).copy_from(&(q * h));
    block
        .view_mut((n, n), (n, n))
        .copy_from(&(a.transpose() * h));
    let exp = block.exp();
    let mut a_d = exp.view((n, n), (n, n)).transpose();
    let mut q_d = &a_d * exp.view((0, n), (n, n));

    block.fill(0.0);
    block.view_mut((0, 0), (n, n)).copy_from(&(a * h));
    block
        .view_mut((0, n), (n, n))
        .copy_from(&(DMatrix::identity(n, n) * h));
    let mut gamma = block.exp().view((0, n), (n, n)).into_owned();

    for _ in 0..halvings {
        q_d = &a_d * &q_d * a_d.transpose() + &q_d;
        gamma = &a_d * &gamma + &gamma;
        a_d = &a_d * &a_d;
    }
    symmetrise(&mut q_d);
    check_finite("transition matrix", a_d.as_slice())?;
    check_finite("process noise", q_d.as_slice())?;
    Ok(Discrete {
        dt,
        a: a_d,
        gamma,
        q: q_d,
    })
}

/// The discretisations of one linear system, one for each distinct step.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    a: DMatrix<f64>,
    q: DMatrix<f64>,
    known: Vec<Arc<Discrete>>,
}

impl Steps {
    pub(crate) fn new(a: DMatrix<f64>, q: DMatrix<f64>) -> Self {
        Steps {
            a,
            q,
            known: Vec::new(),
        }
    }

    /// The discretisation for `dt`. Steps that agree to 1e-9 are one step: clocks differ by rounding from row to row.
    pub(crate) fn get(&mut self, dt: f64) -> Result<&Discrete, FilterError> {
        let same = |d: &Arc<Discrete>| (d.dt - dt).abs() <= 1e-9 * dt;
        let at = match self.known.iter().position(same) {
            Some(at) => at,
            None => {
                let fresh = discretise(&self.a, &self.q, dt)?;
                // A jittered clock never repeats a step: keep a few, not a log's worth.
                if self.known.len() >= 8 {
                    self.known.remove(0);
                }
                self.known.push(Arc::new(fresh));
                self.known.len() - 1
            }
        };
        Ok(&self.known[at])
    }
}

/// One classical Runge-Kutta step of fourth order of x' = f(x, u), u held.
///
/// # Errors
/// Whatever the state space raises.
pub(crate) fn runge_kutta(
    space: &dyn AnyStateSpace,
    x: &DVector<f64>,
    u: &[f64],
    dt: f64,
) -> Result<DVector<f64>, FilterError> {
    let rate = |x: &DVector<f64>| space.rate_value(x.as_slice(), u).map(DVector::from_vec);
    let k1 = rate(x)?;
    let k2 = rate(&(x + &k1 * (dt / 2.0)))?;
    let k3 = rate(&(x + &k2 * (dt / 2.0)))?;
    let k4 = rate(&(x + &k3 * dt))?;
    Ok(x + (k1 + (k2 + k3) * 2.0 + k4) * (dt / 6.0))
}

/// Mean, transition matrix and process noise a step later.
pub(crate) type Propagated = (DVector<f64>, DMatrix<f64>, DMatrix<f64>);

/// Mean, transition matrix and process noise of a nonlinear state space over one step, in substeps of at most
/// `max_step`: the mean by Runge-Kutta, the rest by Van Loan on the Jacobian at each substep's middle.
pub(crate) fn propagate(
    space: &dyn AnyStateSpace,
    q: &DMatrix<f64>,
    mean: &DVector<f64>,
    u: &[f64],
    dt: f64,
    max_step: f64,
) -> Result<Propagated, FilterError> {
    let n = mean.len();
    let count = substeps(dt, max_step)?;
    let h = dt / count as f64;
    let mut x = mean.clone();
    let mut a = DMatrix::identity(n, n);
    let mut noise = DMatrix::zeros(n, n);
    for _ in 0..count {
        let next = runge_kutta(space, &x, u, h)?;
        let middle = (&x + &next) / 2.0;
        let (_, jacobian) = space.rate_jacobian(middle.as_slice(), u)?;
        let step = discretise(&jacobian, q, h)?;
        noise = &step.a * &noise * step.a.transpose() + &step.q;
        a = &step.a * &a;
        x = next;
    }
    Ok((x, a, noise))
}

/// Number of substeps of at most `max_step` \[s\] in a step.
pub(crate) fn substeps(dt: f64, max_step: f64) -> Result<usize, FilterError> {
    let count = (dt / max_step).ceil().max(1.0);
    if count > 1e6 {
        return Err(FilterError::Config {
            key: "substeps of one time step",
            value: count,
            expected: "at most 1e6: restart the filter after a gap",
        });
    }
    Ok(count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x'' = white(q): a = [1 h; 0 1], q = q [h³/3 h²/2; h²/2 h], gamma = [h h²/2; 0 h], also over a long step.
    #[test]
    fn double_integrator_by_hand() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let q = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 3.0]);
        for h in [0.01, 2.0, 3600.0] {
            let d = discretise(&a, &q, h).unwrap();
            let h2 = 3.0 * h * h / 2.0;
            let noise = DMatrix::from_row_slice(2, 2, &[h * h * h, h2, h2, 3.0 * h]);
            assert!((&d.q - &noise).amax() <= 1e-13 * noise.amax());
            let gamma = DMatrix::from_row_slice(2, 2, &[h, h * h / 2.0, 0.0, h]);
            assert!((&d.gamma - &gamma).amax() <= 1e-13 * gamma.amax());
        }
    }

    /// x' = -k x + white(q) relaxes to variance q/(2k); e^(-A h) would overflow over this step.
    #[test]
    fn decay_over_a_long_gap() {
        let a = DMatrix::from_element(1, 1, -2.0);
        let q = DMatrix::from_element(1, 1, 8.0);
        let d = discretise(&a, &q, 1e4).unwrap();
        assert!(
            (d.q[(0, 0)] - 2.0).abs() < 1e-12
                && d.a[(0, 0)] == 0.0
                && (d.gamma[(0, 0)] - 0.5).abs() < 1e-12
        );
    }
}
