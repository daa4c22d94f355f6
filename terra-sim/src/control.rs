//! What the motors do in a segment: a torque profile, or a PI controller that tracks wheel speeds, through a motor that
//! need not be perfect.
//!
//! # Equation
//! T_asked = k_p (ω_ref - ω) + T_i, dT_i/dt = k_i (ω_ref - ω), with k_p = 2 ζ ω_n J, k_i = ω_n² J, ζ = 1,
//! ω_n = 10 rad/s unless the scenario says otherwise, J = I_w + m R²/4: critically damped for a wheel that carries its
//! share of the vehicle without slip. T_i carries on between segments; after a torque segment it starts at the torque
//! that was applied last. At its limit the motor cannot follow, and an integral that pushes further only winds up: it
//! fades out while what is asked goes from the limit to 5 % beyond. A switch in its place would make the motion slide
//! along the limit, where no step is short enough.
//!
//! Motor: T_m = clamp(T_asked(t - delay) - droop ω, ± limit (1 - |ω|/ω_0) when T_m and ω agree in sign, ± limit
//! otherwise), dT/dt = (T_m - T)/lag, delivered η T when it drives and T/η when it is driven, less the friction of the
//! gears T_c tanh(ω/.1 rad/s) + b ω. The current is T/k_t. Without a `[motor]` the delivered torque is the asked one.

use crate::off_library::smooth_step;
use crate::robot::{INTEGRALS_AT, MOTORS_AT, STATES, WHEELS_AT, four};
use crate::scenario::{Command, DriveSegment, Motor, Profile};

/// ζ \[1\].
const DAMPING: f64 = 1.0;

/// The integral fades out within this share of the torque limit.
const FADE: f64 = 0.05;

/// Speed within which Coulomb friction turns its sign \[rad/s\].
const CREEP: f64 = 0.1;

/// The motors of one segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    command: Command,
    motor: Motor,
    start: f64,
    duration: f64,
    /// k_p \[N m s\].
    proportional: f64,
    /// k_i \[N m\].
    integral: f64,
}

impl Control {
    /// The motors of a segment that starts at `start` \[s\]; `inertia` is J.
    pub(crate) fn new(segment: &DriveSegment, motor: Motor, start: f64, inertia: f64) -> Self {
        let frequency = motor.control_frequency;
        Control {
            command: segment.command,
            motor,
            start,
            duration: segment.duration,
            proportional: 2.0 * DAMPING * frequency * inertia,
            integral: frequency * frequency * inertia,
        }
    }

    fn at(&self, profiles: &[Profile; 4], time: f64) -> [f64; 4] {
        let share = ((time - self.start - self.motor.delay) / self.duration).clamp(0.0, 1.0);
        profiles.map(|p| p.at(share))
    }

    fn asked(&self, time: f64, speeds: [f64; 4], integrals: [f64; 4]) -> [f64; 4] {
        match &self.command {
            Command::Torque(profiles) => self.at(profiles, time),
            Command::WheelSpeed(profiles) => {
                let wanted = self.at(profiles, time);
                std::array::from_fn(|q| self.proportional * (wanted[q] - speeds[q]) + integrals[q])
            }
        }
    }

    /// What the motor can do of what is asked, before its lag \[N m\].
    fn possible(&self, asked: f64, speed: f64) -> f64 {
        let torque = asked - self.motor.droop * speed;
        let limit = self.motor.torque_limit;
        let drives = torque * speed > 0.0;
        let limit = if drives && limit.is_finite() && self.motor.no_load_speed.is_finite() {
            limit * (1.0 - speed.abs() / self.motor.no_load_speed).max(0.0)
        } else {
            limit
        };
        torque.clamp(-limit, limit)
    }

    /// Torque of the motors, before gears \[N m\].
    fn made(&self, time: f64, y: &[f64; STATES]) -> [f64; 4] {
        if self.motor.lag > 0.0 {
            return four(y, MOTORS_AT);
        }
        let speeds = four(y, WHEELS_AT);
        let asked = self.asked(time, speeds, four(y, INTEGRALS_AT));
        std::array::from_fn(|q| self.possible(asked[q], speeds[q]))
    }

    /// Currents of the motors \[A\]; none without a torque constant.
    pub(crate) fn current(&self, time: f64, y: &[f64; STATES]) -> Option<[f64; 4]> {
        let constant = self.motor.torque_constant;
        (constant > 0.0).then(|| self.made(time, y).map(|torque| torque / constant))
    }

    /// Torque the motors deliver \[N m\].
    pub(crate) fn torque(&self, time: f64, y: &[f64; STATES]) -> [f64; 4] {
        let speeds = four(y, WHEELS_AT);
        if self.motor == Motor::default() {
            return self.asked(time, speeds, four(y, INTEGRALS_AT));
        }
        let torque = self.made(time, y);
        std::array::from_fn(|q| {
            // η where it drives, 1/η where it is driven, smoothly within a tenth of a watt.
            let direction = (10.0 * torque[q] * speeds[q]).tanh();
            let friction =
                self.motor.coulomb * (speeds[q] / CREEP).tanh() + self.motor.viscous * speeds[q];
            torque[q] * self.motor.efficiency.powf(direction) - friction
        })
    }

    /// Writes dT_i/dt and dT/dt.
    pub(crate) fn rates(&self, time: f64, y: &[f64; STATES], rate: &mut [f64; STATES]) {
        if self.motor.lag > 0.0 {
            let speeds = four(y, WHEELS_AT);
            let asked = self.asked(time, speeds, four(y, INTEGRALS_AT));
            for q in 0..4 {
                let possible = self.possible(asked[q], speeds[q]);
                rate[MOTORS_AT + q] = (possible - y[MOTORS_AT + q]) / self.motor.lag;
            }
        }
        if let Command::WheelSpeed(profiles) = &self.command {
            let wanted = self.at(profiles, time);
            let asked = self.asked(time, four(y, WHEELS_AT), four(y, INTEGRALS_AT));
            for q in 0..4 {
                let error = wanted[q] - y[WHEELS_AT + q];
                let held = asked[q] - self.motor.droop * y[WHEELS_AT + q];
                let beyond = (held - self.possible(asked[q], y[WHEELS_AT + q])).abs();
                let winds_up = if beyond > 0.0 && error * held > 0.0 {
                    smooth_step(beyond / (FADE * self.motor.torque_limit))
                } else {
                    0.0
                };
                rate[INTEGRALS_AT + q] = self.integral * error * (1.0 - winds_up);
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
