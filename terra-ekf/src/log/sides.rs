//! Are left and right the right way round? Wheels that turn faster on the right turn the robot to the left.
//!
//! # Equation
//! Least squares of r on d = R (w_right - w_left)/t_w over the rows: slope b = Σ d r/Σ d², with the noise of both channels.
//! Slip makes b smaller than 1, a hillside may bias it; only swapped sides or a wrong sign make it negative. Judged when
//! |b| is more than six standard deviations from zero and d explains at least half of r.

use std::ops::Range;

use terra_model::Vehicle;

use super::RobotLog;
use crate::spaces::longitudinal_robot::{Z_R, Z_W};

/// True when the yaw rate says that left and right are swapped (or the yaw rate has the wrong sign); false when they are
/// the right way round, and where too little turning tells.
pub(super) fn swapped(log: &RobotLog<'_>, rows: Range<usize>, vehicle: &Vehicle<f64>) -> bool {
    let get = |channel: usize, row: usize| {
        let value = log.channels[channel].get(row).copied().flatten();
        value.filter(|v| v.is_finite() && v.abs() < 1e4)
    };
    let (mut dd, mut dr, mut rr, mut n) = (0.0, 0.0, 0.0, 0.0);
    for row in rows {
        let w = Z_W.map(|channel| get(channel, row));
        let (Some(r), [Some(fl), Some(fr), Some(rl), Some(rear)]) = (get(Z_R, row), w) else {
            continue;
        };
        let d = vehicle.wheel_radius * 0.5 * (fr + rear - fl - rl) / vehicle.track;
        dd += d * d;
        dr += d * r;
        rr += r * r;
        n += 1.0;
    }
    if n < 20.0 || dd <= 0.0 || rr <= 0.0 {
        return false;
    }
    let explained = dr * dr / (dd * rr);
    let slope = dr / dd;
    let sd = ((1.0 - explained).max(0.0) * rr / (dd * (n - 1.0))).sqrt();
    explained >= 0.5 && slope < -6.0 * sd
}
