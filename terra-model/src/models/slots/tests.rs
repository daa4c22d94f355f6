//! Slots against the plain wheels, published figures, limits and second methods.

#![allow(clippy::unwrap_used, clippy::panic)]

use super::*;
use crate::catalogue;
use crate::law::Law;
use crate::{ForceLaw, Registry};

const LOADS: [f64; 2] = [245.25, 2452.5];

fn at(slip: f64, load: f64) -> Contact<f64> {
    Contact::new(slip, load, 0.254, 0.15)
}

fn composed(name: &str) -> Composed {
    let mut parts = name.split(':');
    let wheel = slot("", &WheelKind::ALL, WheelKind::name, parts.next().unwrap()).unwrap();
    let pressure = slot(
        "",
        &PressureKind::ALL,
        PressureKind::name,
        parts.next().unwrap(),
    )
    .unwrap();
    let shear = slot("", &ShearKind::ALL, ShearKind::name, parts.next().unwrap()).unwrap();
    find(wheel, pressure, shear).unwrap()
}

fn law(name: &str) -> Law {
    Law::new(composed(name).shared(), vec![]).unwrap()
}

/// max of the differences of entry angle, pull and torque in the metric of the reference wheel.
fn difference(f: &WheelForces<f64>, g: &WheelForces<f64>) -> f64 {
    let scale = g.drawbar_pull.abs() + g.resistive_torque.abs() / 0.254;
    ((f.drawbar_pull - g.drawbar_pull) / scale)
        .abs()
        .max(((f.resistive_torque - g.resistive_torque) / (0.254 * scale)).abs())
        .max((f.sinkage.unwrap() / g.sinkage.unwrap() - 1.0).abs())
}

/// A soil of the catalogue in the order of Bekker's parameters.
fn soil(id: &str) -> Vec<f64> {
    let plain = Registry::builtin().model("wong-reece").unwrap();
    catalogue::find(id).unwrap().parameters(&*plain).unwrap()
}

/// The same forces, or no equilibrium in both, over the whole catalogue; returns how many had forces.
fn same_over_the_catalogue(
    a: &Law,
    b: &Law,
    bound: f64,
    parameters: impl Fn(&[f64]) -> (Vec<f64>, Vec<f64>),
) -> usize {
    let plain = Registry::builtin().model("wong-reece").unwrap();
    let mut compared = 0;
    for terrain in catalogue::terrains() {
        let Ok(p) = terrain.parameters(&*plain) else {
            continue;
        };
        let (p, q) = parameters(&p);
        for slip in [-1.0, -0.6, -0.2, -0.02, 0.0, 0.05, 0.3, 0.8, 1.0] {
            for load in LOADS {
                match (a.forces(&p, &at(slip, load)), b.forces(&q, &at(slip, load))) {
                    (Ok(f), Ok(g)) => {
                        let off = difference(&f, &g);
                        assert!(
                            off < bound,
                            "{} slip {slip} load {load}: {off:e}",
                            terrain.id
                        );
                        compared += 1;
                    }
                    (f, g) => assert!(
                        matches!(f, Err(ModelError::NoEquilibrium { .. }))
                            && matches!(g, Err(ModelError::NoEquilibrium { .. })),
                        "{} slip {slip} load {load}: {f:?} {g:?}",
                        terrain.id
                    ),
                }
            }
        }
    }
    compared
}

fn plain(name: &str) -> Law {
    Registry::builtin().law(name).unwrap()
}

#[test]
fn composed_from_the_default_slots_is_the_plain_wheel() {
    for wheel in ["wong-reece", "linear-stress"] {
        let slots = law(&format!("{wheel}:bekker:janosi-hanamoto"));
        let compared =
            same_over_the_catalogue(&slots, &plain(wheel), 1e-10, |p| (p.to_vec(), p.to_vec()));
        assert!(compared > 400, "{compared}");
    }
}

/// 245 N on dry sand, and the sinkage by an independent iteration.
#[test]
fn scm_column_has_the_figures_of_its_closed_form() {
    let law = plain("scm-column");
    let p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    for (slip, pull, torque) in [
        (0.1, 22.290_497, 15.113_752),
        (0.3, 84.987_518, 30.829_200),
        (0.9, 146.010_659, 45.922_439),
    ] {
        let f = law.forces(&p, &at(slip, 245.25)).unwrap();
        assert!(
            (f.drawbar_pull - pull).abs() < 1e-3 * 245.25,
            "{} at {slip}",
            f.drawbar_pull
        );
        assert!((f.resistive_torque - torque).abs() < 1e-3 * 245.25 * 0.254);
        assert!((f.angles.unwrap().entry - 0.425_504_400_058_8).abs() < 1e-11);
    }
}

fn conform(some: impl IntoIterator<Item = &'static Combination>) {
    let failures: Vec<String> = some
        .into_iter()
        .filter_map(|c| crate::conformance::check_model_dyn(&Composed(c)).err())
        .map(|e| e.to_string())
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Few combinations in which all that `parts` says of any combination occurs, picked greedily.
fn covering<P: PartialEq>(parts: impl Fn(&Combination) -> Vec<P>) -> Vec<&'static Combination> {
    let mut open: Vec<P> = vec![];
    for part in combinations().iter().flat_map(&parts) {
        if !open.contains(&part) {
            open.push(part);
        }
    }
    let mut chosen = vec![];
    while !open.is_empty() {
        let new = |c: &&Combination| parts(c).iter().filter(|&p| open.contains(p)).count();
        let next = combinations().iter().rev().max_by_key(new).unwrap();
        open.retain(|p| !parts(next).contains(p));
        chosen.push(next);
    }
    chosen
}

fn values(c: &Combination) -> Vec<&'static str> {
    vec![c.wheel.name(), c.pressure.name(), c.shear.name()]
}

/// Every combination keeps what solvers rely on: many minutes, most of them in domains of extreme snow.
///
/// One is known not to: braked at 245 N on soft peat, `grouser-passive:peat` loses its shallow equilibrium at s = -.777 and
/// drops from 65° to 84° of entry angle. The load of a braked wheel need not rise with its sinkage, so the jump is the
/// equations' own.
#[test]
#[ignore = "many minutes"]
fn every_combination_conforms() {
    conform(combinations());
}

/// The same for combinations in which every two slot values that go together do.
#[test]
#[ignore = "minutes"]
fn every_pair_of_slots_conforms() {
    let pairs = covering(|c| {
        let [a, b, d] = [c.wheel.name(), c.pressure.name(), c.shear.name()];
        vec![(a, b), (a, d), (b, d)]
    });
    assert!(pairs.len() < combinations().len() / 2, "{}", pairs.len());
    conform(pairs);
}

/// The same for combinations in which every slot value occurs.
#[test]
fn every_slot_conforms() {
    let some = covering(values);
    let all = WheelKind::ALL.len().max(PressureKind::ALL.len());
    assert_eq!(some.len(), all, "as few as there can be");
    conform(some);
}

/// The short version: finite forces, exact derivatives equal to differences, and no jump at slip zero, on typical soils.
#[test]
fn every_combination_has_forces_and_derivatives() {
    let mut compared = 0;
    for c in combinations() {
        let law = Law::new(Composed(c).shared(), vec![]).unwrap();
        for p in typical::parameters(&c.params) {
            for (slip, load) in [(-0.3, 90.0), (0.05, 245.25), (0.4, 245.25)] {
                let (f, exact) = law.jacobian(&p, &at(slip, load)).unwrap();
                assert!(exact.iter().all(|x| x.is_finite()), "{}", c.name);
                let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / 0.254;
                // By slip and load, of order four.
                for (column, h) in [(p.len(), 1e-4), (p.len() + 1, 1e-3 * load)] {
                    let along = |k: f64| {
                        let step = if column == p.len() {
                            (k * h, 0.0)
                        } else {
                            (0.0, k * h)
                        };
                        let f = law.forces(&p, &at(slip + step.0, load + step.1)).unwrap();
                        [f.drawbar_pull, f.resistive_torque / 0.254]
                    };
                    let (a, b, c2, d) = (along(1.0), along(-1.0), along(2.0), along(-2.0));
                    for row in 0..2 {
                        let slope = (8.0 * (a[row] - b[row]) - (c2[row] - d[row])) / (12.0 * h);
                        let per = if row == 0 { 1.0 } else { 0.254 };
                        let off = (slope - exact[(row, column)] / per).abs() * h / 1e-3;
                        assert!(
                            off < 1e-5 * scale,
                            "{} row {row} column {column} slip {slip}: {off:e} of {scale}",
                            c.name
                        );
                        compared += 1;
                    }
                }
            }
            let near = |slip: f64| law.forces(&p, &at(slip, 245.25)).unwrap().drawbar_pull;
            assert!((near(1e-10) - near(-1e-10)).abs() < 1e-3, "{}", c.name);
        }
    }
    assert!(compared > 3000, "{compared}");
}

/// A Bekker soil in the parameters of another pressure law that should then be the same, and back.
fn limit(name: &str, bound: f64, parameters: impl Fn(&[f64]) -> Vec<f64>) {
    let (wheel, rest) = name.split_once(':').unwrap();
    let plain = plain(wheel);
    let compared = same_over_the_catalogue(
        &Registry::builtin().law(&format!("{wheel}:{rest}")).unwrap(),
        &plain,
        bound,
        |p| (parameters(p), p[..plain.params().len()].to_vec()),
    );
    assert!(compared > 400, "{name}: {compared}");
}

/// (c k_c' + γ b k_φ')(z/b)^n with c k_c' = k_c b^(n-1), γ k_φ' = k_φ b^(n-1): Bekker's law at fixed c, γ, b.
#[test]
fn reece_is_bekker_at_one_width_cohesion_and_weight() {
    const WEIGHT: f64 = 15_000.0;
    limit("wong-reece:reece", 1e-10, |p| {
        // A part of k that cohesion cannot give (c = 0) goes to weight.
        let per = 0.15_f64.powf(p[2] - 1.0);
        let cohesive = if p[3] > 0.0 && p[0] > 0.0 { p[0] } else { 0.0 };
        let frictional = p[1] + (p[0] - cohesive) / 0.15;
        let k_c = if cohesive > 0.0 {
            cohesive * per / p[3]
        } else {
            0.0
        };
        [&[k_c, frictional * per / WEIGHT, p[2], WEIGHT], &p[3..]].concat()
    });
    // Twice as wide is another soil for Bekker, who has no k_c/b here, than for Reece.
    let p = [0.0, 80.0, 1.0, 15_000.0, 1000.0, 0.5, 0.02, 0.4, 0.3];
    let reece = plain("wong-reece:reece");
    let wide = Contact::new(0.3, 490.5, 0.254, 0.3);
    let narrow = at(0.3, 245.25);
    // n = 1: (z/b) γ b k_φ' = γ k_φ' z at any width, so twice the width carries twice the load at the same depth.
    let (f, g) = (
        reece.forces(&p, &wide).unwrap(),
        reece.forces(&p, &narrow).unwrap(),
    );
    assert!((f.sinkage.unwrap() - g.sinkage.unwrap()).abs() < 1e-12);
}

#[test]
fn neutral_values_of_the_other_pressure_laws_are_bekker() {
    limit("wong-reece:slip-exponent", 1e-10, |p| {
        [&p[..3], &[0.0], &p[3..]].concat()
    });
    // The layer's own break cuts a braked contact in other pieces.
    limit("wong-reece:layered", 2e-9, |p| {
        [&p[..3], &[0.0, 0.02], &p[3..]].concat()
    });
    limit("wong-reece:unload-reload", 1e-10, |p| {
        [&p[..3], &[1e8, 0.0, 0.0], &p[3..]].concat()
    });
    limit("scm-column:layered", 1e-9, |p| {
        [&p[..3], &[0.0, 0.02], &p[3..6]].concat()
    });
}

/// n0 + n1 s is the effect of slip-sinkage; k_h (z - z_h) that of a layer.
#[test]
fn pressure_laws_agree_with_the_effects_of_the_same_equation() {
    let sand = soil("dry_sand");
    let effect = plain("wong-reece+slip-sinkage");
    let slots = plain("wong-reece:slip-exponent");
    let f = effect
        .forces(&[&sand[..], &[0.3]].concat(), &at(0.6, 245.25))
        .unwrap();
    let g = slots
        .forces(&[&sand[..3], &[0.3], &sand[3..]].concat(), &at(0.6, 245.25))
        .unwrap();
    assert!(difference(&f, &g) < 1e-10);
    let k = sand[0] / 0.15 + sand[1];
    let layer = 2.0 * k * 0.03_f64.powf(sand[2] - 1.0);
    let effect = plain("wong-reece+layered-soil");
    let slots = plain("wong-reece:layered");
    let f = effect
        .forces(&[&sand[..], &[2.0]].concat(), &at(0.1, 900.0))
        .unwrap();
    let g = slots
        .forces(
            &[&sand[..3], &[layer, 0.03], &sand[3..]].concat(),
            &at(0.1, 900.0),
        )
        .unwrap();
    assert!(difference(&f, &g) < 1e-9, "{:e}", difference(&f, &g));
}

/// p_w (1 - e^(-z/z_w)) with p_w = k z_w is k z for a depth far below z_w.
#[test]
fn deep_snow_starts_as_a_spring() {
    let linear = [0.0, 1e6, 1.0, 1000.0, 0.5, 0.02, 0.4, 0.3];
    let f = plain("wong-reece")
        .forces(&linear, &at(0.3, 100.0))
        .unwrap();
    for depth in [10.0, 100.0, 1000.0] {
        let snow = [&[1e6 * depth, depth], &linear[3..]].concat();
        let g = plain("wong-reece:exponential-snow")
            .forces(&snow, &at(0.3, 100.0))
            .unwrap();
        // The first neglected term of the series is half of z/z_w.
        let bound = g.sinkage.unwrap() / depth;
        assert!(difference(&f, &g) < bound, "{depth}");
    }
    // Peat without its mat is that spring too.
    let peat = [&[1e6, 0.0], &linear[3..]].concat();
    let g = plain("wong-reece:peat")
        .forces(&peat, &at(0.3, 100.0))
        .unwrap();
    assert!(difference(&f, &g) < 1e-10);
}

/// W = b R ∫ k_p (cos θ - cos θ1) R (1 + 4 (m_m/k_p) z/D_h) cos θ dθ of columns, by Simpson's rule.
#[test]
fn peat_carries_what_simpson_says() {
    let p = [3e5, 5e4, 2000.0, 0.5, 0.02];
    let f = plain("scm-column:peat")
        .forces(&p, &at(0.3, 245.25))
        .unwrap();
    let entry = f.angles.unwrap().entry;
    let length = 0.254 * entry.sin();
    let hydraulic = 4.0 * 0.15 * length / (2.0 * (0.15 + length));
    let n = 2000;
    let sum: f64 = (0..=n)
        .map(|q| {
            let angle = entry * f64::from(q) / f64::from(n);
            let z = 0.254 * (angle.cos() - entry.cos());
            let weight = if q == 0 || q == n {
                1.0
            } else if q % 2 == 1 {
                4.0
            } else {
                2.0
            };
            weight * (p[0] * z + 4.0 * p[1] * z * z / hydraulic) * angle.cos()
        })
        .sum();
    let load = 0.15 * 0.254 * sum * entry / f64::from(n) / 3.0;
    assert!((load - 245.25).abs() < 1e-8 * 245.25, "{load}");
}

/// A rut: contact begins at its elastic floor, and beyond the past sinkage the soil is virgin.
#[test]
fn a_rut_is_stiff_until_its_past_sinkage() {
    let sand = soil("dry_sand");
    let law = plain("wong-reece:unload-reload");
    let virgin = plain("wong-reece")
        .forces(&sand, &at(0.2, 245.25))
        .unwrap()
        .sinkage
        .unwrap();
    let again = |past: f64, passes: f64| {
        let p = [&sand[..3], &[5e7, 0.0, past], &sand[3..]].concat();
        let contact = Contact {
            earlier_passes: passes,
            ..at(0.2, 245.25)
        };
        law.forces(&p, &contact).unwrap()
    };
    assert!((again(virgin, 0.0).sinkage.unwrap() - virgin).abs() < 1e-12);
    // Deeper than the load needs: the wheel stays between the elastic floor of the rut and its past sinkage.
    let past = 4.0 * virgin;
    let pressure = (sand[0] / 0.15 + sand[1]) * past.powf(sand[2]);
    let f = again(past, 1.0);
    assert!(f.sinkage.unwrap() > past - pressure / 5e7 && f.sinkage.unwrap() < past);
    // The second pass compacts less soil, and goes a little deeper: its contact is shorter than the first one's.
    let (first, second) = (again(virgin, 0.0), again(virgin, 1.0));
    assert!(second.parts.compaction_resistance < 0.8 * first.parts.compaction_resistance);
    assert!(second.sinkage.unwrap() > virgin);
    // A shallow rut hardly shows.
    assert!((again(1e-5, 1.0).sinkage.unwrap() - virgin).abs() < 1e-4);
}

/// K_r {1 + [1/(K_r (1 - 1/e)) - 1] e^(1 - y)} (1 - e^(-y)) term by term, and its limits.
#[test]
fn the_hump_is_the_published_curve() {
    use std::f64::consts::E;
    let strength = |residual: f64| {
        let p = [1000.0, 0.5, 0.02, residual];
        let params: &'static [Param] = combinations()
            .iter()
            .find(|c| c.name == "scm-column:bekker:wong-hump")
            .map(|c| &c.params[3..7])
            .unwrap();
        let values = Values {
            model: "test",
            params,
            p: &p,
        };
        ShearKind::WongHump.read(&values, &at(0.1, 1.0)).unwrap()
    };
    for residual in [0.1, 0.5, 0.6614, 1.0] {
        let e = |y: f64| strength(residual).mobilised(y);
        for y in [0.0_f64, 0.2, 0.7, 1.0, 2.0, 5.0] {
            let published = residual
                * (1.0 + (1.0 / (residual * (1.0 - 1.0 / E)) - 1.0) * (1.0 - y).exp())
                * (1.0 - (-y).exp());
            assert!((e(y) - published).abs() < 1e-14, "{residual} {y}");
        }
        assert!((e(1.0) - 1.0).abs() < 1e-14 && (e(60.0) - residual).abs() < 1e-14);
        let peak = (0..4000)
            .map(|k| e(f64::from(k) * 1e-3))
            .fold(0.0, f64::max);
        assert!((1.0..1.08).contains(&peak), "{residual}: {peak}");
    }
    // The slope at y = 1 vanishes where A (1 - 2/e) = 1: K_r = .661.
    let s = strength(0.661_4);
    assert!((s.mobilised(1.001) - s.mobilised(0.999)).abs() < 1e-6);
    // K_r = 1 is not Janosi-Hanamoto: (1 + .582 e^(1 - y))(1 - e^(-y)), 5.4 % above its residual at y = ln 5.437.
    let peak = strength(1.0).mobilised(1.693);
    assert!((peak - 1.0535).abs() < 2e-4, "{peak}");
}

/// Muskeg: one at y = 1, nothing at the start and far on.
#[test]
fn muskeg_loses_its_strength() {
    // K = 1 mm: all but the first tenth of the contact is sheared by many K.
    let mut p = soil("upland_sandy_loam");
    p[5] = 1e-3;
    let law = |name: &str| plain(name).forces(&p, &at(0.9, 245.25)).unwrap();
    let (muskeg, janosi) = (law("wong-reece:bekker:muskeg"), law("wong-reece"));
    assert!(muskeg.parts.thrust < 0.2 * janosi.parts.thrust);
    // An interface with the soil's own c and φ is the soil.
    let same = law("wong-reece:bekker:interface");
    assert!(difference(&same, &janosi) < 1e-10);
}

/// Iagnemma's symmetric apex flatters sand at high slip: 63 N instead of 33 N.
#[test]
fn the_symmetric_apex_flatters_sand() {
    let p = soil("dry_sand");
    let symmetric = plain("linear-stress-symmetric")
        .forces(&p[..6], &at(0.95, 245.25))
        .unwrap();
    let full = plain("wong-reece").forces(&p, &at(0.95, 245.25)).unwrap();
    assert!(
        (symmetric.drawbar_pull - 63.0).abs() < 0.5,
        "{}",
        symmetric.drawbar_pull
    );
    assert!((full.drawbar_pull - 33.3).abs() < 0.05);
}

/// The closed forms are the integrals of their own stresses: Gauss-Legendre on the two straight branches.
#[test]
fn linear_closed_forms_are_the_integrals_of_their_stresses() {
    let sand = soil("dry_sand");
    let gauss = crate::quadrature::rule::<{ super::NODES }>();
    for (name, p) in [
        ("linear-stress", sand.clone()),
        ("linear-stress-symmetric", sand[..6].to_vec()),
        (
            "linear-stress:reece:interface",
            vec![30.0, 80.0, 1.1, 15e3, 1040.0, 700.0, 0.4, 0.025, 0.38, 0.41],
        ),
        (
            "ding-closed",
            [&sand[..3], &[0.3], &sand[3..], &[-0.2, 0.0]].concat(),
        ),
    ] {
        let law = plain(name);
        for contact in [at(0.1, 245.25), at(0.8, 1000.0), at(-0.2, 90.0)] {
            let f = law.forces(&p, &contact).unwrap();
            let a = f.angles.unwrap();
            // Three samples are exit, middle, entry; the branches are straight between exit, apex and entry.
            let profile = law.stresses(&p, &contact, 3).unwrap().unwrap();
            let (exit, apex) = (profile.points[0], profile.max_normal);
            let mut sums = [0.0; 3];
            for (from, to, start, end) in [
                (
                    a.exit,
                    a.max_stress,
                    (0.0, exit.shear_stress),
                    (apex.normal_stress, apex.shear_stress),
                ),
                (
                    a.max_stress,
                    a.entry,
                    (apex.normal_stress, apex.shear_stress),
                    (0.0, 0.0),
                ),
            ] {
                for (x, w) in gauss.nodes.iter().zip(&gauss.weights).take(super::NODES) {
                    let (sin, cos) = (from + (to - from) * x).sin_cos();
                    let sigma = start.0 + (end.0 - start.0) * x;
                    let tau = start.1 + (end.1 - start.1) * x;
                    let weight = w * (to - from) * 0.254 * 0.15;
                    sums[0] += weight * (sigma * cos + tau * sin);
                    sums[1] += weight * (tau * cos - sigma * sin);
                    sums[2] += weight * tau * 0.254;
                }
            }
            let scale = contact.normal_load + f.drawbar_pull.abs();
            assert!(
                (sums[0] - contact.normal_load).abs() < 1e-13 * scale,
                "{name} {}",
                sums[0]
            );
            assert!((sums[1] - f.drawbar_pull).abs() < 1e-13 * scale, "{name}");
            assert!(
                (sums[2] - f.resistive_torque).abs() < 1e-13 * scale,
                "{name}"
            );
        }
    }
}

#[test]
fn names_by_slot() {
    let registry = Registry::builtin();
    let name = |n: &str| registry.model(n).map(|m| m.name());
    assert_eq!(
        name("wong-reece:bekker:janosi-hanamoto").unwrap(),
        "wong-reece"
    );
    assert_eq!(name("scm-column:bekker").unwrap(), "scm-column");
    assert_eq!(name("ding-closed:slip-exponent").unwrap(), "ding-closed");
    assert_eq!(
        name("wong-reece:reece:janosi-hanamoto").unwrap(),
        "wong-reece:reece"
    );
    assert_eq!(
        name("wong-reece:reece:wong-hump").unwrap(),
        "wong-reece:reece:wong-hump"
    );
    for (wrong, kind, meant) in [
        ("wong-rece:reece", "wheel", Some("wong-reece")),
        ("wong-reece:rece", "pressure law", Some("reece")),
        ("wong-reece:reece:wong-humb", "shear law", Some("wong-hump")),
        ("wong-reece:qqq", "pressure law", None),
    ] {
        let Err(ModelError::UnknownName {
            kind: k, nearest, ..
        }) = name(wrong)
        else {
            panic!("{wrong}")
        };
        assert_eq!((k, nearest.as_deref()), (kind, meant));
    }
    for wrong in [
        "wong-reece:bekker:janosi-hanamoto:more",
        "wes-brixius:bekker",
        "hard-ground:bekker:muskeg",
        "linear-stress:bekker:muskeg",
        "ding-closed:bekker:wong-hump",
    ] {
        assert!(
            matches!(name(wrong), Err(ModelError::Combination { .. })),
            "{wrong}"
        );
    }
    assert!(Registry::empty().model("wong-reece:reece").is_err());
    // Presets alone are listed.
    assert!(registry.models().iter().all(|m| !m.name().contains(':')));
}

/// σ of the rim by its published formula.
fn rim_stress(p: &[f64], slip: f64, entry: f64, angle: f64) -> f64 {
    let apex = (p[6] + p[7] * slip) * entry;
    let front = if angle >= apex {
        angle
    } else {
        entry - angle * (entry - apex) / apex
    };
    (p[0] / 0.15 + p[1]) * (0.254 * (front.cos() - entry.cos()).max(0.0)).powf(p[2])
}

fn simpson(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = 4000;
    (0..=n)
        .map(|q| {
            let weight = if q == 0 || q == n {
                1.0
            } else {
                f64::from(2 + 2 * (q % 2))
            };
            weight * f(from + (to - from) * f64::from(q) / f64::from(n))
        })
        .sum::<f64>()
        * (to - from)
        / f64::from(n)
        / 3.0
}

#[test]
fn lugs_of_no_height_are_no_lugs() {
    same_over_the_catalogue(
        &plain("grouser-passive"),
        &plain("wong-reece"),
        1e-10,
        |p| ([p, &[15e3, 0.0, 24.0]].concat(), p.to_vec()),
    );
}

/// K of .02 mm: the strength is mobilised all along, and the lugs add N/(2π) ∫ F_p dθ at the same entry angle.
#[test]
fn lugs_add_the_passive_pressure_of_rankine() {
    let mut p = soil("upland_sandy_loam");
    p[5] = 2e-5;
    let (height, count, weight) = (0.012, 20.0, 14e3);
    let lugs = [&p[..], &[weight, height, count]].concat();
    let f = plain("grouser-passive")
        .forces(&lugs, &at(0.5, 245.25))
        .unwrap();
    let entry = f.angles.unwrap().entry;
    let (c, phi) = (p[3], p[4]);
    let np = (std::f64::consts::FRAC_PI_4 + 0.5 * phi).tan().powi(2);
    let parts = |angle: f64| {
        let q = rim_stress(&p, 0.5, entry, angle);
        let own = weight * height * height * np / 2.0;
        let rest = q * height * np + 2.0 * c * height * np.sqrt();
        (
            0.15 * own,
            0.15 * rest,
            0.254 * 0.15 * (c + q * phi.tan()),
            0.254 * 0.15 * q,
        )
    };
    let apex = f.angles.unwrap().max_stress;
    let per = count / std::f64::consts::TAU;
    let integral = |g: &dyn Fn(f64) -> f64| simpson(0.0, apex, g) + simpson(apex, entry, g);
    let load = integral(&|a| {
        let (own, rest, tau, sigma) = parts(a);
        (per * (own + rest) + tau) * a.sin() + sigma * a.cos()
    });
    let thrust = integral(&|a| {
        let (own, rest, tau, _) = parts(a);
        (per * (own + rest) + tau) * a.cos()
    });
    let torque = integral(&|a| {
        let (own, rest, tau, _) = parts(a);
        per * (own * (0.254 + height * 2.0 / 3.0) + rest * (0.254 + height / 2.0)) + tau * 0.254
    });
    // The boundary layer of K is a ten-thousandth of the contact.
    assert!((load / 245.25 - 1.0).abs() < 1e-3, "{load}");
    assert!((f.parts.thrust / thrust - 1.0).abs() < 1e-3);
    assert!((f.resistive_torque / torque - 1.0).abs() < 1e-3);
    assert!(
        f.drawbar_pull
            > 1.5
                * plain("wong-reece")
                    .forces(&p, &at(0.5, 245.25))
                    .unwrap()
                    .drawbar_pull
    );
}

#[test]
fn no_slip_angle_is_no_side_force() {
    same_over_the_catalogue(&plain("lateral"), &plain("wong-reece"), 1e-10, |p| {
        ([p, &[15e3, 0.02]].concat(), p.to_vec())
    });
    let p = [&soil("dry_sand")[..], &[15e3, 0.02]].concat();
    let f = plain("lateral").forces(&p, &at(0.3, 245.25)).unwrap();
    assert_eq!(f.lateral_force, 0.0);
}

/// F_y of Ishigami by Simpson's rule, its antisymmetry, and its growth with the slip angle.
#[test]
fn the_side_force_is_that_of_its_integrals() {
    let sand = soil("dry_sand");
    let (weight, modulus) = (15e3, 0.02);
    let p = [&sand[..], &[weight, modulus]].concat();
    let law = plain("lateral");
    let side = |beta: f64, slip: f64| {
        let contact = Contact {
            slip_angle: beta,
            ..at(slip, 245.25)
        };
        law.forces(&p, &contact).unwrap()
    };
    let (c, phi) = (sand[3], sand[4]);
    for (beta, slip) in [(0.05_f64, 0.1), (0.3, 0.4)] {
        let f = side(beta, slip);
        let a = f.angles.unwrap();
        let x = std::f64::consts::FRAC_PI_4 - 0.5 * phi;
        let d1 = 1.0 / x.tan() + (x + phi).tan();
        let d2 = 1.0 / x.tan() + phi.tan() / x.tan().powi(2);
        let integrand = |angle: f64| {
            let sigma = rim_stress(&sand, slip, a.entry, angle);
            let depth = (sigma / (sand[0] / 0.15 + sand[1])).powf(1.0 / sand[2]);
            let j = 0.254 * (1.0 - slip) * (a.entry - angle) * beta.tan();
            let tau = (c + sigma * phi.tan()) * (1.0 - (-j / modulus).exp());
            let flank = d1 * (c * depth + d2 * weight * depth * depth / 2.0);
            0.254 * 0.15 * tau + (10.0 * beta.tan()).tanh() * flank * (0.254 - depth * angle.cos())
        };
        let force =
            simpson(0.0, a.max_stress, integrand) + simpson(a.max_stress, a.entry, integrand);
        assert!(
            (f.lateral_force / -force - 1.0).abs() < 1e-5,
            "{} {force}",
            f.lateral_force
        );
        assert!((side(-beta, slip).lateral_force + f.lateral_force).abs() < 1e-9);
    }
    assert!(side(0.3, 0.2).lateral_force < side(0.1, 0.2).lateral_force);
    // Spinning in place shears nothing sideways: the flank alone pushes.
    assert!(side(0.3, 0.9).lateral_force > side(0.3, 0.2).lateral_force);
}
