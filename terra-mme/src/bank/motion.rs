//! What a bank of vehicle filters is fed, and the vehicle it believes in.

use terra_model::{AnyEffect, Channel, EffectAt, Touch, Vehicle};

use crate::error::EstimatorError;

/// Channels of a [`MotionSample`]: a_x, ω fl fr rl rr, v, r.
pub const MOTION_CHANNELS: usize = 7;
/// Place of a_x in a sample.
pub const AT_ACCEL: usize = 0;
/// Place of the first wheel speed in a sample.
pub const AT_WHEELS: usize = 1;
/// Place of the ground speed in a sample.
pub const AT_SPEED: usize = 5;
/// Place of the yaw rate in a sample.
pub const AT_YAW: usize = 6;

/// One row of a drive log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionSample {
    /// t \[s\], increasing inside a group.
    pub time: f64,
    /// Segment: filters restart at each.
    pub group: usize,
    /// Torque applied at fl, fr, rl, rr \[N m\].
    pub torque: [f64; 4],
    /// Inclination of the ground \[rad\], nose-up positive, beside the vehicle's own.
    pub pitch: f64,
    /// Mass that is carried beside the vehicle's own \[kg\].
    pub payload: f64,
    /// a_x \[m/s²\], ω fl fr rl rr \[rad/s\], v \[m/s\], r \[rad/s\]; a missing sample is `None`.
    pub channels: [Option<f64>; MOTION_CHANNELS],
}

/// 1-sigma of the sensors per sample, and of what the vehicle model leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionNoise {
    /// a_x \[m/s²\].
    pub accel_x: f64,
    /// ω \[rad/s\].
    pub wheel_speed: f64,
    /// v \[m/s\].
    pub ground_speed: f64,
    /// r \[rad/s\].
    pub yaw_rate: f64,
    /// Logged torque \[N m\].
    pub wheel_torque: f64,
    /// Square roots of the spectral densities of v' \[m/s/√s\], r' and ω' \[rad/s/√s\].
    pub process: [f64; 3],
}

impl Default for MotionNoise {
    /// The sensors of the reproduction of Ray 2008. The process noise covers what a 100 Hz log hides of a torque that
    /// changes between rows; forces are the hypothesis' own business and get none.
    fn default() -> Self {
        MotionNoise {
            accel_x: 0.05,
            wheel_speed: 0.05,
            ground_speed: 0.02,
            yaw_rate: 0.005,
            wheel_torque: 0.1,
            process: [0.005, 0.005, 0.05],
        }
    }
}

/// reported = gain x truth + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) gain: f64,
    pub(crate) offset: f64,
}

const TRUE: Reading = Reading {
    gain: 1.0,
    offset: 0.0,
};

/// The vehicle and its sensors as a hypothesis believes them to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Belief {
    pub(crate) readings: [Reading; MOTION_CHANNELS],
    pub(crate) torque: Reading,
}

/// A vehicle, its sensors, and what is wrong with them, for a bank of filters.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    pub(crate) vehicle: Vehicle<f64>,
    pub(crate) noise: MotionNoise,
    pub(crate) belief: Belief,
}

impl Plant {
    /// The vehicle of the file, with sensors that tell the truth but for noise.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a number that makes no vehicle or no noise.
    pub fn new(vehicle: Vehicle<f64>, noise: MotionNoise) -> Result<Self, EstimatorError> {
        let v = &vehicle;
        for (what, value) in [
            ("mass", v.mass),
            ("yaw inertia", v.yaw_inertia),
            ("track", v.track),
            ("wheelbase", v.wheelbase),
            ("wheel radius", v.wheel_radius),
            ("wheel inertia", v.wheel_inertia),
            ("noise of accel_x", noise.accel_x),
            ("noise of wheel_speed", noise.wheel_speed),
            ("noise of ground_speed", noise.ground_speed),
            ("noise of yaw_rate", noise.yaw_rate),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(value_error(what, value, "a finite value above 0"));
            }
        }
        let [qv, qr, qw] = noise.process;
        for (what, value) in [
            ("yaw damping", v.yaw_damping),
            ("wheel damping", v.wheel_damping),
            ("height of the centre of mass", v.cg_height),
            ("noise of wheel_torque", noise.wheel_torque),
            ("process noise of v", qv),
            ("process noise of r", qr),
            ("process noise of ω", qw),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(value_error(what, value, "a finite value of at least 0"));
            }
        }
        if !(v.cg_to_front_axle > 0.0 && v.cg_to_front_axle < v.wheelbase) {
            return Err(value_error(
                "centre of mass behind the front axle",
                v.cg_to_front_axle,
                "a place between the axles",
            ));
        }
        if v.pitch.is_nan() || v.pitch.abs() >= std::f64::consts::FRAC_PI_2 {
            return Err(value_error("pitch", v.pitch, "an angle in (-π/2, π/2)"));
        }
        Ok(Plant {
            vehicle,
            noise,
            belief: Belief {
                readings: [TRUE; MOTION_CHANNELS],
                torque: TRUE,
            },
        })
    }

    /// The same plant under an effect on the vehicle or on a sensor, of the given magnitudes.
    ///
    /// # Errors
    /// [`EstimatorError::NotSupported`] for an effect that acts elsewhere or on a rate (a delay);
    /// [`EstimatorError::Size`]; [`EstimatorError::Value`] when no vehicle is left.
    pub fn with_effect(
        &self,
        effect: &dyn AnyEffect,
        magnitude: &[f64],
    ) -> Result<Self, EstimatorError> {
        let refuse = |reason| {
            Err(EstimatorError::NotSupported {
                estimator: "innovation-bank",
                choice: effect.name().to_owned(),
                reason,
            })
        };
        if effect
            .touches()
            .iter()
            .any(|t| !matches!(t, Touch::Vehicle | Touch::Sensor))
        {
            return refuse("only effects on vehicle and sensors change the plant");
        }
        if magnitude.len() != effect.params().len() {
            return Err(EstimatorError::Size {
                what: "magnitudes",
                found: magnitude.len(),
                expected: effect.params().len(),
            });
        }
        let reading = |channel, before: Reading| -> Option<Reading> {
            let report =
                |truth, rate| EffectAt::<f64>::report_at(effect, magnitude, channel, truth, rate);
            let (offset, at_one) = (report(0.0, 0.0), report(1.0, 0.0));
            (report(1.0, 1.0) == at_one).then_some(Reading {
                gain: (at_one - offset) * before.gain,
                offset: offset + (at_one - offset) * before.offset,
            })
        };
        let vehicle = EffectAt::<f64>::vehicle_at(effect, magnitude, self.vehicle);
        let mut out = Plant {
            vehicle,
            ..Plant::new(vehicle, self.noise)?
        };
        let kinds = [
            Channel::AccelX,
            Channel::WheelSpeed,
            Channel::WheelSpeed,
            Channel::WheelSpeed,
            Channel::WheelSpeed,
            Channel::GroundSpeed,
            Channel::YawRate,
        ];
        for (k, kind) in kinds.into_iter().enumerate() {
            match reading(kind, self.belief.readings[k]) {
                Some(r) => out.belief.readings[k] = r,
                None => return refuse("a sensor that is late is no plant of this bank"),
            }
        }
        match reading(Channel::WheelTorque, self.belief.torque) {
            Some(r) if r.gain != 0.0 => out.belief.torque = r,
            _ => return refuse("a torque that says nothing cannot be inverted"),
        }
        Ok(out)
    }

    /// The vehicle believed in.
    pub fn vehicle(&self) -> &Vehicle<f64> {
        &self.vehicle
    }

    /// The noise believed in.
    pub fn noise(&self) -> &MotionNoise {
        &self.noise
    }

    /// The plant at a row of the log: with what it carries there, on the slope that it stands on.
    pub(crate) fn at(&self, sample: &MotionSample) -> Plant {
        let mut out = *self;
        out.vehicle.mass += sample.payload;
        out.vehicle.pitch += sample.pitch;
        out
    }

    /// Torque at the wheel behind a logged one.
    pub(crate) fn true_torque(&self, logged: f64) -> f64 {
        (logged - self.belief.torque.offset) / self.belief.torque.gain
    }

    /// Variance of each channel's noise.
    pub(crate) fn variances(&self) -> [f64; MOTION_CHANNELS] {
        let n = &self.noise;
        let w = n.wheel_speed * n.wheel_speed;
        [
            n.accel_x * n.accel_x,
            w,
            w,
            w,
            w,
            n.ground_speed * n.ground_speed,
            n.yaw_rate * n.yaw_rate,
        ]
    }
}

fn value_error(what: &str, value: f64, expected: &'static str) -> EstimatorError {
    EstimatorError::Value {
        what: what.to_owned(),
        value,
        expected,
    }
}
