//! Wheel forces remembered: a table over slip and load that fills itself where the run goes.
//!
//! A drive asks for the forces of nearly the same contact tens of thousands of times, each a root to find. For a model
//! that looks at slip and load alone, in a contact whose radius, width and hooks stay what they are, they are a smooth
//! function of two numbers. Nodes are computed by the model when first needed; between them stands the tensor product
//! of Lagrange polynomials of degree 5 in slip and ln W. Slip below and above 0 never share a polynomial, because
//! braking and driving meet there with a kink.
//!
//! Effects on the contact are applied first, exactly, and each set of hooks they leave has its own nodes; hooks that
//! change all the time (slip-sinkage, terrain drift), effects on the forces, and queries whose nodes are not all there
//! (no equilibrium nearby) go to the law itself. That a model looks at nothing else is checked at the first nodes
//! against contacts that differ in everything else; one difference and the table is never used.

use std::collections::HashMap;
use std::sync::Arc;

use terra_model::{AnyModel, Contact, ForceLaw, Law, ModelError, Touch, WheelForces};

use crate::effects::ActiveEffects;
use crate::error::SimError;

/// Spacing of slip \[1\].
const SLIP_STEP: f64 = 1.0 / 128.0;
/// Slip nodes on each side of 0.
const SLIP_NODES: i32 = 128;
/// Spacing of ln W.
const LOAD_STEP: f64 = 0.05;
/// Nodes of a polynomial.
const POINTS: usize = 6;
/// Nodes at which the model is checked for other dependences.
const CHECKED_NODES: usize = 8;
/// Sets of hooks that get nodes: axles and directions of travel, with room.
const MAX_SHAPES: usize = 6;

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

/// Radius, width and hooks of a contact, to the bit.
type Shape = [u64; 13];

fn shape(at: &Contact<f64>) -> Shape {
    let h = &at.hooks;
    [
        at.radius,
        at.width,
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
    ]
    .map(f64::to_bits)
}

/// Forces at slip node i, load node j; `None` where the soil carries no such contact.
type Nodes = HashMap<(i32, i32), Option<[f64; 4]>>;

/// A soil under a model with effects, and what it answered so far.
pub(crate) struct ForceTable {
    law: Law,
    parameters: Vec<f64>,
    effects: ActiveEffects,
    soil: Vec<f64>,
    usable: bool,
    checked: usize,
    shapes: Vec<(Shape, Nodes)>,
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
            usable: !effects.touch(Touch::Forces),
            checked: 0,
            shapes: Vec::new(),
            has_sinkage: true,
        })
    }

    /// The contact that the soil really sees.
    pub(crate) fn seen(&self, at: &Contact<f64>) -> Contact<f64> {
        self.effects.contact(self.law.model(), &self.soil, at)
    }

    /// Forces of a contact.
    pub(crate) fn forces(&mut self, at: &Contact<f64>) -> Result<Forces, ModelError> {
        if self.usable
            && let Some(forces) = self.interpolate(&self.seen(at))
        {
            return Ok(forces);
        }
        self.law.forces(&self.parameters, at).map(Forces::from)
    }

    /// The model itself on a contact that effects have changed already.
    fn model(&self, seen: &Contact<f64>) -> Option<Forces> {
        let model = self.law.model();
        model
            .wheel_forces_at(&self.soil, seen)
            .ok()
            .map(Forces::from)
    }

    fn interpolate(&mut self, at: &Contact<f64>) -> Option<Forces> {
        let sideways = at.hooks.lateral_slip.is_some_and(|tan| tan != 0.0);
        if sideways || !(at.slip.abs() <= 1.0 && at.normal_load > 0.0) {
            return None;
        }
        let shape = shape(at);
        let index = match self.shapes.iter().position(|(s, _)| *s == shape) {
            Some(index) => index,
            None if self.shapes.len() < MAX_SHAPES => {
                self.shapes.push((shape, Nodes::new()));
                self.shapes.len() - 1
            }
            None => return None,
        };
        // Slip counted from 0 on its own side, so that the stencil never crosses it.
        let side = if at.slip < 0.0 { -1 } else { 1 };
        let x = at.slip.abs() / SLIP_STEP;
        let y = at.normal_load.ln() / LOAD_STEP;
        let reach = POINTS as i32 / 2 - 1;
        let first_x = (x.floor() as i32 - reach).clamp(0, SLIP_NODES + 1 - POINTS as i32);
        let first_y = y.floor() as i32 - reach;
        let (wx, wy) = (
            lagrange(x - f64::from(first_x)),
            lagrange(y - f64::from(first_y)),
        );
        let mut sum = [0.0; 4];
        for (i, wx) in (first_x..).zip(wx) {
            for (j, wy) in (first_y..).zip(wy) {
                let node = self.node(index, side * i, j, at)?;
                for (s, value) in sum.iter_mut().zip(node) {
                    *s += wx * wy * value;
                }
            }
        }
        let [drawbar_pull, resistive_torque, lateral_force, sinkage] = sum;
        let sinkage = self.has_sinkage.then_some(sinkage);
        Some(Forces {
            drawbar_pull,
            resistive_torque,
            lateral_force,
            sinkage,
        })
    }

    fn node(&mut self, index: usize, i: i32, j: i32, at: &Contact<f64>) -> Option<[f64; 4]> {
        if let Some(known) = self.shapes.get(index)?.1.get(&(i, j)) {
            return *known;
        }
        let mut contact = *at;
        contact.slip = f64::from(i) * SLIP_STEP;
        contact.normal_load = (f64::from(j) * LOAD_STEP).exp();
        let value = self.model(&contact);
        if self.checked < CHECKED_NODES {
            self.checked += 1;
            if !self.looks_at_slip_and_load_alone(&contact, value) {
                self.usable = false;
                return None;
            }
        }
        self.has_sinkage &= value.is_none_or(|f| f.sinkage.is_some());
        let node = value.map(|f| {
            [
                f.drawbar_pull,
                f.resistive_torque,
                f.lateral_force,
                f.sinkage.unwrap_or(0.0),
            ]
        });
        self.shapes.get_mut(index)?.1.insert((i, j), node);
        node
    }

    fn looks_at_slip_and_load_alone(&self, contact: &Contact<f64>, value: Option<Forces>) -> bool {
        let mut other = *contact;
        other.speed = -3.7 * contact.speed + 0.81;
        other.wheel_speed = -2.9 * contact.wheel_speed + 1.3;
        other.slip_angle = contact.slip_angle + 0.2;
        other.yaw_rate = contact.yaw_rate + 0.37;
        other.path = contact.path + 11.3;
        other.time = contact.time + 17.9;
        other.earlier_passes = contact.earlier_passes + 2.0;
        other.side = -contact.side;
        self.model(&other) == value
    }
}

/// Weights of nodes 0, 1, ..., POINTS - 1 at x.
fn lagrange(x: f64) -> [f64; POINTS] {
    std::array::from_fn(|i| {
        (0..POINTS)
            .filter(|j| *j != i)
            .map(|j| (x - j as f64) / (i as f64 - j as f64))
            .product()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::LogKind;
    use crate::scenario::EffectSetting;
    use terra_model::{Param, Real, Registry, TerrainModel, catalogue};

    fn table(soil: &str, effects: &[(&str, f64)]) -> ForceTable {
        let registry = Registry::builtin();
        let model = registry.model("wong-reece").unwrap();
        let settings: Vec<EffectSetting> = effects
            .iter()
            .map(|(n, e)| EffectSetting::new(*n, *e))
            .collect();
        let active = ActiveEffects::new(&settings, &model, &registry, LogKind::Drive).unwrap();
        let p = catalogue::find(soil).unwrap().parameters(&*model).unwrap();
        ForceTable::new(&model, &active, p).unwrap()
    }

    /// Largest difference between table and law off the nodes, and the share of queries the table answered.
    fn compare(table: &mut ForceTable, loads: &[f64]) -> (f64, f64) {
        let (mut worst, mut answered, mut asked): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for &load in loads {
            for k in 0..60 {
                let mut at = Contact::new(0.0021 + f64::from(k) / 61.0, load, 0.254, 0.15);
                at.earlier_passes = f64::from(k % 2);
                let Ok(exact) = table.law.forces(&table.parameters, &at) else {
                    continue;
                };
                asked += 1.0;
                let Some(near) = table.interpolate(&table.seen(&at)) else {
                    continue;
                };
                answered += 1.0;
                let scale = exact.drawbar_pull.abs() + exact.resistive_torque / 0.254;
                worst = worst
                    .max((near.drawbar_pull - exact.drawbar_pull).abs() / scale)
                    .max((near.resistive_torque - exact.resistive_torque).abs() / 0.254 / scale)
                    .max((near.sinkage.unwrap() / exact.sinkage.unwrap() - 1.0).abs());
            }
        }
        (worst, answered / asked)
    }

    /// The three soils of the reference paper at both of its loads, to the default tier of 1e-7.
    #[test]
    fn agrees_with_the_model() {
        for soil in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
            let (worst, share) = compare(
                &mut table(soil, &[]),
                &[187.0, 245.25, 310.0, 1900.0, 2452.5],
            );
            assert!(worst < 1e-7 && share > 0.95, "{soil}: {worst:e}, {share}");
        }
    }

    #[test]
    fn agrees_under_effects_with_fixed_hooks() {
        let effects = [
            ("grousers", 0.01),
            ("multipass", 0.8),
            ("wheel-radius-error", 0.04),
        ];
        let (worst, share) = compare(&mut table("dry_sand", &effects), &[187.0, 245.25, 310.0]);
        assert!(worst < 1e-7 && share == 1.0, "{worst:e}, {share}");
    }

    /// Hooks that change with slip run out of room and go to the law, whose answer is exact.
    #[test]
    fn changing_hooks_and_force_effects_are_never_interpolated() {
        let mut digging = table("dry_sand", &[("slip-sinkage", 0.3)]);
        let mut plough = table("dry_sand", &[("bulldozing", 1.0)]);
        for k in 0..40 {
            let at = Contact::new(0.02 * f64::from(k), 245.25, 0.254, 0.15);
            for table in [&mut digging, &mut plough] {
                let exact = Forces::from(table.law.forces(&table.parameters, &at).unwrap());
                let found = table.forces(&at).unwrap();
                assert!((found.drawbar_pull - exact.drawbar_pull).abs() < 1e-5);
                if k as usize > MAX_SHAPES {
                    assert_eq!(found, exact);
                }
            }
        }
        assert!(plough.shapes.is_empty());
    }

    /// Pull that grows with travel speed.
    #[derive(Default)]
    struct Fast;
    impl TerrainModel for Fast {
        const NAME: &'static str = "fast";
        const SUMMARY: &'static str = "pull grows with speed";
        const PARAMS: &'static [Param] = &[];
        const REFERENCE: &'static str = "none";
        fn wheel_forces<T: Real>(
            &self,
            _p: &[T],
            at: &Contact<T>,
        ) -> Result<WheelForces<T>, ModelError> {
            Ok(WheelForces::from_thrust(
                at.speed * at.slip,
                T::zero(),
                T::one(),
            ))
        }
    }

    #[test]
    fn a_model_that_looks_at_the_speed_is_never_tabulated() {
        let registry = Registry::builtin().with_model::<Fast>();
        let model = registry.model("fast").unwrap();
        let none = ActiveEffects::new(&[], &model, &registry, LogKind::Drive).unwrap();
        let mut table = ForceTable::new(&model, &none, Vec::new()).unwrap();
        for speed in [0.5, 2.0] {
            let mut at = Contact::new(0.3, 245.25, 0.254, 0.15);
            at.speed = speed;
            assert_eq!(table.forces(&at).unwrap().drawbar_pull, speed * 0.3);
        }
        assert!(!table.usable);
    }
}
