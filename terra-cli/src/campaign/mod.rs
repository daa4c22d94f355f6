//! Campaigns: many runs with known truth, and how often the answer was right.

pub(crate) mod cross;
pub mod faults;
mod reproduction;
pub(crate) mod targets;

pub use reproduction::{Asked, Figure, reason, reproduction};

use rayon::prelude::*;
use serde::Serialize;
use terra_model::{Registry, catalogue};
use terra_sim::{Command, Profile, paper, simulate_drive};

use crate::error::CliError;
use crate::identify::{IdentifyOptions, identify_drive};
use crate::progress::Stop;

/// A rate with its Wilson 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Right answers over answers.
    pub value: f64,
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
    /// Answers.
    pub n: usize,
}

impl Rate {
    /// The rate of `right` in `n`.
    ///
    /// # Reference
    /// E. B. Wilson, J. American Statistical Association 22(158):209-212, 1927.
    pub fn new(right: usize, n: usize) -> Self {
        let (k, m, z) = (right as f64, n.max(1) as f64, 1.959_964);
        let p = k / m;
        let middle = (p + z * z / (2.0 * m)) / (1.0 + z * z / m);
        let half = z / (1.0 + z * z / m) * (p * (1.0 - p) / m + z * z / (4.0 * m * m)).sqrt();
        Rate {
            value: p,
            lo: (middle - half).max(0.0),
            hi: (middle + half).min(1.0),
            n,
        }
    }
}

/// One soil of a campaign of torque ramps.
#[derive(Clone, Debug, Serialize)]
pub struct RampRow {
    /// True soil.
    pub terrain: String,
    /// Right after so many samples behind the filter's start; a ramp too short for one has none.
    pub right_after: Vec<(usize, Rate)>,
    /// Right at the end.
    pub right_at_end: Rate,
    /// Runs that could not be made, with the first reason.
    pub failed: (usize, Option<String>),
}

/// Samples behind the filter's start at which a campaign looks.
pub const LOOK_AT: [usize; 6] = [1, 2, 5, 10, 20, 50];

/// Torque ramps of the light robot of Ray 2008 on each soil, `runs` noise draws each, identified among `wong21`; the
/// answer is that of the left side. `seconds` of the 2 s ramp are driven. Same seed, same rates, on any number of
/// threads.
///
/// # Errors
/// An unknown soil, an end asked for.
pub fn ramps(
    terrains: &[&str],
    runs: usize,
    seed: u64,
    seconds: f64,
    stop: &Stop,
) -> Result<Vec<RampRow>, CliError> {
    let rover = paper::light_rover();
    let registry = Registry::builtin();
    let hypotheses = catalogue::set("wong21")?;
    let options = IdentifyOptions {
        history: true,
        refine: false,
        check: false,
        ..IdentifyOptions::default()
    };
    terrains
        .iter()
        .map(|&terrain| {
            let scenario = paper::torque_ramp(terrain, seed)?;
            let answer = |run: usize| -> Result<Vec<String>, String> {
                let mut scenario = scenario.clone();
                scenario.run = run as u64;
                for segment in &mut scenario.segments {
                    shorten(segment, seconds);
                }
                let log = simulate_drive(&scenario, &rover, &registry)
                    .map_err(|e| e.to_string())?
                    .log;
                let id = identify_drive(&log, &rover, &registry, &hypotheses, &options)
                    .map_err(|e| e.to_string())?;
                let history = id.groups.into_iter().next().and_then(|g| g.history);
                let history = history.ok_or("no history")?;
                Ok(history
                    .probability
                    .iter()
                    .map(|p| {
                        let best = (0..p.len()).max_by(|&a, &b| p[a].total_cmp(&p[b]));
                        best.map(|k| history.ids[k].clone()).unwrap_or_default()
                    })
                    .collect())
            };
            let answers: Vec<Result<Vec<String>, String>> = (0..runs)
                .into_par_iter()
                .map(|run| stop.go_on().map(|()| answer(run)))
                .collect::<Result<_, CliError>>()?;
            let told: Vec<&Vec<String>> = answers.iter().filter_map(|a| a.as_ref().ok()).collect();
            let right = |pick: &dyn Fn(&Vec<String>) -> Option<String>| {
                let picked: Vec<String> = told.iter().filter_map(|a| pick(a)).collect();
                let good = picked.iter().filter(|id| id.as_str() == terrain).count();
                (!picked.is_empty()).then(|| Rate::new(good, picked.len()))
            };
            let first_failure = answers.iter().find_map(|a| a.as_ref().err().cloned());
            Ok(RampRow {
                terrain: terrain.to_owned(),
                right_after: LOOK_AT
                    .iter()
                    .filter_map(|&k| Some((k, right(&|a| a.get(k - 1).cloned())?)))
                    .collect(),
                right_at_end: right(&|a| a.last().cloned()).unwrap_or(Rate::new(0, 0)),
                failed: (answers.len() - told.len(), first_failure),
            })
        })
        .collect()
}

/// The first `seconds` of a segment, its torques as they were.
fn shorten(segment: &mut terra_sim::DriveSegment, seconds: f64) {
    let share = (seconds / segment.duration).min(1.0);
    let cut = |p: &mut Profile| p.to = p.at(share);
    match &mut segment.command {
        Command::Torque(profiles) | Command::WheelSpeed(profiles) => {
            profiles.iter_mut().for_each(cut);
        }
    }
    segment.duration *= share;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wilson's interval for 9 of 10, by the textbook formula: .596 to .982.
    #[test]
    fn wilson_interval_by_hand() {
        let r = Rate::new(9, 10);
        assert!(
            (r.lo - 0.5958).abs() < 1e-3 && (r.hi - 0.9821).abs() < 1e-3,
            "{r:?}"
        );
    }

    /// The short version of `terra campaign ramps`: 20 draws on the three soils of the paper, right within 2 samples.
    #[test]
    fn ramps_are_identified_within_two_samples() {
        let soils = ["dry_sand", "upland_sandy_loam", "lean_clay_22"];
        for row in ramps(&soils, 20, 1, 0.3, &Stop::default()).unwrap() {
            assert_eq!(row.failed.0, 0, "{:?}", row.failed.1);
            let (_, rate) = row.right_after.iter().find(|(k, _)| *k == 2).unwrap();
            assert_eq!(rate.n, 20);
            // The rate is .97 or more over 200 draws; 18 of 20 or fewer has a chance of 2 % then.
            assert!(rate.value >= 0.9, "{}: {rate:?}", row.terrain);
        }
    }

    /// What was asked to end draws nothing more.
    #[test]
    fn every_campaign_can_be_ended() {
        let stop = Stop::default();
        stop.stop();
        let ended = |e: CliError| matches!(e, CliError::Stopped);
        let many = 1_000_000;
        assert!(ended(
            ramps(&["dry_sand"], many, 1, 2.0, &stop).unwrap_err()
        ));
        assert!(ended(faults::faults(1, 1, "block", &stop).unwrap_err()));
        for table in ["exact", "switch", "perturbed", "mismatch"] {
            let tables = [table.to_owned()];
            assert!(ended(reproduction(2, 1, &tables, &stop).unwrap_err()));
        }
    }
}
