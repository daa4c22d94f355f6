//! Where θm/θ1 = c1 + c2 i meets its limits: forces join at zero slip and at the limit, derivatives are those of the side they
//! are on, and what lies outside the contact is refused by name.

#![allow(clippy::unwrap_used, clippy::panic)]

use terra_model::{
    Contact, Dual8, ForceLaw, Law, ModelError, Registry, Scalar, WheelForces, catalogue, jacobian,
};

const RADIUS: f64 = 0.254;
const WIDTH: f64 = 0.15;
const LOAD: f64 = 245.25;

/// How far to either side of a place forces are compared, and above which slope against slip a difference is a jump.
const NEAR: f64 = 1e-10;
const STEEPEST: f64 = 1e4;

/// Models whose apex is c1 + c2 i, with the places of c1 and c2 and soils that they know.
fn laws() -> Vec<(Law, [usize; 2], Vec<Vec<f64>>)> {
    let registry = Registry::builtin();
    let models = registry.models().iter().chain(registry.named_models());
    let laws = models.filter_map(|model| {
        let place = |name| model.params().iter().position(|p| p.name == name);
        let places = [place("c1")?, place("c2")?];
        let law = Law::new(model.clone(), vec![]).unwrap();
        let known = ["dry_sand", "upland_sandy_loam", "lean_clay_22"].iter();
        let mut soils: Vec<Vec<f64>> = known
            .filter_map(|id| catalogue::find(id).ok()?.parameters(law.model()).ok())
            .collect();
        if soils.is_empty() {
            soils = law.model().typical_parameters();
            soils.truncate(3);
        }
        Some((law, places, soils))
    });
    let laws: Vec<_> = laws.collect();
    assert!(laws.len() >= 5, "{}", laws.len());
    laws
}

fn contact(slip: f64) -> Contact<f64> {
    Contact::new(slip, LOAD, RADIUS, WIDTH)
}

fn three(f: &WheelForces<f64>) -> [f64; 3] {
    [
        f.drawbar_pull / LOAD,
        f.resistive_torque / (LOAD * RADIUS),
        f.sinkage.unwrap() / RADIUS,
    ]
}

fn largest_difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).fold(0.0, |m, k| m.max((a[k] - b[k]).abs()))
}

#[test]
fn forces_join_at_zero_slip_wherever_the_apex_stands() {
    for (law, [c1, _], soils) in laws() {
        let mut compared = 0;
        for mut p in soils {
            for ratio in [0.001, 0.01, 0.0199, 0.02, 0.3, 0.98, 0.985, 0.999] {
                p[c1] = ratio;
                let [before, at, after] =
                    [-NEAR, 0.0, NEAR].map(|slip| law.forces(&p, &contact(slip)));
                let (Ok(before), Ok(at), Ok(after)) = (&before, &at, &after) else {
                    let refused = |f: &Result<WheelForces<f64>, ModelError>| {
                        matches!(f, Err(ModelError::NoEquilibrium { .. }))
                    };
                    assert!(
                        refused(&before) && refused(&at) && refused(&after),
                        "{} c1 {ratio}: {before:?} {at:?} {after:?}",
                        law.model().name()
                    );
                    continue;
                };
                compared += 1;
                let (before, at, after) = (three(before), three(at), three(after));
                let jump = largest_difference(before, at).max(largest_difference(after, at));
                assert!(
                    jump < STEEPEST * NEAR,
                    "{} c1 {ratio} jump {jump:e} {p:?}",
                    law.model().name()
                );
            }
        }
        assert!(compared >= 8, "{} {compared}", law.model().name());
    }
}

#[test]
fn forces_join_where_a_braked_apex_reaches_its_limit() {
    for (law, [c1, c2], soils) in laws() {
        let mut compared = 0;
        for mut p in soils {
            for (first, growth) in [(0.43, 0.32), (0.1, 0.5), (0.03, 1.0)] {
                (p[c1], p[c2]) = (first, growth);
                // c1 + c2 s/(1 + s) = .02
                let i = (0.02 - first) / growth;
                let slip = i / (1.0 - i);
                let before = law.forces(&p, &contact(slip - NEAR));
                let after = law.forces(&p, &contact(slip + NEAR));
                let (Ok(before), Ok(after)) = (before, after) else {
                    continue;
                };
                compared += 1;
                assert!(before.flags.apex_limited || law.model().name() == "braked-two-zone");
                let jump = largest_difference(three(&before), three(&after));
                assert!(
                    jump < STEEPEST * NEAR,
                    "{} slip {slip} jump {jump:e} {p:?}",
                    law.model().name()
                );
            }
        }
        assert!(compared >= 3, "{} {compared}", law.model().name());
    }
}

/// A central difference of the eighth order.
fn difference(of: impl Fn(f64) -> Option<[f64; 3]>, x: f64, h: f64) -> Option<[f64; 3]> {
    const WEIGHTS: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut sum = [0.0; 3];
    for (k, weight) in WEIGHTS.into_iter().enumerate() {
        let step = (k + 1) as f64 * h;
        let (up, down) = (of(x + step)?, of(x - step)?);
        for (row, s) in sum.iter_mut().enumerate() {
            *s += weight * (up[row] - down[row]) / h;
        }
    }
    Some(sum)
}

#[test]
fn derivatives_are_those_of_a_held_apex() {
    for (law, [c1, c2], soils) in laws() {
        let mut compared = 0;
        for mut p in soils {
            // Held at .02, at .98 by a negative growth, at c1 itself below and above the limits, and beside a limit.
            for (first, growth, slip) in [
                (0.43, 0.32, -0.7),
                (0.43, 0.32, -0.56),
                (0.2, 0.8, -0.4),
                (0.012, 0.4, -0.3),
                (0.985, 0.3, -0.005),
            ] {
                (p[c1], p[c2]) = (first, growth);
                let n = p.len();
                let mut x = p.clone();
                x.push(slip);
                let forces = |x: &[f64]| law.forces(&x[..n], &contact(x[n])).ok();
                let Some(value) = forces(&x) else { continue };
                if value.sinkage.is_none() {
                    continue;
                }
                let (_, exact) = jacobian(&x, |x| {
                    let at = Contact {
                        slip: x[n],
                        ..contact(slip).lift()
                    };
                    let f = Dual8::of_model(law.model()).wheel_forces_at(&x[..n], &at)?;
                    Ok::<_, ModelError>(vec![
                        f.drawbar_pull / LOAD,
                        f.resistive_torque / (LOAD * RADIUS),
                        f.sinkage.unwrap() / RADIUS,
                    ])
                })
                .unwrap();
                for (place, h) in [(c1, 2e-5), (c2, 2e-5), (n, 2e-6)] {
                    let along = |v: f64| {
                        let mut y = x.clone();
                        y[place] = v;
                        forces(&y).map(|f| three(&f))
                    };
                    let Some(found) = difference(along, x[place], h) else {
                        continue;
                    };
                    for (row, found) in found.into_iter().enumerate() {
                        let exact = exact[(row, place)];
                        let off = (found - exact).abs() / (1.0 + exact.abs());
                        compared += 1;
                        assert!(
                            off < 1e-6,
                            "{} row {row} by {place}: {exact:e}, by differences {found:e} at slip {slip} {p:?}",
                            law.model().name()
                        );
                    }
                }
                // The law's own fast derivatives say the same.
                if let Ok(Some((_, fast))) = law.model().force_slopes(&p, &contact(slip)) {
                    for place in [c1, c2, n] {
                        let per = [LOAD, LOAD * RADIUS, RADIUS];
                        for row in 0..3 {
                            let (a, b) = (fast[(row, place)] / per[row], exact[(row, place)]);
                            assert!((a - b).abs() <= 1e-8 * (1.0 + b.abs()), "{a:e} {b:e}");
                        }
                    }
                }
            }
        }
        assert!(compared >= 9, "{} {compared}", law.model().name());
    }
}

#[test]
fn an_apex_outside_the_contact_is_refused_by_name() {
    for (law, [c1, c2], soils) in laws() {
        let mut p = soils[0].clone();
        for (first, growth, slip, name) in [
            (0.0, 0.3, 0.0, "c1 + c2 slip"),
            (1.0, 0.3, 0.0, "c1 + c2 slip"),
            (0.8, 0.5, 0.6, "c1 + c2 slip"),
            (0.0, 0.3, -0.2, "c1"),
            (1.0, 0.3, -0.2, "c1"),
        ] {
            (p[c1], p[c2]) = (first, growth);
            match law.forces(&p, &contact(slip)) {
                Err(ModelError::Parameter { parameter, .. }) => {
                    assert_eq!(parameter, name, "{}", law.model().name());
                }
                other => panic!(
                    "{} c1 {first} c2 {growth} slip {slip}: {other:?}",
                    law.model().name()
                ),
            }
        }
    }
}
