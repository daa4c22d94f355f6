//! The fit of one hypothesis: Levenberg-Marquardt on whitened residuals plus prior, inside bounds.
//!
//! # Equation
//! x = argmin |r(x)|² + |x|², r = L^-1 (y - f(x)), J = -dr/dx exact. The certificate is the projected gradient.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use terra_model::{Dual8, Dual16, jacobian, wide_jacobian};

use crate::dataset::{DataSet, Predictor, Stacked};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;
use crate::noise::Whitener;

const MAX_STEPS: usize = 80;
/// Predicted decrease of |r|² + |x|² below which a fit has converged: far below the one unit that matters.
const CERTIFICATE: f64 = 1e-4;
/// Misfit per value beyond the noise from which a fit is far from the data.
const FAR: f64 = 0.3;
/// Steps over which such a fit must come nearer, and by which share of what is left.
const NEARER: (usize, f64) = (6, 0.02);
/// Steps after which a cost is out of reach that so many times the decrease in sight does not bridge.
const REACH: (usize, f64) = (4, 4.0);
/// Predicted decrease below which a carried Jacobian ends a fit.
const CARRIED: f64 = 1e-2;

/// How long a fit goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Effort {
    /// Until an exact Jacobian certifies the end.
    Certified,
    /// The same, unless it stays far from the data and hardly comes nearer: enough to know that it is out of the contest.
    Contest,
    /// As a contest, and given up where this cost is out of reach.
    Below(f64),
    /// As a contest, but the carried Jacobian may end it: for fits to most of the data from a fit to all of it.
    Carried,
}

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Fit vector \[q, s\].
    pub x: DVector<f64>,
    /// Whitened residual (n).
    pub residual: DVector<f64>,
    /// Whitened -dr/dx (n x d).
    pub jacobian: DMatrix<f64>,
    /// |r|² + |x|².
    pub cost: f64,
    /// True when the certificate holds.
    pub converged: bool,
    /// True when it was given up on the way, out of the contest.
    pub given_up: bool,
    /// ln det of the covariance the residual was whitened with.
    pub log_det: f64,
    /// Components that ended on a bound.
    pub at_bound: Vec<bool>,
}

impl Fit {
    /// |r|².
    pub fn chi2(&self) -> f64 {
        self.residual.norm_squared()
    }
}

/// Residual and Jacobian of all observations, not whitened.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn evaluate<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    hypothesis: &Hypothesis,
    x: &[f64],
) -> Result<Stacked, GapError> {
    evaluate_from(data, predictor, hypothesis, x, 0)
}

/// The same, but only the columns of the Jacobian from one on.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn evaluate_from<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    hypothesis: &Hypothesis,
    x: &[f64],
    first: usize,
) -> Result<Stacked, GapError> {
    let (held, free) = x.split_at(first.min(x.len()));
    let each = (0..data.observations.len())
        .into_par_iter()
        .map(|i| {
            let i = data.observations[i].index;
            let raw = predictor.raw(i);
            // Every chunk of derivatives solves the wheels anew, so the widest that is filled is the cheapest.
            if free.len() <= 8 {
                let raw: Vec<Dual8> = raw.into_iter().map(Dual8::from).collect();
                jacobian(free, |free| {
                    let p = hypothesis.parameters(&beside(held, free));
                    predictor.residual(&hypothesis.law, &p, i, &raw)
                })
            } else {
                let raw: Vec<Dual16> = raw.into_iter().map(Dual16::from).collect();
                wide_jacobian(free, |free| {
                    let p = hypothesis.parameters(&beside(held, free));
                    predictor.residual(&hypothesis.law, &p, i, &raw)
                })
            }
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    let n = data.len();
    let mut stacked = Stacked {
        residual: DVector::zeros(n),
        jacobian: DMatrix::zeros(n, free.len()),
    };
    let mut at = 0;
    for (value, jac) in each {
        stacked
            .residual
            .rows_mut(at, value.len())
            .copy_from_slice(&value);
        stacked
            .jacobian
            .rows_mut(at, value.len())
            .copy_from(&(-jac));
        at += value.len();
    }
    Ok(stacked)
}

/// Constants and variables as one vector.
fn beside<T: From<f64> + Copy>(held: &[f64], free: &[T]) -> Vec<T> {
    let held = held.iter().map(|&v| T::from(v));
    held.chain(free.iter().copied()).collect()
}

/// Residual of all observations, not whitened.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn residual<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    hypothesis: &Hypothesis,
    x: &[f64],
) -> Result<DVector<f64>, GapError> {
    let p = hypothesis.parameters(x);
    let each = (0..data.observations.len())
        .into_par_iter()
        .map(|i| data.observations[i].index)
        .map(|i| predictor.residual(&hypothesis.law, &p, i, &predictor.raw(i)))
        .collect::<Result<Vec<_>, GapError>>()?;
    Ok(DVector::from_vec(each.concat()))
}

/// Fits a hypothesis from a start, with a guess of the whitened Jacobian there.
///
/// An exact Jacobian costs several times what a residual does, so between exact ones it is carried along by Broyden's
/// update; only an exact one can certify the end.
///
/// # Errors
/// When the model has no answer at the start; steps into such places are only refused.
pub(crate) fn fit_near<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    hypothesis: &Hypothesis,
    whitener: &Whitener,
    start: &[f64],
    guess: Option<DMatrix<f64>>,
    effort: Effort,
) -> Result<Fit, GapError> {
    let (low, high) = hypothesis.bounds();
    let d = start.len();
    let bounded = |x: DVector<f64>| DVector::from_fn(d, |k, _| x[k].clamp(low[k], high[k]));
    let whiten = |x: &DVector<f64>| -> Result<(DVector<f64>, DMatrix<f64>), GapError> {
        let s = evaluate(data, predictor, hypothesis, x.as_slice())?;
        Ok((
            whitener.apply_vector(&s.residual),
            whitener.apply(&s.jacobian),
        ))
    };
    let whitened = |x: &DVector<f64>| -> Result<DVector<f64>, GapError> {
        let raw = residual(data, predictor, hypothesis, x.as_slice())?;
        Ok(whitener.apply_vector(&raw))
    };
    let cost_of = |r: &DVector<f64>, x: &DVector<f64>| r.norm_squared() + x.norm_squared();

    let mut x = bounded(DVector::from_column_slice(start));
    let guess = guess.filter(|g| g.shape() == (data.len(), d));
    let mut exact = guess.is_none();
    let (mut r, mut j) = match guess {
        Some(j) => (whitened(&x)?, j),
        None => whiten(&x)?,
    };
    let mut cost = cost_of(&r, &x);
    let mut damping = 1e-3;
    let mut converged = false;
    let certified = effort != Effort::Carried;
    let end = if certified { CERTIFICATE } else { CARRIED };
    let near = data.len() as f64 * (1.0 + FAR);
    let mut way = vec![cost];
    let mut given_up = false;
    for _ in 0..MAX_STEPS {
        let (steps, nearer) = NEARER;
        let before = way.len().checked_sub(steps + 1).and_then(|k| way.get(k));
        let left_over = cost - data.len() as f64;
        let stalls = |before: &f64| before - cost < nearer * left_over;
        if effort != Effort::Certified && cost > near && before.is_some_and(stalls) {
            given_up = true;
            break;
        }
        // Half the downhill gradient; components pushed against their bound stay where they are.
        let gradient = j.tr_mul(&r) - &x;
        let held: Vec<bool> = (0..d)
            .map(|k| {
                (x[k] <= low[k] && gradient[k] < 0.0) || (x[k] >= high[k] && gradient[k] > 0.0)
            })
            .collect();
        let free: Vec<usize> = (0..d).filter(|&k| !held[k]).collect();
        let g = DVector::from_iterator(free.len(), free.iter().map(|&k| gradient[k]));
        let jf = j.select_columns(&free);
        let h = jf.tr_mul(&jf) + DMatrix::identity(free.len(), free.len());
        let newton = h.clone().cholesky().map(|c| c.solve(&g));
        let left = newton.as_ref().map(|newton| newton.dot(&g));
        if let Effort::Below(target) = effort
            && way.len() > REACH.0
            && cost - REACH.1 * left.unwrap_or(f64::INFINITY) > target
        {
            given_up = true;
            break;
        }
        let mut step = None;
        if left.is_some_and(|left| left >= end) {
            // A carried Jacobian that finds no step is renewed rather than damped away.
            for _ in 0..if exact { 30 } else { 4 } {
                let damped = &h + DMatrix::from_diagonal(&(h.diagonal() * damping));
                let Some(direction) = damped.cholesky().map(|c| c.solve(&g)) else {
                    break;
                };
                let mut trial = x.clone();
                for (i, &k) in free.iter().enumerate() {
                    trial[k] += direction[i];
                }
                let trial = bounded(trial);
                let better = whitened(&trial).ok().filter(|r| {
                    let c = cost_of(r, &trial);
                    c.is_finite() && c < cost
                });
                if let Some(r) = better {
                    damping = (damping * 0.2).max(1e-12);
                    step = Some((trial, r));
                    break;
                }
                damping = (damping * 5.0).min(1e12);
            }
        }
        match step {
            Some((next, next_r)) => {
                let moved = &next - &x;
                let gained = cost - cost_of(&next_r, &next);
                let slow = gained < 0.25 * left.unwrap_or(0.0);
                let surprise = (&r - &next_r) - &j * &moved;
                (x, r) = (next, next_r);
                cost = cost_of(&r, &x);
                way.push(cost);
                if slow && !exact {
                    (r, j) = whiten(&x)?;
                    exact = true;
                } else {
                    j += surprise * moved.transpose() / moved.norm_squared();
                    exact = false;
                }
            }
            None if !certified && left.is_some_and(|left| left < end) => break,
            None if exact => {
                // Certified, at rounding, or in a corner of the model's domain.
                converged = left.is_some_and(|left| left < 1e-3);
                break;
            }
            None => {
                (r, j) = whiten(&x)?;
                exact = true;
                damping = 1e-3;
            }
        }
    }
    // One that was given up is only known to be far: a carried Jacobian says as much.
    if !exact && certified && !given_up {
        (r, j) = whiten(&x)?;
    }
    let at_bound = (0..d).map(|k| x[k] <= low[k] || x[k] >= high[k]).collect();
    Ok(Fit {
        x,
        residual: r,
        jacobian: j,
        cost,
        converged,
        given_up,
        log_det: whitener.log_det,
        at_bound,
    })
}

/// The best of several starts: the given ones that can be evaluated. `guess` is a whitened Jacobian at the first.
///
/// # Errors
/// The last error when none can.
pub(crate) fn fit_from<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    hypothesis: &Hypothesis,
    whitener: &Whitener,
    starts: &[Vec<f64>],
    mut guess: Option<DMatrix<f64>>,
    effort: Effort,
) -> Result<Fit, GapError> {
    let mut best: Option<Fit> = None;
    let mut error = None;
    for start in starts {
        match fit_near(
            data,
            predictor,
            hypothesis,
            whitener,
            start,
            guess.take(),
            effort,
        ) {
            Ok(f) => {
                if best.as_ref().is_none_or(|b| f.cost < b.cost) {
                    best = Some(f);
                }
            }
            Err(e) => error = Some(e),
        }
    }
    best.ok_or_else(|| error.unwrap_or_else(|| GapError::Soil("a fit without a start".to_owned())))
}
