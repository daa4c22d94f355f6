//! The soil changes under way: how long until the new one is named.

use rayon::prelude::*;
use terra_data::{DriveLog, Series};
use terra_mme::Choice;
use terra_sim::{StartMotion, paper, simulate_drive};

use super::{Asked, Bench, Figure, Told, number, rate};
use crate::error::CliError;
use crate::identify::IdentifyOptions;

/// Columns of two logs, one after the other; the second starts `shift` later.
fn joined(mut first: DriveLog, second: &DriveLog, shift: f64) -> DriveLog {
    let both = |a: &Series, b: &Series| a.iter().chain(b.iter()).collect::<Series>();
    let maybe = |a: &Option<Series>, b: &Option<Series>| {
        a.as_ref().zip(b.as_ref()).map(|(a, b)| both(a, b))
    };
    for q in 0..4 {
        first.wheel_speed[q] = both(&first.wheel_speed[q], &second.wheel_speed[q]);
    }
    if let (Some(a), Some(b)) = (&mut first.wheel_torque, &second.wheel_torque) {
        for q in 0..4 {
            a[q] = both(&a[q], &b[q]);
        }
    }
    first.ground_speed = maybe(&first.ground_speed, &second.ground_speed);
    first.yaw_rate = maybe(&first.yaw_rate, &second.yaw_rate);
    first.accel_x = maybe(&first.accel_x, &second.accel_x);
    first.time.extend(second.time.iter().map(|t| t + shift));
    let rows = first.time.len();
    if let Some(segment) = first.segments.first_mut() {
        segment.rows.end = rows;
    }
    first
}

/// Samples until a change of soil is named and stays so, on line.
pub(super) fn switch(bench: &Bench) -> Result<Vec<Figure>, CliError> {
    const SOILS: [&str; 5] = [
        "dry_sand",
        "upland_sandy_loam",
        "lean_clay_22",
        "north_gower",
        "sandy_loam_mich_11",
    ];
    let mut out = Vec::new();
    // The published delays are those of side sums as they are; prewhitened, a residual that stays counts for a ninth.
    let schemes = [
        ("side-sum", true),
        ("side-sum, not prewhitened", false),
        ("imm", true),
    ]
    .map(|(case, prewhiten)| {
        let name = case.split(',').next().unwrap_or(case);
        let options = IdentifyOptions {
            estimator: Some(name.to_owned()),
            join: name == "imm",
            choice: Choice::online(),
            prewhiten,
            ..bench.options()
        };
        (case, options)
    });
    let mut cases = Vec::new();
    for from in SOILS {
        for to in SOILS.into_iter().filter(|to| *to != from) {
            let mut first = paper::torque_ramp(from, bench.seed)?;
            first.segments[0].duration = 1.0;
            let mut second = paper::torque_ramp(to, bench.seed)?;
            second.segments[0].duration = 1.0;
            let runs = cases.len()..cases.len() + bench.runs;
            cases.extend(runs.map(|run| (to, run, first.clone(), second.clone())));
        }
    }
    let delays: Vec<Vec<Option<Option<usize>>>> = cases
        .par_iter()
        .map(|(to, run, first, second)| {
            bench.stop.go_on()?;
            let drive = || -> Option<(DriveLog, usize)> {
                let (mut first, mut second) = (first.clone(), second.clone());
                (first.run, second.run) = (2 * *run as u64, 2 * *run as u64 + 1);
                let mut longer = first.clone();
                longer.segments[0].duration = 1.01;
                let truth = simulate_drive(&longer, &bench.rover, &bench.registry)
                    .ok()?
                    .truth;
                let first = bench.log(&first)?;
                let n = first.time.len();
                second.segments[0].start = Some(StartMotion {
                    ground_speed: *truth.ground_speed.get(n)?,
                    wheel_speed: [0, 1, 2, 3]
                        .map(|q| truth.wheel_speed[q].get(n).copied().unwrap_or(0.0)),
                });
                let log = joined(first, &bench.log(&second)?, 1.0);
                Some((log, n))
            };
            let drive = drive();
            let one = |options: &IdentifyOptions| -> Option<Option<usize>> {
                let (log, at) = drive.as_ref()?;
                let id = bench.identify(log, options)?;
                let told = Told {
                    truth: (*to).to_owned(),
                    id,
                };
                let h = told.history()?;
                let named: Vec<bool> = (0..h.step.len())
                    .filter(|k| h.time[*k] >= log.time[*at] - 1e-9)
                    .map(|k| told.right_in_row(k) == Some(true))
                    .collect();
                // Delay: the first sample from which the new soil wins to the end.
                let stays = named.iter().rposition(|right| !right).map_or(0, |k| k + 1);
                Some((stays < named.len()).then_some(stays + 1))
            };
            Ok(schemes.iter().map(|(_, options)| one(options)).collect())
        })
        .collect::<Result<_, CliError>>()?;
    // Firm clay pulls little, so that its samples say little: it has a bound of its own.
    let into = [
        ("", 10.0, None),
        (", into stiff clay", 25.0, Some(true)),
        (", into other soils", 10.0, Some(false)),
    ];
    for (s, (name, _)) in schemes.iter().enumerate() {
        for (where_to, most, stiff) in into {
            let wanted = cases
                .iter()
                .zip(&delays)
                .filter(|((to, ..), _)| stiff.is_none_or(|stiff| (*to == "lean_clay_22") == stiff));
            let told: Vec<Option<usize>> = wanted.filter_map(|(_, d)| d[s]).collect();
            let mut found: Vec<usize> = told.iter().flatten().copied().collect();
            found.sort_unstable();
            let n = told.len();
            let quantile = |q: f64| {
                let place = (found.len() as f64 * q) as usize;
                let place = place.min(found.len().saturating_sub(1));
                found.get(place).map(|d| *d as f64)
            };
            for (what, q, known) in [("median", 0.5, most), ("p90", 0.9, 30.0)] {
                let figure = format!("{what} delay (samples){where_to}");
                let asked = stiff.map_or(q > 0.5, |_| q < 0.9);
                out.push(Figure {
                    asked: asked.then_some(Asked::AtMost(known)),
                    ..number("switch", name, &figure, quantile(q), n, Some(known))
                });
            }
            if stiff.is_none() {
                let right = "right at end".to_owned();
                let row = rate("switch", name, right, found.len(), n, Some(1.0));
                out.push(row.asked(Asked::AtLeast(1.0)));
            }
        }
    }
    Ok(out)
}
