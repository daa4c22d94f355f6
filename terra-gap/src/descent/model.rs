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
        let whole = j.tr_mul(j) + DMatrix::identity(all.len(), all.len());
        let free = free_of_bounds(&here.x, &all, &whole, low, high);
        let gradient = all.select_rows(&free);
        let slopes = j.select_columns(&free);
        let curvature = whole.select_columns(&free).select_rows(&free);
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

/// The components that no bound holds: those inside, and those at a bound that the least of the quadratic over the others leads away
/// from it. The gradient where the way stands does not tell: in a narrow valley what is left to go across it outweighs everything.
fn free_of_bounds(
    x: &DVector<f64>,
    gradient: &DVector<f64>,
    curvature: &DMatrix<f64>,
    low: &[f64],
    high: &[f64],
) -> Vec<usize> {
    let inwards = |k: usize, by: f64| (x[k] <= low[k] && by > 0.0) || (x[k] >= high[k] && by < 0.0);
    let (mut free, mut at_bound): (Vec<usize>, Vec<usize>) =
        (0..x.len()).partition(|&k| low[k] < x[k] && x[k] < high[k]);
    while !at_bound.is_empty() {
        let along = curvature.select_columns(&free).select_rows(&free);
        let Some(root) = along.cholesky() else {
            break;
        };
        let step = root.solve(&gradient.select_rows(&free));
        // One that was let go and would go back out is held from now on.
        if let Some(place) = free
            .iter()
            .zip(step.iter())
            .position(|(&k, by)| (x[k] <= low[k] || x[k] >= high[k]) && !inwards(k, *by))
        {
            free.remove(place);
            continue;
        }
        let left = gradient - curvature.select_columns(&free) * step;
        let lead = |k: usize| left[k].powi(2) / curvature[(k, k)];
        let leads = (0..at_bound.len()).filter(|&i| inwards(at_bound[i], left[at_bound[i]]));
        let most = leads.max_by(|a, b| lead(at_bound[*a]).total_cmp(&lead(at_bound[*b])));
        let Some(most) = most else {
            break;
        };
        free.push(at_bound.remove(most));
    }
    free.sort_unstable();
    free
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two components that do nearly the same, the second with a bound at zero, where both stand: across their valley a step is
    /// left that outweighs what leads along it. The least of the quadratic lies inside or not, whatever the gradient says.
    #[test]
    fn a_bound_holds_what_the_least_lies_beyond() {
        let j = DMatrix::from_row_slice(2, 2, &[100.0, 99.0, 0.0, 1.0]);
        let (low, high) = ([f64::NEG_INFINITY, 0.0], [f64::INFINITY; 2]);
        let free = |across: f64, along: f64| {
            let here = Point::new(DVector::zeros(2), DVector::from_vec(vec![across, along]));
            Model::new(&here, &j, &low, &high).free
        };
        // J'r of the second: -4.9, then 4.9.
        assert_eq!(free(-0.1, 5.0), [0, 1]);
        assert_eq!(free(0.1, -5.0), [0]);
        // Where both say the same.
        assert_eq!(free(0.1, 5.0), [0, 1]);
        assert_eq!(free(-0.1, -5.0), [0]);
    }
}
