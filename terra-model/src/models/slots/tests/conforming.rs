//! Combinations of slots under the examination of every model.

use super::*;

fn conform(some: impl IntoIterator<Item = &'static Combination>) {
    // A part of them: `TERRA_COMBINATIONS=grouser-passive:` examines those whose names hold that.
    let asked = std::env::var("TERRA_COMBINATIONS").unwrap_or_default();
    let failures: Vec<String> = some
        .into_iter()
        .filter(|c| c.name.contains(&asked))
        .filter_map(|c| crate::conformance::check_model_dyn(&Composed::exact(c)).err())
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

/// The short version: a balanced load, finite forces, exact derivatives equal to differences, and no jump at slip zero, on typical soils.
#[test]
fn every_combination_has_forces_and_derivatives() {
    let mut compared = 0;
    for c in combinations() {
        let law = Law::new(Composed::exact(c).shared(), vec![]).unwrap();
        for p in typical::parameters(&c.params) {
            for (slip, load) in [(-0.3, 90.0), (0.05, 245.25), (0.4, 245.25)] {
                let (f, exact) = law.jacobian(&p, &at(slip, load)).unwrap();
                let wheel = Composed::exact(c).wheel(&p, &at(slip, load)).unwrap();
                let carried = wheel.sums(f.angles.unwrap().entry).load;
                assert!((carried / load - 1.0).abs() < 1e-10, "{} {carried}", c.name);
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

/// A hook that a combination lists changes its forces, driven or braked.
#[test]
fn every_hook_of_a_combination_acts() {
    use crate::contact::Hooks;
    let moved = |hook: Hook| {
        let mut hooks = Hooks::<f64>::neutral();
        match hook {
            Hook::Stiffness => hooks.stiffness = 1.2,
            Hook::Cohesion => hooks.cohesion = 1.5,
            Hook::Friction => hooks.friction = 1.2,
            Hook::ShearModulus => hooks.shear_modulus = 1.3,
            Hook::SinkageExponent => hooks.sinkage_exponent = 0.1,
            Hook::ContactRadius => hooks.contact_radius = 1.1,
            Hook::ExitRatio => hooks.exit_ratio = 0.2,
            Hook::ShearHump => hooks.shear_hump = 0.3,
            Hook::LugHeight => hooks.lug_height = 0.01,
            Hook::Layer => (hooks.layer_depth, hooks.layer_stiffness) = (2e-3, 1e7),
            Hook::LateralSlip => hooks.lateral_slip = Some(0.2),
        }
        hooks
    };
    for c in combinations() {
        let p = &typical::parameters(&c.params)[0];
        let forces = |slip: f64, hooks: Hooks<f64>| {
            let at = Contact {
                hooks,
                ..at(slip, 245.25)
            };
            let f = ModelAt::wheel_forces_at(&Composed::exact(c), p, &at).unwrap();
            [f.drawbar_pull, f.resistive_torque, f.lateral_force].map(|x| x / 245.25)
        };
        for &hook in &c.hooks {
            let acts = |slip: f64| {
                let nominal = forces(slip, Hooks::neutral());
                let hooked = forces(slip, moved(hook));
                nominal
                    .iter()
                    .zip(hooked)
                    .any(|(a, b)| (a - b).abs() > 1e-6)
            };
            assert!(acts(0.3) && acts(-0.1), "{} {}", c.name, hook.name());
        }
    }
}

/// Every effect on tyres and wheels of two zones: refused, or at magnitude zero bit for bit the wheel alone and with exact
/// derivatives elsewhere.
#[test]
fn effects_go_with_tyres_and_two_zones() {
    let mut carried = 0;
    for name in [
        "compliant-tyre:peat:wong-hump",
        "compliant-tyre:layered:interface",
        "braked-two-zone:exponential-snow:janosi-hanamoto",
        "braked-two-zone:unload-reload:muskeg",
    ] {
        let model = composed(name).shared();
        for effect in Registry::builtin().effects() {
            let checked = crate::conformance::check_pair(&model, effect);
            let checked = checked.unwrap_or_else(|e| panic!("{e}"));
            carried += usize::from(checked.derivatives > 0);
        }
    }
    assert!(carried > 40, "{carried}");
}
