//! What a log must be, and the loop over its segments.

use super::run::FirstPass;
use super::{ForceConfig, RobotLog, Step};
use crate::error::FilterError;
use crate::spaces::longitudinal_robot::{CHANNEL_NAMES, Z_V, Z_W};

/// Estimates the robot's 18 states at every row of every segment.
///
/// The torque between two rows is the mean of both. Missing channels are dropped rows, and so are readings of a sensor
/// that is stuck or that no robot can have. A torque is held over up to [`INPUT_HOLD`](super::INPUT_HOLD) samples; after
/// that the wheel's resistance is not known, its spread grows, and it starts afresh when the torque is back. The mass is
/// the vehicle's and the row's payload, the slope the row's pitch. A gap longer than `restart_gap`, or a clock that jumps
/// back, starts the filter anew; late rows are put in their place by replay. All of this is flagged.
///
/// # Errors
/// [`FilterError::MissingChannel`] for a log without wheel speeds or, unless declared, ground speed,
/// [`FilterError::Segment`] and [`FilterError::Size`] for slices that do not fit, and [`FilterError::AtRow`] around what
/// goes wrong at a row: a time that is none, a payload that leaves no mass, or what the filter raises.
pub fn estimate_forces(log: &RobotLog<'_>, config: &ForceConfig) -> Result<Vec<Step>, FilterError> {
    check(log, config)?;
    let mut first = FirstPass::new(config)?;
    for rows in log.segments {
        first.segment();
        rows.clone().for_each(|row| first.row(&log.row(row)));
    }
    let mut run = first.begin();
    let mut steps = Vec::with_capacity(log.time.len());
    for rows in log.segments {
        run.segment(&mut steps)?;
        for row in rows.clone() {
            run.row(&log.row(row), &mut steps)?;
        }
    }
    run.finish(&mut steps)?;
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
    for (what, column) in [("pitch", log.pitch), ("payload", log.payload)] {
        if !column.is_empty() && column.len() != rows {
            return Err(FilterError::Size {
                what,
                expected: rows,
                found: column.len(),
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
    }
    if rows > 0 {
        required(config, |i| {
            log.channels[i].iter().flatten().any(|v| v.is_finite())
        })?;
    }
    Ok(())
}

/// The channels that a log must have somewhere.
pub(super) fn required(
    config: &ForceConfig,
    there: impl Fn(usize) -> bool,
) -> Result<(), FilterError> {
    for (i, name) in CHANNEL_NAMES.iter().enumerate() {
        let advice = match i {
            Z_V if config.no_ground_speed => continue,
            Z_V => "record it, or declare that there is none",
            _ if Z_W.contains(&i) => "all four wheel speeds are needed",
            _ => continue,
        };
        if !there(i) {
            return Err(FilterError::MissingChannel {
                channel: (*name).to_owned(),
                advice,
            });
        }
    }
    Ok(())
}

/// The numbers of the configuration that the log is run by.
pub(super) fn settings(config: &ForceConfig) -> Result<(), FilterError> {
    if config.restart_gap.is_nan() || config.restart_gap <= 0.0 {
        return Err(FilterError::Config {
            key: "restart_gap",
            value: config.restart_gap,
            expected: "a positive number of seconds",
        });
    }
    if !(config.late.is_finite() && config.late >= 0.0) {
        return Err(FilterError::Config {
            key: "late",
            value: config.late,
            expected: "a number of seconds that is not negative",
        });
    }
    Ok(())
}
