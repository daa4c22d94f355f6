//! Braked wheels of two zones with other laws: against the plain one, the driven rim and a second method.

use super::*;

fn two_zones() -> impl Iterator<Item = &'static Combination> {
    let all = combinations().iter();
    all.filter(|c| c.wheel == WheelKind::BrakedTwoZone)
}

#[test]
fn composed_from_the_default_slots_is_the_plain_wheel_of_two_zones() {
    let slots = law("braked-two-zone:bekker:janosi-hanamoto");
    let plain = plain("braked-two-zone");
    let compared = same_over_the_catalogue(&slots, &plain, 1e-9, |p| (p.to_vec(), p.to_vec()));
    assert!(compared > 300, "{compared}");
    // Within the join, and nearly locked.
    let mut compared = 0;
    for id in [
        "dry_sand",
        "upland_sandy_loam",
        "lean_clay_22",
        "chrono_soft",
    ] {
        let p = soil(id);
        for slip in [
            -0.9999, -0.999, -0.99, -0.95, -0.9, -0.06, -0.05, -0.049, -0.03, -0.01, -1e-3, -1e-5,
        ] {
            for load in [60.0, 245.25, 900.0] {
                match (
                    slots.forces(&p, &at(slip, load)),
                    plain.forces(&p, &at(slip, load)),
                ) {
                    (Ok(f), Ok(g)) => {
                        let off = difference(&f, &g);
                        assert!(off < 1e-9, "{id} slip {slip} load {load}: {off:e}");
                        compared += 1;
                    }
                    (f, g) => assert!(f.is_err() && g.is_err(), "{f:?} {g:?}"),
                }
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn other_laws_that_are_bekkers_are_the_plain_wheel() {
    for (name, in_other_law) in AS_BEKKER {
        let slots = plain(&format!("braked-two-zone:{name}"));
        let compared = same_over_the_catalogue(&slots, &plain("braked-two-zone"), 2e-9, |p| {
            (in_other_law(p), p.to_vec())
        });
        assert!(compared > 300, "{name} {compared}");
    }
}

#[test]
fn driven_it_is_the_rim_with_those_slots() {
    let mut compared = 0;
    for c in two_zones() {
        let rim = find(WheelKind::WongReece, c.pressure, c.shear).unwrap();
        let laws = [Composed::exact(c), rim].map(|m| Law::new(m.shared(), vec![]).unwrap());
        for p in typical::parameters(&c.params) {
            for slip in [0.0, 0.02, 0.3, 1.0] {
                let [a, b] = [&laws[0], &laws[1]].map(|l| l.jacobian(&p, &at(slip, 245.25)));
                let ((f, slopes), (g, others)) = (a.unwrap(), b.unwrap());
                assert_eq!(f.drawbar_pull.to_bits(), g.drawbar_pull.to_bits());
                assert_eq!(f.resistive_torque.to_bits(), g.resistive_torque.to_bits());
                assert_eq!(f.sinkage.unwrap().to_bits(), g.sinkage.unwrap().to_bits());
                assert_eq!(slopes, others);
                compared += 1;
            }
        }
    }
    assert!(compared >= 21 * 16, "{compared}");
}

/// cos θ0 - (1 + s) = tan(45° - φ/2) sin θ0, where σ is largest and the shear changes from against the rotation to with it.
#[test]
fn the_zones_meet_where_the_paper_says() {
    let mut met = 0;
    for c in two_zones() {
        let law = Law::new(Composed::exact(c).shared(), vec![]).unwrap();
        let angle = c
            .params
            .iter()
            .position(|p| p.name == "friction_angle")
            .unwrap();
        for p in typical::parameters(&c.params) {
            for slip in [-0.06_f64, -0.1, -0.2] {
                let Ok(Some(field)) = law.stress_field(&p, &at(slip, 245.25)) else {
                    continue;
                };
                let (entry, meeting) = (field.entry, field.apex);
                let chi = std::f64::consts::FRAC_PI_4 - 0.5 * p[angle];
                let off = meeting.cos() - (1.0 + slip) - chi.tan() * meeting.sin();
                if meeting > 0.979 * entry {
                    // Held, because it would lie ahead of the contact.
                    assert!(off > 0.0, "{} {off}", c.name);
                    continue;
                }
                met += 1;
                assert!(off.abs() < 1e-12, "{} {off:e}", c.name);
                let shear = |angle: f64| field.at(angle).shear_stress;
                let large = shear(0.5 * (entry + meeting));
                assert!(large > 0.0 && shear(0.5 * meeting) < 0.0, "{}", c.name);
                assert!(shear(meeting).abs() < 1e-9 * large.max(1.0), "{}", c.name);
                let top = field.at(meeting).normal_stress;
                assert!(field.at(0.9 * meeting).normal_stress < top);
                assert!(field.at(meeting + 0.1 * (entry - meeting)).normal_stress < top);
            }
        }
    }
    assert!(met > 60, "{met}");
}

/// A layer under both branches and a hump in both zones, by the midpoint rule on the formulas of the papers.
#[test]
fn a_second_quadrature_agrees() {
    let law = plain("braked-two-zone:layered:wong-hump");
    let (k, n, stiff, top) = (8e5, 0.9, 4e6, 0.006);
    let (c, phi, modulus, residual) = (900.0_f64, 0.45_f64, 0.012, 0.6);
    for slip in [-0.9_f64, -0.4, -0.1, -0.04, -0.01] {
        let p = [0.0, k, n, stiff, top, c, phi, modulus, residual, 0.4, 0.3];
        let f = law.forces(&p, &at(slip, 245.25)).unwrap();
        let entry = f.angles.unwrap().entry;
        let past = 1.0 / (1.0 + slip);
        let chi = std::f64::consts::FRAC_PI_4 - 0.5 * phi;
        let meeting = (((1.0 + slip) * chi.cos()).acos() - chi).min(0.98 * entry);
        let weight = (1.0 + slip / 0.05).max(0.0).powi(2);
        let apex = (0.4 + 0.3 * (1.0 - past)) * entry * weight + meeting * (1.0 - weight);
        let e = |j: f64| {
            let y = j.abs() / modulus;
            let lift = 1.0 / (residual * (1.0 - (-1.0_f64).exp())) - 1.0;
            j.signum() * residual * (1.0 + lift * (1.0 - y).exp()) * (1.0 - (-y).exp())
        };
        let shear = |t: f64| {
            let driven = (entry - t) - past * (entry.sin() - t.sin());
            let chord = (entry.sin() - meeting.sin()) / (entry - meeting);
            let two = if t > meeting {
                past * ((entry - t) * chord - (entry.sin() - t.sin()))
            } else {
                (meeting - t) - past * (meeting.sin() - t.sin())
            };
            e(0.254 * (weight * driven + (1.0 - weight) * two))
        };
        let normal = |t: f64| {
            let front = if t > apex {
                t
            } else {
                entry - t * (entry - apex) / apex
            };
            let z = 0.254 * (front.cos() - entry.cos()).max(0.0);
            k * z.powf(n) + stiff * (z - top).max(0.0)
        };
        let steps = 400_000;
        let mut sums = [0.0; 3];
        for q in 0..steps {
            let t = entry * (f64::from(q) + 0.5) / f64::from(steps);
            let (sigma, area) = (normal(t), 0.254 * 0.15 * entry / f64::from(steps));
            let tau = (c + sigma * phi.tan()) * shear(t);
            sums[0] += (sigma * t.cos() + tau * t.sin()) * area;
            sums[1] += (tau * t.cos() - sigma * t.sin()) * area;
            sums[2] += tau * area * 0.254;
        }
        let found = [245.25, f.drawbar_pull, f.resistive_torque];
        for (by_formula, found) in sums.into_iter().zip(found) {
            assert!(
                (by_formula - found).abs() < 1e-4,
                "slip {slip}: {by_formula} {found}"
            );
        }
    }
}

#[test]
fn an_interface_does_not_tell_where_the_zones_meet() {
    let Err(ModelError::Combination { reason, .. }) =
        Registry::builtin().model("braked-two-zone:reece:interface")
    else {
        panic!("known")
    };
    assert!(reason.contains("friction angle") && reason.contains("interface"));
}
