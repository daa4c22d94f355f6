//! Where the soil gives way under a braked wheel: the quick law of fits against the exact one.
#![allow(clippy::unwrap_used, clippy::panic)]

use terra_model::{Contact, ForceLaw, Lanes, ModelError, Registry, Vector};

const R: f64 = 0.254;
const B: f64 = 0.15;

/// Braked wheels on random soils, with humps of the shear curve and rear contacts among them: the quick law says where the soil
/// gives way as the exact one does, and no other root is taken for the one that a sinking wheel reaches.
#[test]
fn the_quick_law_sees_the_folds_that_there_are() {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let quick = law.quick();
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = |low: f64, high: f64| {
        // The upper bits of a congruential generator.
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut carried, mut given_way) = (0, 0);
    for _ in 0..20_000 {
        let p = [
            0.0,
            uniform(8.0, 15.0).exp(),
            uniform(0.2, 1.4),
            uniform(0.0, 20_000.0),
            uniform(0.1, 0.7),
            uniform(-5.5, -3.0).exp(),
            uniform(0.1, 0.6),
            uniform(0.0, 0.3),
        ];
        let mut at = Contact::new(uniform(-0.9, -0.02), uniform(60.0, 900.0), R, B);
        at.hooks.shear_hump = uniform(-1.5, 1.5).max(0.0);
        at.hooks.exit_ratio = uniform(-0.5, 0.5).max(0.0);
        let lifted: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
        match (law.forces(&p, &at), quick.forces_at(&lifted, &at.lift())) {
            (Ok(exact), Ok(found)) => {
                let entry = exact.angles.unwrap().entry;
                let off = found.angles.unwrap().entry.lane(3) / entry - 1.0;
                assert!(off.abs() < 1e-4, "{off} {p:?} {at:?}");
                carried += 1;
            }
            (Err(ModelError::NoEquilibrium { .. }), Err(ModelError::NoEquilibrium { .. })) => {
                given_way += 1;
            }
            (exact, found) => panic!("{p:?} {at:?}: {exact:?}, {:?}", found.err()),
        }
    }
    assert!(
        carried > 5_000 && given_way > 1_000,
        "{carried} {given_way}"
    );
}
