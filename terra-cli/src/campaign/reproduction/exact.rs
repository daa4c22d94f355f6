//! Exact soil in the set: how often it is named after how many samples, and what the probabilities are worth.

use terra_sim::{Scenario, StartMotion};

use super::{Asked, Bench, Figure, Told, number, rate, share};
use crate::campaign::{LOOK_AT, Rate};
use crate::error::CliError;
use crate::identify::IdentifyOptions;

/// Mean difference of what the winners claim and how often they are right.
pub(super) const ECE: &str = "ECE";

/// Exact soil in the set, the proportional split, the bank, and calibration.
pub(super) fn exact(bench: &Bench) -> Result<Vec<Figure>, CliError> {
    let scheme = |name: &str| IdentifyOptions {
        estimator: Some(name.to_owned()),
        join: name == "innovation-bank",
        ..bench.options()
    };
    // Mean of the prototype @1 2 5 10 20 50, end, worst soil @2.
    let published = [
        (
            "side-sum",
            [0.972, 0.977, 0.983, 0.988, 0.997, 1.0, 1.0, 0.76],
        ),
        (
            "proportional-split",
            [0.299, 0.303, 0.305, 0.305, 0.300, 0.269, 0.399, 0.0],
        ),
        (
            "innovation-bank",
            [0.548, 0.867, 0.959, 0.985, 1.0, 1.0, 1.0, f64::NAN],
        ),
    ];
    let told = bench.ramps(|_| {}, &published.map(|(name, _)| scheme(name)))?;
    let mut out = Vec::new();
    for ((name, figures), runs) in published.iter().zip(&told) {
        let known = |x: f64| (!x.is_nan()).then_some(x);
        let looks = LOOK_AT.iter().map(|k| (format!("right @{k}"), Some(*k)));
        for ((what, k), figure) in looks
            .chain([("right at end".to_owned(), None)])
            .zip(figures)
        {
            let (good, n) = share(runs, |t| t.right(k));
            let asked = match (*name, k) {
                ("side-sum", Some(2)) => Some(0.97),
                ("side-sum" | "innovation-bank", Some(20)) => Some(0.99),
                ("side-sum", Some(50)) => Some(0.999),
                _ => None,
            };
            out.push(Figure {
                asked: asked.map(Asked::AtLeast),
                ..rate("exact", name, what, good, n, known(*figure))
            });
        }
        if *name == "side-sum" {
            // The paper's own three terrains.
            for (soil, figure) in [
                ("dry_sand", 1.0),
                ("upland_sandy_loam", 1.0),
                ("lean_clay_22", 0.985),
            ] {
                let of_soil = runs.iter().filter(|t| t.truth == soil);
                let (good, n) = share(of_soil, |t| t.right(Some(2)));
                let what = format!("right @2, {soil}");
                let row = rate("exact", name, what, good, n, Some(figure));
                out.push(row.asked(Asked::AtLeast(0.97)));
            }
        }
        let worst = bench
            .soils
            .iter()
            .map(|soil| {
                share(runs.iter().filter(|t| t.truth == *soil), |t| {
                    t.right(Some(2))
                })
            })
            .min_by(|a, b| {
                Rate::new(a.0, a.1)
                    .value
                    .total_cmp(&Rate::new(b.0, b.1).value)
            });
        if let Some((good, n)) = worst {
            let what = "right @2, worst soil".to_owned();
            let row = rate("exact", name, what, good, n, known(figures[7]));
            out.push(if *name == "side-sum" {
                row.asked(Asked::AtLeast(0.70))
            } else {
                row
            });
        }
        out.extend(calibration(name, runs));
    }
    let name = "innovation-bank";
    let radius = bench.rover.wheel.radius;
    let told = bench.ramps(|s| from_any_speed(s, radius), &[scheme(name)])?;
    for runs in &told {
        out.extend(calibration("innovation-bank, from any speed", runs));
    }
    Ok(out)
}

/// Largest speed \[m/s\] and slips at which the runs begin that do not start at standstill.
const SPEED: f64 = 1.0;
const SLIP: [f64; 2] = [0.05, 0.95];

/// Starts each run at another speed and slip, spread evenly over both.
///
/// # Reference
/// M. Roberts, *The unreasonable effectiveness of quasirandom sequences*, 2018: shares of powers of the plastic number.
fn from_any_speed(scenario: &mut Scenario, radius: f64) {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let k = scenario.run as f64 + 0.5;
    let speed = SPEED * (k / PLASTIC).fract();
    let slip = SLIP[0] + (SLIP[1] - SLIP[0]) * (k / (PLASTIC * PLASTIC)).fract();
    for segment in &mut scenario.segments {
        segment.start = Some(StartMotion {
            ground_speed: speed,
            wheel_speed: [speed / ((1.0 - slip) * radius); 4],
        });
    }
}

/// NLL by sample, expected calibration error, and confident mistakes.
fn calibration(name: &str, runs: &[Told]) -> Vec<Figure> {
    let published = match name {
        "side-sum" => Some([0.055, 0.053, 0.037, 0.022, 0.005, f64::NAN]),
        "innovation-bank" => Some([0.061, 0.032, 0.018, 0.001, 0.0, f64::NAN]),
        _ => None,
    };
    let mut out = Vec::new();
    let mut last = f64::INFINITY;
    let judged = name != "proportional-split";
    for (i, k) in LOOK_AT.into_iter().enumerate() {
        let losses: Vec<f64> = runs
            .iter()
            .filter_map(|t| t.probability_of_truth(k))
            .map(|p| -p.max(1e-300).ln())
            .collect();
        let mean = losses.iter().sum::<f64>() / losses.len().max(1) as f64;
        let known = published.map(|p| p[i]).filter(|p| !p.is_nan());
        let figure = format!("NLL @{k}");
        // It must not rise, but for less than one could print.
        let asked = (judged && last.is_finite()).then_some(Asked::AtMost(last + 5e-4));
        last = last.min(mean);
        out.push(Figure {
            asked,
            ..number(
                "calibration",
                name,
                &figure,
                (!losses.is_empty()).then_some(mean),
                losses.len(),
                known,
            )
        });
    }
    for k in LOOK_AT {
        let stated: Vec<f64> = runs.iter().filter_map(|t| Some(t.at(Some(k))?.1)).collect();
        let mean = stated.iter().sum::<f64>() / stated.len().max(1) as f64;
        out.push(number(
            "calibration",
            name,
            &format!("mean p of the winner @{k}"),
            (!stated.is_empty()).then_some(mean),
            stated.len(),
            None,
        ));
    }
    // Ten bins of the winner's probability over all looks.
    let mut bins = [(0.0, 0usize, 0usize, 0.0); 10];
    let (mut wrong, mut sure) = (0, 0);
    for t in runs {
        for k in LOOK_AT {
            let Some((id, p)) = t.at(Some(k)) else {
                continue;
            };
            let right = id == t.truth;
            let bin = &mut bins[((p * 10.0) as usize).min(9)];
            bin.0 += p;
            bin.1 += usize::from(right);
            bin.2 += 1;
            bin.3 += p * (1.0 - p);
            if p > 0.99 {
                sure += 1;
                wrong += usize::from(!right);
            }
        }
    }
    let all: usize = bins.iter().map(|b| b.2).sum();
    let gap: f64 = bins.iter().map(|b| (b.0 - b.1 as f64).abs()).sum();
    let (ece, confident) = match name {
        "side-sum" => (Some(0.0025), Some(0.0)),
        "innovation-bank" => (Some(0.0052), Some(0.0)),
        _ => (None, None),
    };
    for (k, (sum, good, n, _)) in bins.iter().enumerate().filter(|(_, b)| b.2 > 0) {
        let mean = sum / *n as f64;
        let what = format!(
            "right at p {:.1}-{:.1}, mean p {mean:.3}",
            0.1 * k as f64,
            0.1 * (k + 1) as f64
        );
        out.push(rate("calibration", name, what, *good, *n, None));
    }
    // What answers that are right exactly as often as they say would have: E|Σ (right - p)| of a bin, by its variance.
    let chance: f64 = bins
        .iter()
        .map(|b| (2.0 / std::f64::consts::PI * b.3).sqrt())
        .sum();
    out.push(number(
        "calibration",
        name,
        "ECE by chance alone, at least",
        (all > 0).then(|| chance / all as f64),
        all,
        None,
    ));
    let asked = |bound| judged.then_some(Asked::AtMost(bound));
    out.push(Figure {
        asked: asked(0.01),
        ..number(
            "calibration",
            name,
            ECE,
            (all > 0).then(|| gap / all as f64),
            all,
            ece,
        )
    });
    out.push(Figure {
        asked: asked(0.003),
        ..rate(
            "calibration",
            name,
            "wrong given p > .99".to_owned(),
            wrong,
            sure,
            confident,
        )
    });
    out
}

#[cfg(test)]
mod tests {
    use terra_sim::paper;

    use super::*;

    /// A hundred starts fill every tenth of speeds and slips alike.
    #[test]
    fn starts_are_spread_evenly() {
        let radius = 0.254;
        let mut tenths = [[0; 10]; 2];
        for run in 0..100 {
            let mut scenario = paper::torque_ramp("dry_sand", 1).unwrap();
            scenario.run = run;
            from_any_speed(&mut scenario, radius);
            let start = scenario.segments[0].start.unwrap();
            let rim = radius * start.wheel_speed[0];
            let slip = 1.0 - start.ground_speed / rim;
            let shares = [
                start.ground_speed / SPEED,
                (slip - SLIP[0]) / (SLIP[1] - SLIP[0]),
            ];
            for (tenths, share) in tenths.iter_mut().zip(shares) {
                tenths[(10.0 * share) as usize] += 1;
            }
        }
        let even = tenths.as_flattened().iter();
        assert!(even.clone().all(|n| (8..=12).contains(n)), "{tenths:?}");
    }
}
