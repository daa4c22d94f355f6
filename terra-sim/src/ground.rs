//! What the wheels stand on along the way, and what they leave behind.
//!
//! Each wheel has a soil of its own from the start and another from each change on; a change blends the forces of both
//! soils over its length with a smooth step. A wheel stands at the vehicle's signed path plus its distance ahead of the
//! centre of mass. Equal soils share one table of forces.
//!
//! Ruts are remembered in the plane, in square cells as wide as the wheel: a wheel that leaves a cell leaves one pass
//! more in it, whichever wheel comes next, forward or back.

use std::collections::HashMap;
use std::sync::Arc;

use terra_data::Start;
use terra_model::{AnyModel, Contact, ModelError};

use crate::effects::ActiveEffects;
use crate::error::SimError;
use crate::force_table::{ForceTable, Forces};
use crate::off_library::smooth_step;
use crate::scenario::Scenario;
use crate::soil;

/// A change of soil.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Where it begins \[m\].
    from: f64,
    /// Over what length \[m\].
    blend: f64,
    /// Table of each wheel from there on.
    table: [usize; 4],
}

/// The soils of a drive.
pub(crate) struct Ground {
    tables: Vec<ForceTable>,
    first: [usize; 4],
    changes: Vec<Change>,
}

impl Ground {
    /// The soils of a scenario under its model and effects.
    pub(crate) fn new(
        scenario: &Scenario,
        model: &Arc<dyn AnyModel>,
        effects: &ActiveEffects,
    ) -> Result<Self, SimError> {
        let mut known: Vec<Start> = Vec::new();
        let mut tables = Vec::new();
        let mut table = |terrain: &Start| -> Result<usize, SimError> {
            if let Some(i) = known.iter().position(|k| k == terrain) {
                return Ok(i);
            }
            let p = soil::parameters(terrain, &**model)?;
            tables.push(ForceTable::new(model, effects, p)?);
            known.push(terrain.clone());
            Ok(known.len() - 1)
        };
        let mut four = |t: [&Start; 4]| -> Result<[usize; 4], SimError> {
            Ok([table(t[0])?, table(t[1])?, table(t[2])?, table(t[3])?])
        };
        let (left, right) = (&scenario.left, &scenario.right);
        let first = match &scenario.world.wheels {
            Some([fl, fr, rl, rr]) => four([fl, fr, rl, rr])?,
            None => four([left, right, left, right])?,
        };
        let mut changes = Vec::new();
        let mut last = f64::NEG_INFINITY;
        for patch in &scenario.world.patches {
            if !(patch.from.is_finite() && patch.blend.is_finite() && patch.blend >= 0.0)
                || patch.from < last
            {
                return Err(SimError::Value {
                    quantity: "patch from_m".to_owned(),
                    value: patch.from,
                    expected: "patches in the order of the path, each behind the blend of the one before",
                });
            }
            last = patch.from + patch.blend;
            let [fl, fr, rl, rr] = &patch.terrain;
            changes.push(Change {
                from: patch.from,
                blend: patch.blend,
                table: four([fl, fr, rl, rr])?,
            });
        }
        Ok(Ground {
            tables,
            first,
            changes,
        })
    }

    /// The table before a place, the one after it, and the share of the latter.
    fn at(&self, wheel: usize, position: f64) -> (usize, usize, f64) {
        let passed = self.changes.partition_point(|c| c.from <= position);
        let before = |n: usize| {
            let tables = match n.checked_sub(1).and_then(|n| self.changes.get(n)) {
                Some(change) => &change.table,
                None => &self.first,
            };
            tables.get(wheel).copied().unwrap_or(0)
        };
        match passed.checked_sub(1).and_then(|n| self.changes.get(n)) {
            Some(change) if position < change.from + change.blend => (
                before(passed - 1),
                before(passed),
                smooth_step((position - change.from) / change.blend),
            ),
            _ => (before(passed), before(passed), 1.0),
        }
    }

    /// True where the soil changes along the path.
    pub(crate) fn changes(&self) -> bool {
        !self.changes.is_empty()
    }

    /// Between instants: which contacts are worth remembering.
    pub(crate) fn settle(&mut self) {
        self.tables.iter_mut().for_each(ForceTable::settle);
    }

    fn table(&mut self, index: usize, at: &Contact<f64>) -> Result<Forces, ModelError> {
        match self.tables.get_mut(index) {
            Some(table) => table.forces(at),
            None => Err(ModelError::UnknownName {
                kind: "soil of a wheel",
                name: index.to_string(),
                nearest: None,
            }),
        }
    }

    /// Forces of a contact of this wheel at this place.
    pub(crate) fn forces(
        &mut self,
        wheel: usize,
        position: f64,
        at: &Contact<f64>,
    ) -> Result<Forces, ModelError> {
        let (old, new, share) = self.at(wheel, position);
        let there = self.table(new, at)?;
        if old == new || share >= 1.0 {
            return Ok(there);
        }
        let here = self.table(old, at)?;
        let mix = |a: f64, b: f64| a + share * (b - a);
        Ok(Forces {
            drawbar_pull: mix(here.drawbar_pull, there.drawbar_pull),
            resistive_torque: mix(here.resistive_torque, there.resistive_torque),
            lateral_force: mix(here.lateral_force, there.lateral_force),
            sinkage: here.sinkage.zip(there.sinkage).map(|(a, b)| mix(a, b)),
        })
    }

    /// The contact that the soil really sees.
    pub(crate) fn seen(&self, wheel: usize, position: f64, at: &Contact<f64>) -> Contact<f64> {
        let (_, new, _) = self.at(wheel, position);
        self.tables.get(new).map_or(*at, |table| table.seen(at))
    }
}

/// Ruts in the plane.
#[derive(Clone, Debug)]
pub(crate) struct Ruts {
    cell: f64,
    passes: HashMap<(i64, i64), u32>,
    under: [Option<(i64, i64)>; 4],
}

impl Ruts {
    /// Virgin ground in cells of that width \[m\].
    pub(crate) fn new(cell: f64) -> Self {
        Ruts {
            cell,
            passes: HashMap::new(),
            under: [None; 4],
        }
    }

    fn key(&self, (x, y): (f64, f64)) -> (i64, i64) {
        // Rounded, so that wheels half a track beside a straight path lie inside a cell.
        let index = |v: f64| (v / self.cell).round() as i64;
        (index(x), index(y))
    }

    /// Passes that wheels left here.
    pub(crate) fn passes(&self, place: (f64, f64)) -> u32 {
        self.passes.get(&self.key(place)).copied().unwrap_or(0)
    }

    /// The wheels stand there now; true when a rut was left behind.
    pub(crate) fn step(&mut self, places: [(f64, f64); 4]) -> bool {
        let mut changed = false;
        for (wheel, place) in places.into_iter().enumerate() {
            let key = self.key(place);
            if let Some(slot) = self.under.get_mut(wheel)
                && *slot != Some(key)
                && let Some(left) = slot.replace(key)
            {
                *self.passes.entry(left).or_insert(0) += 1;
                changed = true;
            }
        }
        changed
    }
}
