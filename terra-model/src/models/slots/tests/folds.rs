//! Braked wheels that the soil gives way under: where the load falls as the wheel sinks.

use super::*;
use crate::root::RISING_EXIT;

/// Loads at entry angles of a fine grid up to 90°, and the place of the first that is positive and more than the next.
fn loads(wheel: &Wheel<f64>) -> (Vec<f64>, Option<usize>) {
    let angle = |k: usize| (k as f64 * 0.05).to_radians();
    let loads: Vec<f64> = (1..=1800).map(|k| wheel.sums(angle(k)).load).collect();
    let first = loads
        .windows(2)
        .position(|w| w[0] > 0.0 && w[1] < w[0] * (1.0 - 1e-12));
    (loads, first)
}

/// Whatever a dense scan says: the root is where the load is first reached, and there is none past the first largest load.
/// Returns how many contacts gave way before they were buried.
fn agrees_with_a_scan(name: &str, p: &[f64], slip: f64) -> usize {
    let model = composed(name);
    let wheel = model.wheel(p, &at(slip, 245.25)).unwrap();
    let (loads, first) = loads(&wheel);
    let end = first.unwrap_or(loads.len() - 1);
    let most = loads[end];
    if most <= 0.0 {
        return 0;
    }
    for share in [0.2, 0.7, 0.98, 1.001, 1.2] {
        let load = share * most;
        let found = ModelAt::wheel_forces_at(&model, p, &at(slip, load));
        let place = format!("{name} slip {slip} load {load} of {most}, {p:?}");
        if share < 1.0 {
            let crossing = loads[..=end].iter().position(|w| *w >= load).unwrap();
            let entry = found.expect(&place).angles.unwrap().entry.to_degrees();
            let grid = (crossing + 1) as f64 * 0.05;
            assert!((entry - grid).abs() <= 0.0501, "{entry} {grid}: {place}");
        } else {
            let Err(ModelError::NoEquilibrium { max_load, .. }) = found else {
                panic!("{found:?}: {place}")
            };
            assert!((max_load / most - 1.0).abs() < 1e-3, "{max_load}: {place}");
        }
    }
    usize::from(first.is_some())
}

/// Lugs on soft peat at s = -.78: 245.0 N at 65°, less further down, 245 N again at 84°. As the slip passes -.7767 the
/// shallow balance of 245.25 N vanishes; the wheel is then carried no more, and does not jump to the deep one.
#[test]
fn the_balance_of_lugs_on_peat_ends_in_a_fold() {
    let name = "grouser-passive:peat:janosi-hanamoto";
    let p = [
        3e5,
        5e4,
        900.0,
        0.523_598_775_598_298_8,
        0.01,
        0.5,
        0.0,
        15e3,
        0.01,
        24.0,
    ];
    let model = composed(name);
    let wheel = model.wheel(&p, &at(-0.78, 245.25)).unwrap();
    let load = |degrees: f64| wheel.sums(degrees.to_radians()).load;
    assert!(load(65.0) > 244.5 && load(65.0) < 245.25);
    assert!(load(80.0) < 200.0 && load(84.0) > 245.25);
    let forces = |slip: f64| ModelAt::wheel_forces_at(&model, &p, &at(slip, 245.25));
    // Near the fold the angle goes with the root of what is left of the slip.
    let entry = |slip: f64| forces(slip).unwrap().angles.unwrap().entry.to_degrees();
    assert!((entry(-0.776) - 65.39).abs() < 0.01);
    assert!(
        (entry(-0.776_79) - 65.8).abs() < 0.3,
        "{}",
        entry(-0.776_79)
    );
    for slip in [-0.7768, -0.777, -0.8, -1.0] {
        let Err(ModelError::NoEquilibrium { max_load, .. }) = forces(slip) else {
            panic!("{slip}")
        };
        assert!((235.0..245.25).contains(&max_load), "{max_load}");
    }
    assert_eq!(agrees_with_a_scan(name, &p, -0.78), 1);
}

/// The combination with that fold under the whole examination, jumps in slip included.
#[test]
fn lugs_on_peat_conform() {
    let model = composed("grouser-passive:peat:janosi-hanamoto");
    crate::conformance::check_model_dyn(&model).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn braked_wheels_are_carried_where_a_scan_first_finds_the_load() {
    let mut folds = 0;
    for name in [
        "wong-reece:bekker:janosi-hanamoto",
        "wong-reece:exponential-snow:janosi-hanamoto",
        "grouser-passive:bekker:janosi-hanamoto",
        "grouser-passive:peat:janosi-hanamoto",
        "wong-reece:bekker:wong-hump",
        "linear-stress:bekker:janosi-hanamoto",
    ] {
        for p in typical::parameters(composed(name).params()) {
            for slip in [-0.2, -0.8, -0.95, -1.0] {
                folds += agrees_with_a_scan(name, &p, slip);
            }
        }
    }
    assert!(folds > 10, "{folds}");
}

/// The wheel by its short and long rules, from any start.
#[test]
fn the_plain_wheel_finds_the_same_end_of_its_balance() {
    let wheel = crate::models::WongReece;
    let mut folds = 0;
    for id in [
        "dry_sand",
        "chrono_soft",
        "snow_us_harrison_1",
        "lean_clay_22",
    ] {
        let p = catalogue::find(id).unwrap().parameters(&wheel).unwrap();
        for slip in [-0.9, -0.95, -1.0] {
            let load = |degrees: f64| {
                wheel
                    .supported_load(&p, &at(slip, 1.0), degrees.to_radians())
                    .unwrap()
            };
            let scan: Vec<f64> = (1..=900).map(|k| load(f64::from(k) * 0.1)).collect();
            let end = scan.windows(2).position(|w| w[0] > 0.0 && w[1] < w[0]);
            folds += usize::from(end.is_some());
            let most = scan[end.unwrap_or(scan.len() - 1)];
            for start in [0.01, 0.3, 1.5] {
                let from = |load: f64| wheel.forces_from(&p, &at(slip, load), start);
                let f = from(0.99 * most).unwrap();
                let cold = plain("wong-reece")
                    .forces(&p, &at(slip, 0.99 * most))
                    .unwrap();
                assert!(difference(&f, &cold) < 1e-9, "{id} {slip} {start}");
                assert!(
                    matches!(from(1.01 * most), Err(ModelError::NoEquilibrium { max_load, .. })
                        if (max_load / most - 1.0).abs() < 1e-4),
                    "{id} {slip} {start}"
                );
            }
        }
    }
    assert!(folds >= 2, "{folds}");
}

/// Parameters of a wheel with linear stresses and next to no shear.
fn early(name: &str, n: f64, c1: f64, exit: f64) -> Vec<f64> {
    let model = composed(name);
    let value = |p: &Param| match p.name {
        "k_c" | "slip_exponent" | "c2" | "lug_reach" => 0.0,
        "k_phi" => 1e5,
        "sinkage_exponent" => n,
        "cohesion" => 0.0,
        "friction_angle" => 0.05,
        "shear_modulus" => 0.02,
        "c1" => c1,
        "c3" => exit,
        other => panic!("{other}"),
    };
    model.params().iter().map(value).collect()
}

/// Linear stresses have no theorem about a load that rises: towards 90° A falls, by d ln A/d ln θ1 = -.66 at 85° with the apex
/// near the entry, against n (1 + θ1 cot θ1) = 1.13 n of σm. So with little shear the most is carried before 90° for n below .6.
#[test]
fn a_driven_wheel_with_linear_stresses_ends_where_its_load_falls() {
    let mut folds = 0;
    let names = [
        "linear-stress:bekker:janosi-hanamoto",
        "ding-closed:slip-exponent:janosi-hanamoto",
    ];
    for name in names {
        let exits: &[f64] = if name.starts_with("ding") {
            &[-0.4, 0.0, 0.4]
        } else {
            &[0.0]
        };
        for n in [0.1, 0.3, 0.5] {
            for c1 in [0.6, 0.9, 0.97] {
                for exit in exits {
                    let p = early(name, n, c1, *exit);
                    for slip in [0.0, 0.3, 1.0] {
                        folds += agrees_with_a_scan(name, &p, slip);
                    }
                }
            }
        }
        let p = early(name, 0.3, 0.97, 0.0);
        assert_eq!(agrees_with_a_scan(name, &p, 0.3), 1, "{name}");
        let p = early(name, 1.5, 0.9, 0.0);
        assert_eq!(agrees_with_a_scan(name, &p, 0.3), 0, "{name}");
    }
    assert!(folds > 10, "{folds}");
}

/// The same for the model without slots.
#[test]
fn linear_stress_itself_ends_where_its_load_falls() {
    let slotted = composed("linear-stress:bekker:janosi-hanamoto");
    let plain = plain("linear-stress");
    for slip in [0.1, 0.6] {
        let p = early("linear-stress:bekker:janosi-hanamoto", 0.3, 0.97, 0.0);
        let (loads, end) = loads(&slotted.wheel(&p, &at(slip, 1.0)).unwrap());
        let end = end.unwrap();
        assert!((1539..1760).contains(&end), "77 to 88 degrees: {end}");
        let most = loads[end];
        let f = plain.forces(&p, &at(slip, 0.999 * most)).unwrap();
        let entry = f.angles.unwrap().entry.to_degrees();
        assert!(entry < (end + 1) as f64 * 0.05, "{entry}");
        assert!(
            matches!(plain.forces(&p, &at(slip, 1.001 * most)), Err(ModelError::NoEquilibrium { max_load, .. })
                if (max_load / most - 1.0).abs() < 1e-5)
        );
    }
}

/// A rear contact longer than half the entry angle: the load of a driven wheel may fall too, and a fine scan says where. With
/// E = j/K, c ∫ E sin θ dθ goes with 1/6 - e²/2 - e³/3 for θ2 = -e θ1, which is zero at e = 1/2.
#[test]
fn a_long_rear_contact_is_searched() {
    let model = composed("wong-reece:bekker:janosi-hanamoto");
    let (mut folds, mut compared) = (0, 0);
    for exit in [0.2, 0.5, 0.6, 0.8, 0.9] {
        for n in [0.3, 0.6, 0.9] {
            for (k, c1) in [(1e4, 0.3), (1e5, 0.05), (1e5, 0.6)] {
                for slip in [0.05, 0.2, 1.0] {
                    let p = [0.0, k, n, 1e5, 0.0, 0.05, c1, 0.0];
                    let mut contact = at(slip, 1.0);
                    contact.hooks.exit_ratio = exit;
                    let (loads, first) = loads(&model.wheel(&p, &contact).unwrap());
                    folds += usize::from(first.is_some());
                    let place = format!("{exit} {n} {k} {c1} {slip} {first:?}");
                    assert!(first.is_none() || exit > RISING_EXIT, "{place}");
                    let most = loads[first.unwrap_or(loads.len() - 1)];
                    let deeper = loads.iter().copied().fold(0.0, f64::max);
                    if most <= 0.02 * deeper {
                        continue;
                    }
                    contact.normal_load = 0.9 * most;
                    let reached = loads.iter().position(|w| *w >= 0.9 * most).unwrap();
                    let found = [
                        ModelAt::wheel_forces_at(&model, &p, &contact),
                        plain("wong-reece").forces(&p, &contact),
                    ];
                    for forces in found {
                        let entry = forces.expect(&place).angles.unwrap().entry.to_degrees();
                        let off = entry - (reached + 1) as f64 * 0.05;
                        assert!(off.abs() <= 0.0501, "{entry} {off}: {place}");
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(folds > 5 && compared > 150, "{folds} {compared}");
}
