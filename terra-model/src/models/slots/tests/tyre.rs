//! Tyres with other laws: against the plain tyre, their limits and a second method.

use super::*;

const PRESSURES: [f64; 4] = [5e3, 2e4, 1e5, 5e6];

fn tyres() -> impl Iterator<Item = &'static Combination> {
    let all = combinations().iter();
    all.filter(|c| c.wheel == WheelKind::CompliantTyre)
}

fn place(c: &Combination, name: &str) -> usize {
    c.params.iter().position(|p| p.name == name).unwrap()
}

/// The same soil under a tyre of another pressure.
fn with_pressure(c: &Combination, p: &[f64], pressure: f64) -> Vec<f64> {
    let mut p = p.to_vec();
    p[place(c, "tyre_pressure")] = pressure;
    p
}

/// The largest difference of pull and torque, in shares of all forces, of sinkage and of entry angle from those of the plain
/// tyre over the catalogue, and how many contacts were compared.
fn off_the_plain_tyre(slots: &Law, parameters: impl Fn(&[f64], f64) -> Vec<f64>) -> (f64, usize) {
    let (rigid, plain) = (plain("wong-reece"), plain("compliant-tyre"));
    let (mut worst, mut compared) = (0.0_f64, 0);
    for terrain in catalogue::terrains() {
        let Ok(p) = terrain.parameters(rigid.model()) else {
            continue;
        };
        for pressure in PRESSURES {
            for slip in [-1.0, -0.6, -0.2, -0.02, 0.0, 0.05, 0.3, 0.8, 1.0] {
                for load in LOADS {
                    let (own, p) = (parameters(&p, pressure), [&p[..6], &[pressure]].concat());
                    let found = slots.forces(&own, &at(slip, load));
                    let (f, g) = match (found, plain.forces(&p, &at(slip, load))) {
                        (Ok(f), Ok(g)) => (f, g),
                        (f, g) => {
                            assert!(
                                matches!(f, Err(ModelError::NoEquilibrium { .. }))
                                    && matches!(g, Err(ModelError::NoEquilibrium { .. })),
                                "{} {pressure} slip {slip} load {load}: {f:?} {g:?}",
                                terrain.id
                            );
                            continue;
                        }
                    };
                    let entry = g.angles.unwrap().entry;
                    let scale = load + g.drawbar_pull.abs() + g.resistive_torque.abs() / 0.254;
                    // The plain sinkage is a difference of versines.
                    let depth = g.sinkage.unwrap();
                    let off = [
                        (f.drawbar_pull - g.drawbar_pull) / scale,
                        (f.resistive_torque - g.resistive_torque) / (0.254 * scale),
                        (f.sinkage.unwrap() - depth) / (depth + 1e-6 * 0.254),
                        (f.angles.unwrap().entry - entry) / entry,
                    ];
                    compared += 1;
                    worst = off.into_iter().fold(worst, |m, x| m.max(x.abs()));
                }
            }
        }
    }
    (worst, compared)
}

#[test]
fn composed_from_the_default_slots_is_the_plain_tyre() {
    let slots = law("compliant-tyre:bekker:janosi-hanamoto");
    let (worst, compared) =
        off_the_plain_tyre(&slots, |p, pressure| [&p[..6], &[pressure]].concat());
    assert!(worst < 1e-9 && compared > 1500, "{worst:e} {compared}");
}

#[test]
fn other_laws_that_are_bekkers_are_the_plain_tyre() {
    let interface: (&str, InOtherLaw) = ("bekker:interface", |p| p.to_vec());
    for (name, in_other_law) in AS_BEKKER.into_iter().chain([interface]) {
        let slots = plain(&format!("compliant-tyre:{name}"));
        let (worst, compared) = off_the_plain_tyre(&slots, |p, pressure| {
            in_other_law(&[&p[..6], &[pressure]].concat())
        });
        assert!(
            worst < 2e-9 && compared > 1500,
            "{name} {worst:e} {compared}"
        );
    }
}

/// Its pressure does not matter, and its stresses are largest at the bottom: the rigid wheel whose apex is there.
#[test]
fn a_tyre_harder_than_the_soil_pushes_is_a_rigid_wheel() {
    let mut compared = 0;
    for c in tyres() {
        let tyre = Composed::exact(c);
        let rim = find(WheelKind::WongReece, c.pressure, c.shear).unwrap();
        for p in typical::parameters(&c.params) {
            for (slip, load) in [(-0.3, 90.0), (0.0, 245.25), (0.3, 245.25), (1.0, 900.0)] {
                let at = at(slip, load);
                let [hard, harder] = [1e9, 3e9].map(|pressure| {
                    ModelAt::wheel_forces_at(&tyre, &with_pressure(c, &p, pressure), &at)
                });
                // The bottom itself would have no rear: as good as there.
                let apex = [&p[..c.params.len() - 1], &[1e-7, 0.0]].concat();
                let rigid = ModelAt::wheel_forces_at(&rim, &apex, &at);
                let (Ok(hard), Ok(harder), Ok(rigid)) = (hard, harder, rigid) else {
                    continue;
                };
                assert_eq!(hard.drawbar_pull.to_bits(), harder.drawbar_pull.to_bits());
                assert_eq!(hard.angles.unwrap().exit, 0.0);
                let off = difference(&hard, &rigid);
                assert!(off < 1e-6, "{} slip {slip} load {load}: {off:e}", c.name);
                compared += 1;
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

/// Snow that gives way below the pressure of the tyre never flattens it.
#[test]
fn a_soil_that_never_pushes_so_hard_leaves_the_tyre_round() {
    let snow = typical::parameters(
        &composed("compliant-tyre:exponential-snow:janosi-hanamoto")
            .of
            .params,
    );
    let law = plain("compliant-tyre:exponential-snow");
    for mut p in snow {
        let strength = p[0];
        let last = p.len() - 1;
        let mut exit = |share: f64, load: f64| {
            p[last] = share * strength;
            let f = law.forces(&p, &at(0.2, load)).ok()?;
            Some((f.angles?.exit, f.drawbar_pull.to_bits()))
        };
        for load in [245.25, 0.2 * strength * 0.15 * 0.254] {
            let round = exit(1.000_001, load);
            assert_eq!(round, exit(100.0, load));
            assert!(round.is_none_or(|(exit, _)| exit == 0.0));
        }
        let flat = exit(0.2, 0.2 * strength * 0.15 * 0.254);
        assert!(flat.unwrap().0 < 0.0);
    }
}

/// On ground that hardly gives, all is flat: p_t b l = W, z = 0, and with little to slide over the shear stress is E of a
/// straight line under all of it.
#[test]
fn on_firm_ground_the_tyre_carries_its_load_by_its_pressure() {
    let pressure = 5e4;
    for c in tyres() {
        let value = |p: &Param| match p.name {
            "k_c" | "k_c_prime" | "slip_exponent" | "past_sinkage" => 0.0,
            "k_phi" | "peat_stiffness" | "unloading_stiffness" => 1e13,
            "k_phi_prime" => 1e9,
            "unit_weight" => 15e3,
            "sinkage_exponent" => 1.0,
            "snow_pressure" => 1e8,
            "snow_depth" => 1e-5,
            "mat_stiffness" | "unloading_growth" | "layer_stiffness" => 1e5,
            "layer_depth" => 0.01,
            "cohesion" | "adhesion" => 800.0,
            "friction_angle" | "interface_friction_angle" => 0.5,
            "shear_modulus" => 0.01,
            "residual_ratio" => 0.6,
            "tyre_pressure" => pressure,
            other => panic!("{other}"),
        };
        let p: Vec<f64> = c.params.iter().map(value).collect();
        let length = 500.0 / (pressure * 0.2);
        let from = (0.5 * length / 0.3_f64).asin();
        for slip in [0.05, 0.5, 1.0] {
            let contact = Contact::new(slip, 500.0, 0.3, 0.2);
            let law = Law::new(Composed::exact(c).shared(), vec![]).unwrap();
            let f = law.forces(&p, &contact).unwrap();
            let exit = f.angles.unwrap().exit;
            assert!((exit + from).abs() < 1e-3, "{} {exit} {from}", c.name);
            assert!(f.sinkage.unwrap() < 1e-4, "{}", c.name);
            // The mean of E over y = i x/K.
            let far = slip * length / 0.01;
            let steps = 20_000;
            let e = |y: f64| {
                let rise = 1.0 - (-y).exp();
                match c.shear {
                    ShearKind::WongHump => {
                        let lift = 1.0 / (0.6 * (1.0 - (-1.0_f64).exp())) - 1.0;
                        0.6 * (1.0 + lift * (1.0 - y).exp()) * rise
                    }
                    ShearKind::Muskeg => y * (1.0 - y).exp(),
                    _ => rise,
                }
            };
            let mean: f64 = (0..steps)
                .map(|k| e(far * (f64::from(k) + 0.5) / f64::from(steps)))
                .sum::<f64>()
                / f64::from(steps);
            let slides = (0.2 * length * 800.0 + 500.0 * 0.5_f64.tan()) * mean;
            let off = f.drawbar_pull / slides - 1.0;
            assert!(off.abs() < 1e-2, "{} slip {slip}: {off:e}", c.name);
            let off = f.resistive_torque / (f.drawbar_pull * 0.3 * from.cos()) - 1.0;
            assert!(off.abs() < 1e-2, "{} slip {slip}: {off:e}", c.name);
        }
    }
}

/// The soil pushes as hard as the tyre where the flat begins, for every law, a layer of an effect included, and nowhere harder.
#[test]
fn stresses_join_where_the_flat_begins() {
    let mut flats = 0;
    for c in tyres() {
        let law = Law::new(Composed::exact(c).shared(), vec![]).unwrap();
        for p in typical::parameters(&c.params) {
            for (pressure, layer) in [(6e3, 0.0), (2e4, 0.0), (6e3, 3e6), (2e4, 3e6)] {
                let p = with_pressure(c, &p, pressure);
                let mut contact = at(0.2, 245.25);
                contact.hooks.layer_depth = 2e-3;
                contact.hooks.layer_stiffness = layer;
                let field = law.stress_field(&p, &contact).unwrap().unwrap();
                // A front shorter than this is not seen from its angles.
                let Some(from) = field.flat.filter(|from| field.entry - from > 1e-4) else {
                    continue;
                };
                flats += 1;
                let above = field.at(from + 1e-12).normal_stress;
                let off = above / pressure - 1.0;
                assert!(off.abs() < 1e-7, "{} {p:?} {layer}: {off:e}", c.name);
                assert_eq!(field.at(0.3 * from).normal_stress, pressure);
                for k in 0..=50 {
                    let angle = from + (field.entry - from) * f64::from(k) / 50.0;
                    let normal = field.at(angle).normal_stress;
                    assert!(normal <= pressure * (1.0 + 1e-9), "{} {normal}", c.name);
                }
            }
        }
    }
    assert!(flats > 200, "{flats}");
}

/// Peat under the whole contact, its mean shear a hump: Simpson's rule over the published laws, with z_0 and the length of the
/// contact found together by halving.
#[test]
fn a_second_quadrature_agrees_on_peat() {
    let simpson = |a: f64, b: f64, f: &dyn Fn(f64) -> f64| {
        let n = 100_000;
        let h = (b - a) / f64::from(n);
        (0..n)
            .map(|k| {
                let x = a + h * f64::from(k);
                (f(x) + 4.0 * f(x + 0.5 * h) + f(x + h)) * h / 6.0
            })
            .sum::<f64>()
    };
    let law = plain("compliant-tyre:peat:wong-hump");
    let (k_p, m_m, c, phi, modulus, residual) = (3e5, 5e5, 2000.0, 0.5, 0.015, 0.6);
    for (pressure, flat) in [(6e3, true), (1e4, true), (1e6, false)] {
        for slip in [-0.4, -0.02, 0.0, 0.05, 0.7] {
            let p = [k_p, m_m, c, phi, modulus, residual, pressure];
            let f = law.forces(&p, &at(slip, 245.25)).unwrap();
            let angles = f.angles.unwrap();
            let (entry, from) = (angles.entry, -angles.exit);
            assert_eq!(from > 0.0, flat);
            let push = |z: f64, from: f64| {
                let length = 0.254 * (entry.sin() + from.sin());
                let hydraulic = 4.0 * 0.15 * length / (2.0 * (0.15 + length));
                k_p * z + 4.0 * m_m * z * z / hydraulic
            };
            let depth = |t: f64| 0.254 * (t.cos() - entry.cos());
            let (mut low, mut high) = (0.0, entry);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if push(depth(middle), middle) > pressure {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            assert!((from - low).abs() < 1e-9, "{from} {low}");
            let i: f64 = if slip < 0.0 {
                slip / (1.0 + slip)
            } else {
                slip
            };
            let e = |j: f64| {
                let y = j.abs() / modulus;
                let lift = 1.0 / (residual * (1.0 - (-1.0_f64).exp())) - 1.0;
                j.signum() * residual * (1.0 + lift * (1.0 - y).exp()) * (1.0 - (-y).exp())
            };
            let j = |t: f64| 0.254 * ((entry - t) - (1.0 - i) * (entry.sin() - t.sin()));
            let normal = |t: f64| push(depth(t).max(0.0), from);
            let shear = |t: f64| (c + normal(t) * phi.tan()) * e(j(t));
            let length = 2.0 * 0.254 * from.sin();
            let under = simpson(0.0, length, &|x| {
                (c + pressure * phi.tan()) * e(j(from) + i * x)
            });
            let area = 0.254 * 0.15;
            let load = simpson(from, entry, &|t| normal(t) * t.cos() + shear(t) * t.sin()) * area
                + pressure * length * 0.15;
            let pull = simpson(from, entry, &|t| shear(t) * t.cos() - normal(t) * t.sin()) * area
                + under * 0.15;
            let torque = (simpson(from, entry, &shear) * area + under * from.cos() * 0.15) * 0.254;
            for (found, by_simpson) in [
                (245.25, load),
                (f.drawbar_pull, pull),
                (f.resistive_torque, torque),
            ] {
                assert!(
                    (found - by_simpson).abs() < 1e-5,
                    "p_t {pressure} slip {slip}: {found} {by_simpson}"
                );
            }
        }
    }
}

/// The load of a driven tyre rises with its entry angle, flat or round, which is what the search for folds relies on.
#[test]
fn the_load_of_a_driven_tyre_rises() {
    for c in tyres().filter(|c| !c.shear.falls()) {
        for p in typical::parameters(&c.params) {
            for pressure in [3e3, 2e4, 1e5] {
                for slip in [0.0, 0.1, 1.0] {
                    let p = with_pressure(c, &p, pressure);
                    let wheel = Composed::exact(c).wheel(&p, &at(slip, 1.0)).unwrap();
                    let load = |k: u32| wheel.load((f64::from(k) * 0.05).to_radians());
                    let loads: Vec<f64> = (1..=1800).map(load).collect();
                    assert!(
                        loads.windows(2).all(|w| w[0] < w[1]),
                        "{} {p:?} {slip}",
                        c.name
                    );
                }
            }
        }
    }
}
