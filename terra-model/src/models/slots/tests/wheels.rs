//! Wheels against the plain ones, published figures and integrals of their own stresses.

use super::*;

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
