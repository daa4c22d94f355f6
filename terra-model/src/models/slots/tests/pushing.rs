//! Lugs and flanks that push soil, against Simpson's rule.

use super::*;

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
    let thrust = integral(&|a| parts(a).2 * a.cos());
    let lug_thrust = integral(&|a| {
        let (own, rest, ..) = parts(a);
        per * (own + rest) * a.cos()
    });
    let torque = integral(&|a| {
        let (own, rest, tau, _) = parts(a);
        per * (own * (0.254 + height * 2.0 / 3.0) + rest * (0.254 + height / 2.0)) + tau * 0.254
    });
    // The boundary layer of K is a ten-thousandth of the contact.
    assert!((load / 245.25 - 1.0).abs() < 1e-3, "{load}");
    assert!((f.parts.thrust / thrust - 1.0).abs() < 1e-3);
    assert!((f.parts.lug_thrust / lug_thrust - 1.0).abs() < 1e-3);
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

/// Load, pull and torque are the integrals of the stresses that the profile gives, lugs, their arm and braking included;
/// and beside the rim's own shear stress it is N F_p/(2π R b) by Rankine's formula.
#[test]
fn stresses_of_lugs_carry_the_wheel() {
    let sand = soil("dry_sand");
    let (height, count, weight) = (0.02, 24.0, 15e3);
    for (name, p) in [
        (
            "grouser-passive",
            [&sand[..], &[weight, height, count]].concat(),
        ),
        (
            "ding-closed",
            [&sand[..3], &[0.3], &sand[3..], &[-0.2, 0.015]].concat(),
        ),
    ] {
        let law = plain(name);
        for contact in [at(0.1, 245.25), at(0.7, 600.0), at(-0.2, 90.0)] {
            let f = law.forces(&p, &contact).unwrap();
            let apex = f.angles.unwrap().max_stress;
            let profile = law.stresses(&p, &contact, 16_001).unwrap().unwrap();
            let mut sums = [0.0; 3];
            for pair in profile.points.windows(2) {
                let area = 0.5 * (pair[1].angle - pair[0].angle) * 0.254 * 0.15;
                for point in pair {
                    let (sin, cos) = point.angle.sin_cos();
                    let (normal, tau) = (point.normal_stress, point.shear_stress);
                    sums[0] += area * (normal * cos + tau * sin);
                    sums[1] += area * (tau * cos - normal * sin);
                    sums[2] += area * tau * point.shear_arm;
                }
            }
            let force = f.parts.thrust.abs() + f.parts.compaction_resistance.abs();
            assert!((sums[0] / contact.normal_load - 1.0).abs() < 1e-5, "{name}");
            assert!((sums[1] - f.drawbar_pull).abs() < 1e-5 * force, "{name}");
            assert!(
                (sums[2] / f.resistive_torque - 1.0).abs() < 1e-5,
                "{name} {} {}",
                sums[2],
                f.resistive_torque
            );
            assert!(profile.points.iter().all(|q| q.shear_arm > 0.254), "{name}");
            if name == "ding-closed" {
                continue;
            }
            let (c, phi) = (p[3], p[4]);
            let np = (std::f64::consts::FRAC_PI_4 + 0.5 * phi).tan().powi(2);
            for point in profile
                .points
                .iter()
                .filter(|q| q.angle > apex)
                .step_by(997)
            {
                let (angle, sigma) = (point.angle, point.normal_stress);
                let entry = f.angles.unwrap().entry;
                let i = if contact.slip < 0.0 {
                    contact.slip / (1.0 + contact.slip)
                } else {
                    contact.slip
                };
                let j = 0.254 * ((entry - angle) - (1.0 - i) * (entry.sin() - angle.sin()));
                let e = (1.0 - (-j.abs() / p[5]).exp()).copysign(j);
                let push = weight * height * height * np / 2.0
                    + sigma * height * np
                    + 2.0 * c * height * np.sqrt();
                let spread = count * push / (std::f64::consts::TAU * 0.254);
                let tau = (c + sigma * phi.tan() + spread) * e;
                assert!(
                    (point.shear_stress - tau).abs() < 1e-6 * tau.abs() + 1e-6,
                    "{} {tau}",
                    point.shear_stress
                );
            }
        }
    }
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

/// Over the passage of one lug the pushes have the mean that the forces of the model hold, and with few lugs they rise and
/// fall by more than that mean's tenth; with many they hardly do.
#[test]
fn a_lugs_passage_has_the_mean_of_the_forces() {
    let law = plain("grouser-passive");
    for slip in [-0.2, 0.1, 0.5] {
        let mut swings = vec![];
        for count in [12.0, 96.0] {
            let p = [&soil("upland_sandy_loam")[..], &[14e3, 0.012, count]].concat();
            let at = at(slip, 245.25);
            let f = law.forces(&p, &at).unwrap();
            let cycle = law.lug_cycle(&p, &at, 2000).unwrap().unwrap();
            let mean = |pick: fn(&LugPhase) -> f64| cycle.iter().map(pick).sum::<f64>() / 2000.0;
            let pull = mean(|c| c.pull);
            assert!(
                (pull / f.parts.lug_thrust - 1.0).abs() < 2e-3,
                "{pull} {}",
                f.parts.lug_thrust
            );
            assert_eq!(mean(|c| c.load) > 0.0, slip > 0.0);
            let most = cycle
                .iter()
                .map(|c| c.pull)
                .fold(f64::NEG_INFINITY, f64::max);
            let least = cycle.iter().map(|c| c.pull).fold(f64::INFINITY, f64::min);
            swings.push((most - least) / pull.abs());
        }
        assert!(
            swings[0] > 0.1 && swings[1] < 0.2 * swings[0],
            "{slip}: {swings:?}"
        );
    }
}

/// A wheel with so few lugs that one at most is in the soil: at the moment it stands at an angle it pushes F_p there.
#[test]
fn one_lug_pushes_what_its_formula_says() {
    let mut p = soil("upland_sandy_loam");
    p[5] = 2e-5;
    let (height, weight) = (0.012, 14e3);
    let lugs = [&p[..], &[weight, height, 4.0]].concat();
    let law = plain("grouser-passive");
    let at = at(0.5, 245.25);
    let entry = law.forces(&lugs, &at).unwrap().angles.unwrap().entry;
    let np = (std::f64::consts::FRAC_PI_4 + 0.5 * p[4]).tan().powi(2);
    let mut seen = 0;
    for moment in law.lug_cycle(&lugs, &at, 400).unwrap().unwrap() {
        let angle = std::f64::consts::FRAC_PI_2 - moment.phase;
        if angle >= entry {
            assert_eq!((moment.pull, moment.torque, moment.load), (0.0, 0.0, 0.0));
            continue;
        }
        // Beside the entry the strength is not mobilised yet.
        if angle > 0.97 * entry {
            continue;
        }
        let q = rim_stress(&p, 0.5, entry, angle);
        let own = weight * height * height * np / 2.0;
        let rest = q * height * np + 2.0 * p[3] * height * np.sqrt();
        let force = 0.15 * (own + rest);
        let torque = 0.15 * (own * (0.254 + height * 2.0 / 3.0) + rest * (0.254 + height / 2.0));
        assert!(
            (moment.pull - force * angle.cos()).abs() < 1e-3 * force,
            "{angle}"
        );
        assert!((moment.load - force * angle.sin()).abs() < 1e-3 * force);
        assert!((moment.torque / torque - 1.0).abs() < 1e-3);
        seen += 1;
    }
    assert!(seen > 50, "{seen}");
    assert!(
        plain("wong-reece")
            .lug_cycle(&p, &at, 10)
            .unwrap()
            .is_none()
    );
    assert!(
        law.lug_cycle(&[&p[..], &[weight, height, 0.0]].concat(), &at, 10)
            .unwrap()
            .is_none()
    );
}
