//! Scenario files, and a short run of what they say.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::Rover;
use terra_fuzz::{check_drive, check_rig, rigs, rovers, run};
use terra_model::Registry;
use terra_sim::{Scenario, simulate_drive, simulate_rig};

static REGISTRY: LazyLock<Registry> = LazyLock::new(Registry::builtin);
static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static RIGS: LazyLock<[Rover; 2]> = LazyLock::new(rigs);

/// Longest drive \[s\] and most points of a rig that are run: an input may take a second.
const LONGEST: f64 = 0.01;
const MOST_POINTS: usize = 8;

fuzz_target!(|data: &[u8]| run(|| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let Ok(scenario) = Scenario::parse(text, "x") else {
        return;
    };
    assert_ne!(scenario.segments.is_empty(), scenario.trials.is_empty());
    let duration: f64 = scenario.segments.iter().map(|s| s.duration).sum();
    let points: usize = scenario
        .trials
        .iter()
        .map(|t| t.slip.len() * t.normal_load.len() * t.repeats as usize)
        .sum();
    if scenario.trials.is_empty() {
        assert!(scenario.rate > 0.0 && scenario.rate.is_finite());
        if duration <= LONGEST
            && duration * scenario.rate <= 20.0
            && let Ok(done) = simulate_drive(&scenario, &ROVERS[0], &REGISTRY)
        {
            check_drive(&done.log, &ROVERS[0]);
        }
    } else if points <= MOST_POINTS
        && let Ok(done) = simulate_rig(&scenario, &RIGS[0], &REGISTRY)
    {
        check_rig(&done.log, &RIGS[0]);
    }
}));
