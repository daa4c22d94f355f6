//! Are left and right the right way round? Wheels that turn faster on the right turn the robot to the left.
//!
//! # Equation
//! Least squares of r on d = R (w_right - w_left)/t_w over the rows: slope b = Σ d r/Σ d², with the noise of both channels.
//! Slip makes b smaller than 1, a hillside may bias it; only swapped sides or a wrong sign make it negative. Judged when
//! |b| is more than six standard deviations from zero and d explains at least half of r.

use terra_model::Vehicle;

use super::row::RobotRow;
use crate::spaces::longitudinal_robot::{Z_R, Z_W};

/// The sums over the rows of a segment.
pub(super) struct Turning {
    radius: f64,
    track: f64,
    dd: f64,
    dr: f64,
    rr: f64,
    n: f64,
}

impl Turning {
    pub(super) fn new(vehicle: &Vehicle<f64>) -> Self {
        Turning {
            radius: vehicle.wheel_radius,
            track: vehicle.track,
            dd: 0.0,
            dr: 0.0,
            rr: 0.0,
            n: 0.0,
        }
    }

    pub(super) fn see(&mut self, row: &RobotRow) {
        let get = |channel: usize| row.channels[channel].filter(|v| v.is_finite() && v.abs() < 1e4);
        let (Some(r), [Some(fl), Some(fr), Some(rl), Some(rear)]) = (get(Z_R), Z_W.map(get)) else {
            return;
        };
        let d = self.radius * 0.5 * (fr + rear - fl - rl) / self.track;
        self.dd += d * d;
        self.dr += d * r;
        self.rr += r * r;
        self.n += 1.0;
    }

    /// True when the yaw rate says that left and right are swapped (or the yaw rate has the wrong sign); false when they
    /// are the right way round, and where too little turning tells.
    pub(super) fn swapped(&self) -> bool {
        let &Turning { dd, dr, rr, n, .. } = self;
        if n < 20.0 || dd <= 0.0 || rr <= 0.0 {
            return false;
        }
        let explained = dr * dr / (dd * rr);
        let slope = dr / dd;
        let sd = ((1.0 - explained).max(0.0) * rr / (dd * (n - 1.0))).sqrt();
        explained >= 0.5 && slope < -6.0 * sd
    }
}
