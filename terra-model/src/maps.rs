//! Pull and torque of one soil as a table over slip and load: a thousandth of a solve's cost.
//!
//! # Equation
//! D/W and T/(R W) as Chebyshev series in slip and in x, x = ln W scaled to \[-1, 1\]. Where the soil's bearing limit lies
//! within the loads asked for, x runs up to just below the limit at each slip, so that the table ends where the
//! equilibria do.
//!
//! # Errors
//! A query beyond the table is [`ModelError::OutsideMap`], one beyond the bearing limit [`ModelError::NoEquilibrium`]:
//! nothing is extended or clamped.

use crate::batch::{Batch, BatchForces, Precision};
use crate::contact::Contact;
use crate::error::ModelError;
use crate::lanes::{Lanes, Vector};
use crate::law::{ForceLaw, Law};
use crate::real::Real;

mod bicubic;
mod chebyshev;
mod range;
mod surface;

pub use bicubic::BicubicMap;
pub use range::{MapError, MapRange, MapSlopes};
pub use surface::{Beside, ForceSurface, SurfaceContacts, SurfaceNodes, SurfacePlace};

use chebyshev::{
    CHUNKS, LOADS, chebyshev, coefficients, dot, polynomial_slopes, polynomials, series,
};
use range::outside;

/// Nodes in slip and load, tried in turn.
const SIZES: [(usize, usize); 4] = [(6, 12), (8, 16), (10, 20), (16, 24)];
/// Where a map ends below the bearing limit.
const BELOW_LIMIT: f64 = 0.995;
/// A load that no soil carries \[N\].
const UNBEARABLE: f64 = 1e15;

/// Pull and torque of one soil and wheel over slip and load.
#[derive(Clone, Debug)]
pub struct ForceMap {
    range: MapRange,
    radius: f64,
    /// ln of the largest load by slip, as a series: one term where it does not depend on slip.
    top: Vec<f64>,
    /// Bearing limits are in the map.
    limited: bool,
    /// By slip: D/W and T/(R W) over load.
    rows: Vec<[[Lanes; CHUNKS]; 2]>,
    error: MapError,
}

/// The first of these sizes whose map is as exact as wanted; `build` gives its error with it.
fn smallest<M>(
    sizes: &[(usize, usize)],
    wanted: f64,
    mut build: impl FnMut((usize, usize)) -> Result<(f64, M), ModelError>,
) -> Result<M, ModelError> {
    let mut reached = f64::INFINITY;
    for &nodes in sizes {
        let (error, map) = build(nodes)?;
        if error <= wanted {
            return Ok(map);
        }
        reached = reached.min(error);
    }
    Err(ModelError::MapAccuracy { reached, wanted })
}

impl ForceMap {
    /// The smallest map of a law with these parameters whose error is within `wanted`.
    ///
    /// # Errors
    /// [`ModelError::MapAccuracy`]; [`ModelError::OutsideMap`] for a range that is empty or beyond \[0, 1\] in slip; what the
    /// law answers at a node.
    pub fn within(
        law: &Law,
        p: &[f64],
        range: MapRange,
        radius: f64,
        width: f64,
        wanted: f64,
    ) -> Result<Self, ModelError> {
        smallest(&SIZES, wanted, |nodes| {
            let map = Self::new(law, p, range, radius, width, nodes)?;
            Ok((map.error.max, map))
        })
    }

    /// A map of a given number of nodes in slip (2 to 24) and load (2 to 24), with its error measured.
    ///
    /// # Errors
    /// As [`ForceMap::within`].
    pub fn new(
        law: &Law,
        p: &[f64],
        range: MapRange,
        radius: f64,
        width: f64,
        nodes: (usize, usize),
    ) -> Result<Self, ModelError> {
        let (slips, loads) = (nodes.0.clamp(2, LOADS), nodes.1.clamp(2, LOADS));
        let (mut map, slip_nodes) = Self::bare(law, p, range, radius, width, slips)?;
        map.rows = vec![[[Lanes::zero(); CHUNKS]; 2]; slips];
        let load_nodes: Vec<f64> = (0..loads).map(|k| chebyshev(k, loads)).collect();
        let (at, values) = map.solve(law, p, width, &slip_nodes, &load_nodes)?;
        // Values at nodes to coefficients, first along the load, then along the slip.
        for output in 0..2 {
            let scaled: Vec<Vec<f64>> = values
                .iter()
                .zip(&at)
                .map(|(v, at)| {
                    let arm = if output == 0 { 1.0 } else { radius };
                    v[output] / (at.1 * arm)
                })
                .collect::<Vec<f64>>()
                .chunks(loads)
                .map(coefficients)
                .collect();
            for load in 0..loads {
                let column: Vec<f64> = scaled.iter().map(|row| row[load]).collect();
                for (row, value) in map.rows.iter_mut().zip(coefficients(&column)) {
                    let chunk = &mut row[output][load / 8];
                    let lanes = (0..8).map(|q| if q == load % 8 { value } else { chunk.lane(q) });
                    *chunk = Lanes::gather(lanes);
                }
            }
        }
        map.error = map.measured(law, p, width, slips, loads)?;
        Ok(map)
    }

    /// Where slips and loads lie in a map, without values, and its nodes in slip.
    fn bare(
        law: &Law,
        p: &[f64],
        range: MapRange,
        radius: f64,
        width: f64,
        slips: usize,
    ) -> Result<(Self, Vec<f64>), ModelError> {
        range.check()?;
        let slip_nodes: Vec<f64> = (0..slips)
            .map(|k| range.slip_at(chebyshev(k, slips)))
            .collect();
        let (top, limited) = tops(law, p, &range, &slip_nodes, radius, width)?;
        let map = ForceMap {
            range,
            radius,
            top,
            limited,
            rows: vec![],
            error: MapError {
                max: f64::INFINITY,
                median: f64::INFINITY,
            },
        };
        Ok((map, slip_nodes))
    }

    /// The error found when it was built.
    pub fn error(&self) -> MapError {
        self.error
    }

    /// What it was built for.
    pub fn range(&self) -> MapRange {
        self.range
    }

    /// Largest load of the map at a slip \[N\]: that of its range, or just below the bearing limit.
    pub fn largest_load(&self, slip: f64) -> f64 {
        series(&self.top, self.range.scaled_slip(slip)).0.exp()
    }

    /// D \[N\] and T \[N m\].
    ///
    /// # Errors
    /// [`ModelError::OutsideMap`], [`ModelError::NoEquilibrium`].
    pub fn forces(&self, slip: f64, normal_load: f64) -> Result<[f64; 2], ModelError> {
        let (s, x, _) = self.place(slip, normal_load)?;
        let over_load = polynomials(x);
        let mut sums = [[Lanes::zero(); CHUNKS]; 2];
        let (mut before, mut now) = (s, 1.0);
        for row in &self.rows {
            for (sum, row) in sums.iter_mut().zip(row) {
                for (sum, c) in sum.iter_mut().zip(row) {
                    *sum = c.mul_add(Lanes::from(now), *sum);
                }
            }
            (before, now) = (now, 2.0 * s * now - before);
        }
        let [pull, torque] = sums.map(|sum| dot(&sum, &over_load));
        Ok([pull * normal_load, torque * normal_load * self.radius])
    }

    /// Pull and torque with their slopes in slip and load.
    ///
    /// # Errors
    /// As [`ForceMap::forces`].
    pub fn slopes(&self, slip: f64, normal_load: f64) -> Result<MapSlopes, ModelError> {
        let (s, x, top) = self.place(slip, normal_load)?;
        let over_load = polynomials(x);
        let over_load_slope = polynomial_slopes(x);
        let mut sums = [[[Lanes::zero(); CHUNKS]; 2]; 2];
        let (mut before, mut now) = ((s, 1.0), (1.0, 0.0));
        for row in &self.rows {
            for (output, row) in row.iter().enumerate() {
                for (chunk, c) in row.iter().enumerate() {
                    let [value, slope] = &mut sums[output];
                    value[chunk] = c.mul_add(Lanes::from(now.0), value[chunk]);
                    slope[chunk] = c.mul_add(Lanes::from(now.1), slope[chunk]);
                }
            }
            let next = (
                2.0 * s * now.0 - before.0,
                2.0 * (now.0 + s * now.1) - before.1,
            );
            (before, now) = (now, next);
        }
        let [s_rate, x_by_slip, x_by_load] = self.rates(x, top, normal_load);
        let mut found = MapSlopes {
            forces: [0.0; 2],
            by_slip: [0.0; 2],
            by_load: [0.0; 2],
        };
        for (output, [value, slope]) in sums.iter().enumerate() {
            let arm = if output == 0 { 1.0 } else { self.radius };
            let share = dot(value, &over_load);
            let by_x = dot(value, &over_load_slope);
            let by_s = dot(slope, &over_load);
            let scale = arm * normal_load;
            found.forces[output] = share * scale;
            found.by_slip[output] = (by_s * s_rate + by_x * x_by_slip) * scale;
            found.by_load[output] = share * arm + by_x * x_by_load * scale;
        }
        Ok(found)
    }

    /// Slopes of the scaled slip by slip, and of the scaled load by slip and by load.
    fn rates(&self, x: f64, (high, high_slope): (f64, f64), normal_load: f64) -> [f64; 3] {
        // x = 2 (ln W - low)/(high(s) - low) - 1
        let span = high - self.range.normal_load.0.ln();
        let s_rate = 2.0 / (self.range.slip.1 - self.range.slip.0);
        [
            s_rate,
            -(x + 1.0) * high_slope * s_rate / span,
            2.0 / (span * normal_load),
        ]
    }

    /// Scaled slip and load, and ln of the top with its slope; an error outside.
    fn place(&self, slip: f64, load: f64) -> Result<(f64, f64, (f64, f64)), ModelError> {
        let (low, high) = self.range.slip;
        if !(low..=high).contains(&slip) {
            return Err(outside("slip", slip, low, high));
        }
        let s = self.range.scaled_slip(slip);
        let top = series(&self.top, s);
        let bottom = self.range.normal_load.0;
        let x = 2.0 * (load.ln() - bottom.ln()) / (top.0 - bottom.ln()) - 1.0;
        // Rounding of the logarithms at the edges.
        if (-1.0 - 1e-12..=1.0 + 1e-12).contains(&x) {
            return Ok((s, x, top));
        }
        let high = top.0.exp();
        let limit = high / BELOW_LIMIT;
        if self.limited && load > limit {
            return Err(ModelError::NoEquilibrium {
                load,
                max_load: limit,
            });
        }
        Err(outside("normal_load", load, bottom, high))
    }

    /// Slips and loads of a grid, row by row, and pull and torque there.
    fn solve(
        &self,
        law: &Law,
        p: &[f64],
        width: f64,
        slips: &[f64],
        scaled_loads: &[f64],
    ) -> Result<Grid, ModelError> {
        let bottom = self.range.normal_load.0.ln();
        let mut at = Vec::with_capacity(slips.len() * scaled_loads.len());
        for &slip in slips {
            let top = series(&self.top, self.range.scaled_slip(slip)).0;
            at.extend(
                scaled_loads
                    .iter()
                    .map(|x| (slip, (bottom + 0.5 * (x + 1.0) * (top - bottom)).exp())),
            );
        }
        let (slip, normal_load): (Vec<f64>, Vec<f64>) = at.iter().copied().unzip();
        let columns: Vec<&[f64]> = p.iter().map(std::slice::from_ref).collect();
        let mut out = BatchForces::default();
        let batch = Batch {
            parameters: &columns,
            slip: &slip,
            normal_load: &normal_load,
            radius: self.radius,
            width,
        };
        law.solve_batch(&batch, Precision::Double, &mut out)?;
        for status in out.status {
            status?;
        }
        let values = out
            .drawbar_pull
            .into_iter()
            .zip(out.resistive_torque)
            .map(|(d, t)| [d, t])
            .collect();
        Ok((at, values))
    }

    /// Compares with the law between the nodes and on the edges.
    fn measured(
        &self,
        law: &Law,
        p: &[f64],
        width: f64,
        slips: usize,
        loads: usize,
    ) -> Result<MapError, ModelError> {
        let between =
            |n: usize| (0..=n).map(move |k| -(std::f64::consts::PI * k as f64 / n as f64).cos());
        let slips: Vec<f64> = between(slips).map(|x| self.range.slip_at(x)).collect();
        let loads: Vec<f64> = between(loads).collect();
        let (at, values) = self.solve(law, p, width, &slips, &loads)?;
        MapError::between(&at, &values, self.radius, |slip, load| {
            self.forces(slip, load)
        })
    }
}

/// Slips and loads, and pull and torque.
type Grid = (Vec<(f64, f64)>, Vec<[f64; 2]>);

/// ln of the largest load as a series in slip, and whether it is the bearing limit's.
fn tops(
    law: &Law,
    p: &[f64],
    range: &MapRange,
    slips: &[f64],
    radius: f64,
    width: f64,
) -> Result<(Vec<f64>, bool), ModelError> {
    let mut limits = Vec::with_capacity(slips.len());
    let edges = [range.slip.0, range.slip.1];
    let mut reached = false;
    for (k, &slip) in slips.iter().chain(&edges).enumerate() {
        let limit = match law.forces(p, &Contact::new(slip, UNBEARABLE, radius, width)) {
            Err(ModelError::NoEquilibrium { max_load, .. }) => max_load * BELOW_LIMIT,
            Err(e) => return Err(e),
            Ok(_) => f64::INFINITY,
        };
        reached |= limit < range.normal_load.1;
        if k < slips.len() {
            limits.push(limit.ln());
        }
    }
    let least = limits.iter().copied().fold(f64::INFINITY, f64::min).exp();
    if !reached {
        return Ok((vec![range.normal_load.1.ln()], false));
    }
    if least <= range.normal_load.0 {
        return Err(ModelError::NoEquilibrium {
            load: range.normal_load.0,
            max_load: least,
        });
    }
    Ok((coefficients(&limits), true))
}
