//! Where a segment begins: the first belief, and the torques with their gaps held.

use nalgebra::DVector;

use super::{INPUT_HOLD, RobotLog};
use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::spaces::LongitudinalRobot;
use crate::spaces::longitudinal_robot::{CHANNELS, R, STATES, T, V, W, Z_R, Z_V, Z_W};
use crate::state_space::StateSpace;

const TORQUE_NAMES: [&str; 4] = ["torque_fl", "torque_fr", "torque_rl", "torque_rr"];

/// The name of a wheel's torque in flags and errors.
pub(super) fn torque_name(wheel: usize) -> &'static str {
    TORQUE_NAMES.get(wheel).copied().unwrap_or("torque")
}

/// Torque at each row of `rows`, and whether it is held. A gap at the head is filled with the first value after it.
///
/// # Errors
/// [`FilterError::MissingInput`] when a value is missing for more than [`INPUT_HOLD`] samples.
pub(super) fn held_torque(
    log: &RobotLog<'_>,
    rows: std::ops::Range<usize>,
    wheel: usize,
) -> Result<Vec<(f64, bool)>, FilterError> {
    let at = |row: usize| {
        log.torque[wheel]
            .get(row)
            .copied()
            .flatten()
            .filter(|v| v.is_finite())
    };
    let missing = |row: usize| FilterError::MissingInput {
        input: torque_name(wheel).to_owned(),
        time: log.time.get(row).copied().unwrap_or(f64::NAN),
        limit: INPUT_HOLD,
    };
    let head = rows.clone().take(INPUT_HOLD + 1).find_map(at);
    let mut last = head.ok_or_else(|| missing(rows.start))?;
    let mut gap = 0;
    rows.map(|row| match at(row) {
        Some(value) => {
            (last, gap) = (value, 0);
            Ok((value, false))
        }
        None => {
            gap += 1;
            if gap > INPUT_HOLD {
                Err(missing(row))
            } else {
                Ok((last, true))
            }
        }
    })
    .collect()
}

/// The belief before a segment's first sample, and the channels whose first sample went into it.
///
/// Speeds start at their first sample, with the prior's spread or the sensor's, whichever is wider; that sample is then
/// not used a second time. A speed without a sample in the first row starts at the next one there is, ten times as wide.
/// Resistive torques start at the applied ones, forces at zero.
pub(super) fn first_belief(
    space: &LongitudinalRobot,
    log: &RobotLog<'_>,
    rows: std::ops::Range<usize>,
    torque: [f64; 4],
    no_ground_speed: bool,
) -> (Gaussian, Vec<usize>) {
    let prior = space.prior();
    let noise = space.measurement_noise();
    let mut mean = [0.0; STATES];
    let mut sd: Vec<f64> = (0..STATES)
        .map(|i| prior.covariance[(i, i)].sqrt())
        .collect();
    let mut taken = Vec::new();
    let mut pairs = vec![(V, Z_V), (R, Z_R)];
    pairs.extend(W.into_iter().zip(Z_W));
    for (state, channel) in pairs {
        if channel == Z_V && no_ground_speed {
            continue;
        }
        let at = |row: usize| {
            log.channels[channel]
                .get(row)
                .copied()
                .flatten()
                .filter(|v| v.is_finite())
        };
        let spread = sd[state].max(noise[(channel, channel)].sqrt());
        if let Some(value) = at(rows.start) {
            (mean[state], sd[state]) = (value, spread);
            taken.push(channel);
        } else {
            mean[state] = rows.clone().find_map(at).unwrap_or(0.0);
            sd[state] = 10.0 * spread;
        }
    }
    if no_ground_speed {
        // All that is known of v is that the wheels roll: their mean rim speed, wrong by half of it.
        let rim = W.iter().map(|&w| mean[w]).sum::<f64>() / 4.0 * space.vehicle().wheel_radius;
        mean[V] = rim;
        sd[V] = sd[V].hypot(0.5 * rim);
    }
    for (q, &t) in T.iter().enumerate() {
        mean[t] = torque[q];
    }
    (
        Gaussian {
            mean: DVector::from_column_slice(&mean),
            ..Gaussian::independent(&mean, &sd)
        },
        taken,
    )
}

/// The sample at a row without the channels in `skip`.
pub(super) fn sample(
    log: &RobotLog<'_>,
    row: usize,
    no_ground_speed: bool,
    skip: &[usize],
) -> [Option<f64>; CHANNELS] {
    std::array::from_fn(|i| {
        let absent = skip.contains(&i) || (i == Z_V && no_ground_speed);
        if absent {
            None
        } else {
            log.channels[i]
                .get(row)
                .copied()
                .flatten()
                .filter(|v| v.is_finite())
        }
    })
}
