//! Soils near those of the set: does the nearest one win, and what does refinement make of it?

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use terra_data::Start;
use terra_model::{Contact, ForceLaw, catalogue};
use terra_sim::paper;

use super::{Bench, Figure, Told, number, rate, share};
use crate::error::CliError;
use crate::identify::IdentifyOptions;

/// Truths 10 % off a soil of the set: does its own copy win, and what does refinement make of the force at a load that
/// was never driven?
pub(super) fn perturbed(bench: &Bench) -> Result<Vec<Figure>, CliError> {
    const WITHHELD: f64 = 400.0;
    let published = [
        ("dry_sand", 0.95, 0.995, 0.014),
        ("upland_sandy_loam", 0.63, 0.78, 0.013),
        ("lean_clay_22", 0.39, 0.44, 0.009),
    ];
    let car = &bench.rover.wheel;
    let mut out = Vec::new();
    for (soil, at_2, at_end, error) in published {
        let base = catalogue::find(soil)?.parameters(bench.law.model())?;
        let options = IdentifyOptions {
            refine: true,
            ..bench.options()
        };
        let told: Vec<Option<(Told, Option<f64>)>> = (0..bench.runs)
            .into_par_iter()
            .map(|run| {
                let mut rng = ChaCha8Rng::seed_from_u64(bench.seed);
                rng.set_stream(u64::MAX - run as u64);
                let truth: Vec<f64> = base
                    .iter()
                    .map(|p| {
                        let z: f64 = StandardNormal.sample(&mut rng);
                        p * (1.0 + 0.1 * z)
                    })
                    .collect();
                let torque = |slip: f64| {
                    let at = Contact::new(slip, 245.25, car.radius, car.width);
                    bench
                        .law
                        .forces(&truth, &at)
                        .ok()
                        .map(|f| f.resistive_torque)
                };
                let names = bench.law.params().iter().map(|p| p.name.to_owned());
                let values: BTreeMap<String, f64> = names.zip(truth.iter().copied()).collect();
                let mut scenario = paper::torque_ramp(soil, bench.seed).ok()?;
                scenario.run = run as u64;
                (scenario.left, scenario.right) =
                    (Start::Values(values.clone()), Start::Values(values));
                let profile = terra_sim::Profile {
                    from: 1.15 * torque(1.0)?,
                    to: 1.02 * torque(0.05)?,
                };
                scenario.segments[0].command = terra_sim::Command::Torque([profile; 4]);
                let id = bench.identify(&bench.log(&scenario)?, &options)?;
                let refined = id
                    .groups
                    .first()
                    .and_then(|g| g.refined.as_ref().ok())
                    .map(|r| r.fit.parameters());
                let off = refined.and_then(|fitted| {
                    let mut errors = Vec::new();
                    for slip in [0.1, 0.2, 0.4, 0.6, 0.8] {
                        let at = Contact::new(slip, WITHHELD, car.radius, car.width);
                        let (a, b) = (
                            bench.law.forces(&truth, &at).ok()?,
                            bench.law.forces(&fitted, &at).ok()?,
                        );
                        let size = a.drawbar_pull.abs() + a.resistive_torque / car.radius;
                        errors.push((a.drawbar_pull - b.drawbar_pull).abs() / size);
                        errors.push((a.resistive_torque / b.resistive_torque - 1.0).abs());
                    }
                    median(errors)
                });
                Some((
                    Told {
                        truth: soil.to_owned(),
                        id,
                    },
                    off,
                ))
            })
            .collect();
        let told: Vec<(Told, Option<f64>)> = told.into_iter().flatten().collect();
        for (what, k, known) in [
            ("own copy @2", Some(2), at_2),
            ("own copy at end", None, at_end),
        ] {
            let (good, n) = share(told.iter().map(|t| &t.0), |t| t.right(k));
            out.push(rate(
                "perturbed",
                soil,
                what.to_owned(),
                good,
                n,
                Some(known),
            ));
        }
        let errors: Vec<f64> = told.iter().filter_map(|t| t.1).collect();
        let n = errors.len();
        out.push(number(
            "perturbed",
            soil,
            "refined force error at 400 N",
            median(errors),
            n,
            Some(error),
        ));
    }
    Ok(out)
}

fn median(mut x: Vec<f64>) -> Option<f64> {
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied()
}
