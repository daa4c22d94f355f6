//! Where a segment begins: the first belief, and the samples of a row.

use nalgebra::DVector;

use super::Dropped;
use super::inputs::{Input, InputState};
use super::row::RobotRow;
use crate::gaussian::Gaussian;
use crate::spaces::LongitudinalRobot;
use crate::spaces::longitudinal_robot::{CHANNELS, R, STATES, T, V, W, Z_R, Z_V, Z_W};
use crate::state_space::StateSpace;

/// Rows that a run sees ahead of the one it is at.
pub(super) const AHEAD: usize = 256;

/// The belief before a segment's first sample, and the channels whose first sample went into it.
///
/// Speeds start at their first sample, with the prior's spread or the sensor's, whichever is wider; that sample is then
/// not used a second time. A speed without a sample in the first row starts at the next one there is, ten times as wide.
/// Resistive torques start at the applied ones, forces at zero. `next` gives a channel's next reading after the row.
pub(super) fn first_belief(
    space: &LongitudinalRobot,
    row: &RobotRow,
    next: impl Fn(usize) -> Option<f64>,
    input: &Input,
    no_ground_speed: bool,
    skip: &[(usize, Dropped)],
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
        let spread = sd[state].max(noise[(channel, channel)].sqrt());
        let first = row.channels[channel]
            .filter(|v| plausible(channel, *v) && skip.iter().all(|d| d.0 != channel));
        if let Some(value) = first {
            (mean[state], sd[state]) = (value, spread);
            taken.push(channel);
        } else {
            mean[state] = next(channel).unwrap_or(0.0);
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
        mean[t] = input.torque[q];
        if input.state[q] == InputState::Unknown {
            sd[t] *= 10.0;
        }
    }
    (
        Gaussian {
            mean: DVector::from_column_slice(&mean),
            ..Gaussian::independent(&mean, &sd)
        },
        taken,
    )
}

/// Readings beyond these are none \[m/s², rad/s, m/s, rad/s\]: far outside what a robot can do, and far inside what would
/// upset the arithmetic.
const MOST: [f64; CHANNELS] = [1e4, 1e4, 1e4, 1e4, 1e4, 1e3, 1e3];

/// True for a finite reading a robot can have.
pub(super) fn plausible(channel: usize, value: f64) -> bool {
    value.abs() <= MOST[channel]
}

/// The finite readings at a row.
pub(super) fn sample(row: &RobotRow, no_ground_speed: bool) -> [Option<f64>; CHANNELS] {
    std::array::from_fn(|i| {
        row.channels[i].filter(|v| v.is_finite() && !(i == Z_V && no_ground_speed))
    })
}
