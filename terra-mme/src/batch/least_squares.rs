//! Nonlinear least squares with bounds: the parameters whose forces come nearest to those observed, no prior.
//!
//! # Equation
//! q* = argmin Σ_k r~_kᵀ S~_k⁻¹ r~_k over a box of the [`FitSpace`], by Levenberg-Marquardt on the free components; a
//! component at its bound whose gradient points outwards is held there. S~_k is that of the current q at every step.
//!
//! # Reference
//! L. E. Ray, Proc. SPIE (2008), eq. 21 (the fit that hypotheses replace); D. W. Marquardt, SIAM J. 11(2):431-441, 1963;
//! D. P. Bertsekas, SIAM J. Control and Optimization 20(2):221-246, 1982 (projected Newton steps).

use nalgebra::{DMatrix, DVector};
use terra_model::order::descending;
use terra_model::{ForceLaw, Law};

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;
use crate::linearise::{Linearised, Problem};
use crate::observation::ForceObservation;
use crate::sets::Axis;
use crate::whiten::Prewhitening;

/// Half-width of the box where no bound is given, in prior sd of the parameter.
const REACH: f64 = 5.0;

/// How a fit runs.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastSquaresOptions {
    /// As in the weighing.
    pub whitening: Option<Prewhitening>,
    /// Bounds by parameter (or `k_eq`); a parameter without one stays in the law's range and within five prior sd of the
    /// start.
    pub bounds: Vec<Axis>,
    /// Largest number of steps of one fit.
    pub max_steps: usize,
    /// Nats still to be gained below which a fit has converged.
    pub tolerance: f64,
    /// Starts of a set that are followed: those that fit best before the first step.
    pub starts: usize,
}

impl Default for LeastSquaresOptions {
    fn default() -> Self {
        LeastSquaresOptions {
            whitening: None,
            bounds: Vec::new(),
            max_steps: 60,
            tolerance: 1e-6,
            starts: 6,
        }
    }
}

/// A minimum, or where the steps ran out.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalFit {
    /// The law's parameters.
    pub parameters: Vec<f64>,
    /// Σ r~ᵀS~⁻¹r~.
    pub chi2: f64,
    /// Number of whitened rows.
    pub rows: usize,
    /// ln p(observations | parameters).
    pub log_likelihood: f64,
    /// No more than the tolerance is to be gained.
    pub converged: bool,
    /// Steps tried.
    pub steps: usize,
    /// Parameters held by a bound.
    pub held: Vec<&'static str>,
    /// Whitened residual, by which minima are told apart.
    pub(super) residual: DVector<f64>,
}

/// Fits a law from one start.
///
/// # Errors
/// [`EstimatorError::NoObservations`]; [`EstimatorError::Name`] for a bound of an unknown parameter;
/// [`EstimatorError::Value`] for bounds that do not hold the start; [`EstimatorError::Model`] when the start is infeasible at an
/// observation; [`EstimatorError::NotPositiveDefinite`]; [`EstimatorError::NoSinkage`].
pub fn least_squares(
    law: &Law,
    space: &FitSpace,
    observations: &[ForceObservation],
    options: &LeastSquaresOptions,
) -> Result<LocalFit, EstimatorError> {
    let problem = Problem::new(law, space, observations, options.whitening)?;
    let (lower, upper) = bounds(law, space, &options.bounds)?;
    let mut q = DVector::zeros(space.dim());
    let mut at = problem.linearise(q.as_slice())?;
    let (mut damping, mut growth) = (1e-3, 2.0);
    let mut steps = 0;
    let mut gain = newton(&at, &q, &lower, &upper, 0.0)?.1;
    while gain > options.tolerance && steps < options.max_steps {
        steps += 1;
        let (step, _) = newton(&at, &q, &lower, &upper, damping)?;
        let next = clamp(&(&q + step), &lower, &upper);
        let cost = at.residual.norm_squared();
        // A refusal at a trial point only says that the step was too long.
        let better = problem
            .residual(next.as_slice(), &at.factors)
            .filter(|r| r.norm_squared() <= cost)
            .and_then(|_| problem.linearise(next.as_slice()).ok());
        match better {
            Some(there) => {
                damping = (damping / 3.0).max(1e-12);
                growth = 2.0;
                q = next;
                at = there;
                gain = newton(&at, &q, &lower, &upper, 0.0)?.1;
            }
            None => {
                damping *= growth;
                growth *= 2.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
    }
    let names = space.names();
    let gradient = at.jacobian.tr_mul(&at.residual);
    let held = (0..q.len()).filter(|&k| is_held(k, &q, &gradient, &lower, &upper));
    Ok(LocalFit {
        parameters: space.parameters(q.as_slice()),
        chi2: at.residual.norm_squared(),
        rows: at.residual.len(),
        log_likelihood: at.log_density(),
        converged: gain <= options.tolerance,
        steps,
        held: held.filter_map(|k| names.get(k).copied()).collect(),
        residual: at.residual,
    })
}

/// Bounds in q: the law's legal range, the reach around the start, and what the caller says.
fn bounds(
    law: &Law,
    space: &FitSpace,
    given: &[Axis],
) -> Result<(DVector<f64>, DVector<f64>), EstimatorError> {
    let names = space.names();
    for axis in given {
        if !names.iter().any(|n| *n == axis.parameter) {
            let nearest = terra_model::nearest(&axis.parameter, names.iter().copied());
            return Err(terra_model::ModelError::UnknownName {
                kind: "fitted parameter",
                name: axis.parameter.clone(),
                nearest: nearest.map(str::to_owned),
            }
            .into());
        }
    }
    let n = space.dim();
    let (mut lower, mut upper) = (DVector::zeros(n), DVector::zeros(n));
    for (k, name) in names.iter().enumerate() {
        let own = match *name {
            "k_eq" => "k_phi",
            other => other,
        };
        let legal = law.params().iter().find(|p| p.name == own);
        let (mut low, mut high) = legal.map_or((f64::NEG_INFINITY, f64::INFINITY), |p| {
            (space.coordinate(k, p.min), space.coordinate(k, p.max))
        });
        match given.iter().find(|a| a.parameter == *name) {
            Some(axis) => {
                low = low.max(space.coordinate(k, axis.low));
                high = high.min(space.coordinate(k, axis.high));
            }
            None => (low, high) = (low.max(-REACH), high.min(REACH)),
        }
        if low.is_nan() || high.is_nan() || low > 1e-9 || high < -1e-9 {
            return Err(EstimatorError::Value {
                what: format!("bounds of {name}"),
                value: space.physical(&vec![0.0; n])[k],
                expected: "bounds with the start between them",
            });
        }
        (lower[k], upper[k]) = (low.min(0.0), high.max(0.0));
    }
    Ok((lower, upper))
}

fn clamp(q: &DVector<f64>, lower: &DVector<f64>, upper: &DVector<f64>) -> DVector<f64> {
    q.zip_map(lower, f64::max).zip_map(upper, f64::min)
}

fn is_held(
    k: usize,
    q: &DVector<f64>,
    gradient: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> bool {
    q[k] <= lower[k] && gradient[k] > 0.0 || q[k] >= upper[k] && gradient[k] < 0.0
}

/// The damped Gauss-Newton step inside the box, and the nats it promises.
///
/// A component that the step would take across its bound is put there, and the others are solved for anew. What is
/// promised is at least what a step down the free gradient would gain, so that a promise of nothing means a minimum.
fn newton(
    at: &Linearised,
    q: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
    damping: f64,
) -> Result<(DVector<f64>, f64), EstimatorError> {
    let n = q.len();
    let gradient = at.jacobian.tr_mul(&at.residual);
    let curvature = at.jacobian.tr_mul(&at.jacobian);
    let mut free: Vec<usize> = (0..n)
        .filter(|&k| !is_held(k, q, &gradient, lower, upper))
        .collect();
    let downhill = steepest(&gradient, &curvature, &free, q, lower, upper);
    // Where the data say nothing the Hessian is singular; the gradient is then 0 along it too, and so is the step.
    let ridge = 1e-12 * (1.0 + curvature.diagonal().amax());
    let mut moved = DVector::zeros(n);
    loop {
        let pull = &gradient + &curvature * &moved;
        let m = free.len();
        let hessian = DMatrix::from_fn(m, m, |i, j| {
            let (a, b) = (free[i], free[j]);
            let extra = if i == j {
                ridge + damping * (1.0 + curvature[(a, a)])
            } else {
                0.0
            };
            curvature[(a, b)] + extra
        });
        let right = DVector::from_fn(m, |i, _| -pull[free[i]]);
        let factor = hessian.cholesky().ok_or(EstimatorError::Decomposition {
            what: "Cholesky of the Hessian",
        })?;
        let step = factor.solve(&right);
        let inside = |i: usize| {
            let next = q[free[i]] + step[i];
            next >= lower[free[i]] && next <= upper[free[i]]
        };
        let (stay, cross): (Vec<usize>, Vec<usize>) = (0..m).partition(|&i| inside(i));
        if cross.is_empty() {
            for (i, &k) in free.iter().enumerate() {
                moved[k] = step[i];
            }
            break;
        }
        for i in cross {
            let k = free[i];
            moved[k] = if step[i] < 0.0 { lower[k] } else { upper[k] } - q[k];
        }
        free = stay.into_iter().map(|i| free[i]).collect();
        if free.is_empty() {
            break;
        }
    }
    let gain = -gradient.dot(&moved) - 0.5 * moved.dot(&(&curvature * &moved));
    if gain >= downhill.1 {
        Ok((moved, gain))
    } else if damping == 0.0 {
        Ok(downhill)
    } else {
        Ok((moved, downhill.1))
    }
}

/// The best step down the gradient of the free components that stays inside the box, and its gain.
fn steepest(
    gradient: &DVector<f64>,
    curvature: &DMatrix<f64>,
    free: &[usize],
    q: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> (DVector<f64>, f64) {
    let mut down = DVector::zeros(q.len());
    for &k in free {
        down[k] = -gradient[k];
    }
    let slope = down.norm_squared();
    let bend = down.dot(&(curvature * &down));
    let mut length = if bend > 0.0 { slope / bend } else { 0.0 };
    for &k in free {
        let room = if down[k] < 0.0 { lower[k] } else { upper[k] } - q[k];
        if down[k] != 0.0 {
            length = length.min(room / down[k]);
        }
    }
    (down * length, length * slope - 0.5 * length * length * bend)
}

/// Fits from many starts, best first; fits whose forces are the same (within `same` nats) are one.
pub(super) fn distinct(mut fits: Vec<(String, LocalFit)>, same: f64) -> Vec<(String, LocalFit)> {
    descending(&mut fits, |f| f.1.log_likelihood);
    let mut out: Vec<(String, LocalFit)> = Vec::new();
    for (id, fit) in fits {
        let known = out
            .iter()
            .any(|(_, f)| 0.5 * (&f.residual - &fit.residual).norm_squared() < same);
        if !known {
            out.push((id, fit));
        }
    }
    out
}
