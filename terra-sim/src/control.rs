//! What the motors do in a segment: a torque profile, or a PI controller that tracks wheel speeds.
//!
//! # Equation
//! T = k_p (ω_ref - ω) + T_i, dT_i/dt = k_i (ω_ref - ω), with k_p = 2 ζ ω_n J, k_i = ω_n² J, ζ = 1,
//! ω_n = 10 rad/s, J = I_w + m R²/4: critically damped for a wheel that carries its share of the vehicle without slip.
//! T_i carries on between segments; after a torque segment it starts at the torque that was applied last.

use crate::robot::{INTEGRALS_AT, STATES, WHEELS_AT};
use crate::scenario::{Command, DriveSegment, Profile};

/// ω_n \[rad/s\].
const NATURAL_FREQUENCY: f64 = 10.0;
/// ζ \[1\].
const DAMPING: f64 = 1.0;

/// The motors of one segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    command: Command,
    start: f64,
    duration: f64,
    /// k_p \[N m s\].
    proportional: f64,
    /// k_i \[N m\].
    integral: f64,
}

impl Control {
    /// The motors of a segment that starts at `start` \[s\]; `inertia` is J.
    pub(crate) fn new(segment: &DriveSegment, start: f64, inertia: f64) -> Self {
        Control {
            command: segment.command,
            start,
            duration: segment.duration,
            proportional: 2.0 * DAMPING * NATURAL_FREQUENCY * inertia,
            integral: NATURAL_FREQUENCY * NATURAL_FREQUENCY * inertia,
        }
    }

    fn at(&self, profiles: &[Profile; 4], time: f64) -> [f64; 4] {
        let share = ((time - self.start) / self.duration).clamp(0.0, 1.0);
        profiles.map(|p| p.at(share))
    }

    /// Torque the motors deliver \[N m\].
    pub(crate) fn torque(&self, time: f64, speeds: [f64; 4], integrals: [f64; 4]) -> [f64; 4] {
        match &self.command {
            Command::Torque(profiles) => self.at(profiles, time),
            Command::WheelSpeed(profiles) => {
                let wanted = self.at(profiles, time);
                std::array::from_fn(|q| self.proportional * (wanted[q] - speeds[q]) + integrals[q])
            }
        }
    }

    /// Writes dT_i/dt.
    pub(crate) fn integral_rate(&self, time: f64, y: &[f64; STATES], rate: &mut [f64; STATES]) {
        if let Command::WheelSpeed(profiles) = &self.command {
            let wanted = self.at(profiles, time);
            for q in 0..4 {
                rate[INTEGRALS_AT + q] = self.integral * (wanted[q] - y[WHEELS_AT + q]);
            }
        }
    }

    /// T_i after this segment, for a speed controller that follows.
    pub(crate) fn hand_over(&self, y: &mut [f64; STATES]) {
        if let Command::Torque(profiles) = &self.command {
            let last = profiles.map(|p| p.to);
            y[INTEGRALS_AT..INTEGRALS_AT + 4].copy_from_slice(&last);
        }
    }
}
