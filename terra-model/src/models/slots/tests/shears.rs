//! Shear laws against their published curves.

use super::*;

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

/// The mean of E, with its sign, over straight lines of y by the antiderivatives of the published curves.
#[test]
fn means_under_a_flat_are_those_of_antiderivatives() {
    use std::f64::consts::E;
    for name in ["janosi-hanamoto", "wong-hump", "muskeg"] {
        let kind = slot("", &ShearKind::ALL, ShearKind::name, name).unwrap();
        let p = [1000.0, 0.5, 1.0, 0.6];
        let c = composed(&format!("scm-column:bekker:{name}")).of;
        let params: &'static [Param] = &c.params[3..];
        let values = Values {
            model: "test",
            params,
            p: &p[..params.len()],
        };
        let strength = kind.read(&values, &at(0.1, 1.0)).unwrap();
        // ∫ E from 0 to |y|.
        let integral = |y: f64| {
            let y = y.abs();
            let (one, two) = (-(-y).exp_m1(), -0.5 * (-2.0 * y).exp_m1());
            match kind {
                ShearKind::WongHump => {
                    let lift = (1.0 / (0.6 * (1.0 - 1.0 / E)) - 1.0) * E;
                    0.6 * (y - one + lift * (one - two))
                }
                ShearKind::Muskeg => E * (1.0 - (1.0 + y) * (-y).exp()),
                _ => y - one,
            }
        };
        for start in [0.0, 0.3, 2.0, 40.0, -0.5, -7.0] {
            for change in [
                0.5, 3.0, 30.0, 1e3, 1e7, 1e13, -0.5, -3.0, -30.0, -1e3, -1e7, -1e13,
            ] {
                let end = start + change;
                let exact = (integral(end) - integral(start)) / change;
                let found = super::super::tyre::mean_mobilised(&strength, start, change);
                // The antiderivatives' own rounding.
                let bound = 1e-13 + 1e-15 * integral(end).max(integral(start)) / change.abs();
                assert!(
                    (found - exact).abs() < bound,
                    "{name} {start} {change}: {found} {exact}"
                );
            }
        }
        let still = super::super::tyre::mean_mobilised(&strength, 0.7, 0.0);
        assert!((still - strength.mobilised(0.7)).abs() < 1e-15);
    }
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
