//! From the truth of a drive to its log: sensor effects, delay, white noise.
//!
//! Reported = report(truth, late by the delay of an effect) + noise, noise of sd `[noise]` x `noise_scale`, one random
//! stream a channel and wheel. The log has what the vehicle of the reference paper measures (wheel speeds, applied
//! torques, ground speed, yaw rate, specific force), sinkage when `[noise]` names its sensor, and what the operator
//! declared (pitch, payload, pass).

use std::array;

use terra_data::{DriveLog, GroundSpeedSource, Noise, Rover, Series};
use terra_model::Channel;

use crate::effects::ActiveEffects;
use crate::error::SimError;
use crate::noise::{Stream, White};
use crate::scenario::Scenario;
use crate::truth::DriveTruth;

/// v at each step of the integrator, for sensors that are late.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpeedHistory {
    /// (t, v), in order; a reset starts a new piece.
    pieces: Vec<Vec<(f64, f64)>>,
}

impl SpeedHistory {
    pub(crate) fn begin(&mut self, time: f64, speed: f64) {
        self.pieces.push(vec![(time, speed)]);
    }

    pub(crate) fn push(&mut self, time: f64, speed: f64) {
        if let Some(piece) = self.pieces.last_mut() {
            piece.push((time, speed));
        }
    }

    /// v a while before `time`, straight between steps; before the piece began, as at its beginning.
    fn at(&self, time: f64, delay: f64) -> Option<f64> {
        let piece = self
            .pieces
            .iter()
            .rev()
            .find(|p| p.first().is_some_and(|(t, _)| *t <= time + 1e-12))?;
        let wanted = time - delay;
        let after = piece.partition_point(|(t, _)| *t <= wanted);
        let (before, next) = (piece.get(after.wrapping_sub(1)), piece.get(after));
        match (before, next) {
            (Some((t0, v0)), Some((t1, v1))) => Some(v0 + (v1 - v0) * (wanted - t0) / (t1 - t0)),
            (Some((_, v)), None) | (None, Some((_, v))) => Some(*v),
            (None, None) => None,
        }
    }
}

/// The 1-sigma of a channel; missing is an error unless the run is without noise.
pub(crate) fn sd_of(noise: &Noise, key: &str, scale: f64) -> Result<f64, SimError> {
    match noise.get(key) {
        Some(sd) => Ok(sd * scale),
        None if scale == 0.0 => Ok(0.0),
        None => Err(SimError::MissingNoise {
            key: key.to_owned(),
        }),
    }
}

/// The columns the operator declares, where a segment gave them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Declared {
    pub(crate) pitch: Option<Series>,
    pub(crate) payload: Option<Series>,
    pub(crate) pass: Option<Series>,
}

/// The log of a drive.
pub(crate) fn log(
    truth: &DriveTruth,
    history: &SpeedHistory,
    declared: Declared,
    scenario: &Scenario,
    rover: &Rover,
    effects: &ActiveEffects,
) -> Result<DriveLog, SimError> {
    let sd = |key: &str| sd_of(&rover.noise, key, scenario.noise_scale);
    let channel = |values: &[f64], what: Channel, stream: Stream, sd: f64| -> Series {
        let mut white = White::new(scenario.seed, scenario.run, stream, sd);
        values
            .iter()
            .map(|v| Some(effects.report(what, *v) + white.draw()))
            .collect()
    };

    let sd_speed = sd("wheel_speed_rad_s")?;
    let wheel_speed = array::from_fn(|q| {
        channel(
            &truth.wheel_speed[q],
            Channel::WheelSpeed,
            Stream::WheelSpeed(q),
            sd_speed,
        )
    });
    let sd_torque = sd("wheel_torque_N_m")?;
    let wheel_torque = array::from_fn(|q| {
        channel(
            &truth.wheel_torque[q],
            Channel::WheelTorque,
            Stream::WheelTorque(q),
            sd_torque,
        )
    });

    let ground_speed = match rover.filter.ground_speed {
        GroundSpeedSource::None => None,
        GroundSpeedSource::Log => {
            let delay = effects.delay(Channel::GroundSpeed);
            let late: Vec<f64>;
            let values = if delay > 0.0 {
                late = truth
                    .time
                    .iter()
                    .zip(&truth.ground_speed)
                    .map(|(t, v)| history.at(*t, delay).unwrap_or(*v))
                    .collect();
                &late
            } else {
                &truth.ground_speed
            };
            Some(channel(
                values,
                Channel::GroundSpeed,
                Stream::GroundSpeed,
                sd("ground_speed_m_s")?,
            ))
        }
    };
    let yaw_rate = channel(
        &truth.yaw_rate,
        Channel::YawRate,
        Stream::YawRate,
        sd("yaw_rate_rad_s")?,
    );
    let accel_x = channel(
        &truth.accel_x,
        Channel::AccelX,
        Stream::AccelX,
        sd("accel_x_m_s2")?,
    );
    let sinkage = match (&truth.sinkage, rover.noise.get("sinkage_m")) {
        (Some(z), Some(sd)) => {
            let sd = sd * scenario.noise_scale;
            Some(array::from_fn(|q| {
                channel(&z[q], Channel::Sinkage, Stream::Sinkage(q), sd)
            }))
        }
        _ => None,
    };

    Ok(DriveLog {
        time: truth.time.clone(),
        segments: truth.segments.clone(),
        wheel_speed,
        wheel_torque: Some(wheel_torque),
        ground_speed,
        yaw_rate: Some(yaw_rate),
        accel_x: Some(accel_x),
        sinkage,
        pitch: declared.pitch,
        payload: declared.payload,
        pass: declared.pass,
        ..DriveLog::default()
    })
}
