//! What the figures say, in numbers, against what is published of the method.

use std::sync::OnceLock;

use super::*;

/// Soil, draws with it in the set, draws with everything 10 % off.
type Case = (&'static str, Vec<Drive>, Vec<Drive>);

fn cases() -> &'static (Soils, Vec<Case>) {
    static CASES: OnceLock<(Soils, Vec<Case>)> = OnceLock::new();
    CASES.get_or_init(|| {
        let soils = Soils::of_the_paper();
        let case = |soil| {
            let exact = drives(soil, |run| exact(&soils, soil, SEED, run));
            let near = drives(soil, |run| perturbed(&soils, soil, SEED, run));
            (soil, exact, near)
        };
        let cases = SOILS.map(case).into();
        (soils, cases)
    })
}

/// Errors of pull and torque of the left side in every draw, and in units of the stated sd.
fn errors(drives: &[Drive]) -> [Vec<(f64, f64)>; 2] {
    let mut out = [vec![], vec![]];
    for d in drives {
        let t = &d.truth;
        for (row, s) in &d.forces {
            let truth = [
                t.drawbar_pull[0][*row] + t.drawbar_pull[2][*row],
                t.resistive_torque[0][*row],
            ];
            for k in 0..2 {
                let off = s.vector[k] - truth[k];
                out[k].push((off, off / s.covariance[(k, k)].sqrt()));
            }
        }
    }
    out
}

/// A prototype of this filter had an RMSE of 2.32 N in the force of a side and .66 N m in a torque; no fewer than 95 in 100
/// errors lie within two of the sd that it states. (Nearly all do: the random walk allows for faster changes than a ramp.)
#[test]
fn forces_are_as_exact_as_published_and_no_worse_than_they_say() {
    for (soil, exact, _) in &cases().1 {
        for (errors, published) in errors(exact).iter().zip([2.32, 0.66]) {
            let n = errors.len() as f64;
            let rmse = (errors.iter().map(|e| e.0 * e.0).sum::<f64>() / n).sqrt();
            let within = errors.iter().filter(|e| e.1.abs() < 2.0).count() as f64 / n;
            println!("{soil}: rmse {rmse:.3} (published {published}), within two sd {within:.3}");
            assert!(rmse < 1.25 * published, "{soil}: {rmse}");
            assert!(within > 0.95, "{soil}: {within}");
        }
    }
}

/// "Exact hypothesis present: correct within 2 iterations"; a prototype found 1.00, 1.00 and .985.
#[test]
fn the_soil_itself_is_named_within_two_samples() {
    for (soil, exact, _) in &cases().1 {
        let right = exact.iter().filter(|d| d.named(2)).count();
        println!("{soil}: {right} of {DRAWS} after 2");
        assert!(right as u64 >= DRAWS - 1, "{soil}: {right}");
        assert!(exact.iter().all(Drive::named_at_end));
    }
}

/// Everything 10 % off: "sand and loam pick their own copy, lean clay goes to heavy clay or a mixture"; a prototype found
/// .995, .78 and .44 at the end, heavy clay in 55 % of the draws on lean clay.
#[test]
fn copies_are_named_as_often_as_published() {
    let mut right = Vec::new();
    for (soil, _, near) in &cases().1 {
        let own = near.iter().filter(|d| d.named_at_end()).count();
        println!(
            "{soil}: own copy {own} of {DRAWS}, rival {:?}",
            figures::rival(near)
        );
        right.push(own);
    }
    assert!(right[0] >= right[1] && right[1] >= right[2], "{right:?}");
    assert!(right[0] >= 16 && right[2] <= 15, "{right:?}");
    let clay = figures::rival(&cases().1[2].2);
    assert_eq!(clay.as_deref(), Some("heavy_clay_25"));
}

/// Peaks of both stresses and their angles under the winner, all four within 20 %: .55, .49 and .32 of draws in a
/// prototype, not all of them as the paper's one draw had it.
#[test]
fn stresses_come_near_but_not_always() {
    let (soils, cases) = cases();
    for (soil, _, near) in cases {
        let features = |p: &[f64]| {
            let s = figures::profile(soils, p).unwrap();
            let (normal, shear) = (s.max_normal, s.max_shear);
            [
                normal.normal_stress,
                normal.angle,
                shear.shear_stress,
                shear.angle,
            ]
        };
        let own = features(&soils.parameters(soil));
        let good = near.iter().filter(|d| {
            let found = features(&figures::winner(d));
            own.iter()
                .zip(found)
                .all(|(a, b)| (b / a - 1.0).abs() < 0.2)
        });
        let good = good.count();
        println!("{soil}: four features within 20 % in {good} of {DRAWS}");
        assert!((2..=18).contains(&good), "{soil}: {good}");
    }
}

/// Five figures a soil, each an SVG that says what it shows and a table of the same numbers.
#[test]
fn every_figure_is_there() {
    let (soils, cases) = cases();
    for (soil, exact, near) in cases {
        let files = figures::of_soil(soils, exact, near);
        assert_eq!(files.len(), 5);
        for f in files {
            assert!(f.svg.starts_with("<svg") && f.svg.ends_with("</svg>"));
            assert!(f.csv.lines().count() > 40, "{soil}: {}", f.name);
            assert!(
                !f.svg.contains("NaN") && !f.csv.contains("NaN"),
                "{}",
                f.name
            );
        }
    }
}
