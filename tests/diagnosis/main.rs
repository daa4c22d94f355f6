//! Diagnoses of logs whose answer is known, made by the truth simulator, and of measured ones.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod contrast;
mod measured;
mod properties;
mod rig;
mod several;
mod vehicle;
mod watch;

use terra::data::{Rover, parse_rover};
use terra::gap::Diagnosis;

/// A rig with the noise of a good testbed.
fn rig() -> Rover {
    parse_rover(
        r#"
        [wheel]
        radius_m = 0.254
        width_m = 0.15
        [terrain]
        model = "wong-reece"
        start = "dry_sand"
        [noise]
        drawbar_pull_N = 0.5
        torque_N_m = 0.1
        sinkage_m = 0.001
        slip = 0.005
        normal_load_N = 0.5
        "#,
        "rig.toml",
    )
    .unwrap()
}

/// Probability of one answer, 0 when it is not among the causes.
fn probability(d: &Diagnosis, name: &str) -> f64 {
    d.causes
        .iter()
        .find(|c| c.name == name)
        .map_or(0.0, |c| c.probability)
}

fn total(d: &Diagnosis) -> f64 {
    d.causes.iter().map(|c| c.probability).sum::<f64>() + d.probability_none + d.probability_unknown
}
