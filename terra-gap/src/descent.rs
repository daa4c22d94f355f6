//! The way down: Levenberg-Marquardt with geodesic acceleration, inside bounds.
//!
//! # Equation
//! x = argmin |r(x)|² + |x|², J = -dr/dx. A step is v + a/2 with (H + λ diag H) v = J'r - x, H = J'J + I, and
//! (H + λ diag H) a = J' r_vv, where r_vv is the second derivative of r along v. Soil parameters trade off against each other
//! along narrow bent valleys: straight steps creep along these, bent ones follow them.
//!
//! # Source
//! Transtrum & Sethna 2012, "Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares minimization",
//! arXiv:1201.5885.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::error::GapError;
use crate::memory::Remembered;

mod model;
use model::{Model, Point, acceleration};

const MAX_STEPS: usize = 80;
/// Attempts at one step, the damping raised from each to the next.
const ATTEMPTS: usize = 30;
/// The same with a carried Jacobian, which is then renewed rather than damped away.
const ATTEMPTS_CARRIED: usize = 4;
/// Predicted decrease of |r|² + |x|² below which a way has ended: far below the one unit that matters.
const CERTIFICATE: f64 = 1e-4;
/// The same for a fit of a contest, and for a carried Jacobian.
const CONTEST: f64 = 1e-2;
const CARRIED: f64 = 1e-2;
const ROUGHLY: f64 = 0.1;
/// Promise up to which a way that found no step down has converged: a tenth of the parameters' own uncertainty.
const CONVERGED: f64 = 1e-2;
/// Promise of an exact Jacobian up to which such a fit's step is its last one: within half a unit of the parameters' own
/// uncertainty a Jacobian hardly changes, and where the step keeps what was promised there is no need to ask for it once more.
const LAST: f64 = 0.25;
/// Promise and gain over so many steps below which such a fit has ended at a kink of the law.
const KINK: (f64, f64, usize) = (0.1, 0.01, 3);
/// Promise below which a fit of a contest creeps on to no purpose where its exact Jacobians brought less than this share of it over
/// so many steps.
const CREEP: (f64, f64, usize) = (2.0, 0.5, 2);
/// The same of a carried Jacobian, which mends itself: promise, and gain over so many steps.
const CREEP_CARRIED: (f64, f64, usize) = (0.5, 0.2, 4);
/// Misfit per value beyond the noise from which a fit is far from the data.
const FAR: f64 = 0.3;
/// Steps over which such a fit must come nearer, and by which share of what is left.
const NEARER: (usize, f64) = (6, 0.02);
/// The same steps where a Jacobian is carried, from an end nearby.
const NEARER_CARRIED: usize = 3;
/// Steps over which such a fit must come nearer fast enough to arrive at all, if it comes so many times as fast from there on.
const ARRIVING: (usize, f64) = (4, 2.0);
/// Share of what is left beyond the noise that a whole step must promise such a fit.
const PROMISING: f64 = 0.01;
/// Share of it below which a carried Jacobian's promise no longer matters.
const SETTLED: f64 = 1e-3;
/// Steps after which a cost is out of reach that so many times the decrease in sight does not bridge.
const REACH: (usize, f64) = (4, 4.0);
/// Damping at the start, its change after a step that was as good as foreseen and after one that was refused.
const DAMPING: (f64, f64, f64) = (1e-3, 0.25, 4.0);
/// Largest change after several that were refused one after the other, each by [`DAMPING`] more than the one before.
const RAISED: f64 = 64.0;
/// Share of the foreseen decrease from which the damping is lowered once more.
const AS_FORESEEN: f64 = 0.9;
/// Exact Jacobians that a carried one may need before each step has its own: Broyden's update does not follow a kink.
const RENEWALS: usize = 3;
/// Damping at a start near the data, where the tangent is nearly right: more would hold back what a narrow valley leaves free.
const DAMPING_NEAR: f64 = 1e-6;
/// Share of the foreseen decrease from which straight steps do.
const STRAIGHT: f64 = 0.75;
/// Share below which the damping rises although the step was taken.
const POOR: f64 = 0.25;
/// Largest acceleration against the velocity that is believed, as 2 |a| / |v|.
const BENT: f64 = 0.75;

/// How long a fit goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Effort {
    /// Until an exact Jacobian certifies the end.
    Certified,
    /// The same, unless it stays far from the data and hardly comes nearer: enough to know that it is out of the contest.
    Contest,
    /// As a contest, from where it ended under another noise.
    Again,
    /// As a contest, and given up where this cost is out of reach.
    Below(f64),
    /// As a contest, but a Jacobian carried along by Broyden's update may end it: for fits that start at their end.
    Carried,
    /// The same, and ended a tenth of a unit early: for looking around.
    Roughly,
}

/// A vector of residuals and its slopes.
pub(crate) trait Residuals {
    /// r (n).
    ///
    /// # Errors
    /// Where there is no answer.
    fn value(&self, x: &DVector<f64>) -> Result<DVector<f64>, GapError>;

    /// r (n) and -dr/dx (n x d).
    ///
    /// # Errors
    /// Where there is no answer.
    fn slopes(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), GapError>;
}

/// What is known at a start before a way down begins there.
#[derive(Clone)]
pub(crate) struct Known {
    /// r, where another way ended at this very place.
    pub residual: Option<DVector<f64>>,
    /// -dr/dx.
    pub jacobian: Arc<DMatrix<f64>>,
    /// Whether that is exact, and not of a place nearby or carried along.
    pub exact: bool,
    /// Where the solvers of that other way ended.
    pub near: Remembered,
}

impl Known {
    /// A Jacobian of a place nearby, and what is remembered there.
    pub(crate) fn nearby(jacobian: Arc<DMatrix<f64>>, near: &Remembered) -> Self {
        Known {
            residual: None,
            jacobian,
            exact: false,
            near: near.clone(),
        }
    }

    /// Only some of the values.
    pub(crate) fn of_rows(&self, rows: &[usize]) -> Self {
        Known {
            residual: self.residual.as_ref().map(|r| r.select_rows(rows)),
            jacobian: self.jacobian.select_rows(rows).into(),
            exact: self.exact,
            near: self.near.clone(),
        }
    }
}

/// Where a way down ended.
pub(crate) struct End {
    pub x: DVector<f64>,
    pub residual: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    /// Whether that is exact, and not carried along.
    pub exact: bool,
    pub cost: f64,
    pub converged: bool,
    pub given_up: bool,
}

/// Why a way goes no further.
enum Stop {
    /// The law promises no more, or at a kink not enough; whether that is certified.
    Down(bool),
    /// Out of the contest.
    GivenUp,
}

/// What a step is asked for.
#[derive(Clone, Copy, PartialEq)]
enum Asks {
    /// The value alone: its Jacobian is carried along.
    Value,
    /// Value and slopes at once: most steps are taken.
    Both,
    /// The slopes too once its value is lower: steps are doubtful.
    SlopesThen,
}

/// A way down.
struct Way<'a, R> {
    problem: &'a R,
    low: &'a [f64],
    high: &'a [f64],
    effort: Effort,
    here: Point,
    /// -dr/dx here, and whether it is exact or carried along.
    j: DMatrix<f64>,
    exact: bool,
    damping: f64,
    /// How often a carried one was replaced.
    renewals: usize,
    /// Whether the next step bends, and whether the step before was refused at first.
    bent: bool,
    doubtful: bool,
    /// Whether the step before was a last one that kept what an exact Jacobian promised.
    kept: bool,
    /// Cost after every step.
    costs: Vec<f64>,
}

/// Goes down from a start.
///
/// # Errors
/// Where there is no answer at the start; steps into such places are only refused.
pub(crate) fn descend<R: Residuals>(
    problem: &R,
    (low, high): (&[f64], &[f64]),
    start: &[f64],
    known: Option<Known>,
    effort: Effort,
) -> Result<End, GapError> {
    let given = start;
    let start = DVector::from_fn(start.len(), |k, _| start[k].clamp(low[k], high[k]));
    let known = known.filter(|_| start.as_slice() == given);
    let exact = known.as_ref().is_none_or(|known| known.exact);
    let (r, j) = match known {
        Some(Known {
            residual: Some(r),
            jacobian,
            ..
        }) => (r, Arc::unwrap_or_clone(jacobian)),
        Some(Known { jacobian, .. }) => (problem.value(&start)?, Arc::unwrap_or_clone(jacobian)),
        None => problem.slopes(&start)?,
    };
    let here = Point::new(start, r);
    let mut way = Way {
        problem,
        low,
        high,
        effort,
        costs: vec![here.cost],
        here,
        j,
        exact,
        damping: DAMPING.0,
        renewals: 0,
        bent: !effort.carries(),
        doubtful: false,
        kept: false,
    };
    way.damping = way.first_damping();
    let mut stop = Stop::Down(false);
    for _ in 0..MAX_STEPS {
        let model = Model::new(&way.here, &way.j, low, high);
        if let Some(reason) = way.ended(&model) {
            stop = reason;
            break;
        }
        if way.promise(&model) >= way.end() && way.step(&model) {
            continue;
        }
        let end = (effort.ends_carried() || way.kept) && way.promise(&model) < way.end();
        if end || way.exact || !way.renew() {
            // Certified, at rounding, or in a corner of the model's domain.
            let certified = way.exact || way.kept;
            stop = Stop::Down(certified && way.promise(&model) < CONVERGED);
            break;
        }
        way.damping = way.first_damping();
    }
    // One that was given up is only known to be far: a carried Jacobian says as much.
    let given_up = matches!(stop, Stop::GivenUp);
    let mut converged = matches!(stop, Stop::Down(true));
    let carried = effort.ends_carried() || way.kept;
    if !way.exact && !carried && !given_up && way.renew() {
        let model = Model::new(&way.here, &way.j, low, high);
        converged |= way.promise(&model) < CONVERGED;
    }
    Ok(End {
        x: way.here.x,
        residual: way.here.r,
        jacobian: way.j,
        exact: way.exact,
        cost: way.here.cost,
        converged,
        given_up,
    })
}

impl Effort {
    /// Whether a carried Jacobian may end it.
    fn ends_carried(self) -> bool {
        matches!(self, Effort::Carried | Effort::Roughly)
    }

    /// Whether a Jacobian is carried along between exact ones.
    fn carries(self) -> bool {
        self == Effort::Again || self.ends_carried()
    }
}

impl<R: Residuals> Way<'_, R> {
    /// Whether a Jacobian is still carried along.
    fn carries(&self) -> bool {
        self.effort.carries() && self.renewals < RENEWALS
    }

    /// Misfit beyond the noise.
    fn beyond(&self) -> f64 {
        (self.here.cost - self.here.r.len() as f64).max(0.0)
    }

    fn is_far(&self) -> bool {
        self.here.cost > self.here.r.len() as f64 * (1.0 + FAR)
    }

    fn first_damping(&self) -> f64 {
        if self.is_far() {
            DAMPING.0
        } else {
            DAMPING_NEAR
        }
    }

    /// Decrease of the cost that a whole step promises.
    fn promise(&self, model: &Model) -> f64 {
        model.left.unwrap_or(0.0)
    }

    /// Promise below which the way has ended.
    fn end(&self) -> f64 {
        match self.effort {
            Effort::Certified => CERTIFICATE,
            Effort::Contest | Effort::Again | Effort::Below(_) => CONTEST,
            Effort::Carried => CARRIED.max(SETTLED * self.beyond()),
            Effort::Roughly => ROUGHLY.max(SETTLED * self.beyond()),
        }
    }

    /// Decrease of the cost over the last so many steps.
    fn gained(&self, steps: usize) -> Option<f64> {
        let before = self.costs.len().checked_sub(steps + 1);
        Some(self.costs.get(before?)? - self.here.cost)
    }

    /// Whether it is in vain to go on.
    fn ended(&self, model: &Model) -> Option<Stop> {
        if self.effort == Effort::Certified {
            return None;
        }
        let promise = self.promise(model);
        let (carries, beyond) = (self.carries(), self.beyond());
        if self.is_far() {
            let steps = if carries { NEARER_CARRIED } else { NEARER.0 };
            let stalls = self.gained(steps).is_some_and(|g| g < NEARER.1 * beyond);
            let stalls = stalls || !arrives(&self.costs, self.here.r.len());
            let idle = (self.exact || carries) && promise < PROMISING * beyond;
            if stalls || idle {
                return Some(Stop::GivenUp);
            }
        }
        let (small, little, steps) = KINK;
        if self.exact && promise < small && self.gained(steps).is_some_and(|g| g < little) {
            return Some(Stop::Down(promise < CONVERGED));
        }
        let creeps = if carries {
            let (promised, gained, steps) = CREEP_CARRIED;
            promise < promised && self.gained(steps).is_some_and(|g| g < gained)
        } else {
            let (promised, share, steps) = CREEP;
            let slow = self.gained(steps).is_some_and(|g| g < share * promise);
            self.exact && promise < promised && slow
        };
        if creeps {
            return Some(Stop::Down(self.exact && promise < CONVERGED));
        }
        let (steps, reach) = REACH;
        match self.effort {
            Effort::Below(target) if self.costs.len() > steps => {
                (self.here.cost - reach * promise > target).then_some(Stop::GivenUp)
            }
            _ => None,
        }
    }

    /// Whether the next step is the last one if it keeps what it promises.
    fn is_last(&self, model: &Model) -> bool {
        self.effort != Effort::Certified && self.exact && self.promise(model) < LAST
    }

    /// One step down; false where none was found.
    fn step(&mut self, model: &Model) -> bool {
        let attempts = if self.exact {
            ATTEMPTS
        } else {
            ATTEMPTS_CARRIED
        };
        let (last, carries) = (self.is_last(model), self.carries());
        self.bent &= !last;
        let mut raise = 1.0;
        for attempt in 0..attempts {
            let Some(solver) = model.damped(self.damping) else {
                return false;
            };
            let velocity = solver.solve(&model.gradient);
            let asks = match attempt {
                _ if carries => Asks::Value,
                0 if last => Asks::Value,
                0 if !self.doubtful => Asks::Both,
                _ => Asks::SlopesThen,
            };
            if let Some((next, slopes)) = self.attempt(model, &velocity, &solver, asks) {
                let foreseen = model.foresees(&velocity);
                let kept = (self.here.cost - next.cost) / foreseen > STRAIGHT && attempt == 0;
                self.take(model, next, slopes, foreseen, attempt > 0);
                self.kept = last && kept && !self.exact;
                return true;
            }
            self.bent = !carries;
            raise = f64::min(raise * DAMPING.2, RAISED);
            self.damping = (self.damping * raise).min(1e12);
        }
        false
    }

    /// The point after a step, where that is lower, with its slopes unless they are carried along.
    fn attempt(
        &self,
        model: &Model,
        velocity: &DVector<f64>,
        solver: &Cholesky<f64, Dyn>,
        asks: Asks,
    ) -> Option<(Point, Option<DMatrix<f64>>)> {
        let (low, high) = (self.low, self.high);
        let mut whole = velocity.clone();
        if self.bent
            && let Some(a) =
                acceleration(self.problem, model, &self.here, velocity, solver, low, high)
        {
            if 2.0 * model.length(&a) > BENT * model.length(velocity) {
                return None;
            }
            whole += a * 0.5;
        }
        let to = model.from(&self.here.x, &whole, low, high);
        let (r, slopes) = if asks == Asks::Both {
            let (r, j) = self.problem.slopes(&to).ok()?;
            (r, Some(j))
        } else {
            (self.problem.value(&to).ok()?, None)
        };
        let next = Point::new(to, r);
        if !(next.cost.is_finite() && next.cost < self.here.cost) {
            return None;
        }
        let slopes = match slopes {
            // At the edge of what the soil carries there may be an answer without slopes: no way goes on from there.
            None if asks == Asks::SlopesThen => Some(self.problem.slopes(&next.x).ok()?.1),
            found => found,
        };
        Some((next, slopes))
    }

    /// Goes there.
    fn take(
        &mut self,
        model: &Model,
        next: Point,
        slopes: Option<DMatrix<f64>>,
        foreseen: f64,
        refused: bool,
    ) {
        let carries = self.carries();
        let share = (self.here.cost - next.cost) / foreseen;
        if share > STRAIGHT && !refused {
            let once_more = if share > AS_FORESEEN { DAMPING.1 } else { 1.0 };
            self.damping = (self.damping * DAMPING.1 * once_more).max(1e-12);
        } else if share < POOR {
            self.damping *= DAMPING.2.sqrt();
        }
        // A step that damping holds short is in a bent valley as well.
        let held = foreseen < STRAIGHT * self.promise(model);
        self.bent = !carries && (held || share < STRAIGHT);
        self.doubtful = refused;
        let moved = &next.x - &self.here.x;
        let surprise = (&self.here.r - &next.r) - &self.j * &moved;
        self.here = next;
        self.costs.push(self.here.cost);
        if let Some(slopes) = slopes {
            (self.j, self.exact) = (slopes, true);
        } else if self.exact || share >= POOR || !self.renew() {
            self.j += surprise * moved.transpose() / moved.norm_squared();
            self.exact = false;
        }
    }

    /// An exact Jacobian here, where there is one.
    fn renew(&mut self) -> bool {
        let Ok((_, slopes)) = self.problem.slopes(&self.here.x) else {
            return false;
        };
        (self.j, self.exact) = (slopes, true);
        self.renewals += 1;
        true
    }
}

/// Whether a way far from the data, of so many values, can still come to them: whether the last of its costs fell so fast that
/// the steps left are enough.
fn arrives(costs: &[f64], values: usize) -> bool {
    let (steps, faster) = ARRIVING;
    let before = costs.len().checked_sub(steps + 1);
    let (Some(before), Some(&here)) = (before.map(|k| costs[k]), costs.last()) else {
        return true;
    };
    let beyond = |cost: f64| cost - values as f64;
    let left = (MAX_STEPS + 1).saturating_sub(costs.len()) as f64;
    let pace = (beyond(before) / beyond(here)).ln() / steps as f64;
    faster * pace * left > (beyond(here) / (FAR * values as f64)).ln()
}

#[cfg(test)]
mod tests;
