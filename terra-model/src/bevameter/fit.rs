//! Least squares of one law on many tests, and how sure its parameters are.
//!
//! # Reference
//! D. W. Marquardt, SIAM J. 11(2):431-441, 1963.

use nalgebra::{DMatrix, DVector};

use super::curve::{Curve, Prepared};
use super::interval::{effective_share, half_widths};
use super::report::{Estimate, LawFit};
use crate::dual::{Dual8, jacobian};
use crate::error::ModelError;
use crate::real::Real;

/// One fitted parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Free {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) way: Way,
}

/// How a parameter is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// By its logarithm: above 0.
    Log,
    /// As it is.
    Linear,
    /// By its logit: between 0 and 1.
    Share,
}

impl Free {
    /// Steps from `from` to `to`, linear ones in units of `scale`.
    pub(super) fn steps(self, from: f64, to: f64, scale: f64) -> f64 {
        let logit = |x: f64| (x / (1.0 - x)).ln();
        match self.way {
            Way::Log => (to / from).ln(),
            Way::Linear => (to - from) / scale,
            Way::Share => logit(to) - logit(from),
        }
    }

    /// The value `q` steps from `start`.
    fn moved<T: Real>(self, start: f64, scale: f64, q: T) -> T {
        match self.way {
            Way::Log => q.exp() * start,
            Way::Linear => q * scale + start,
            Way::Share => {
                let odds = (-q).exp() * ((1.0 - start) / start);
                T::one() / (odds + 1.0)
            }
        }
    }
}

/// A law to fit, one of several of its kind.
pub(super) trait Form: Sync {
    fn law(&self) -> &'static str;
    fn free(&self) -> &[Free];
    /// Stress at x, for a plate of radius or a normal stress of `given`.
    fn stress<T: Real>(&self, p: &[T], given: f64, x: f64) -> T;
    /// Where to begin.
    fn starts(&self, tests: &[Prepared]) -> Vec<Vec<f64>>;
    /// Different values of `given` without which nothing follows.
    fn givens(&self) -> usize;
    /// A fitted number as it is reported.
    fn shown(&self, _name: &str, value: f64) -> f64 {
        value
    }
}

/// The fit with what it was made of.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub(super) p: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) residual: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
}

const STEPS: usize = 200;
/// Misfit over stress below which no law is better than another: what averaging a curve leaves.
const NO_EVIDENCE: f64 = 1e-3;

/// Least squares from every start; none where no start gives finite stresses.
pub(super) fn solve<F: Form>(form: &F, tests: &[Prepared]) -> Option<Solution> {
    form.starts(tests)
        .iter()
        .filter_map(|start| from(form, tests, start))
        .min_by(|a, b| {
            a.residual
                .norm_squared()
                .total_cmp(&b.residual.norm_squared())
        })
}

/// Physical values of q: start e^q by logarithm, start + scale q else.
fn physical<F: Form, T: Real>(form: &F, start: &[f64], scale: &[f64], q: &[T]) -> Vec<T> {
    form.free()
        .iter()
        .zip(start)
        .zip(scale)
        .zip(q)
        .map(|(((free, start), scale), q)| free.moved(*start, *scale, *q))
        .collect()
}

/// Each test weighs the same, whatever its number of points.
fn weights(tests: &[Prepared]) -> Vec<f64> {
    let all: usize = tests.iter().map(|t| t.points.len()).sum();
    let each = all as f64 / tests.len().max(1) as f64;
    tests
        .iter()
        .map(|t| (each / t.points.len().max(1) as f64).sqrt())
        .collect()
}

type Linear = (DVector<f64>, DMatrix<f64>);

fn linearise<F: Form>(
    form: &F,
    tests: &[Prepared],
    start: &[f64],
    scale: &[f64],
    q: &DVector<f64>,
) -> Option<Linear> {
    let weights = weights(tests);
    let (residual, jac) = jacobian::<std::convert::Infallible>(q.as_slice(), |q: &[Dual8]| {
        let p = physical(form, start, scale, q);
        Ok(tests
            .iter()
            .zip(&weights)
            .flat_map(|(t, w)| {
                let p = &p;
                t.points
                    .iter()
                    .map(move |(x, y)| (form.stress(p, t.given, *x) - *y) * *w)
            })
            .collect())
    })
    .ok()?;
    let residual = DVector::from_vec(residual);
    let finite = residual.iter().chain(jac.iter()).all(|v| v.is_finite());
    finite.then_some((residual, jac))
}

pub(super) fn from<F: Form>(form: &F, tests: &[Prepared], start: &[f64]) -> Option<Solution> {
    let n = start.len();
    let scale: Vec<f64> = start.iter().map(|s| s.abs().max(1e-12)).collect();
    let mut q = DVector::zeros(n);
    let (mut residual, mut jac) = linearise(form, tests, start, &scale, &q)?;
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let normal = jac.transpose() * &jac;
        let gradient = jac.transpose() * &residual;
        let mut damped = normal.clone();
        for k in 0..n {
            damped[(k, k)] += damping * normal[(k, k)].max(1e-300);
        }
        let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
            continue;
        };
        let trial = &q - &step;
        let cost = residual.norm_squared();
        match linearise(form, tests, start, &scale, &trial) {
            Some((r, j)) if r.norm_squared() <= cost => {
                let gained = cost - r.norm_squared();
                (q, residual, jac) = (trial, r, j);
                damping = (damping * 0.2).max(1e-12);
                if gained <= 1e-14 * cost && step.amax() < 1e-8 {
                    break;
                }
            }
            _ => {
                damping *= 4.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
    }
    Some(Solution {
        p: physical(form, start, &scale, q.as_slice()),
        scale,
        residual,
        jacobian: jac,
    })
}

/// Number of different radii or normal stresses.
pub(super) fn different(tests: &[Prepared]) -> usize {
    let mut seen: Vec<f64> = vec![];
    for t in tests {
        if seen.iter().all(|s| (s - t.given).abs() > 1e-6 * s.abs()) {
            seen.push(t.given);
        }
    }
    seen.len()
}

/// One law on all tests; none where it cannot be fitted.
pub(super) fn report<F: Form>(form: &F, tests: &[Prepared]) -> Option<(LawFit, f64)> {
    let found = solve(form, tests)?;
    let (interval, halves) = half_widths(form, tests, &found);
    let parameters = form
        .free()
        .iter()
        .zip(&found.p)
        .zip(halves.iter().zip(&found.scale))
        .map(|((free, &value), (half, scale))| {
            let low = free.moved(value, *scale, -half);
            let high = free.moved(value, *scale, *half);
            Estimate {
                name: free.name,
                unit: free.unit,
                value: form.shown(free.name, value),
                low: form.shown(free.name, low),
                high: form.shown(free.name, high),
            }
        })
        .collect();
    let points: f64 = found.residual.len() as f64;
    let square: f64 = tests
        .iter()
        .zip(weights(tests))
        .map(|(t, w)| t.points.iter().map(|p| (w * p.1).powi(2)).sum::<f64>())
        .sum();
    let rms = (found.residual.norm_squared() / points).sqrt();
    let fitted = tests
        .iter()
        .map(|t| {
            t.points
                .iter()
                .map(|(x, _)| form.stress(&found.p, t.given, *x))
                .collect()
        })
        .collect();
    let share = effective_share(tests, &found.residual);
    Some((
        LawFit {
            law: form.law(),
            parameters,
            interval,
            rms,
            rms_share: rms / (square / points).sqrt(),
            delta_bic: 0.0,
            fitted,
        },
        points * share,
    ))
}

/// Fills in the differences of the information criterion, with the effective number of points of the law that fits best.
pub(super) fn rank(fits: Vec<(LawFit, f64)>) -> Vec<LawFit> {
    let effective = fits
        .iter()
        .min_by(|a, b| a.0.rms.total_cmp(&b.0.rms))
        .map_or(1.0, |f| f.1.max(2.0));
    let criterion = |f: &LawFit| {
        let share = f.rms_share.max(NO_EVIDENCE);
        effective * share.powi(2).ln() + f.parameters.len() as f64 * effective.ln()
    };
    let least = fits
        .iter()
        .map(|f| criterion(&f.0))
        .fold(f64::INFINITY, f64::min);
    fits.into_iter()
        .map(|(mut f, _)| {
            f.delta_bic = criterion(&f) - least;
            f
        })
        .collect()
}

/// A parameter whose value over the first half of the way lies outside its interval: one law does not describe the tests.
pub(super) fn moves<F: Form>(
    form: &F,
    tests: &[Prepared],
    whole: &LawFit,
    name: &'static str,
    way: &str,
) -> Option<String> {
    let halves: Vec<Prepared> = tests.iter().map(Prepared::first_half).collect();
    if halves.iter().any(|t| t.points.len() < 5) {
        return None;
    }
    let place = form.free().iter().position(|f| f.name == name)?;
    let first = *solve(form, &halves)?.p.get(place)?;
    let all = whole.get(name)?;
    let outside = first < all.low || first > all.high;
    let far = (first - all.value).abs() > 0.1 * all.value.abs();
    (outside && far).then(|| {
        format!(
            "{name}: {:.4} over the whole {way}, {first:.4} over its first half; no one value describes these tests",
            all.value
        )
    })
}

/// The tests, each on its own fit to be fitted.
pub(super) fn prepare(curves: &[Curve], from: f64, to: f64) -> Result<Vec<Prepared>, ModelError> {
    if curves.is_empty() {
        return Err(not_fitted(&[]));
    }
    curves.iter().map(|c| c.prepare(from, to)).collect()
}

/// The error of tests that no law could be fitted to.
pub(super) fn not_fitted(tests: &[Prepared]) -> ModelError {
    ModelError::Curve {
        test: tests.first().map_or("none".to_owned(), |t| t.test.clone()),
        what: "laws that could be fitted",
        found: 0.0,
        expected: "at least one",
    }
}
