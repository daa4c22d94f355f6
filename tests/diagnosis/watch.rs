//! A long drive watched: quiet where nothing changes, flagged soon after something does, and not before.

use std::path::Path;

use terra::data::{DriveLog, Rover, Start, parse_rover, read_rover};
use terra::gap::{
    BaselineSpan, Provenance, Watch, WatchEvent, WatchSettings, WatchStep, watch_json,
};
use terra::model::Registry;
use terra::sim::{Command, DriveSegment, Patch, Profile, Scenario, StartMotion, simulate_drive};

use crate::part;

/// When the torque sensors go wrong \[s\].
const STEP: f64 = 40.0;

pub(crate) fn rover() -> Rover {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drive");
    read_rover(folder.join("rover.toml")).unwrap()
}

fn even(from: f64, to: f64) -> [Profile; 4] {
    [Profile { from, to }; 4]
}

/// A patrol of rounds of 15 s: faster, front against rear wheels, slower, without a stop between.
pub(crate) fn patrol(rounds: usize, seed: u64) -> Scenario {
    patrol_at(1.0, rounds, seed)
}

/// The same so many times as fast.
fn patrol_at(pace: f64, rounds: usize, seed: u64) -> Scenario {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drive");
    let mut scenario = Scenario::read(&folder.join("rich.toml")).unwrap();
    scenario.seed = seed;
    scenario.effects.clear();
    scenario.segments.clear();
    let still = |v| Profile { from: v, to: v };
    let (fast, slow) = (5.0 * pace, 3.0 * pace);
    for round in 0..rounds {
        let behind = still(3.4 * pace);
        let fight = [still(fast), still(fast), behind, behind];
        for (name, command) in [
            ("faster", even(slow, fast)),
            ("fight", fight),
            ("slower", even(fast, slow)),
        ] {
            let name = format!("{name} {round}");
            let mut segment = DriveSegment::new(name, 5.0, Command::WheelSpeed(command));
            if scenario.segments.is_empty() {
                segment.start = Some(StartMotion {
                    ground_speed: 0.7 * pace,
                    wheel_speed: [slow; 4],
                });
            }
            scenario.segments.push(segment);
        }
    }
    scenario
}

fn simulated(scenario: &Scenario) -> DriveLog {
    simulate_drive(scenario, &rover(), &Registry::builtin())
        .unwrap()
        .log
}

/// Torque sensors that read so many times too much from a moment on.
fn with_wrong_torques(mut log: DriveLog, from: f64, factor: f64) -> DriveLog {
    let times = log.time.clone();
    for series in log.wheel_torque.iter_mut().flatten() {
        *series = series
            .iter()
            .zip(&times)
            .map(|(v, t)| v.map(|v| if *t >= from { v * factor } else { v }))
            .collect();
    }
    log
}

fn settings() -> WatchSettings {
    WatchSettings {
        baseline: BaselineSpan::Seconds(30.0),
        ..WatchSettings::default()
    }
}

struct Watched {
    watch: Watch,
    steps: Vec<WatchStep>,
    events: Vec<WatchEvent>,
}

fn watched(pieces: &[DriveLog]) -> Watched {
    let mut watch = Watch::new(&rover(), &Registry::builtin(), &settings()).unwrap();
    let mut steps = vec![];
    for piece in pieces {
        steps.extend(watch.push(piece).unwrap());
    }
    steps.extend(watch.finish().unwrap());
    let events = steps.iter().filter_map(|s| s.closed.clone()).collect();
    Watched {
        watch,
        steps,
        events,
    }
}

fn json(w: &Watched) -> String {
    watch_json(&w.watch, &w.events, &Provenance::default()).to_string()
}

/// The claim is that at most one log in twenty raises an event. Of six it may be one by chance (probability of two or more at
/// 5 %: 3 %); the long run is [`nulls_stay_quiet_at_the_stated_rate`].
#[test]
fn a_log_in_which_nothing_changes_stays_quiet() {
    let loud = loud_nulls(1.0, 0..6, 4);
    assert!(loud <= 1, "{loud} of 6");
}

/// The same at a quarter of a metre a second, where the noise of slip is five times as large: it is in the signature of whatever
/// follows slip as well as in the residual, and must not add up.
#[test]
fn a_slow_log_in_which_nothing_changes_stays_quiet() {
    let loud = loud_nulls(0.2, 0..6, 6);
    assert!(loud <= 1, "{loud} of 6");
}

/// 200 logs of 90 s. At 5 % each, more than 18 loud ones have a probability of 1 %.
#[test]
#[ignore = "a campaign of minutes"]
fn nulls_stay_quiet_at_the_stated_rate() {
    let loud = loud_nulls(1.0, 1000..1200, 6);
    println!("{loud} of 200 nulls raise an event");
    assert!(loud <= 18, "{loud} of 200");
}

fn loud_nulls(pace: f64, seeds: std::ops::Range<u64>, rounds: usize) -> usize {
    seeds
        .filter(|seed| {
            let w = watched(&[simulated(&patrol_at(pace, rounds, *seed))]);
            assert_eq!(w.watch.refused(), None);
            for e in &w.events {
                println!(
                    "{seed}: {} {:.2} over {:.2} after {:.1} s",
                    e.score, e.sigma, e.threshold, e.delay_s
                );
            }
            !w.events.is_empty()
        })
        .count()
}

/// Torque sensors that read 15 % more from 40 s on. An even chance to be flagged is promised for one prior sd (12 %) after the
/// expected delay; 15 % must be flagged within twice that.
#[test]
fn a_torque_sensor_that_goes_wrong_is_flagged_in_time_and_not_before() {
    let w = watched(&[with_wrong_torques(simulated(&patrol(4, 21)), STEP, 1.15)]);
    let first = &w.events[0];
    let baseline = w.watch.baseline().unwrap();
    let expected = baseline
        .expected_delay
        .iter()
        .find(|d| d.effect == "torque-scale")
        .and_then(|d| d.delay_s)
        .expect("a scale of 12 % can be seen");
    println!("{first:?} expected {expected}");
    assert!(first.flagged.time_s > STEP, "{first:?}");
    assert!(
        first.flagged.time_s < STEP + 2.0 * expected,
        "{first:?} {expected}"
    );
    assert!((first.onset.time_s - STEP).abs() < 2.0, "{first:?}");
    assert!((first.delay_s - (first.flagged.time_s - first.onset.time_s) - 0.2).abs() < 1e-6);
    assert!(first.channel.starts_with("wheel_torque"), "{first:?}");
    assert!(first.closed.is_none(), "it stays: {first:?}");
    let hint = first.nearest.iter().find(|h| h.effect == "torque-scale");
    let hint = hint.expect("torque-scale is among the hints");
    // The effect's e has T_true = (1 + e) T_reported.
    assert!(
        (hint.magnitude - (1.0 / 1.15 - 1.0)).abs() < 0.05,
        "{hint:?}"
    );
    let opened = w.steps.iter().filter(|s| s.opened.is_some()).count();
    assert_eq!(opened, w.events.len());
}

/// Dry sand gives way to lean clay after 30 m: flagged within 5 s, where it is.
#[test]
fn another_soil_along_the_path_is_flagged_where_it_begins() {
    let mut scenario = patrol(4, 22);
    let clay = || Start::Id("lean_clay_22".to_owned());
    scenario.world.patches = vec![Patch {
        from: 36.0,
        blend: 0.5,
        terrain: [clay(), clay(), clay(), clay()],
    }];
    let w = watched(&[simulated(&scenario)]);
    let first = &w.events[0];
    println!("{first:?}");
    // The front wheels, .3 m ahead of the centre of mass, meet it first.
    assert!(first.flagged.path_m > 35.0, "{first:?}");
    assert!((first.onset.path_m - 36.0).abs() < 3.0, "{first:?}");
    assert!(first.delay_s < 5.0, "{first:?}");
    assert_eq!(first.nearest[0].effect, "soil-change", "{first:?}");
}

/// What is wrong for a while is over when it ends.
#[test]
fn an_event_closes_when_its_cause_is_gone() {
    let log = simulated(&patrol(5, 23));
    let wrong = with_wrong_torques(log, STEP, 1.3);
    let log = with_wrong_torques(wrong, STEP + 10.0, 1.0 / 1.3);
    let w = watched(&[log]);
    assert_eq!(w.events.len(), 1, "{:?}", w.events);
    let closed = w.events[0].closed.as_ref().expect("it is over");
    assert!(
        closed.time_s > STEP + 10.0 && closed.time_s < STEP + 34.0,
        "{closed:?}"
    );
}

/// Where pieces end and how many threads there are cannot matter: the same bytes.
#[test]
fn pieces_and_threads_change_nothing() {
    let log = with_wrong_torques(simulated(&patrol(3, 24)), 35.0, 1.2);
    let whole = watched(std::slice::from_ref(&log));
    assert!(!whole.events.is_empty());
    let sizes = [1, 19, 20, 21, 733, 1, 1500];
    let mut pieces = vec![];
    let mut from = 0;
    for size in sizes.into_iter().cycle() {
        let to = (from + size).min(log.time.len());
        pieces.push(part(&log, from, to));
        from = to;
        if from == log.time.len() {
            break;
        }
    }
    let cut = watched(&pieces);
    assert_eq!(json(&whole), json(&cut));
    let looks = |w: &Watched| -> Vec<String> {
        let text = |s: &WatchStep| format!("{:?} {:?}", s.at, s.looks);
        w.steps.iter().map(text).collect()
    };
    assert_eq!(looks(&whole), looks(&cut));
}

#[test]
fn what_cannot_be_watched_says_why() {
    let mut named = WatchSettings {
        baseline: BaselineSpan::Segment("fight 0".to_owned()),
        ..settings()
    };
    let run = |settings: &WatchSettings| {
        let mut watch = Watch::new(&rover(), &Registry::builtin(), settings).unwrap();
        watch.push(&simulated(&patrol(1, 25))).unwrap();
        watch.finish().map(|_| watch.refused().map(str::to_owned))
    };
    let reason = run(&named).unwrap().expect("24 windows are too few");
    assert!(reason.contains("usable windows"), "{reason}");
    named.baseline = BaselineSpan::Segment("fihgt".to_owned());
    let error = run(&named).expect_err("no such segment").to_string();
    assert!(
        error.contains("'fihgt'") && error.contains("fight 0"),
        "{error}"
    );
    named.baseline = BaselineSpan::Seconds(60.0);
    let mut watch = Watch::new(&rover(), &Registry::builtin(), &named).unwrap();
    watch.push(&simulated(&patrol(2, 25))).unwrap();
    watch.finish().unwrap();
    let reason = watch.refused().expect("a baseline longer than the log");
    assert!(reason.contains("nothing was watched"), "{reason}");
    for (baseline, alarms) in [(-1.0, 0.05), (f64::NAN, 0.05), (20.0, 0.0), (20.0, 1.0)] {
        let wrong = WatchSettings {
            baseline: BaselineSpan::Seconds(baseline),
            false_alarms: alarms,
            effects: None,
        };
        assert!(Watch::new(&rover(), &Registry::builtin(), &wrong).is_err());
    }
    let rig = parse_rover(
        "[wheel]\nradius_m = 0.2\nwidth_m = 0.1\n[terrain]\nmodel = \"wong-reece\"\n[noise]\n",
        "rig.toml",
    );
    assert!(Watch::new(&rig.unwrap(), &Registry::builtin(), &settings()).is_err());
}
