//! Forces on a regular grid of slip and ln(load), node by node.
//!
//! # Equation
//! D/W, T/(R W), z/R at the nodes; between them the cubic through the four nearest nodes along each axis (Lagrange).

use terra_model::{Contact, ForceLaw};
use wide::f64x4;

use super::kernel::{Group, TILE, padded};
use crate::error::EstimatorError;
use crate::force_table::TableBox;
use crate::hypothesis::HypothesisSet;
use crate::prediction::model_error;
use crate::residual::is_infeasible;

/// Hypotheses of a vector of the kernel.
pub(super) const LANES: usize = 8;
/// Nodes of an interpolation along each axis.
pub(super) const ALONG: usize = 4;
/// Forces of a node.
pub(super) const OUTPUTS: usize = 3;

/// Forces of many hypotheses on a grid, `values[tile][slip][output][load][vector]`: of a tile, the four nodes along the load
/// that an interpolation takes lie together.
#[derive(Clone, Debug)]
pub struct GridTable {
    pub(super) range: TableBox,
    pub(super) radius: f64,
    pub(super) width: f64,
    /// ln of the box's least load, and nodes per unit of slip and of ln(load).
    scale: [f64; 3],
    /// Vectors of hypotheses; the last ones may be padded.
    pub(super) vectors: usize,
    /// Blocks of a tile: one an output and node.
    pub(super) blocks: usize,
    pub(super) values: Vec<[f32; LANES]>,
    /// Feasible at every node.
    pub(super) feasible: Vec<bool>,
}

/// First node, weights of the four from there, and their slopes.
pub(super) type Along = (usize, [f64; ALONG], [f64; ALONG]);

/// An interpolation at one contact: its first block, blocks from node to node along slip and from output to output, and along
/// slip and load the four weights and their slopes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stencil {
    first: usize,
    step: usize,
    across: usize,
    weight: [[f64; ALONG]; 2],
    slope: [[f64; ALONG]; 2],
}

impl Stencil {
    /// Adds the groups of one output, taken `share` times.
    pub(super) fn groups(&self, output: usize, share: f64, out: &mut Vec<Group>) {
        let [slip, load] = self.weight;
        let group = |(a, slip): (usize, f64)| Group {
            source: 0,
            block: self.first + output * self.across + a * self.step,
            weight: load.map(|load| (slip * share * load) as f32),
        };
        out.extend(slip.into_iter().enumerate().map(group));
    }

    /// Number of the first node along slip.
    pub(super) fn first_slip(&self) -> usize {
        self.first / self.step
    }

    /// The weights along slip.
    pub(super) fn slip_weights(&self) -> &[f64; ALONG] {
        &self.weight[0]
    }

    /// Value and slopes in slip and ln(load) of an output of the hypothesis at `place`.
    pub(super) fn value(&self, values: &[[f32; LANES]], place: Place, output: usize) -> [f64; 3] {
        let values = values.as_flattened();
        let first = self.first + output * self.across;
        // Four nodes along slip side by side.
        let mut from: [usize; ALONG] =
            std::array::from_fn(|a| place.first + (first + a * self.step) * place.step);
        let (mut at_slip, mut slope) = (f64x4::ZERO, f64x4::ZERO);
        for (load, in_load) in self.weight[1].iter().zip(&self.slope[1]) {
            let node = from.map(|from| values.get(from).map_or(0.0, |v| f64::from(*v)));
            from = from.map(|from| from + place.step);
            let node = f64x4::from(node);
            at_slip = node.mul_add(f64x4::splat(*load), at_slip);
            slope = node.mul_add(f64x4::splat(*in_load), slope);
        }
        let (slip, in_slip) = (f64x4::from(self.weight[0]), f64x4::from(self.slope[0]));
        [at_slip * slip, at_slip * in_slip, slope * slip].map(f64x4::reduce_add)
    }
}

/// Where a hypothesis stands in `values`: its number in the first block of its tile, and numbers from block to block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    first: usize,
    step: usize,
}

impl GridTable {
    /// Tabulates every hypothesis on contacts like the template. A hypothesis that is infeasible at any node is not
    /// tabulated.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a bad box or fewer than four nodes along an axis; [`EstimatorError::NotSupported`]
    /// for a law with effects, which may look at more of a contact than slip and load; [`EstimatorError::Model`].
    pub fn new(
        set: &HypothesisSet,
        range: TableBox,
        template: &Contact<f64>,
    ) -> Result<Self, EstimatorError> {
        let range = range.checked()?;
        let (nx, ny) = range.nodes;
        if nx < 4 || ny < 4 {
            return Err(EstimatorError::Value {
                what: "nodes of a grid".to_owned(),
                value: nx.min(ny) as f64,
                expected: "at least 4 along each axis",
            });
        }
        let (vectors, blocks) = (padded(set.len()), nx * OUTPUTS * ny);
        let mut values = vec![[0.0f32; LANES]; blocks * vectors];
        let mut feasible = vec![true; set.len()];
        let (low, high) = (range.load.0.ln(), range.load.1.ln());
        for (j, h) in set.hypotheses().iter().enumerate() {
            let place = place(j, vectors, blocks);
            if !h.law.effects().is_empty() {
                return Err(EstimatorError::NotSupported {
                    estimator: "fused",
                    choice: h.law.name(),
                    reason: "effects may look at more of a contact than slip and load",
                });
            }
            'nodes: for a in 0..nx {
                for b in 0..ny {
                    let share = |k: usize, n: usize| k as f64 / (n - 1) as f64;
                    let load = (low + (high - low) * share(b, ny)).exp();
                    let at = Contact {
                        slip: range.slip.0 + (range.slip.1 - range.slip.0) * share(a, nx),
                        normal_load: load,
                        ..*template
                    };
                    let f = match h.law.forces(&h.parameters, &at) {
                        Ok(f) => f,
                        Err(e) if is_infeasible(&e) => {
                            feasible[j] = false;
                            break 'nodes;
                        }
                        Err(e) => return Err(model_error(&h.id, e)),
                    };
                    let r = template.radius;
                    let node = [
                        f.drawbar_pull / load,
                        f.resistive_torque / (r * load),
                        f.sinkage.unwrap_or(0.0) / r,
                    ];
                    for (output, value) in node.into_iter().enumerate() {
                        let block = (a * OUTPUTS + output) * ny + b;
                        values.as_flattened_mut()[place.first + block * place.step] = value as f32;
                    }
                }
            }
        }
        Ok(GridTable {
            range,
            radius: template.radius,
            width: template.width,
            scale: [
                low,
                (nx - 1) as f64 / (range.slip.1 - range.slip.0),
                (ny - 1) as f64 / (high - low),
            ],
            vectors,
            blocks,
            values,
            feasible,
        })
    }

    /// Where hypothesis j stands.
    pub(super) fn place(&self, j: usize) -> Place {
        place(j, self.vectors, self.blocks)
    }

    /// The interpolation at a contact.
    pub(super) fn stencil(&self, at: &Contact<f64>) -> Result<Stencil, EstimatorError> {
        let same = |quantity, value: f64, own: f64| {
            (quantity, value, own * (1.0 - 1e-9), own * (1.0 + 1e-9))
        };
        for (quantity, value, min, max) in [
            same("radius", at.radius, self.radius),
            same("width", at.width, self.width),
        ] {
            inside(quantity, value, (min, max))?;
        }
        self.at(at.slip, at.normal_load)
    }

    /// The interpolation at a slip and a load \[N\] of a wheel of the template's size.
    pub(super) fn at(&self, slip: f64, load: f64) -> Result<Stencil, EstimatorError> {
        let ny = self.range.nodes.1;
        let (i, slip, in_slip) = self.along_slip(slip)?;
        let (k, load, in_load) = self.along_load(load)?;
        Ok(Stencil {
            first: i * OUTPUTS * ny + k,
            step: OUTPUTS * ny,
            across: ny,
            weight: [slip, load],
            slope: [in_slip, in_load],
        })
    }

    /// First node along slip, and weights; `None` outside the table.
    #[inline]
    pub(super) fn slip_weights(&self, slip: f64) -> Option<(usize, [f64; ALONG])> {
        let (least, most) = self.range.slip;
        let (first, weight, _) = cubic((slip - least) * self.scale[1], self.range.nodes.0);
        (least..=most).contains(&slip).then_some((first, weight))
    }

    /// First node along slip, weights, and their slopes.
    #[inline]
    pub(super) fn along_slip(&self, slip: f64) -> Result<Along, EstimatorError> {
        inside("slip", slip, self.range.slip)?;
        let per_slip = self.scale[1];
        let (i, weight, slope) = cubic((slip - self.range.slip.0) * per_slip, self.range.nodes.0);
        Ok((i, weight, slope.map(|d| d * per_slip)))
    }

    /// The same along ln(load).
    #[inline]
    pub(super) fn along_load(&self, load: f64) -> Result<Along, EstimatorError> {
        inside("normal_load", load, self.range.load)?;
        let [low, _, per_log] = self.scale;
        let (k, weight, slope) = cubic((load.ln() - low) * per_log, self.range.nodes.1);
        Ok((k, weight, slope.map(|d| d * per_log)))
    }

    /// Block of an output at a node along slip and one along the load.
    pub(super) fn block(&self, slip: usize, output: usize, load: usize) -> usize {
        (slip * OUTPUTS + output) * self.range.nodes.1 + load
    }
}

#[inline]
fn inside(
    quantity: &'static str,
    value: f64,
    (min, max): (f64, f64),
) -> Result<(), EstimatorError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(EstimatorError::OutsideTable {
        quantity,
        value,
        min,
        max,
    })
}

/// Tiles are whole but for the last.
fn place(j: usize, vectors: usize, blocks: usize) -> Place {
    let (vector, lane) = (j / LANES, j % LANES);
    let tile = vector / TILE;
    let step = LANES * TILE.min(vectors - tile * TILE);
    Place {
        first: (tile * TILE * blocks) * LANES + vector % TILE * LANES + lane,
        step,
    }
}

/// First node, weights and slopes of the cubic through four of n nodes at 0, 1, .. n-1.
#[inline(always)]
fn cubic(x: f64, n: usize) -> (usize, [f64; 4], [f64; 4]) {
    // Through 32 bits, which the processor converts by itself.
    let first = (x as u32 as usize).saturating_sub(1).min(n - 4);
    let t = x - first as f64;
    let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
    let weight = [
        b * c * d * (-1.0 / 6.0),
        a * c * d * 0.5,
        a * b * d * -0.5,
        a * b * c * (1.0 / 6.0),
    ];
    let slope = [
        -(c * d + b * d + b * c) / 6.0,
        (c * d + a * d + a * c) / 2.0,
        -(b * d + a * d + a * b) / 2.0,
        (b * c + a * c + a * b) / 6.0,
    ];
    (first, weight, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic is its own interpolant, and so is its slope.
    #[test]
    fn a_cubic_is_reproduced() {
        let f = |x: f64| 1.0 - 2.0 * x + 0.3 * x * x - 0.05 * x.powi(3);
        let d = |x: f64| -2.0 + 0.6 * x - 0.15 * x * x;
        for x in [0.0, 0.4, 1.0, 2.7, 5.5, 8.0] {
            let (first, weight, slope) = cubic(x, 9);
            let sum = |w: [f64; 4]| -> f64 {
                w.iter()
                    .enumerate()
                    .map(|(k, w)| w * f((first + k) as f64))
                    .sum()
            };
            assert!((sum(weight) - f(x)).abs() < 1e-12, "{x}");
            assert!((sum(slope) - d(x)).abs() < 1e-12, "{x}");
        }
    }
}
