//! Forces of many hypotheses as one linear map of shared features of slip and load.
//!
//! # Equation
//! D/W, T/(R W), z/R = Σ_ab c_ab T_a(x) T_b(y), x and y the slip and ln(load) scaled to [-1, 1], T Chebyshev
//! polynomials; c by collocation at the Chebyshev nodes. With features φ = T_a(x) T_b(y) (K of them), a hypothesis is
//! its coefficient vector θ (3K), and a force observation is A F = Φ θ.
//!
//! Errors concentrate at the edge of what a soil can carry: a hypothesis that is infeasible at any node is not
//! tabulated. Nothing is clamped: a contact outside the box is an error.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use terra_model::{Contact, ForceLaw};

use crate::error::EstimatorError;
use crate::hypothesis::{Hypothesis, HypothesisSet};
use crate::observation::ForceObservation;
use crate::prediction::model_error;
use crate::residual::is_infeasible;

/// The box of a table and its resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableBox {
    /// Smallest and largest library slip. Driving and braking are best kept in two tables: forces have a kink at 0.
    pub slip: (f64, f64),
    /// Smallest and largest normal load \[N\].
    pub load: (f64, f64),
    /// Chebyshev nodes along slip and along ln(load).
    pub nodes: (usize, usize),
}

impl TableBox {
    pub(crate) fn checked(self) -> Result<Self, EstimatorError> {
        let fail = |what: &str, value, expected| {
            Err(EstimatorError::Value {
                what: what.to_owned(),
                value,
                expected,
            })
        };
        let ((s0, s1), (w0, w1)) = (self.slip, self.load);
        if !(s0 >= -1.0 && s1 <= 1.0 && s0 < s1) {
            return fail(
                "table slip range",
                s1 - s0,
                "an increasing range inside [-1, 1]",
            );
        }
        if !(w0 > 0.0 && w1 > w0 && w1.is_finite()) {
            return fail(
                "table load range",
                w1 - w0,
                "an increasing range of finite loads above 0 N",
            );
        }
        if self.nodes.0 == 0 || self.nodes.1 == 0 {
            return fail("table nodes", 0.0, "at least 1 node along each axis");
        }
        Ok(self)
    }
}

/// Shared features and the coefficients of each hypothesis.
#[derive(Clone, Debug)]
pub struct ForceTable {
    range: TableBox,
    radius: f64,
    width: f64,
    /// One vector (3K) a hypothesis: D/W, T/(R W), z/R; none where it is infeasible inside the box.
    coefficients: Vec<Option<DVector<f64>>>,
}

/// T_0 .. T_(n-1) and their derivatives at x.
fn chebyshev(x: f64, n: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut t, mut d) = (vec![1.0; n], vec![0.0; n]);
    if n > 1 {
        (t[1], d[1]) = (x, 1.0);
    }
    for k in 2..n {
        t[k] = 2.0 * x * t[k - 1] - t[k - 2];
        d[k] = 2.0 * t[k - 1] + 2.0 * x * d[k - 1] - d[k - 2];
    }
    (t, d)
}

/// x_q = cos(π (q + 1/2)/n).
fn node(q: usize, n: usize) -> f64 {
    (PI * (q as f64 + 0.5) / n as f64).cos()
}

fn scaled(x: f64, (low, high): (f64, f64)) -> f64 {
    (2.0 * x - low - high) / (high - low)
}

impl ForceTable {
    /// Tabulates every hypothesis on contacts like the template.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a bad box; [`EstimatorError::NotSupported`] for a law with effects, which may look
    /// at more of a contact than slip and load; [`EstimatorError::Model`].
    pub fn new(
        set: &HypothesisSet,
        range: TableBox,
        template: &Contact<f64>,
    ) -> Result<Self, EstimatorError> {
        let range = range.checked()?;
        let coefficients = set
            .hypotheses()
            .iter()
            .map(|h| coefficients(h, range, template))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(ForceTable {
            range,
            radius: template.radius,
            width: template.width,
            coefficients,
        })
    }

    /// Number of features K of one force.
    pub fn features(&self) -> usize {
        self.range.nodes.0 * self.range.nodes.1
    }

    /// Coefficients (3K) of hypothesis j; none where it is infeasible in the box.
    pub fn coefficients(&self, j: usize) -> Option<&DVector<f64>> {
        self.coefficients.get(j).and_then(Option::as_ref)
    }

    /// Φ (m x 3K) of an observation, with its slopes in slip and load of each wheel (2w matrices m x 3K).
    ///
    /// # Errors
    /// [`EstimatorError::OutsideTable`].
    pub fn observe(
        &self,
        obs: &ForceObservation,
    ) -> Result<(DMatrix<f64>, Vec<DMatrix<f64>>), EstimatorError> {
        let (k, m) = (self.features(), obs.forces.len());
        let mut map = DMatrix::zeros(m, 3 * k);
        let mut slopes = Vec::with_capacity(2 * obs.contacts.len());
        for (wheel, at) in obs.contacts.iter().enumerate() {
            self.inside(at)?;
            let log_load = (self.range.load.0.ln(), self.range.load.1.ln());
            let (tx, dx) = chebyshev(scaled(at.slip, self.range.slip), self.range.nodes.0);
            let (ty, dy) = chebyshev(scaled(at.normal_load.ln(), log_load), self.range.nodes.1);
            let x_slope = 2.0 / (self.range.slip.1 - self.range.slip.0);
            let y_slope = 2.0 / (log_load.1 - log_load.0) / at.normal_load;
            let (w, r) = (at.normal_load, at.radius);
            let (mut in_slip, mut in_load) = (DMatrix::zeros(m, 3 * k), DMatrix::zeros(m, 3 * k));
            // Force = scale x Σ c φ; only the scale of D and T grows with the load.
            for (force, scale, growth) in [(0, w, 1.0), (1, r * w, r), (2, r, 0.0)] {
                for row in 0..m {
                    let a = obs.map[(row, 3 * wheel + force)];
                    if a == 0.0 {
                        continue;
                    }
                    for (feature, (p, q)) in pairs(self.range.nodes).enumerate() {
                        let column = force * k + feature;
                        let phi = tx[p] * ty[q];
                        map[(row, column)] += a * scale * phi;
                        in_slip[(row, column)] = a * scale * dx[p] * x_slope * ty[q];
                        in_load[(row, column)] =
                            a * (growth * phi + scale * tx[p] * dy[q] * y_slope);
                    }
                }
            }
            slopes.extend([in_slip, in_load]);
        }
        Ok((map, slopes))
    }

    fn inside(&self, at: &Contact<f64>) -> Result<(), EstimatorError> {
        let same = |quantity, value: f64, own: f64| {
            (quantity, value, own * (1.0 - 1e-9), own * (1.0 + 1e-9))
        };
        let checks = [
            ("slip", at.slip, self.range.slip.0, self.range.slip.1),
            (
                "normal_load",
                at.normal_load,
                self.range.load.0,
                self.range.load.1,
            ),
            same("radius", at.radius, self.radius),
            same("width", at.width, self.width),
        ];
        for (quantity, value, min, max) in checks {
            if !(min..=max).contains(&value) {
                return Err(EstimatorError::OutsideTable {
                    quantity,
                    value,
                    min,
                    max,
                });
            }
        }
        Ok(())
    }
}

fn pairs(nodes: (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    (0..nodes.0).flat_map(move |a| (0..nodes.1).map(move |b| (a, b)))
}

fn coefficients(
    h: &Hypothesis,
    range: TableBox,
    template: &Contact<f64>,
) -> Result<Option<DVector<f64>>, EstimatorError> {
    if !h.law.effects().is_empty() {
        return Err(EstimatorError::NotSupported {
            estimator: "sufficient-statistics",
            choice: h.law.name(),
            reason: "effects may look at more of a contact than slip and load",
        });
    }
    let (nx, ny) = range.nodes;
    let k = nx * ny;
    let (low, high) = (range.load.0.ln(), range.load.1.ln());
    let middle = |(low, high): (f64, f64), x: f64| 0.5 * (low + high) + 0.5 * (high - low) * x;
    let mut theta = DVector::zeros(3 * k);
    for (qx, qy) in pairs(range.nodes) {
        let (x, y) = (node(qx, nx), node(qy, ny));
        let load = middle((low, high), y).exp();
        let at = Contact {
            slip: middle(range.slip, x),
            normal_load: load,
            ..*template
        };
        let f = match h.law.forces(&h.parameters, &at) {
            Ok(f) => f,
            Err(e) if is_infeasible(&e) => return Ok(None),
            Err(e) => return Err(model_error(&h.id, e)),
        };
        let r = template.radius;
        let values = [
            f.drawbar_pull / load,
            f.resistive_torque / (r * load),
            f.sinkage.unwrap_or(0.0) / r,
        ];
        let ((tx, _), (ty, _)) = (chebyshev(x, nx), chebyshev(y, ny));
        for (feature, (a, b)) in pairs(range.nodes).enumerate() {
            // Discrete orthogonality: weight 2/n, 1/n for the constant.
            let weight =
                (if a == 0 { 1.0 } else { 2.0 }) * (if b == 0 { 1.0 } else { 2.0 }) / k as f64;
            for (force, value) in values.iter().enumerate() {
                theta[force * k + feature] += weight * value * tx[a] * ty[b];
            }
        }
    }
    Ok(Some(theta))
}
