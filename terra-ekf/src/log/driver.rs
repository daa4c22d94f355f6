//! The loop over a log's rows.

use std::ops::Range;
use std::sync::Arc;

use super::start::{first_belief, held_torque, sample, torque_name};
use super::{Flag, ForceConfig, RobotLog, Step};
use crate::error::FilterError;
use crate::filter::Filter;
use crate::measurement::Measurement;
use crate::smoother::{Passage, smooth};
use crate::spaces::longitudinal_robot::{CHANNEL_NAMES, CHANNELS, STATES, Z_V, Z_W};
use crate::state_space::AnyStateSpace;

/// Estimates the robot's 18 states at every row of every segment.
///
/// The torque between two rows is the mean of both. Missing channels are dropped rows; a torque is held over up to
/// [`INPUT_HOLD`](super::INPUT_HOLD) samples. A gap longer than `restart_gap` starts the filter anew.
///
/// # Errors
/// [`FilterError::TimeStep`] where time does not increase, [`FilterError::MissingInput`] where a torque is missing for
/// too long, [`FilterError::MissingChannel`] for a log without wheel speeds or, unless declared, ground speed,
/// [`FilterError::Segment`] and [`FilterError::Size`] for slices that do not fit, or what the filter raises.
pub fn estimate_forces(log: &RobotLog<'_>, config: &ForceConfig) -> Result<Vec<Step>, FilterError> {
    check(log, config)?;
    let space: Arc<dyn AnyStateSpace> = Arc::new(config.space);
    let mut filter = config
        .registry
        .filter(&config.filter, space, config.settings)?;
    let mut steps = Vec::with_capacity(log.time.len());
    for (segment, rows) in log.segments.iter().enumerate() {
        run_segment(log, config, &mut *filter, segment, rows.clone(), &mut steps)?;
    }
    Ok(steps)
}

fn check(log: &RobotLog<'_>, config: &ForceConfig) -> Result<(), FilterError> {
    let rows = log.time.len();
    for (segment, range) in log.segments.iter().enumerate() {
        let overlaps = segment > 0 && log.segments[segment - 1].end > range.start;
        if range.start > range.end || range.end > rows || overlaps {
            return Err(FilterError::Segment {
                segment,
                start: range.start,
                end: range.end,
                rows,
            });
        }
    }
    for torque in log.torque {
        if torque.len() != rows {
            return Err(FilterError::Size {
                what: "torque",
                expected: rows,
                found: torque.len(),
            });
        }
    }
    for (i, channel) in log.channels.iter().enumerate() {
        if !channel.is_empty() && channel.len() != rows {
            return Err(FilterError::Size {
                what: CHANNEL_NAMES[i],
                expected: rows,
                found: channel.len(),
            });
        }
        let advice = match i {
            Z_V if config.no_ground_speed => continue,
            Z_V => "record it, or declare that there is none",
            _ if Z_W.contains(&i) => "all four wheel speeds are needed",
            _ => continue,
        };
        if rows > 0 && channel.iter().all(|v| v.is_none_or(|v| !v.is_finite())) {
            return Err(FilterError::MissingChannel {
                channel: CHANNEL_NAMES[i].to_owned(),
                advice,
            });
        }
    }
    if config.restart_gap.is_nan() || config.restart_gap <= 0.0 {
        return Err(FilterError::Config {
            key: "restart_gap",
            value: config.restart_gap,
            expected: "a positive number of seconds",
        });
    }
    Ok(())
}

/// Channels absent from the whole segment, when some states cannot be known without them.
fn not_observable(
    log: &RobotLog<'_>,
    config: &ForceConfig,
    filter: &dyn Filter,
    rows: &Range<usize>,
) -> Result<Vec<&'static str>, FilterError> {
    let mut present = [false; CHANNELS];
    for row in rows.clone() {
        for (seen, value) in present
            .iter_mut()
            .zip(sample(log, row, config.no_ground_speed, &[]))
        {
            *seen |= value.is_some();
        }
        if present == [true; CHANNELS] {
            return Ok(Vec::new());
        }
    }
    let there: Vec<usize> = (0..CHANNELS).filter(|&i| present[i]).collect();
    if filter.space().observability_rank(&there)? == STATES {
        return Ok(Vec::new());
    }
    Ok((0..CHANNELS)
        .filter(|&i| !present[i])
        .map(|i| CHANNEL_NAMES[i])
        .collect())
}

fn run_segment(
    log: &RobotLog<'_>,
    config: &ForceConfig,
    filter: &mut dyn Filter,
    segment: usize,
    rows: Range<usize>,
    steps: &mut Vec<Step>,
) -> Result<(), FilterError> {
    let mut torque = Vec::with_capacity(4);
    for wheel in 0..4 {
        if !rows.is_empty() {
            torque.push(held_torque(log, rows.clone(), wheel)?);
        }
    }
    let blind = not_observable(log, config, filter, &rows)?;
    let mut passages: Vec<Passage> = Vec::new();
    let first = steps.len();
    let mut started = rows.start;
    let mut last: Option<(f64, [f64; 4])> = None;
    for row in rows.clone() {
        let time = log.time[row];
        let applied: [f64; 4] = std::array::from_fn(|q| torque[q][row - rows.start].0);
        let dt = last.map(|(before, _)| time - before);
        if !time.is_finite() || dt.is_some_and(|dt| dt <= 0.0) {
            return Err(FilterError::TimeStep {
                dt: dt.unwrap_or(f64::NAN),
                time,
            });
        }
        let gap = dt.is_some_and(|dt| dt > config.restart_gap);
        let mut taken = Vec::new();
        match (dt, last) {
            (Some(dt), Some((_, before))) if !gap => {
                let mean: [f64; 4] = std::array::from_fn(|q| 0.5 * (before[q] + applied[q]));
                filter.predict(&mean, dt)?;
            }
            _ => {
                let belief;
                (belief, taken) = first_belief(
                    &config.space,
                    log,
                    row..rows.end,
                    applied,
                    config.no_ground_speed,
                );
                filter.restart(belief)?;
                started = row;
                finish(config, &mut passages, &mut steps[first..])?;
            }
        }
        last = Some((time, applied));
        let z = Measurement::new(&sample(log, row, config.no_ground_speed, &taken));
        let innovation = filter.update(&z)?;
        if config.smooth {
            passages.push(Passage::of(filter));
        }

        let mut degraded: Vec<&'static str> = (0..CHANNELS)
            .filter(|&i| match innovation.ratio[i] {
                Some(ratio) => ratio > 1.0,
                None => !taken.contains(&i),
            })
            .map(|i| CHANNEL_NAMES[i])
            .collect();
        degraded.extend(
            (0..4)
                .filter(|&q| torque[q][row - rows.start].1)
                .map(torque_name),
        );
        let flag = if gap {
            Flag::Reset(Vec::new())
        } else if !innovation.resets.is_empty() {
            Flag::Reset(
                innovation
                    .resets
                    .iter()
                    .map(|&i| CHANNEL_NAMES[i])
                    .collect(),
            )
        } else if row - started < config.start_wait {
            Flag::Starting
        } else if !blind.is_empty() {
            Flag::NotObservable(blind.clone())
        } else if !degraded.is_empty() {
            Flag::Degraded(degraded)
        } else {
            Flag::Ok
        };
        steps.push(Step {
            row,
            segment,
            time,
            flag,
            since_start: row - started,
            nis: innovation.nis,
            dof: innovation.dof,
            belief: filter.belief().clone(),
            innovation,
            taken,
            torque: applied,
        });
    }
    finish(config, &mut passages, &mut steps[first..])
}

/// Replaces the last `passages.len()` beliefs by smoothed ones: one unbroken run of the filter.
fn finish(
    config: &ForceConfig,
    passages: &mut Vec<Passage>,
    steps: &mut [Step],
) -> Result<(), FilterError> {
    if config.smooth && !passages.is_empty() {
        let from = steps.len() - passages.len();
        for (step, belief) in steps[from..].iter_mut().zip(smooth(passages)?) {
            step.belief = belief;
        }
    }
    passages.clear();
    Ok(())
}
