//! Pressure laws against one another, their limits and Simpson's rule.

use super::*;

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
