//! The fit of one hypothesis: whitened residuals plus prior, r = L^-1 (y - f(x)), J = -dr/dx exact, down to their least.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::LaneDual;

use crate::dataset::{DataSet, Stacked};
pub(crate) use crate::descent::{Effort, Known};
use crate::descent::{End, Residuals, descend};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;
use crate::memory::{Memory, Remembered};
use crate::noise::Whitener;
use crate::predictor::{Predictor, varying};

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Fit vector \[q, s\].
    pub x: DVector<f64>,
    /// Whitened residual (n).
    pub residual: DVector<f64>,
    /// Whitened -dr/dx (n x d), shared: rivals are copied with theirs.
    pub jacobian: Arc<DMatrix<f64>>,
    /// Whether the Jacobian is the law's own there, and not carried along or a tangent's.
    pub exact: bool,
    /// Whether the residual is a tangent's, and not the law's own.
    pub tangent: bool,
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
    /// Where its solvers ended.
    pub(crate) near: Remembered,
}

impl Fit {
    /// |r|².
    pub fn chi2(&self) -> f64 {
        self.residual.norm_squared()
    }

    /// Whether it ended with this noise: another one has another density.
    pub(crate) fn is_whitened_by(&self, whitener: &Whitener) -> bool {
        self.log_det == whitener.log_det
    }

    /// What it knows for a fit with the same noise that begins where it ended, with more columns at zero.
    pub(crate) fn known(&self, jacobian: impl Into<Arc<DMatrix<f64>>>) -> Known {
        Known {
            residual: (!self.tangent).then(|| self.residual.clone()),
            jacobian: jacobian.into(),
            exact: self.exact,
            near: self.near.clone(),
        }
    }

    /// Where its tangent has its least inside bounds: what would pass one is held there, and the others are sought anew.
    pub(crate) fn least_within(&self, low: &[f64], high: &[f64]) -> DVector<f64> {
        let mut to = self.x.clone();
        let mut free: Vec<usize> = (0..to.len()).collect();
        while !free.is_empty() {
            for &k in &free {
                to[k] = 0.0;
            }
            // What is left for the free ones, all of them at zero.
            let left = &self.residual - &*self.jacobian * (&to - &self.x);
            let slopes = self.jacobian.select_columns(&free);
            let curvature = slopes.tr_mul(&slopes) + DMatrix::identity(free.len(), free.len());
            // Positive definite by construction.
            let Some(root) = curvature.cholesky() else {
                return self.x.clone();
            };
            let least = root.solve(&slopes.tr_mul(&left));
            for (&k, x) in free.iter().zip(least.iter()) {
                to[k] = x.clamp(low[k], high[k]);
            }
            let before = free.len();
            free.retain(|&k| low[k] < to[k] && to[k] < high[k]);
            if free.len() == before {
                break;
            }
        }
        to
    }

    /// Decrease of the cost that a whole step of its tangent still promises, over the components that no bound holds.
    pub(crate) fn promise(&self) -> f64 {
        let free: Vec<usize> = (0..self.x.len()).filter(|&k| !self.at_bound[k]).collect();
        let slopes = self.jacobian.select_columns(&free);
        let gradient = slopes.tr_mul(&self.residual) - self.x.select_rows(&free);
        let curvature = slopes.tr_mul(&slopes) + DMatrix::identity(free.len(), free.len());
        let step = curvature.cholesky().map(|c| c.solve(&gradient));
        step.map_or(f64::INFINITY, |step| step.dot(&gradient))
    }
}

#[cfg(test)]
impl Fit {
    /// One without parameters that leaves this.
    pub(crate) fn of_residual(residual: DVector<f64>) -> Self {
        Fit {
            x: DVector::zeros(0),
            jacobian: DMatrix::zeros(residual.len(), 0).into(),
            cost: residual.norm_squared(),
            residual,
            exact: true,
            tangent: false,
            converged: true,
            given_up: false,
            log_det: 0.0,
            at_bound: vec![],
            near: Remembered::default(),
        }
    }
}

/// Residual and Jacobian of all observations, not whitened; with what a fit remembers that ended there or near there.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn evaluate(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
    near: &Remembered,
) -> Result<Stacked, GapError> {
    let memory = Memory::after(near, predictor.contacts());
    evaluate_from(data, predictor, hypothesis, x, 0, &memory)
}

/// The same, but only the columns of the Jacobian from one on.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn evaluate_from(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
    first: usize,
    memory: &Memory,
) -> Result<Stacked, GapError> {
    let (held, free) = x.split_at(first.min(x.len()));
    let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
    let n = data.len();
    let mut stacked = Stacked {
        residual: DVector::zeros(n),
        jacobian: DMatrix::zeros(n, free.len()),
    };
    for start in (0..free.len().max(1)).step_by(LaneDual::SLOPES) {
        let ends = free.len().min(start + LaneDual::SLOPES);
        let seed = |(k, &v): (usize, &f64)| varying(k, v.into(), &(start..ends));
        let mut at: Vec<LaneDual> = held.iter().map(|&v| LaneDual::from(v)).collect();
        at.extend(free.iter().enumerate().map(seed));
        let p = hypothesis.parameters(&at);
        let found = predictor.slopes(&hypothesis.law, &p, &(0..0), &indices, memory)?;
        let each = found.iter().zip(&data.observations);
        let rows = each.flat_map(|(found, o)| found.iter().zip(o.added()));
        for (row, (sloped, shift)) in rows.enumerate() {
            stacked.residual[row] = sloped.value + shift;
            for (column, slope) in (start..ends).zip(sloped.slopes) {
                stacked.jacobian[(row, column)] = -slope;
            }
        }
    }
    Ok(stacked)
}

/// Residual of all observations, not whitened.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn residual(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
) -> Result<DVector<f64>, GapError> {
    residual_near(data, predictor, hypothesis, x, &Memory::none())
}

/// The same, where a fit has asked before.
fn residual_near(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
    memory: &Memory,
) -> Result<DVector<f64>, GapError> {
    let p = hypothesis.parameters(x);
    let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
    let mut each = predictor.residuals(&hypothesis.law, &p, &indices, memory)?;
    for (value, o) in each.iter_mut().zip(&data.observations) {
        value
            .iter_mut()
            .zip(o.added())
            .for_each(|(r, more)| *r += more);
    }
    Ok(DVector::from_vec(each.concat()))
}

/// A hypothesis against data, whitened.
struct Whitened<'a> {
    data: &'a DataSet,
    predictor: &'a dyn Predictor,
    hypothesis: &'a Hypothesis,
    whitener: &'a Whitener,
    memory: Memory,
}

impl Residuals for Whitened<'_> {
    fn value(&self, x: &DVector<f64>) -> Result<DVector<f64>, GapError> {
        let (x, memory) = (x.as_slice(), &self.memory);
        let raw = residual_near(self.data, self.predictor, self.hypothesis, x, memory)?;
        Ok(self.whitener.apply_vector(&raw))
    }

    fn slopes(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), GapError> {
        let (x, memory) = (x.as_slice(), &self.memory);
        let raw = evaluate_from(self.data, self.predictor, self.hypothesis, x, 0, memory)?;
        Ok((
            self.whitener.apply_vector(&raw.residual),
            self.whitener.apply(&raw.jacobian),
        ))
    }
}

/// Fits a hypothesis from a start, with what is known there, whitened.
///
/// # Errors
/// When the model has no answer at the start; steps into such places are only refused.
pub(crate) fn fit_near(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    whitener: &Whitener,
    start: &[f64],
    known: Option<Known>,
    effort: Effort,
) -> Result<Fit, GapError> {
    let (low, high) = hypothesis.bounds();
    let problem = Whitened {
        data,
        predictor,
        hypothesis,
        whitener,
        memory: known.as_ref().map_or_else(
            || Memory::of(predictor.contacts()),
            |known| Memory::after(&known.near, predictor.contacts()),
        ),
    };
    let known = known.filter(|k| k.jacobian.shape() == (data.len(), start.len()));
    let End {
        x,
        residual,
        jacobian,
        exact,
        cost,
        converged,
        given_up,
    } = descend(&problem, (&low, &high), start, known, effort)?;
    let at_bound = (0..x.len())
        .map(|k| x[k] <= low[k] || x[k] >= high[k])
        .collect();
    Ok(Fit {
        x,
        residual,
        jacobian: jacobian.into(),
        exact,
        tangent: false,
        cost,
        converged,
        given_up,
        log_det: whitener.log_det,
        at_bound,
        near: problem.memory.remembered(),
    })
}

/// Shares of the starts at which a fit begins where the soil does not carry the vehicle at the starts themselves: an end at the
/// edge of what it carries is no start under another noise, or at other inputs.
const BACK: [f64; 4] = [1.0, 0.999, 0.99, 0.9];

/// The answer from the starts as they are, or from as far back towards the prior centre as it takes; with the share of the starts
/// that it was found at.
///
/// # Errors
/// Of the starts as they are, where the model has no answer at any of these; others at once.
pub(crate) fn backed<A>(
    starts: &[Vec<f64>],
    mut from: impl FnMut(&[Vec<f64>]) -> Result<A, GapError>,
) -> Result<(A, f64), GapError> {
    let mut error = None;
    for share in BACK {
        let nearer = |start: &Vec<f64>| start.iter().map(|x| share * x).collect();
        let nearer: Vec<Vec<f64>> = starts.iter().map(nearer).collect();
        match from(&nearer) {
            Err(e @ GapError::Model(_)) => error = error.or(Some(e)),
            answer => return Ok((answer?, share)),
        }
    }
    Err(error.unwrap_or_else(|| GapError::Soil("a fit without a start".to_owned())))
}

/// What is said of an answer that was found at a share of the end it was asked at.
pub(crate) fn note_of_edge(what: &str, share: f64) -> Option<String> {
    (share < 1.0).then(|| {
        format!(
            "{what}: taken {:.1} % of the way back to the prior centre, as the soil only just carries the load",
            100.0 * (1.0 - share)
        )
    })
}

/// Residual of all observations at the end of a fit, not whitened. At the edge of what the soil carries two rules of integration may
/// differ about whether it does: then as far back as it takes, which the data set notes.
///
/// # Errors
/// Where the model has no answer there either.
pub(crate) fn residual_at_end(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    end: &[f64],
    what: &str,
) -> Result<DVector<f64>, GapError> {
    let (found, share) = backed(&[end.to_vec()], |ends| {
        residual(data, predictor, hypothesis, &ends[0])
    })?;
    data.notes.extend(note_of_edge(what, share));
    Ok(found)
}

/// The best of several starts: the given ones that can be evaluated, or all of them a little nearer to the prior centre where none
/// can. What is `known` is so at the first, whitened.
///
/// # Errors
/// The last error when none can.
pub(crate) fn fit_from(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    whitener: &Whitener,
    starts: &[Vec<f64>],
    mut known: Option<Known>,
    effort: Effort,
) -> Result<Fit, GapError> {
    backed(starts, |starts| {
        let mut best: Option<Fit> = None;
        let mut error = None;
        for start in starts {
            let known = known.take();
            match fit_near(data, predictor, hypothesis, whitener, start, known, effort) {
                Ok(f) => {
                    if best.as_ref().is_none_or(|b| f.cost < b.cost) {
                        best = Some(f);
                    }
                }
                Err(e) => error = Some(e),
            }
        }
        best.ok_or_else(|| {
            error.unwrap_or_else(|| GapError::Soil("a fit without a start".to_owned()))
        })
    })
    // Where a fit begins changes nothing that is told.
    .map(|(fit, _)| fit)
}

#[cfg(test)]
mod tests {
    use terra_model::ModelError;

    use super::*;

    /// On a straight problem the promise is all that is left to gain: the cost there less the least, which the normal equations
    /// give. A component that a bound holds promises nothing.
    #[test]
    fn the_promise_of_a_straight_problem_is_kept() {
        let slopes = DMatrix::from_row_slice(3, 2, &[1.0, 0.5, -0.3, 2.0, 0.7, 0.1]);
        let measured = DVector::from_vec(vec![2.0, -1.0, 0.5]);
        let at = |x: DVector<f64>, bounded: bool| {
            let residual = &measured - &slopes * &x;
            let cost = residual.norm_squared() + x.norm_squared();
            Fit {
                x,
                residual,
                jacobian: slopes.clone().into(),
                exact: true,
                tangent: false,
                cost,
                converged: false,
                given_up: false,
                log_det: 0.0,
                at_bound: vec![false, bounded],
                near: Remembered::default(),
            }
        };
        let curvature = slopes.tr_mul(&slopes) + DMatrix::identity(2, 2);
        let least = curvature
            .cholesky()
            .unwrap()
            .solve(&slopes.tr_mul(&measured));
        let least = at(least, false);
        assert!(least.promise().abs() < 1e-12, "{}", least.promise());
        let short = at(DVector::from_vec(vec![0.2, 0.4]), false);
        let gain = short.cost - least.cost;
        assert!(
            (short.promise() / gain - 1.0).abs() < 1e-12,
            "{} {gain}",
            short.promise()
        );
        // With the second component held: the least along the first alone.
        let held = at(DVector::from_vec(vec![0.2, 0.4]), true);
        let first = slopes.column(0);
        let pull = first.dot(&held.residual) - held.x[0];
        let gain = pull * pull / (first.norm_squared() + 1.0);
        assert!(
            (held.promise() / gain - 1.0).abs() < 1e-12,
            "{} {gain}",
            held.promise()
        );
    }

    /// Soil and effect that do nearly the same, of which the data want much of the one against more of the other: with the effect
    /// held at zero the soil is where it is without the effect, and not where it would stand beside it.
    #[test]
    fn what_a_bound_holds_leaves_the_rest_at_its_own_least() {
        let slopes = DMatrix::from_row_slice(3, 2, &[50.0, 49.0, 50.0, 50.0, 50.0, 51.0]);
        let at = |columns: usize| {
            let x = DVector::from_element(columns, 0.1);
            Fit {
                residual: DVector::from_vec(vec![7.0, 2.0, -3.0]),
                jacobian: slopes.columns(0, columns).into_owned().into(),
                exact: true,
                tangent: false,
                cost: 0.0,
                converged: false,
                given_up: false,
                log_det: 0.0,
                at_bound: vec![false; columns],
                near: Remembered::default(),
                x,
            }
        };
        let (none, most) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
        let open = at(2).least_within(&none, &most);
        assert!(open[0] > 2.0 && open[1] < -2.0, "{open}");
        let held = at(2).least_within(&[f64::NEG_INFINITY, 0.0], &most);
        let mut alone = at(1);
        alone.residual += slopes.column(1) * 0.1;
        let alone = alone.least_within(&none[..1], &most[..1]);
        assert!(
            held[1] == 0.0 && (held[0] - alone[0]).abs() < 1e-12,
            "{held} {alone}"
        );
        // The gradient of the quadratic is zero along what is free.
        let r = &at(2).residual - &slopes * (&open - &at(2).x);
        assert!((slopes.tr_mul(&r) - &open).amax() < 1e-9);
    }

    /// A start just beyond what the soil carries begins a thousandth nearer and says so; one far beyond says why; other errors stay.
    #[test]
    fn a_start_at_the_edge_steps_back() {
        let carried = |starts: &[Vec<f64>]| {
            if starts[0][0] < 2.0 {
                return Ok(starts[0].clone());
            }
            Err(GapError::Model(ModelError::NoEquilibrium {
                load: starts[0][0],
                max_load: 2.0,
            }))
        };
        let from = |x: f64| backed(&[vec![x, 1.0]], carried);
        let (as_it_is, share) = from(1.9).unwrap();
        assert_eq!(
            (as_it_is, note_of_edge("rms", share)),
            (vec![1.9, 1.0], None)
        );
        let (nearer, share) = from(2.001).unwrap();
        assert_eq!(nearer, [0.999 * 2.001, 0.999]);
        let note = note_of_edge("rms", share).unwrap();
        assert!(note.starts_with("rms: taken 0.1 %"), "{note}");
        let refused = from(3.0).unwrap_err();
        assert!(matches!(
            refused,
            GapError::Model(ModelError::NoEquilibrium { load, .. }) if load == 3.0
        ));
        let mut asked = 0;
        let other: Result<((), f64), _> = backed(&[vec![3.0]], |_| {
            asked += 1;
            Err(GapError::Soil("no soil".to_owned()))
        });
        assert!(matches!(other, Err(GapError::Soil(_))) && asked == 1);
    }
}
