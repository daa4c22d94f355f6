//! The law around one point of a way down: quadratic, and how it bends along a step.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::Residuals;

/// Step along the velocity, as a share of it, from which the acceleration is measured.
const PROBE: f64 = 0.1;

/// A point on the way.
pub(super) struct Point {
    pub(super) x: DVector<f64>,
    pub(super) r: DVector<f64>,
    pub(super) cost: f64,
}

impl Point {
    pub(super) fn new(x: DVector<f64>, r: DVector<f64>) -> Self {
        let cost = r.norm_squared() + x.norm_squared();
        Point { x, r, cost }
    }
}

/// The quadratic model at a point, over the components that no bound holds.
pub(super) struct Model {
    pub(super) free: Vec<usize>,
    /// Half the downhill gradient.
    pub(super) gradient: DVector<f64>,
    pub(super) slopes: DMatrix<f64>,
    curvature: DMatrix<f64>,
    /// Decrease that the whole step of it foresees.
    pub(super) left: Option<f64>,
}

impl Model {
    pub(super) fn new(here: &Point, j: &DMatrix<f64>, low: &[f64], high: &[f64]) -> Self {
        let all = j.tr_mul(&here.r) - &here.x;
        // Components pushed against their bound stay where they are.
        let free: Vec<usize> = (0..all.len())
            .filter(|&k| {
                !((here.x[k] <= low[k] && all[k] < 0.0) || (here.x[k] >= high[k] && all[k] > 0.0))
            })
            .collect();
        let gradient = DVector::from_iterator(free.len(), free.iter().map(|&k| all[k]));
        let slopes = j.select_columns(&free);
        let curvature = slopes.tr_mul(&slopes) + DMatrix::identity(free.len(), free.len());
        let left = curvature
            .clone()
            .cholesky()
            .map(|c| c.solve(&gradient).dot(&gradient));
        Model {
            free,
            gradient,
            slopes,
            curvature,
            left,
        }
    }

    pub(super) fn damped(&self, damping: f64) -> Option<Cholesky<f64, Dyn>> {
        let diagonal = self.curvature.diagonal() * damping;
        (&self.curvature + DMatrix::from_diagonal(&diagonal)).cholesky()
    }

    /// Decrease that a step foresees.
    pub(super) fn foresees(&self, step: &DVector<f64>) -> f64 {
        2.0 * self.gradient.dot(step) - step.dot(&(&self.curvature * step))
    }

    /// A step's length in units of the parameters' own uncertainty.
    pub(super) fn length(&self, step: &DVector<f64>) -> f64 {
        let weighed = step.component_mul(&self.curvature.diagonal());
        weighed.dot(step).sqrt()
    }

    /// A step from a point, inside the bounds.
    pub(super) fn from(
        &self,
        x: &DVector<f64>,
        step: &DVector<f64>,
        low: &[f64],
        high: &[f64],
    ) -> DVector<f64> {
        let mut to = x.clone();
        for (i, &k) in self.free.iter().enumerate() {
            to[k] = (to[k] + step[i]).clamp(low[k], high[k]);
        }
        to
    }
}

/// How the valley bends along a velocity; none where there is no answer a little along it.
pub(super) fn acceleration<R: Residuals>(
    problem: &R,
    model: &Model,
    here: &Point,
    velocity: &DVector<f64>,
    solver: &Cholesky<f64, Dyn>,
    low: &[f64],
    high: &[f64],
) -> Option<DVector<f64>> {
    let to = model.from(&here.x, &(velocity * PROBE), low, high);
    let r = problem.value(&to).ok()?;
    let moved = to - &here.x;
    let moved = DVector::from_iterator(model.free.len(), model.free.iter().map(|&k| moved[k]));
    let second = (r - &here.r + &model.slopes * moved) * (2.0 / (PROBE * PROBE));
    Some(solver.solve(&model.slopes.tr_mul(&second)))
}
