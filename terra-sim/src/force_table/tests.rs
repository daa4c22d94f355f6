//! The table against the law it stands for.

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

/// Both passes of [`compare`] come often enough to get grids, grids of their own included.
fn admit(table: &mut ForceTable, loads: &[f64]) {
    for _ in 0..2 * ADMITTED_AT {
        for pass in [0.0, 1.0] {
            let mut at = Contact::new(0.1, loads[0], 0.254, 0.15);
            at.earlier_passes = pass;
            table.forces(&at).unwrap();
        }
        table.settle();
    }
}

/// Largest difference between table and law off the nodes, and the share of queries the table answered.
fn compare(table: &mut ForceTable, loads: &[f64]) -> (f64, f64) {
    let (mut worst, mut answered, mut asked): (f64, f64, f64) = (0.0, 0.0, 0.0);
    admit(table, loads);
    for &load in loads {
        for k in 0..60 {
            let mut at = Contact::new(0.0021 + f64::from(k) / 61.0, load, 0.254, 0.15);
            at.earlier_passes = f64::from(k % 2);
            let Ok(exact) = table.law.forces(&table.parameters, &at) else {
                continue;
            };
            asked += 1.0;
            let Some(near) = table.interpolate(&at) else {
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

/// Effects that look at slip and load alone are part of the law that is tabulated, whether they change the contact
/// with slip or the forces behind it.
#[test]
fn agrees_under_effects_of_slip_and_on_forces() {
    for effect in [
        ("slip-sinkage", 0.3),
        ("bulldozing", 1.0),
        ("shear-hump", 0.4),
    ] {
        let mut table = table("dry_sand", &[effect]);
        let (worst, share) = compare(&mut table, &[187.0, 245.25, 310.0]);
        assert!(
            worst < 1e-7 && share > 0.9,
            "{effect:?}: {worst:e}, {share}"
        );
    }
}

/// A soil that stiffens along the path, or with speed, is never tabulated: each answer is the law's own.
#[test]
fn changing_contacts_go_to_the_law() {
    for effect in [("terrain-drift", 0.4), ("rate-stiffening", 0.3)] {
        let mut table = table("dry_sand", &[effect]);
        for k in 0..400 {
            let mut at = Contact::new(0.2, 245.25, 0.254, 0.15);
            at.path = 0.01 * f64::from(k);
            at.speed = 0.3 + 0.002 * f64::from(k);
            let exact = table.exact(&at).unwrap();
            assert_eq!(table.forces(&at).unwrap(), exact, "{effect:?}");
            table.settle();
        }
        assert!(!table.usable, "{effect:?}");
    }
}

/// A layer that is reached at one load is a kink, and cells across it answer nothing.
#[test]
fn cells_across_a_kink_are_left_to_the_law() {
    let mut table = table("dry_sand", &[("layered-soil", 2.0)]);
    let loads: Vec<f64> = (0..60).map(|k| 120.0 * 1.03f64.powi(k)).collect();
    let (worst, _) = compare(&mut table, &loads);
    assert!(worst < 1e-6, "{worst:e}");
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
    for k in 0..100 {
        let speed = 0.5 + 0.01 * f64::from(k);
        let mut at = Contact::new(0.3, 245.25, 0.254, 0.15);
        at.speed = speed;
        assert_eq!(table.forces(&at).unwrap().drawbar_pull, speed * 0.3);
        table.settle();
    }
    assert!(!table.usable);
}
