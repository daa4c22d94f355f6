//! Sigma points in place of the Jacobian, while slip is so uncertain that forces are no straight line across it.
//!
//! # Reference
//! I. Arasaratnam, S. Haykin, IEEE Trans. Automatic Control 54(6):1254-1269, 2009 (the cubature rule).

use terra_model::STANDSTILL_SPEED;

use super::motion::Plant;
use super::rates::lever;
use super::vehicle_filter::{Estimate, Infeasible, STATES, Vector};

/// 1-sigma of slip above which sigma points take the place of the Jacobian.
const BENT: f64 = 0.1;

impl Estimate {
    /// True while slip is so uncertain that forces are no straight line across it.
    pub(super) fn bends(&self, plant: &Plant) -> bool {
        let radius = plant.vehicle.wheel_radius;
        (0..4).any(|q| {
            let (w, arm) = (2 + q, lever(plant, q));
            let travel = self.x[0] + arm * self.x[1];
            let rim = radius * self.x[w];
            let scale = rim.abs().max(travel.abs()).max(STANDSTILL_SPEED);
            let variance = radius * radius * self.p[w][w] + self.p[0][0] + arm * arm * self.p[1][1]
                - 2.0 * radius * (self.p[0][w] + arm * self.p[1][w])
                + 2.0 * arm * self.p[0][1];
            variance > (BENT * scale).powi(2)
        })
    }

    /// The points x ± √n L_k of the cubature rule, P = L Lᵀ; none when P has no root.
    fn points(&self) -> Option<[Vector; 2 * STATES]> {
        let mut l = [[0.0; STATES]; STATES];
        for j in 0..STATES {
            let rest = self.p[j][j] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
            if rest.is_nan() || rest <= 0.0 {
                return None;
            }
            l[j][j] = rest.sqrt();
            for i in j + 1..STATES {
                let sum = self.p[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                l[i][j] = sum / l[j][j];
            }
        }
        let root = (STATES as f64).sqrt();
        Some(std::array::from_fn(|k| {
            let sign = if k < STATES { root } else { -root };
            std::array::from_fn(|i| self.x[i] + sign * l[i][k % STATES])
        }))
    }

    /// Mean and covariance after a flow by the cubature rule (I. Arasaratnam, S. Haykin, IEEE Trans. Automatic Control
    /// 54(6):1254-1269, 2009); none when a point leaves what the soil carries.
    pub(super) fn spread(
        &self,
        flow: &impl Fn(&Vector, f64) -> Result<(Vector, f64), Infeasible>,
    ) -> Option<Self> {
        let share = 1.0 / (2 * STATES) as f64;
        let mut moved = Vec::with_capacity(2 * STATES);
        for x in self.points()? {
            moved.push(flow(&x, self.accel).ok()?);
        }
        let mut next = Estimate {
            x: [0.0; STATES],
            p: [[0.0; STATES]; STATES],
            accel: 0.0,
        };
        for (x, accel) in &moved {
            for (sum, x) in next.x.iter_mut().zip(x) {
                *sum += share * x;
            }
            next.accel += share * accel;
        }
        for (x, _) in &moved {
            for i in 0..STATES {
                for j in 0..STATES {
                    next.p[i][j] += share * (x[i] - next.x[i]) * (x[j] - next.x[j]);
                }
            }
        }
        next.x.iter().all(|v| v.is_finite()).then_some(next)
    }

    /// Mean and variance of a quantity by the cubature rule, and its covariance with the state.
    pub(super) fn seen_from_points(
        &self,
        seen: &impl Fn(&Vector) -> Result<f64, Infeasible>,
    ) -> Option<(f64, f64, Vector)> {
        let share = 1.0 / (2 * STATES) as f64;
        let points = self.points()?;
        let mut values = [0.0; 2 * STATES];
        for (value, x) in values.iter_mut().zip(&points) {
            *value = seen(x).ok()?;
        }
        let mean: f64 = values.iter().map(|v| share * v).sum();
        let variance = values.iter().map(|v| share * (v - mean).powi(2)).sum();
        let mut with = [0.0; STATES];
        for (value, x) in values.iter().zip(&points) {
            for i in 0..STATES {
                with[i] += share * (value - mean) * (x[i] - self.x[i]);
            }
        }
        Some((mean, variance, with))
    }
}
