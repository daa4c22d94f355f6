//! Where the soil gives way under a braked wheel: the quick law of fits against the exact one.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::f64::consts::FRAC_PI_2;

use terra_model::models::WongReece;
use terra_model::{Contact, ForceLaw, Lanes, ModelError, Registry, Vector};

const R: f64 = 0.254;
const B: f64 = 0.15;

/// Numbers that look random, the same in every run.
struct Draws(u64);

impl Draws {
    const fn new() -> Self {
        Draws(0x9e37_79b9_7f4a_7c15)
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        // The upper bits of a congruential generator.
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A soil and a braked wheel on it, at times with a hump of the shear curve or a rear contact.
    fn braked_wheel(&mut self) -> ([f64; 8], Contact<f64>) {
        let p = [
            0.0,
            self.uniform(8.0, 15.0).exp(),
            self.uniform(0.2, 1.4),
            self.uniform(0.0, 20_000.0),
            self.uniform(0.1, 0.7),
            self.uniform(-5.5, -3.0).exp(),
            self.uniform(0.1, 0.6),
            self.uniform(0.0, 0.3),
        ];
        let mut at = Contact::new(self.uniform(-0.9, -0.02), self.uniform(60.0, 900.0), R, B);
        at.hooks.shear_hump = self.uniform(-1.5, 1.5).max(0.0);
        at.hooks.exit_ratio = self.uniform(-0.5, 0.5).max(0.0);
        (p, at)
    }
}

/// Braked wheels on random soils, with humps of the shear curve and rear contacts among them: the quick law says where the soil
/// gives way as the exact one does, its entry angle is right to a part in a thousand even there, and no other root is taken for the
/// one that a sinking wheel reaches.
#[test]
fn the_quick_law_sees_the_folds_that_there_are() {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let quick = law.quick();
    let mut draws = Draws::new();
    let (mut carried, mut given_way) = (0, 0);
    for _ in 0..20_000 {
        let (p, at) = draws.braked_wheel();
        let lifted: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
        match (law.forces(&p, &at), quick.forces_at(&lifted, &at.lift())) {
            (Ok(exact), Ok(found)) => {
                let entry = exact.angles.unwrap().entry;
                let off = found.angles.unwrap().entry.lane(3) / entry - 1.0;
                assert!(off.abs() < 1e-3, "{off} {p:?} {at:?}");
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

/// What a fit remembers of a wheel never changes which root is found: soil, slip and load walk in steps of up to so much, and an
/// answer from near the last one is the answer without it.
#[test]
fn a_remembered_angle_leads_to_the_root_that_a_sinking_wheel_reaches() {
    let quick = Registry::builtin().law("wong-reece").unwrap().quick();
    let mut draws = Draws::new();
    let (mut carried, mut given_way) = (0, 0);
    for step in [0.003, 0.03, 0.3] {
        for _ in 0..150 {
            let (mut p, mut at) = draws.braked_wheel();
            let mut last = None;
            for _ in 0..30 {
                let soil: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
                let entry = |near: Option<f64>| {
                    let mut at = at.lift::<Lanes>();
                    at.near = near.map(Lanes::from);
                    let forces = quick.forces_at(&soil, &at)?;
                    Ok::<_, ModelError>(forces.angles.unwrap().entry.lane(0))
                };
                last = match (entry(None), entry(last)) {
                    (Ok(anew), Ok(near)) => {
                        assert!(
                            (near / anew - 1.0).abs() < 1e-4,
                            "{near} {anew} {p:?} {at:?}"
                        );
                        carried += 1;
                        Some(near)
                    }
                    (Err(_), Err(_)) => {
                        given_way += 1;
                        None
                    }
                    (anew, near) => panic!("{p:?} {at:?}: {anew:?}, {near:?} near {last:?}"),
                };
                for v in &mut p[1..] {
                    *v *= draws.uniform(-step, step).exp();
                }
                at.slip = (at.slip * draws.uniform(-step, step).exp()).max(-0.95);
                at.normal_load *= draws.uniform(-step, step).exp();
            }
        }
    }
    assert!(
        carried > 5_000 && given_way > 1_000,
        "{carried} {given_way}"
    );
}

/// Where a sinking wheel comes to rest by a look at every so many angles: the two that its own lies between. None where the soil
/// gives way first: where it carries less by a `wrinkle` than `foothold` or more of the load further up.
fn by_small_steps(
    angles: &[f64],
    loads: &[f64],
    load: f64,
    (foothold, wrinkle): (f64, f64),
) -> Option<[f64; 2]> {
    let mut most = foothold;
    for k in 1..angles.len() {
        if loads[k] >= load {
            return Some([angles[k - 1], angles[k]]);
        }
        // Nothing that carries less holds it up.
        if most > foothold && loads[k] < most * (1.0 - wrinkle) {
            return None;
        }
        most = most.max(loads[k]);
    }
    None
}

/// Braked wheels again, half of them sunk deeper than forty degrees: the quick law finds the root that small steps from the surface
/// come to first, and none where the soil gives way on the way there.
#[test]
fn the_quick_law_finds_what_small_steps_find() {
    const STEPS: u32 = 2000;
    let quick = Registry::builtin().law("wong-reece").unwrap().quick();
    // Close steps where the wheel hardly sinks.
    let angle = |k: u32| FRAC_PI_2 * (f64::from(k) / f64::from(STEPS)).powf(1.5);
    let angles: Vec<f64> = (0..=STEPS).map(angle).collect();
    let mut draws = Draws::new();
    let (mut shallow, mut deep, mut given_way) = (0, 0, 0);
    for _ in 0..1200 {
        let (p, at) = draws.braked_wheel();
        let carried = |angle: &f64| WongReece.supported_load(&p, &at, *angle).unwrap();
        let mut loads = vec![0.0];
        loads.extend(angles[1..].iter().map(carried));
        let load = at.normal_load;
        let by_steps = by_small_steps(&angles, &loads, load, (0.003 * load, 1e-6));
        // Less than a hundredth of the load, or of the most there is, holds nothing up, and a search does not tell a wrinkle from
        // a fold.
        let most = loads.iter().copied().fold(load, f64::max);
        if by_steps != by_small_steps(&angles, &loads, load, (0.03 * most, 0.01)) {
            continue;
        }
        let lifted: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
        let found = quick.forces_at(&lifted, &at.lift());
        match (found.map(|f| f.angles.unwrap().entry.lane(5)), by_steps) {
            (Ok(found), Some([above, below])) => {
                let near = found > above * (1.0 - 1e-4) && found < below * (1.0 + 1e-4);
                assert!(near, "{found} of {above}..{below}: {p:?} {at:?}");
                if found > 0.7 {
                    deep += 1;
                } else {
                    shallow += 1;
                }
            }
            (Err(ModelError::NoEquilibrium { .. }), None) => given_way += 1,
            (found, by_steps) => panic!("{found:?} {by_steps:?}: {p:?} {at:?}"),
        }
    }
    assert!(
        shallow > 300 && deep > 300 && given_way > 200,
        "{shallow} {deep} {given_way}"
    );
}
