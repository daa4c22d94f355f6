//! A log that goes through twice, row by row, instead of lying in memory.

use proptest::prelude::*;
use terra_ekf::spaces::longitudinal_robot::{LongitudinalRobot, V, W};
use terra_ekf::{
    FilterError, FirstPass, Flag, ForceConfig, RobotLog, RobotRow, Step, estimate_forces,
};

use crate::common::rng;
use crate::driving::{drive, sensors};

fn config() -> ForceConfig {
    ForceConfig::new(LongitudinalRobot::light().unwrap())
}

/// Both passes over segments of rows; the steps are taken whenever `take` rows have gone in.
fn run(
    segments: &[Vec<RobotRow>],
    config: &ForceConfig,
    take: usize,
) -> Result<Vec<Step>, FilterError> {
    let mut first = FirstPass::new(config)?;
    for rows in segments {
        first.segment();
        rows.iter().for_each(|row| first.row(row));
    }
    let mut second = first.run()?;
    let (mut steps, mut new, mut k) = (Vec::new(), Vec::new(), 0);
    for rows in segments {
        second.segment(&mut new)?;
        for row in rows {
            second.row(row, &mut new)?;
            k += 1;
            if k % take == 0 {
                steps.append(&mut new);
            }
        }
    }
    second.finish(&mut new)?;
    steps.append(&mut new);
    Ok(steps)
}

/// A robot that rolls at .5 m/s, 20 samples a second.
fn rolling(rows: usize) -> Vec<RobotRow> {
    (0..rows)
        .map(|row| RobotRow {
            row,
            time: 0.05 * row as f64,
            torque: [Some(2.0); 4],
            channels: [0.0, 2.0, 2.0, 2.0, 2.0, 0.5, 0.0].map(Some),
            ..RobotRow::default()
        })
        .collect()
}

/// A speed that is missing where the filter starts begins at the next one there is, however far ahead that is, after a jump
/// of the clock as at the head, and never at one of the next segment.
#[test]
fn a_start_looks_as_far_ahead_as_it_must() {
    for hole in [1, 2, 254, 255, 256, 257, 258, 1025, 5000] {
        for start in [0, 1, 200, 700] {
            let mut rows = rolling(start + hole + 10);
            for row in &mut rows[start..] {
                row.time += 100.0;
            }
            for row in &mut rows[start..start + hole] {
                row.channels[5] = None;
                // No reading a robot can have is no reading.
                row.channels[2] = Some(1e9);
            }
            rows[start + hole].channels[5] = Some(0.7);
            rows[start + hole].channels[2] = Some(2.5);
            let steps = run(std::slice::from_ref(&rows), &config(), 64).unwrap();
            let at = &steps[start];
            assert_eq!(at.since_start, 0);
            assert!((at.belief.mean[V] - 0.7).abs() < 1e-9, "{hole} {start}");
            assert!((at.belief.mean[W[1]] - 2.5).abs() < 1e-9, "{hole} {start}");

            let (head, tail) = rows.split_at(start + hole);
            let steps = run(&[head.to_vec(), tail.to_vec()], &config(), 64);
            // Without any speed in its segment there is none to begin at.
            if start == 0 {
                assert_eq!(steps.unwrap()[0].belief.mean[V], 0.0, "{hole}");
            }
        }
    }
}

/// The usual step is the segment's own, known at its first row: the same pause of .2 s is a hole among steps of .05 s, and
/// none among steps of .1 s.
#[test]
fn what_is_said_of_a_segment_holds_from_its_first_row() {
    let mut fast = rolling(200);
    let mut slow = rolling(200);
    slow.iter_mut().for_each(|r| r.time *= 2.0);
    for rows in [&mut fast, &mut slow] {
        let late = 0.2 - (rows[31].time - rows[30].time);
        rows[31..].iter_mut().for_each(|r| r.time += late);
    }
    // Right wheels that are faster in a turn to the right: sides swapped, which only the whole segment tells.
    let mut swapped = rolling(200);
    for (k, row) in swapped.iter_mut().enumerate() {
        let turn = if k < 100 { 0.0 } else { (0.1 * k as f64).sin() };
        row.channels[2] = Some(2.0 + turn);
        row.channels[4] = Some(2.0 + turn);
        row.channels[6] = Some(-0.4 * turn);
    }
    let steps = run(&[fast, slow, swapped], &config(), 7).unwrap();
    let names = |k: usize| match &steps[k].flag {
        Flag::Degraded(names) => names.clone(),
        _ => Vec::new(),
    };
    assert!(names(31).contains(&"time") && !names(30).contains(&"time"));
    assert!(!names(231).contains(&"time"));
    assert!(names(430).contains(&"sides") && !names(230).contains(&"sides"));
}

/// A log that grew between the passes is refused by name, at the first row too many; so is one without wheel speeds.
#[test]
fn the_passes_must_meet_the_same_rows() {
    let config = config();
    let rows = rolling(50);
    let mut first = FirstPass::new(&config).unwrap();
    first.segment();
    rows[..40].iter().for_each(|row| first.row(row));
    let mut second = first.run().unwrap();
    let mut steps = Vec::new();
    second.segment(&mut steps).unwrap();
    for row in &rows {
        second.row(row, &mut steps).unwrap();
    }
    let error = second.segment(&mut steps).unwrap_err();
    assert_eq!(error, FilterError::FirstPass { segment: 0 });
    assert_eq!(steps.len(), 40);

    let mut first = FirstPass::new(&config).unwrap();
    first.segment();
    for row in &rows {
        let channels = [None; 7];
        first.row(&RobotRow { channels, ..*row });
    }
    assert!(matches!(
        first.run().err(),
        Some(FilterError::MissingChannel { .. })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whole logs and single rows are run alike, with holes, pauses, late and repeated rows, whenever the steps are taken.
    #[test]
    fn taken_at_any_time_the_steps_are_those_of_the_log(
        seed in 0..40u64,
        holes in proptest::collection::vec((0..200usize, 0..11usize, 1..30usize), 0..8),
        clock in proptest::collection::vec((1..200usize, prop_oneof![Just(-0.015), Just(-0.01), Just(3.0), Just(-5.0)]), 0..5),
        cut in 1..199usize,
        take in 1..250usize,
        smooth in any::<bool>(),
    ) {
        let mut rng = rng(seed, 0);
        let d = drive("upland_sandy_loam", &mut rng);
        let mut channels = sensors(&d, &mut rng);
        let mut time = d.time.clone();
        let some = |v: &[f64]| v.iter().copied().map(Some).collect::<Vec<_>>();
        let mut torque = [0; 4].map(|_| some(&d.torque));
        for (from, column, length) in holes {
            let column = match column {
                c @ 0..7 => &mut channels[c],
                c => &mut torque[c - 7],
            };
            let end = (from + length).min(200);
            column[from..end].fill(None);
        }
        for (row, by) in clock {
            if by > -1.0 && by < 1.0 {
                time[row] += by;
            } else {
                time[row..].iter_mut().for_each(|t| *t += by);
            }
        }
        let segments = [0..cut, cut..200];
        let log = RobotLog {
            time: &time,
            segments: &segments,
            torque: torque.each_ref().map(Vec::as_slice),
            channels: channels.each_ref().map(Vec::as_slice),
            pitch: &[],
            payload: &[],
        };
        let rows = segments.clone().map(|rows| {
            rows.map(|row| RobotRow {
                row,
                time: time[row],
                torque: torque.each_ref().map(|t| t[row]),
                channels: channels.each_ref().map(|c| c[row]),
                ..RobotRow::default()
            })
            .collect::<Vec<_>>()
        });
        let config = ForceConfig { smooth, ..config() };
        match (estimate_forces(&log, &config), run(&rows, &config, take)) {
            (Ok(whole), Ok(steps)) => {
                prop_assert_eq!(steps.len(), 200);
                prop_assert_eq!(format!("{steps:?}"), format!("{whole:?}"));
            }
            (whole, steps) => prop_assert_eq!(steps.err(), whole.err()),
        }
    }
}
