//! Forces of one hypothesis and their slopes in slip and load, remembered where a drive goes.
//!
//! A bank asks each hypothesis for nearly the same contacts again and again, each a root to find. For a law that looks at
//! slip and load alone D/W and T/(R W) are smooth in u = ln(1 + |s|/0.05) and ln W: nodes are computed by the law when
//! first needed, between them stands the tensor product of cubic Lagrange polynomials. Driving and braking never share
//! a polynomial, because forces have a kink at slip 0. Where a node is missing (no equilibrium nearby, a load outside
//! the grid) the law itself answers, with its exact derivatives: nothing is clamped.

use std::sync::{Arc, OnceLock};

use terra_model::{Contact, Dual8, ForceLaw, Law, ModelError, jacobian};

/// Nodes along u on each side of slip 0.
const SLIPS: usize = 64;
/// Slip at which nodes are spaced twice as wide as at 0.
const BEND: f64 = 0.05;
/// Spacing of ln W.
const LOAD_STEP: f64 = 0.08;
/// Nodes along ln W.
const LOADS: usize = 32;
/// Smallest tabulated load over the nominal one.
const LIGHTEST: f64 = 0.22;

/// D \[N\], T \[N m\] and their slopes in slip and load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WheelForce {
    pub(crate) pull: f64,
    pub(crate) pull_slip: f64,
    pub(crate) pull_load: f64,
    pub(crate) torque: f64,
    pub(crate) torque_slip: f64,
    pub(crate) torque_load: f64,
}

/// D/W and T/(R W) of a node; none where the soil carries no such contact.
type Node = OnceLock<Option<[f64; 2]>>;

/// One hypothesis on wheels of one geometry.
#[derive(Debug)]
pub(crate) struct SoilMap {
    law: Arc<Law>,
    parameters: Vec<f64>,
    radius: f64,
    width: f64,
    first_load: f64,
    /// Driving, then braking; empty when the law looks at more than slip and load.
    nodes: Vec<Node>,
}

fn bend(slip: f64) -> f64 {
    (1.0 + slip / BEND).ln() * scale()
}

/// Nodes per unit of ln(1 + s/BEND).
fn scale() -> f64 {
    (SLIPS - 1) as f64 / (1.0 + 1.0 / BEND).ln()
}

/// Weights of nodes 0..4 at x, and their derivatives.
fn cubic(x: f64) -> ([f64; 4], [f64; 4]) {
    let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
    (
        [
            -b * c * d / 6.0,
            a * c * d / 2.0,
            -a * b * d / 2.0,
            a * b * c / 6.0,
        ],
        [
            -(c * d + b * d + b * c) / 6.0,
            (c * d + a * d + a * c) / 2.0,
            -(b * d + a * d + a * b) / 2.0,
            (b * c + a * c + a * b) / 6.0,
        ],
    )
}

impl SoilMap {
    pub(crate) fn new(
        law: &Arc<Law>,
        parameters: &[f64],
        radius: f64,
        width: f64,
        nominal_load: f64,
    ) -> Self {
        let map = SoilMap {
            law: Arc::clone(law),
            parameters: parameters.to_vec(),
            radius,
            width,
            first_load: (nominal_load * LIGHTEST).ln(),
            nodes: Vec::new(),
        };
        if !map.slip_and_load_alone(nominal_load) {
            return map;
        }
        SoilMap {
            nodes: (0..2 * SLIPS * LOADS).map(|_| Node::new()).collect(),
            ..map
        }
    }

    /// Contacts that differ in everything else give the same forces.
    fn slip_and_load_alone(&self, load: f64) -> bool {
        [0.07, 0.6].into_iter().all(|slip| {
            let plain = Contact::new(slip, load, self.radius, self.width);
            let mut other = plain;
            other.speed = 0.81;
            other.wheel_speed = 1.3;
            other.yaw_rate = 0.37;
            other.path = 11.3;
            other.time = 17.9;
            other.earlier_passes = 1.0;
            other.side = -1.0;
            other.ahead = 0.4;
            let forces = |at| {
                self.law
                    .forces(&self.parameters, at)
                    .ok()
                    .map(|f| (f.drawbar_pull, f.resistive_torque))
            };
            forces(&plain) == forces(&other)
        })
    }

    /// Forces at a contact of this map's wheel; none where the soil does not carry it.
    pub(crate) fn forces(&self, at: &Contact<f64>) -> Option<WheelForce> {
        match self.interpolate(at.slip, at.normal_load) {
            Some(f) => Some(f),
            None if self.hopeless(at.slip, at.normal_load) => None,
            None => self.exact(at).ok(),
        }
    }

    /// True inside a cell of the grid no corner of which can be carried, not even the lightest: a soil that is too soft
    /// for a load is too soft for a larger one.
    fn hopeless(&self, slip: f64, load: f64) -> bool {
        let y = (load.ln() - self.first_load) / LOAD_STEP;
        if self.nodes.is_empty() || slip.is_nan() || !(1.0..(LOADS - 2) as f64).contains(&y) {
            return false;
        }
        let (x, y) = (
            (bend(slip.abs()).floor() as usize).min(SLIPS - 2),
            y.floor() as usize,
        );
        let side = usize::from(slip < 0.0);
        (0..2).all(|i| (0..2).all(|j| self.node(side, x + i, y + j).is_none()))
    }

    fn exact(&self, at: &Contact<f64>) -> Result<WheelForce, ModelError> {
        // Checks of the contact and the number of parameters.
        self.law.forces(&self.parameters, at)?;
        let (value, slope) = jacobian(&[at.slip, at.normal_load], |x| {
            let mut contact: Contact<Dual8> = at.lift();
            contact.slip = x[0];
            contact.normal_load = x[1];
            let p: Vec<Dual8> = self.parameters.iter().map(|v| Dual8::from(*v)).collect();
            let f = self.law.forces_at(&p, &contact)?;
            Ok::<_, ModelError>(vec![f.drawbar_pull, f.resistive_torque])
        })?;
        let get = |k: usize| value.get(k).copied().unwrap_or(f64::NAN);
        Ok(WheelForce {
            pull: get(0),
            pull_slip: slope[(0, 0)],
            pull_load: slope[(0, 1)],
            torque: get(1),
            torque_slip: slope[(1, 0)],
            torque_load: slope[(1, 1)],
        })
    }

    fn interpolate(&self, slip: f64, load: f64) -> Option<WheelForce> {
        if self.nodes.is_empty() || !(slip.abs() <= 1.0 && load > 0.0) {
            return None;
        }
        let y = (load.ln() - self.first_load) / LOAD_STEP;
        if !(1.0..(LOADS - 2) as f64).contains(&y) {
            return None;
        }
        let x = bend(slip.abs());
        let first_x = (x.floor() as usize).saturating_sub(1).min(SLIPS - 4);
        let first_y = (y.floor() as usize).saturating_sub(1).min(LOADS - 4);
        let ((wx, dx), (wy, dy)) = (cubic(x - first_x as f64), cubic(y - first_y as f64));
        let side = usize::from(slip < 0.0);
        let (mut value, mut in_x, mut in_y) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for i in 0..4 {
            let (mut row, mut row_y) = ([0.0; 2], [0.0; 2]);
            for j in 0..4 {
                let node = self.node(side, first_x + i, first_y + j)?;
                for k in 0..2 {
                    row[k] += wy[j] * node[k];
                    row_y[k] += dy[j] * node[k];
                }
            }
            for k in 0..2 {
                value[k] += wx[i] * row[k];
                in_x[k] += dx[i] * row[k];
                in_y[k] += wx[i] * row_y[k];
            }
        }
        let sign = if slip < 0.0 { -1.0 } else { 1.0 };
        let du = sign * scale() / (BEND + slip.abs());
        // d(W f(ln W))/dW = f + f'.
        let grow = |k: usize| value[k] + in_y[k] / LOAD_STEP;
        Some(WheelForce {
            pull: load * value[0],
            pull_slip: load * in_x[0] * du,
            pull_load: grow(0),
            torque: self.radius * load * value[1],
            torque_slip: self.radius * load * in_x[1] * du,
            torque_load: self.radius * grow(1),
        })
    }

    fn node(&self, side: usize, i: usize, j: usize) -> Option<[f64; 2]> {
        let node = self.nodes.get((side * SLIPS + i) * LOADS + j)?;
        *node.get_or_init(|| {
            let size = (BEND * ((i as f64 / scale()).exp() - 1.0)).clamp(0.0, 1.0);
            let slip = if side == 1 { -size } else { size };
            let load = (self.first_load + LOAD_STEP * j as f64).exp();
            let at = Contact::new(slip, load, self.radius, self.width);
            let f = self.law.forces(&self.parameters, &at).ok()?;
            Some([
                f.drawbar_pull / load,
                f.resistive_torque / (self.radius * load),
            ])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_model::{Registry, catalogue};

    /// The table is there to be fast, not to be different: value and slopes of the law within 1e-4 of the force scale,
    /// driving and braking, off the nodes.
    #[test]
    fn table_and_law_agree_in_value_and_slope() {
        let law = Arc::new(Registry::builtin().law("wong-reece").unwrap());
        for id in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
            let p = catalogue::find(id)
                .unwrap()
                .parameters(law.model())
                .unwrap();
            let map = SoilMap::new(&law, &p, 0.254, 0.15, 245.25);
            let mut answered = 0;
            for k in 0..60 {
                for load in [150.0, 245.25, 340.0] {
                    let slip = -0.3 + 1.3 * f64::from(k) / 60.0 + 0.0037;
                    let at = Contact::new(slip, load, 0.254, 0.15);
                    let (Ok(exact), Some(near)) = (map.exact(&at), map.interpolate(slip, load))
                    else {
                        continue;
                    };
                    answered += 1;
                    let scale = exact.pull.abs() + exact.torque.abs() / 0.254;
                    // Slopes per unit of slip bend over 0.05 near the kink.
                    let slope = scale / (BEND + slip.abs());
                    for (a, b, size) in [
                        (near.pull, exact.pull, scale),
                        (near.torque, exact.torque, scale * 0.254),
                        (near.pull_slip, exact.pull_slip, 10.0 * slope),
                        (near.torque_slip, exact.torque_slip, 10.0 * slope * 0.254),
                        (near.pull_load, exact.pull_load, 10.0 * scale / load),
                        (near.torque_load, exact.torque_load, 2.54 * scale / load),
                    ] {
                        assert!(
                            (a - b).abs() < 1e-4 * size,
                            "{id} {slip} {load}: {near:?} {exact:?}"
                        );
                    }
                }
            }
            assert!(answered > 150, "{id}: {answered}");
        }
    }

    #[test]
    fn an_effect_that_looks_at_the_pass_is_never_tabulated() {
        let law = Arc::new(Registry::builtin().law("wong-reece+multipass").unwrap());
        let mut p = catalogue::find("dry_sand")
            .unwrap()
            .parameters(law.model())
            .unwrap();
        p.push(0.8);
        p.resize(law.params().len(), 0.0);
        let map = SoilMap::new(&law, &p, 0.254, 0.15, 245.25);
        assert!(map.nodes.is_empty());
        let mut at = Contact::new(0.3, 245.25, 0.254, 0.15);
        at.earlier_passes = 1.0;
        let f = map.forces(&at).unwrap();
        let exact = law.forces(&p, &at).unwrap().drawbar_pull;
        assert!((f.pull / exact - 1.0).abs() < 1e-12);
    }
}
