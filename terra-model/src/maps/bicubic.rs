//! The same map as values on a grid, with a cubic through the four nearest in each direction.
//!
//! Sixteen values a query whatever the number of nodes, where the series takes all of its own: more memory, less work, and
//! an error that falls with the fourth power of the step. Between cells the value is continuous, its slope only to the order
//! of the error.
//!
//! # Equation
//! Lagrange's cubic through nodes at r = 0, 1, 2, 3, e.g. w_1 = r (r - 2)(r - 3)/2, in slip and in x.
//!
//! # Reference
//! M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, 25.2.13.

use super::{ForceMap, MapError, MapRange, MapSlopes, smallest};
use crate::error::ModelError;
use crate::law::Law;

/// Nodes in slip and load, tried in turn.
const SIZES: [(usize, usize); 4] = [(16, 8), (32, 12), (64, 16), (128, 24)];
/// Nodes of the edge at the bearing limit.
const EDGE: usize = 24;
/// Fewest nodes a direction.
const FEWEST: usize = 4;

/// Pull and torque of one soil and wheel on a grid of slips and loads.
#[derive(Clone, Debug)]
pub struct BicubicMap {
    /// Where slips and loads lie in the map; it holds no values of its own.
    frame: ForceMap,
    slips: usize,
    loads: usize,
    /// D/W and T/(R W), load by load within slip.
    values: Vec<[f64; 2]>,
    error: MapError,
}

/// First node and weights of value and slope (by the scaled coordinate) around a point of \[-1, 1\].
struct Stencil {
    first: usize,
    value: [f64; 4],
    slope: [f64; 4],
}

impl Stencil {
    fn at(scaled: f64, nodes: usize) -> Self {
        let per_unit = 0.5 * (nodes - 1) as f64;
        let place = (scaled + 1.0) * per_unit;
        let first = (place.floor().max(1.0) as usize - 1).min(nodes - FEWEST);
        let r = place - first as f64;
        let (a, b, c) = (r - 1.0, r - 2.0, r - 3.0);
        let sum = |x: f64, y: f64, z: f64| x * y + y * z + z * x;
        Stencil {
            first,
            value: [
                -a * b * c / 6.0,
                r * b * c / 2.0,
                -r * a * c / 2.0,
                r * a * b / 6.0,
            ],
            slope: [
                -sum(a, b, c) / 6.0,
                sum(r, b, c) / 2.0,
                -sum(r, a, c) / 2.0,
                sum(r, a, b) / 6.0,
            ]
            .map(|w| w * per_unit),
        }
    }
}

impl BicubicMap {
    /// The smallest map of a law with these parameters whose error is within `wanted`.
    ///
    /// # Errors
    /// As [`ForceMap::within`].
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

    /// A map of a given number of nodes in slip and load (at least 4), with its error measured half-way between them.
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
        let (frame, _) = ForceMap::bare(law, p, range, radius, width, EDGE)?;
        let (slips, loads) = (nodes.0.max(FEWEST), nodes.1.max(FEWEST));
        let even = |n: usize, parts: usize| -> Vec<f64> {
            let last = (n - 1) * parts;
            (0..=last)
                .map(|k| 2.0 * k as f64 / last as f64 - 1.0)
                .collect()
        };
        let slip_nodes = |parts| -> Vec<f64> {
            even(slips, parts)
                .into_iter()
                .map(|s| range.slip_at(s))
                .collect()
        };
        let (at, values) = frame.solve(law, p, width, &slip_nodes(1), &even(loads, 1))?;
        let values = at
            .iter()
            .zip(values)
            .map(|((_, load), [d, t])| [d / load, t / (load * radius)])
            .collect();
        let mut map = BicubicMap {
            frame,
            slips,
            loads,
            values,
            error: MapError {
                max: f64::INFINITY,
                median: f64::INFINITY,
            },
        };
        // Half-way between nodes Lagrange's cubic is near its worst.
        let (at, truth) = map
            .frame
            .solve(law, p, width, &slip_nodes(2), &even(loads, 2))?;
        map.error = MapError::between(&at, &truth, radius, |slip, load| map.forces(slip, load))?;
        Ok(map)
    }

    /// The error found when it was built.
    pub fn error(&self) -> MapError {
        self.error
    }

    /// What it was built for.
    pub fn range(&self) -> MapRange {
        self.frame.range()
    }

    /// Largest load of the map at a slip \[N\].
    pub fn largest_load(&self, slip: f64) -> f64 {
        self.frame.largest_load(slip)
    }

    /// D \[N\] and T \[N m\].
    ///
    /// # Errors
    /// [`ModelError::OutsideMap`], [`ModelError::NoEquilibrium`].
    pub fn forces(&self, slip: f64, normal_load: f64) -> Result<[f64; 2], ModelError> {
        let (s, x, _) = self.frame.place(slip, normal_load)?;
        let (by_slip, by_load) = (Stencil::at(s, self.slips), Stencil::at(x, self.loads));
        let [d, t] = self.sum(&by_slip, &by_load, &by_slip.value, &by_load.value);
        Ok([d * normal_load, t * (self.frame.radius * normal_load)])
    }

    /// Pull and torque with their slopes in slip and load.
    ///
    /// # Errors
    /// As [`BicubicMap::forces`].
    pub fn slopes(&self, slip: f64, normal_load: f64) -> Result<MapSlopes, ModelError> {
        let (s, x, top) = self.frame.place(slip, normal_load)?;
        let (by_slip, by_load) = (Stencil::at(s, self.slips), Stencil::at(x, self.loads));
        let share = self.sum(&by_slip, &by_load, &by_slip.value, &by_load.value);
        let in_s = self.sum(&by_slip, &by_load, &by_slip.slope, &by_load.value);
        let in_x = self.sum(&by_slip, &by_load, &by_slip.value, &by_load.slope);
        let [s_rate, x_by_slip, x_by_load] = self.frame.rates(x, top, normal_load);
        let mut found = MapSlopes {
            forces: [0.0; 2],
            by_slip: [0.0; 2],
            by_load: [0.0; 2],
        };
        for output in 0..2 {
            let arm = if output == 0 { 1.0 } else { self.frame.radius };
            let scale = arm * normal_load;
            found.forces[output] = share[output] * scale;
            found.by_slip[output] = (in_s[output] * s_rate + in_x[output] * x_by_slip) * scale;
            found.by_load[output] = share[output] * arm + in_x[output] * x_by_load * scale;
        }
        Ok(found)
    }

    /// Sixteen values, weighed.
    fn sum(
        &self,
        slip: &Stencil,
        load: &Stencil,
        over_slip: &[f64; 4],
        over_load: &[f64; 4],
    ) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (row, ws) in over_slip.iter().enumerate() {
            let start = (slip.first + row) * self.loads + load.first;
            let values = self.values.get(start..start + FEWEST).unwrap_or_default();
            for ([d, t], wl) in values.iter().zip(over_load) {
                sum[0] += ws * wl * d;
                sum[1] += ws * wl * t;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contact, ForceLaw, Registry, catalogue};

    const RANGE: MapRange = MapRange {
        slip: (0.02, 0.95),
        normal_load: (120.0, 450.0),
    };

    fn soil(id: &str) -> (Law, Vec<f64>) {
        let law = Registry::builtin().law("wong-reece").unwrap();
        let p = catalogue::find(id)
            .unwrap()
            .parameters(law.model())
            .unwrap();
        (law, p)
    }

    /// A cubic in both directions is reproduced, value and slope, in every cell.
    #[test]
    fn stencils_are_exact_for_cubics() {
        let f = |x: f64| 1.0 + x - 2.0 * x * x + 0.5 * x * x * x;
        for nodes in [4, 5, 9] {
            for k in 0..=40 {
                let x = f64::from(k) / 20.0 - 1.0;
                let s = Stencil::at(x, nodes);
                let node = |q: usize| 2.0 * (s.first + q) as f64 / (nodes - 1) as f64 - 1.0;
                let sum = |w: &[f64; 4]| (0..4).map(|q| w[q] * f(node(q))).sum::<f64>();
                assert!((sum(&s.value) - f(x)).abs() < 1e-12);
                assert!((sum(&s.slope) - (1.0 - 4.0 * x + 1.5 * x * x)).abs() < 1e-11);
            }
        }
    }

    /// 64 x 16 nodes are good to 1e-4, what was measured holds off the places it was measured at, and slopes are those of
    /// the law.
    #[test]
    fn measured_errors_hold_elsewhere() {
        for id in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
            let (law, p) = soil(id);
            let map = BicubicMap::new(&law, &p, RANGE, 0.254, 0.15, (64, 16)).unwrap();
            let bound = map.error();
            assert!(bound.max <= 1e-4 && bound.median <= 1e-6, "{id}: {bound:?}");
            for k in 0..200 {
                let slip = 0.02 + 0.93 * (f64::from(k) * 0.618_034).fract();
                let load = 120.0 + 330.0 * (f64::from(k) * 0.754_878).fract();
                let at = Contact::new(slip, load, 0.254, 0.15);
                let (f, jac) = law.jacobian(&p, &at).unwrap();
                let [d, t] = map.forces(slip, load).unwrap();
                let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / 0.254;
                let error = ((d - f.drawbar_pull) / scale)
                    .abs()
                    .max((t / f.resistive_torque - 1.0).abs());
                assert!(error <= 1.5 * bound.max, "{id}: {error} at {slip}, {load}");
                assert!(error <= 1e-4, "{id}: {error} at {slip}, {load}");
                let slopes = map.slopes(slip, load).unwrap();
                assert_eq!(slopes.forces, [d, t]);
                let n = p.len();
                assert!((slopes.by_slip[0] - jac[(0, n)]).abs() < 0.02 * scale);
                assert!((slopes.by_load[1] - jac[(1, n + 1)]).abs() < 1e-3 * scale / load);
            }
        }
    }

    /// Halving the step divides the error by about sixteen.
    #[test]
    fn the_error_is_of_fourth_order() {
        let (law, p) = soil("dry_sand");
        let error = |nodes| {
            BicubicMap::new(&law, &p, RANGE, 0.254, 0.15, nodes)
                .unwrap()
                .error()
                .max
        };
        let ratio = error((17, 17)) / error((33, 33));
        assert!((6.0..40.0).contains(&ratio), "{ratio}");
    }

    /// Outside is an error, beyond the bearing limit of snow too; a bound that cannot be met says what was reached.
    #[test]
    fn outside_is_an_error() {
        let (law, p) = soil("snow_us_harrison_1");
        let range = MapRange {
            slip: (0.02, 0.95),
            normal_load: (60.0, 245.25),
        };
        let map = BicubicMap::new(&law, &p, range, 0.254, 0.15, (32, 12)).unwrap();
        assert!(matches!(
            map.forces(0.9, 245.25),
            Err(ModelError::NoEquilibrium { .. })
        ));
        assert!(matches!(
            map.forces(0.01, 100.0),
            Err(ModelError::OutsideMap { .. })
        ));
        let tight = BicubicMap::within(&law, &p, range, 0.254, 0.15, 1e-13);
        assert!(matches!(tight, Err(ModelError::MapAccuracy { .. })));
        let (law, p) = soil("dry_sand");
        let map = BicubicMap::within(&law, &p, RANGE, 0.254, 0.15, 1e-3).unwrap();
        assert!(map.error().max <= 1e-3 && map.slips < 128);
    }
}
