//! What is known at one instant, and what the last ones let expect of the next.

use crate::robot::STATES;
use crate::wheel::WheelState;

/// Everything at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instant {
    /// dy/dt.
    pub(crate) rate: [f64; STATES],
    /// Specific force along x \[m/s²\].
    pub(crate) specific_force: f64,
    /// Specific force along y \[m/s²\].
    pub(crate) side_force: f64,
    /// Torque the motors deliver \[N m\].
    pub(crate) motor_torque: [f64; 4],
    /// Wheels.
    pub(crate) wheels: [WheelState; 4],
}

impl Instant {
    /// On the chord from `before` through this, as far behind this as `share` of their distance.
    #[inline]
    pub(crate) fn beyond(&self, before: &Instant, share: f64) -> Instant {
        let along = |now: f64, before: f64| now + share * (now - before);
        let mut out = *self;
        for (rate, old) in out.rate.iter_mut().zip(&before.rate) {
            *rate = along(*rate, *old);
        }
        out.specific_force = along(self.specific_force, before.specific_force);
        out.side_force = along(self.side_force, before.side_force);
        for (wheel, old) in out.wheels.iter_mut().zip(&before.wheels) {
            wheel.drawbar_pull = along(wheel.drawbar_pull, old.drawbar_pull);
            wheel.resistive_torque = along(wheel.resistive_torque, old.resistive_torque);
            wheel.lateral_force = along(wheel.lateral_force, old.lateral_force);
            wheel.sinkage = wheel.sinkage.zip(old.sinkage).map(|(n, o)| along(n, o));
            wheel.normal_load = along(wheel.normal_load, old.normal_load);
            if let Some(contact) = &mut wheel.contact {
                contact.normal_load = wheel.normal_load;
            }
        }
        out
    }
}

/// Start of the next solution for the accelerations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Warm {
    /// a_x \[m/s²\].
    ahead: f64,
    /// Of "acceleration of the forces less a" by a \[1\].
    pub(crate) slope: f64,
    /// a_y \[m/s²\].
    pub(crate) aside: f64,
    /// When that was.
    time: f64,
    /// a_x by time between the last two instants \[m/s³\].
    trend: f64,
}

/// Change of a_x that a trend may promise \[m/s²\].
const PROMISED: f64 = 1.0;

impl Warm {
    /// Nothing known.
    pub(crate) const COLD: Warm = Warm {
        ahead: 0.0,
        slope: -1.0,
        aside: 0.0,
        time: f64::NEG_INFINITY,
        trend: 0.0,
    };

    /// a_x as the last two instants let expect it.
    #[inline]
    pub(crate) fn expected(&self, time: f64) -> f64 {
        let rise = self.trend * (time - self.time);
        if rise.abs() < PROMISED {
            self.ahead + rise
        } else {
            self.ahead
        }
    }

    /// One instant more.
    #[inline]
    pub(crate) fn learn(&mut self, time: f64, slope: f64, (ahead, aside): (f64, f64)) {
        let passed = time - self.time;
        if passed != 0.0 {
            self.trend = if passed.is_finite() {
                (ahead - self.ahead) / passed
            } else {
                0.0
            };
        }
        *self = Warm {
            ahead,
            slope,
            aside,
            time,
            trend: self.trend,
        };
    }
}
