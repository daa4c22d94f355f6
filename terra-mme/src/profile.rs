//! Profile likelihood: how far one parameter can be moved when all others follow, for the data that a design expects.
//!
//! # Equation
//! Δ(q_k) = min over the other q of Σ |L⁻¹(f(q) - f(q*))|², the expected data being f(q*). The 95 % interval is Δ <= 3.84. No
//! prior enters, so a direction that the design cannot see shows as an interval without an end.
//!
//! # Reference
//! A. Raue et al., Bioinformatics 25(15):1923-1929, 2009.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use terra_model::Contact;

use crate::design::Design;
use crate::error::EstimatorError;

/// Δ of a 95 % interval of one parameter.
const CHI2_95: f64 = 3.841_458_820_694;
/// Farthest that is looked, in prior sd.
const FARTHEST: f64 = 6.0;
/// Steps of the walk.
const STEP: f64 = 0.25;
const ITERATIONS: usize = 30;

/// One parameter's profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its name.
    pub name: &'static str,
    /// Physical value and Δ, in rising order of the value.
    pub points: Vec<(f64, f64)>,
    /// Lower end of the 95 % interval; none within six prior sd.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// A contact with what it should show at the truth.
struct Row {
    at: Contact<f64>,
    forces: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

/// The profile of every parameter of the design's space around q.
///
/// # Errors
/// As [`Design::jacobian`].
pub fn profiles(
    design: &Design<'_>,
    q: &[f64],
    contacts: &[Contact<f64>],
) -> Result<Vec<Profile>, EstimatorError> {
    let mut rows = vec![];
    for at in contacts {
        if let Some(local) = design.local(q, at)? {
            rows.push(Row {
                at: *at,
                factor: design.factor(&local)?,
                forces: local.forces,
            });
        }
    }
    let names = design.space().names();
    let bounds = design.space().lower_bounds();
    Ok(names
        .into_iter()
        .enumerate()
        .map(|(k, name)| {
            let least = bounds.get(k).copied().unwrap_or(f64::NEG_INFINITY);
            let (down, low) = walk(design, &rows, q, k, -STEP, least);
            let (up, high) = walk(design, &rows, q, k, STEP, least);
            let value = |at: f64| {
                let mut moved = q.to_vec();
                if let Some(v) = moved.get_mut(k) {
                    *v = at;
                }
                design.space().physical(&moved).get(k).copied()
            };
            let start = q.get(k).copied().unwrap_or(0.0);
            let points = down
                .into_iter()
                .rev()
                .chain([(start, 0.0)])
                .chain(up)
                .filter_map(|(at, d)| Some((value(at)?, d)))
                .collect();
            Profile {
                name,
                points,
                low: low.and_then(value),
                high: high.and_then(value),
            }
        })
        .collect())
}

/// Steps away from the truth until Δ passes the level: the points, and where it passes.
fn walk(
    design: &Design<'_>,
    rows: &[Row],
    truth: &[f64],
    k: usize,
    step: f64,
    least: f64,
) -> (Vec<(f64, f64)>, Option<f64>) {
    let start = truth.get(k).copied().unwrap_or(0.0);
    let mut q = DVector::from_column_slice(truth);
    let mut points = vec![];
    let mut before = (start, 0.0);
    // Short steps first: a well-known parameter leaves its interval within a hundredth of a prior sd.
    let mut reach = step / 64.0;
    loop {
        let at = start + reach;
        if reach.abs() > FARTHEST || at < least {
            return (points, None);
        }
        if let Some(v) = q.get_mut(k) {
            *v = at;
        }
        let Some(delta) = minimise(design, rows, &mut q, truth, k) else {
            return (points, None);
        };
        points.push((at, delta));
        if delta >= CHI2_95 {
            // Δ is nearly a parabola: linear in its root.
            let (a, b) = (f64::sqrt(before.1), delta.sqrt());
            let share = (CHI2_95.sqrt() - a) / (b - a).max(1e-12);
            return (points, Some(before.0 + share * (at - before.0)));
        }
        before = (at, delta);
        reach = if reach.abs() < step.abs() {
            2.0 * reach
        } else {
            reach + step
        };
    }
}

type System = (DVector<f64>, DMatrix<f64>);

fn system(design: &Design<'_>, rows: &[Row], q: &DVector<f64>) -> Option<System> {
    let (mut residual, mut jac) = (vec![], vec![]);
    for row in rows {
        let local = design.local(q.as_slice(), &row.at).ok()??;
        let white = |m: &DMatrix<f64>| row.factor.l().solve_lower_triangular(m);
        let off = &local.forces - &row.forces;
        residual.extend(row.factor.l().solve_lower_triangular(&off)?.iter().copied());
        jac.push(white(&local.jacobian)?);
    }
    let mut all = DMatrix::zeros(residual.len(), q.len());
    let mut at = 0;
    for block in jac {
        all.rows_mut(at, block.nrows()).copy_from(&block);
        at += block.nrows();
    }
    Some((DVector::from_vec(residual), all))
}

/// Moves all components of q but k to the least misfit, and returns it.
///
/// Directions that nothing sees would wander: a pull to the truth of 1e-6 prior sd⁻² holds them, and is not counted.
fn minimise(
    design: &Design<'_>,
    rows: &[Row],
    q: &mut DVector<f64>,
    truth: &[f64],
    k: usize,
) -> Option<f64> {
    const HOLD: f64 = 1e-6;
    let truth = DVector::from_column_slice(truth);
    let bounds = DVector::from_vec(design.space().lower_bounds());
    let cost =
        |r: &DVector<f64>, q: &DVector<f64>| r.norm_squared() + HOLD * (q - &truth).norm_squared();
    let (mut residual, mut jac) = system(design, rows, q)?;
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let mut held = jac.clone();
        held.fill_column(k, 0.0);
        let mut normal = held.transpose() * &held;
        let gradient = held.transpose() * &residual + (&*q - &truth) * HOLD;
        for i in 0..q.len() {
            normal[(i, i)] += HOLD + damping * normal[(i, i)].max(1e-9);
        }
        let mut step = -Cholesky::new(normal)?.solve(&gradient);
        step[k] = 0.0;
        let mut trial = (&*q + &step).zip_map(&bounds, f64::max);
        trial[k] = q[k];
        let before = cost(&residual, q);
        match system(design, rows, &trial) {
            Some((r, j)) if cost(&r, &trial) <= before => {
                let gained = before - cost(&r, &trial);
                (*q, residual, jac) = (trial, r, j);
                damping *= 0.2;
                if gained < 1e-6 * (1.0 + before) {
                    break;
                }
            }
            _ => {
                damping *= 5.0;
                if damping > 1e9 {
                    break;
                }
            }
        }
    }
    Some(residual.norm_squared())
}
