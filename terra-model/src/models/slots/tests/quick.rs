//! The short rule of fits against the exact one.

use super::*;
use crate::lanes::{Lanes, Vector};
use crate::models::bekker;

/// Every soil of the catalogue, driven and braked, at two loads: forces in lanes by the short rule are those of one contact to a
/// part in ten thousand, or two in a thousand under a shear law that peaks, and mostly to one in a hundred thousand.
#[test]
fn the_short_rule_is_right_for_fits() {
    for (name, more, bound) in [
        ("scm-column:bekker:janosi-hanamoto", 0.0, 1e-4),
        ("scm-column:bekker:wong-hump", 0.3, 2e-3),
        ("lateral:bekker:janosi-hanamoto", 0.02, 1e-4),
        ("wong-reece:reece:janosi-hanamoto", 0.0, 1e-4),
        ("braked-two-zone:reece:janosi-hanamoto", 0.0, 1e-4),
    ] {
        let law = law(name);
        let quick = law.quick();
        let mut all = vec![];
        for terrain in catalogue::terrains() {
            let Ok(p) = terrain.parameters(&*Registry::builtin().model("wong-reece").unwrap())
            else {
                continue;
            };
            let p: Vec<f64> = law
                .params()
                .iter()
                .map(|param| {
                    let own = bekker::PARAMS.iter().position(|q| q.name == param.name);
                    match param.name {
                        "k_c_prime" => 0.0,
                        "k_phi_prime" => (p[0] / 0.15 + p[1]) * 0.15_f64.powf(p[2] - 1.0) / 15e3,
                        "unit_weight" => 15e3,
                        _ => own.map_or(more, |k| p[k]),
                    }
                })
                .collect();
            for slip in [-0.6, -0.2, -0.02, 0.05, 0.3, 0.8] {
                for load in LOADS {
                    let contact = at(slip, load);
                    let lifted: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
                    let Ok(exact) = law.forces(&p, &contact) else {
                        continue;
                    };
                    let short = quick.forces_at(&lifted, &contact.lift()).unwrap();
                    let mut one = exact;
                    one.drawbar_pull = short.drawbar_pull.lane(0);
                    one.resistive_torque = short.resistive_torque.lane(0);
                    one.sinkage = short.sinkage.map(|z| z.lane(0));
                    all.push((difference(&one, &exact), terrain.id.clone(), slip, load));
                    // One contact is as exact as ever.
                    assert_eq!(
                        difference(&quick.forces(&p, &contact).unwrap(), &exact),
                        0.0
                    );
                }
            }
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (worst, middle) = (all.last().unwrap(), &all[all.len() / 2]);
        assert!(all.len() > 100 && worst.0 < bound, "{name}: {worst:?}");
        assert!(middle.0 < 1e-5, "{name}: {middle:?}");
    }
}
