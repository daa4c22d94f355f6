//! Wheel forces remembered: tables over slip and load that fill themselves where the run goes.
//!
//! A drive asks for the forces of nearly the same contact hundreds of thousands of times, each a root to find. Where
//! model and effects together look at slip and load alone, in a contact whose radius, width and hooks stay what they are,
//! the forces are a smooth function of two numbers, and a [`Grid`] answers: a coarse one, and a finer one where that is not
//! exact. It is the law itself, effects included, that is tabulated.
//!
//! Each cell is audited before it answers: the polynomial is compared with the law in the middle of the cell, and a cell
//! that is off by more than [`AUDIT`] is left to the finer grid, one of that to the law for good (a kink, a layer that is
//! reached, no equilibrium nearby). The law is asked there about a contact that differs in everything else. Where that is
//! what the difference comes from, sides and passes get grids of their own, or the table is never used. A wheel that slides
//! sideways, and a contact that is never twice the same (terrain drift along the path), go to the law.
//!
//! Which contacts have a grid is settled between instants, never among the wheels of one, so that wheels in the same
//! contact get the same answer whatever their order.

use std::sync::Arc;

use terra_model::{AnyModel, Contact, ForceLaw, Law, ModelError, WheelForces};

use crate::effects::ActiveEffects;
use crate::error::SimError;
use crate::grid::{Cell, Grid, Node, Spacing};

/// Largest error of a cell in its middle, as a share of |D| + |T|/R and of z.
const AUDIT: f64 = 1e-7;
/// The grids of a contact, tried in turn.
const LEVELS: [Spacing; 2] = [
    Spacing {
        slip_cells: 32,
        load_step: 0.1,
    },
    Spacing {
        slip_cells: 64,
        load_step: 0.05,
    },
];
/// Sets of passes, sides and hooks that get grids.
const MAX_SHAPES: usize = 16;
/// How often a contact must come again before it gets them: those that change all the time never do.
const ADMITTED_AT: u32 = 24;
/// Contacts that wait for it.
const WAITING: usize = 8;

/// D, T, F_y, z of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Forces {
    pub(crate) drawbar_pull: f64,
    pub(crate) resistive_torque: f64,
    pub(crate) lateral_force: f64,
    pub(crate) sinkage: Option<f64>,
}

impl From<WheelForces<f64>> for Forces {
    fn from(f: WheelForces<f64>) -> Self {
        Forces {
            drawbar_pull: f.drawbar_pull,
            resistive_torque: f.resistive_torque,
            lateral_force: f.lateral_force,
            sinkage: f.sinkage,
        }
    }
}

/// All of a contact but slip, load and motion, to the bit; what differs most often stands first.
type Shape = [u64; 17];
/// The numbers of a shape that tell sides and passes apart.
const SIDED: usize = 4;

fn shape(at: &Contact<f64>) -> Shape {
    let h = &at.hooks;
    [
        at.side,
        at.earlier_passes,
        at.ahead,
        at.wheelbase,
        at.radius,
        h.stiffness,
        h.cohesion,
        h.friction,
        h.shear_modulus,
        h.sinkage_exponent,
        h.contact_radius,
        h.exit_ratio,
        h.shear_hump,
        h.lug_height,
        h.layer_depth,
        h.layer_stiffness,
        at.width,
    ]
    .map(f64::to_bits)
}

/// A soil under a model with effects, and what it answered so far.
pub(crate) struct ForceTable {
    law: Law,
    parameters: Vec<f64>,
    effects: ActiveEffects,
    soil: Vec<f64>,
    usable: bool,
    /// Sides and passes have grids of their own.
    sided: bool,
    grids: Vec<(Shape, [Grid; LEVELS.len()])>,
    waiting: [(Shape, u32); WAITING],
    next: usize,
    /// The model gives a sinkage.
    has_sinkage: bool,
}

impl ForceTable {
    /// The soil's parameters under `model` and `effects`.
    pub(crate) fn new(
        model: &Arc<dyn AnyModel>,
        effects: &ActiveEffects,
        soil: Vec<f64>,
    ) -> Result<Self, SimError> {
        Ok(ForceTable {
            law: effects.law(model)?,
            parameters: effects.parameters(&soil),
            effects: effects.clone(),
            soil,
            usable: true,
            sided: false,
            grids: Vec::new(),
            waiting: [([0; 17], 0); WAITING],
            next: 0,
            has_sinkage: true,
        })
    }

    /// The contact that the soil really sees.
    pub(crate) fn seen(&self, at: &Contact<f64>) -> Contact<f64> {
        self.effects.contact(self.law.model(), &self.soil, at)
    }

    /// Forces of a contact.
    #[inline]
    pub(crate) fn forces(&mut self, at: &Contact<f64>) -> Result<Forces, ModelError> {
        if self.usable
            && let Some(forces) = self.interpolate(at)
        {
            return Ok(forces);
        }
        self.exact(at)
    }

    fn exact(&self, at: &Contact<f64>) -> Result<Forces, ModelError> {
        self.law.forces(&self.parameters, at).map(Forces::from)
    }

    /// Gives grids to the contacts that keep coming. Between instants only.
    pub(crate) fn settle(&mut self) {
        for (shape, times) in &mut self.waiting {
            if *times >= ADMITTED_AT && self.grids.len() < MAX_SHAPES {
                *times = 0;
                self.grids.push((*shape, LEVELS.map(Grid::new)));
            }
        }
    }

    /// The grids of this contact, where it has some.
    fn grids(&mut self, shape: Shape) -> Option<usize> {
        if let Some(index) = self.grids.iter().position(|(s, _)| *s == shape) {
            return Some(index);
        }
        match self.waiting.iter_mut().find(|(s, _)| *s == shape) {
            Some((_, times)) => *times += 1,
            None => {
                if let Some(slot) = self.waiting.get_mut(self.next) {
                    *slot = (shape, 1);
                }
                self.next = (self.next + 1) % WAITING;
            }
        }
        None
    }

    fn shape(&self, at: &Contact<f64>) -> Shape {
        let mut shape = shape(at);
        if !self.sided {
            shape[..SIDED].fill(0);
        }
        shape
    }

    fn interpolate(&mut self, at: &Contact<f64>) -> Option<Forces> {
        let sideways = at.hooks.lateral_slip.is_some_and(|tan| tan != 0.0);
        if sideways || !(at.slip.abs() <= 1.0 && at.normal_load > 0.0) {
            return None;
        }
        let index = self.grids(self.shape(at))?;
        let ln_load = at.normal_load.ln();
        for level in 0..LEVELS.len() {
            let grid = self.grids.get(index)?.1.get(level)?;
            let cell = grid.cell(at.slip, ln_load);
            let trusted = match grid.trusted(&cell) {
                Some(trusted) => trusted,
                None => self.audit(index, level, &cell, at)?,
            };
            if trusted {
                let grid = self.grids.get(index)?.1.get(level)?;
                let [drawbar_pull, resistive_torque, lateral_force, sinkage] = grid.value(&cell)?;
                return Some(Forces {
                    drawbar_pull,
                    resistive_torque,
                    lateral_force,
                    sinkage: self.has_sinkage.then_some(sinkage),
                });
            }
        }
        None
    }

    /// Fills the nodes of a cell and decides whether it may answer; none where the grid itself is of no use.
    fn audit(
        &mut self,
        index: usize,
        level: usize,
        cell: &Cell,
        at: &Contact<f64>,
    ) -> Option<bool> {
        let contact = |slip: f64, load: f64| {
            let mut contact = *at;
            contact.slip = slip;
            contact.normal_load = load;
            contact
        };
        let (_, grids) = self.grids.get_mut(index)?;
        let slot = grids.get_mut(level)?;
        let mut grid = std::mem::replace(slot, Grid::new(LEVELS[level]));
        grid.fill(cell, |slip, load| self.node(&contact(slip, load)));
        let (slip, load) = cell.middle();
        let near = grid.value(&grid.cell(slip, load.ln()));
        let middle = contact(slip, load);
        let mut strange = otherwise(&middle);
        if !self.sided {
            strange.side = -middle.side;
            strange.earlier_passes = middle.earlier_passes + 1.0;
            strange.ahead = -middle.ahead - 0.1;
            strange.wheelbase = 1.7 * middle.wheelbase;
        }
        let exact = self.node(&strange);
        let trusted = exact
            .zip(near)
            .is_some_and(|(exact, near)| agrees(&exact, &near, at.radius));
        if !trusted {
            let plain = self.node(&middle);
            if plain != exact {
                // Something else than slip and load tells: a grid for each side and pass, or none at all.
                if !self.sided && self.node(&otherwise(&middle)) == plain {
                    self.sided = true;
                    self.grids.clear();
                    self.waiting = Default::default();
                } else {
                    self.usable = false;
                }
                return None;
            }
        }
        grid.trust(cell, trusted);
        *self.grids.get_mut(index)?.1.get_mut(level)? = grid;
        Some(trusted)
    }

    /// What the law says, as a node; none where the soil carries no such contact.
    fn node(&mut self, at: &Contact<f64>) -> Option<Node> {
        let f = self.exact(at).ok()?;
        self.has_sinkage &= f.sinkage.is_some();
        Some([
            f.drawbar_pull,
            f.resistive_torque,
            f.lateral_force,
            f.sinkage.unwrap_or(0.0),
        ])
    }
}

fn agrees(exact: &Node, near: &Node, radius: f64) -> bool {
    let [pull, torque, side, sinkage] = *exact;
    let scale = pull.abs() + torque.abs() / radius;
    let [d_pull, d_torque, d_side, d_sinkage]: Node =
        std::array::from_fn(|k| (near[k] - exact[k]).abs());
    d_pull.max(d_torque / radius).max(d_side) <= AUDIT * (scale + side.abs())
        && d_sinkage <= AUDIT * sinkage.abs()
}

/// The same slip and load in another motion.
fn otherwise(contact: &Contact<f64>) -> Contact<f64> {
    let mut other = *contact;
    other.speed = -3.7 * contact.speed + 0.81;
    other.wheel_speed = -2.9 * contact.wheel_speed + 1.3;
    other.slip_angle = contact.slip_angle + 0.2;
    other.yaw_rate = contact.yaw_rate + 0.37;
    other.path = contact.path + 11.3;
    other.time = contact.time + 17.9;
    other
}

#[cfg(test)]
mod tests;
