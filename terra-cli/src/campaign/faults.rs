//! Faults of sensors, torques and clocks: is each flagged, does every number stay finite, is the filter itself again half
//! a second after the fault's end?

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use serde::Serialize;
use terra_ekf::spaces::longitudinal_robot::CHANNEL_NAMES;
use terra_ekf::{Consistency, Flag, ForceConfig, StateSpace, Step};
use terra_model::Registry;
use terra_sim::{paper, simulate_drive};

use super::Rate;
use crate::error::CliError;
use crate::progress::Stop;
use crate::robot::{Columns, prepare};

/// Soils of the campaign.
const SOILS: [&str; 3] = ["dry_sand", "upland_sandy_loam", "lean_clay_22"];
/// Row at which a fault begins; the ramp has 200.
const BEGIN: usize = 80;
/// Rows after a fault's end in which the filter may recover: half a second.
const RECOVERY: usize = 50;
const TORQUES: [&str; 4] = ["torque_fl", "torque_fr", "torque_rl", "torque_rr"];

/// What happens to the readings of one channel.
#[derive(Clone, Copy)]
enum Reading {
    Missing,
    Infinite,
    /// Off by so many 1-sigma.
    Off(f64),
    /// Every so many rows off by so many 1-sigma.
    Outliers(usize, f64),
    Value(f64),
    Stuck,
    /// Full scale: one and a half times the largest reading of the log, constant.
    Saturated,
    Times(f64),
}

#[derive(Clone, Copy)]
enum Fault {
    Channel(Reading, usize),
    AllMissing(usize),
    TorqueMissing(usize),
    TorqueValue(f64, usize),
    Duplicate,
    SameInstant,
    /// A row comes so many rows late.
    Late(usize),
    ClockJump(f64),
    RowsLost(usize),
}

const KINDS: [(&str, Fault); 25] = [
    ("missing, 1 sample", Fault::Channel(Reading::Missing, 1)),
    ("missing, .1 s", Fault::Channel(Reading::Missing, 10)),
    ("missing, .5 s", Fault::Channel(Reading::Missing, 50)),
    ("infinite, .1 s", Fault::Channel(Reading::Infinite, 10)),
    ("all sensors missing, .3 s", Fault::AllMissing(30)),
    ("outlier, 50 sigma", Fault::Channel(Reading::Off(50.0), 1)),
    (
        "outliers, 50 sigma, 5 %",
        Fault::Channel(Reading::Outliers(20, 50.0), 50),
    ),
    (
        "outliers, 1e6 sigma, 5 %",
        Fault::Channel(Reading::Outliers(20, 1e6), 50),
    ),
    ("1e300, .05 s", Fault::Channel(Reading::Value(1e300), 5)),
    (
        "-1e308, 1 sample",
        Fault::Channel(Reading::Value(-1e308), 1),
    ),
    ("stuck, .5 s", Fault::Channel(Reading::Stuck, 50)),
    ("saturated, .3 s", Fault::Channel(Reading::Saturated, 30)),
    (
        "offset 40 sigma, .3 s",
        Fault::Channel(Reading::Off(40.0), 30),
    ),
    ("wrong sign, .3 s", Fault::Channel(Reading::Times(-1.0), 30)),
    (
        "degrees for radians, .3 s",
        Fault::Channel(Reading::Times(57.295_779_513), 30),
    ),
    ("torque missing, .03 s", Fault::TorqueMissing(3)),
    ("torque missing, .5 s", Fault::TorqueMissing(50)),
    ("torque 1e300, .1 s", Fault::TorqueValue(1e300, 10)),
    ("row twice", Fault::Duplicate),
    ("two samples of one instant", Fault::SameInstant),
    ("row .1 s late", Fault::Late(10)),
    ("row .2 s late", Fault::Late(20)),
    ("clock 1 h ahead", Fault::ClockJump(3600.0)),
    ("clock 1 h back", Fault::ClockJump(-3600.0)),
    ("nine rows lost", Fault::RowsLost(9)),
];

/// How the filter took one kind of fault.
#[derive(Clone, Debug, Serialize)]
pub struct FaultRow {
    /// Kind.
    pub kind: String,
    /// Runs.
    pub runs: usize,
    /// Runs in which the fault could be known: some reading more than ten 1-sigma from the true one, or missing, repeated
    /// or out of time.
    pub knowable: usize,
    /// Of these, flagged under the faulty channel's name while the fault lasted.
    pub flagged: Rate,
    /// Runs whose NIS was nominal again .5 s after the fault's end: inside its 99.99 % band, or no more than 1.3 times
    /// that of the same rows without fault.
    pub recovered: Rate,
    /// Runs with a number that is not finite.
    pub not_finite: usize,
    /// Runs that ended with an error, with the first.
    pub refused: (usize, Option<String>),
    /// Runs that panicked.
    pub panics: usize,
}

/// All kinds, and all runs together.
#[derive(Clone, Debug, Serialize)]
pub struct FaultReport {
    /// One a kind.
    pub rows: Vec<FaultRow>,
    /// Their sum.
    pub total: FaultRow,
}

/// What was done to a log: the rows concerned afterwards, the name to be flagged, and whether it can be known.
struct Done {
    rows: Range<usize>,
    name: &'static str,
    knowable: bool,
}

#[derive(Clone, Default)]
struct Outcome {
    knowable: bool,
    flagged: bool,
    recovered: bool,
    not_finite: bool,
    refused: Option<String>,
    panicked: bool,
}

fn spoil(log: &mut Columns, fault: Fault, channel: usize, sd: f64) -> Done {
    let name = CHANNEL_NAMES[channel];
    let wheel = channel % 4;
    match fault {
        Fault::Channel(reading, rows) => {
            let rows = BEGIN..BEGIN + rows;
            let column = &mut log.channels[channel];
            let clean = column.clone();
            let most = clean.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
            for k in rows.clone() {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                column[k] = match reading {
                    Reading::Missing => Some(f64::NAN),
                    Reading::Infinite => Some(sign * f64::INFINITY),
                    Reading::Off(size) => clean[k].map(|v| v + size * sd),
                    Reading::Outliers(every, size) if (k - BEGIN).is_multiple_of(every) => {
                        clean[k].map(|v| v + size * sd)
                    }
                    Reading::Outliers(..) => clean[k],
                    Reading::Value(value) => Some(value),
                    Reading::Stuck => clean[BEGIN],
                    Reading::Saturated => Some(1.5 * most),
                    Reading::Times(factor) => clean[k].map(|v| v * factor),
                };
            }
            let told = |k: usize| match (column[k], clean[k]) {
                (Some(now), Some(was)) => {
                    // NaN and infinity are no readings, and so known.
                    let near = (now - was).abs() <= 10.0 * sd;
                    !near
                }
                _ => true,
            };
            let stuck = matches!(reading, Reading::Stuck);
            let knowable = stuck || rows.clone().any(told);
            Done {
                rows,
                name,
                knowable,
            }
        }
        Fault::AllMissing(rows) => {
            let rows = BEGIN..BEGIN + rows;
            for column in &mut log.channels {
                column[rows.clone()].fill(None);
            }
            Done {
                rows,
                name,
                knowable: true,
            }
        }
        Fault::TorqueMissing(rows) => {
            let rows = BEGIN..BEGIN + rows;
            log.torque[wheel][rows.clone()].fill(None);
            Done {
                rows,
                name: TORQUES[wheel],
                knowable: true,
            }
        }
        Fault::TorqueValue(value, rows) => {
            let rows = BEGIN..BEGIN + rows;
            log.torque[wheel][rows.clone()].fill(Some(value));
            Done {
                rows,
                name: TORQUES[wheel],
                knowable: true,
            }
        }
        Fault::Duplicate => {
            let n = log.time.len();
            let mut order: Vec<usize> = (0..n).collect();
            order.insert(BEGIN + channel, BEGIN + channel);
            reorder(log, &order);
            at(BEGIN + channel + 1)
        }
        Fault::SameInstant => {
            log.time[BEGIN + channel] = log.time[BEGIN + channel - 1];
            at(BEGIN + channel)
        }
        Fault::Late(by) => {
            let mut order: Vec<usize> = (0..log.time.len()).collect();
            order[BEGIN + channel..=BEGIN + channel + by].rotate_left(1);
            reorder(log, &order);
            at(BEGIN + channel + by)
        }
        Fault::ClockJump(by) => {
            log.time[BEGIN + channel..]
                .iter_mut()
                .for_each(|t| *t += by);
            at(BEGIN + channel)
        }
        Fault::RowsLost(rows) => {
            let lost = BEGIN + channel..BEGIN + channel + rows;
            let order: Vec<usize> = (0..log.time.len()).filter(|k| !lost.contains(k)).collect();
            reorder(log, &order);
            at(BEGIN + channel)
        }
    }
}

/// A fault of one row's clock.
fn at(row: usize) -> Done {
    Done {
        rows: row..row + 1,
        name: "time",
        knowable: true,
    }
}

fn reorder(log: &mut Columns, order: &[usize]) {
    let pick = |v: &mut Vec<Option<f64>>| {
        if !v.is_empty() {
            *v = order.iter().map(|&k| v[k]).collect();
        }
    };
    log.time = order.iter().map(|&k| log.time[k]).collect();
    log.torque.iter_mut().for_each(pick);
    log.channels.iter_mut().for_each(pick);
    log.segments = std::iter::once(0..order.len()).collect();
}

fn names(flag: &Flag) -> &[&'static str] {
    match flag {
        Flag::Ok | Flag::Starting => &[],
        Flag::Reset(n) | Flag::NotObservable(n) | Flag::Degraded(n) => n,
    }
}

/// NIS over its degrees of freedom from `from` on, and the upper end of its band.
fn nis(steps: &[Step], from: usize) -> Option<(f64, f64)> {
    let mut c = Consistency::new();
    for step in steps.get(from..)? {
        c.add(&step.innovation);
    }
    Some((c.mean()?, c.band(0.9999)?.1))
}

fn run(clean: &Columns, config: &ForceConfig, fault: Fault, channel: usize) -> Outcome {
    let sd = StateSpace::measurement_noise(&config.space)[(channel, channel)].sqrt();
    let mut log = clean.clone();
    let done = spoil(&mut log, fault, channel, sd);
    let mut outcome = Outcome {
        knowable: done.knowable,
        ..Outcome::default()
    };
    let estimate = |log: &Columns| catch_unwind(AssertUnwindSafe(|| log.estimate(config)));
    let (steps, without) = match (estimate(&log), estimate(clean)) {
        (Ok(Ok(steps)), Ok(Ok(without))) => (steps, without),
        (Ok(Err(e)), _) | (_, Ok(Err(e))) => {
            outcome.refused = Some(e.to_string());
            return outcome;
        }
        _ => {
            outcome.panicked = true;
            return outcome;
        }
    };
    outcome.not_finite = !steps.iter().all(|s| {
        let b = &s.belief;
        s.nis.is_finite()
            && b.mean
                .iter()
                .chain(b.covariance.iter())
                .all(|v| v.is_finite())
            && s.innovation.ratio.iter().flatten().all(|r| r.is_finite())
    });
    // A clock that jumped is a restart: it names nothing, and nothing else restarts.
    let jumped = |flag: &Flag| done.name == "time" && *flag == Flag::Reset(Vec::new());
    outcome.flagged = done.rows.clone().any(|k| {
        steps
            .get(k)
            .is_some_and(|s| names(&s.flag).contains(&done.name) || jumped(&s.flag))
    });
    let from = done.rows.end + RECOVERY;
    let clean_nis = nis(&without, from.min(without.len().saturating_sub(1))).map(|n| n.0);
    outcome.recovered = nis(&steps, from)
        .is_some_and(|(mean, high)| mean <= high || clean_nis.is_some_and(|c| mean <= 1.3 * c));
    outcome
}

fn row(kind: &str, outcomes: &[Outcome]) -> FaultRow {
    let count = |pick: fn(&Outcome) -> bool| outcomes.iter().filter(|o| pick(o)).count();
    let knowable = count(|o| o.knowable);
    let refused: Vec<&String> = outcomes.iter().filter_map(|o| o.refused.as_ref()).collect();
    FaultRow {
        kind: kind.to_owned(),
        runs: outcomes.len(),
        knowable,
        flagged: Rate::new(count(|o| o.knowable && o.flagged), knowable),
        recovered: Rate::new(count(|o| o.recovered), outcomes.len()),
        not_finite: count(|o| o.not_finite),
        refused: (refused.len(), refused.first().map(|e| (*e).clone())),
        panics: count(|o| o.panicked),
    }
}

/// Every kind of fault in every channel on every soil, in as many draws as make at least `runs` runs. Same seed, same
/// figures, on any number of threads.
///
/// # Errors
/// An unknown filter, an end asked for.
pub fn faults(runs: usize, seed: u64, filter: &str, stop: &Stop) -> Result<FaultReport, CliError> {
    let rover = paper::light_rover();
    let registry = Registry::builtin();
    let draws = runs.div_ceil(KINDS.len() * CHANNEL_NAMES.len() * SOILS.len());
    let mut drives = Vec::new();
    for soil in SOILS {
        let scenario = paper::torque_ramp(soil, seed)?;
        for draw in 0..draws {
            let mut scenario = scenario.clone();
            scenario.run = draw as u64;
            drives.push(scenario);
        }
    }
    let logs: Vec<(Columns, ForceConfig)> = drives
        .par_iter()
        .map(|scenario| {
            stop.go_on()?;
            let log = simulate_drive(scenario, &rover, &registry)?.log;
            prepare(&log, &rover, filter, false)
        })
        .collect::<Result<_, CliError>>()?;
    let jobs: Vec<(usize, usize, usize)> = (0..KINDS.len())
        .flat_map(|kind| {
            (0..CHANNEL_NAMES.len())
                .flat_map(move |c| (0..SOILS.len() * draws).map(move |d| (kind, c, d)))
        })
        .collect();
    let outcomes: Vec<Outcome> = jobs
        .par_iter()
        .map(|&(kind, channel, drive)| {
            stop.go_on()?;
            let (columns, config) = &logs[drive];
            Ok(run(columns, config, KINDS[kind].1, channel))
        })
        .collect::<Result<_, CliError>>()?;
    let each = CHANNEL_NAMES.len() * SOILS.len() * draws;
    let rows = KINDS
        .iter()
        .zip(outcomes.chunks(each))
        .map(|((kind, _), outcomes)| row(kind, outcomes))
        .collect();
    Ok(FaultReport {
        rows,
        total: row("all", &outcomes),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The short version of `terra campaign faults`: every kind, channel and soil once. The limits are those of the
    /// campaign: nothing panics, nothing is not finite, all is flagged, 99 % recover.
    #[test]
    fn faults_are_flagged_and_survived() {
        let report = faults(1, 1, "block", &Stop::default()).unwrap();
        let t = &report.total;
        assert_eq!(t.runs, 525);
        assert_eq!((t.panics, t.not_finite, t.refused.0), (0, 0, 0), "{t:?}");
        for row in &report.rows {
            assert!(row.knowable == 0 || row.flagged.value == 1.0, "{row:?}");
        }
        assert!(t.recovered.value >= 0.99, "{t:?}");
    }
}
