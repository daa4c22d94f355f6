//! From the truth of a drive to its log: sensor effects, delay, white noise, and what `[sensor.<channel>]` adds.
//!
//! Reading = quantised(saturated(scale x report(truth, late) + bias + noise + outlier)), or missing. Noise has the sd of
//! `[noise]` x `noise_scale` (or the sensor's own), one random stream a channel and wheel, and another for its faults.
//! The log has what the vehicle of the reference paper measures (wheel speeds, applied torques, ground speed, yaw rate,
//! specific force), sinkage when `[noise]` names its sensor, whatever else a `[sensor.<channel>]` names, and what the
//! operator declared (pitch, roll, payload, pass).

use std::borrow::Cow;

use terra_data::{DriveLog, GroundSpeedSource, Noise, Rover, Series, WHEELS};
use terra_model::{Channel, Late, Touch};

use crate::effects::ActiveEffects;
use crate::error::SimError;
use crate::filter::Filter;
use crate::history::{History, Known};
use crate::noise::{Faults, Stream, White};
use crate::scenario::{Scenario, SensorSettings};
use crate::truth::DriveTruth;

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
    pub(crate) roll: Option<Series>,
    pub(crate) payload: Option<Series>,
    pub(crate) pass: Option<Series>,
}

/// True when some sensor may report what was a while ago.
pub(crate) fn any_late(scenario: &Scenario, effects: &ActiveEffects) -> bool {
    let mut sensors = scenario.world.sensors.values();
    effects.touch(Touch::Sensor) || sensors.any(|sensor| sensor.delay > 0.0)
}

/// Channels that every log has: their noise must be declared.
const USUAL: [&str; 5] = [
    "wheel_speed_rad_s",
    "wheel_torque_N_m",
    "ground_speed_m_s",
    "yaw_rate_rad_s",
    "accel_x_m_s2",
];

/// All that readings are made of.
struct Bench<'a> {
    truth: &'a DriveTruth,
    history: &'a History,
    scenario: &'a Scenario,
    rover: &'a Rover,
    effects: &'a ActiveEffects,
}

/// One channel of one wheel or of the body.
struct Source<'a> {
    /// Column without its wheel.
    key: &'static str,
    /// Column.
    column: String,
    values: &'a [f64],
    known: Option<Known>,
    channel: Option<Channel>,
    stream: Stream,
}

impl Bench<'_> {
    /// What the scenario says of this sensor: of the wheel's own before that of all wheels.
    fn settings(&self, source: &Source<'_>) -> SensorSettings {
        let sensors = &self.scenario.world.sensors;
        sensors
            .get(&source.column)
            .or_else(|| sensors.get(source.key))
            .copied()
            .unwrap_or_default()
    }

    fn named(&self, key: &str) -> bool {
        let sensors = &self.scenario.world.sensors;
        let (stem, unit) = wheel_column(key);
        sensors.contains_key(key)
            || WHEELS
                .iter()
                .any(|w| sensors.contains_key(&format!("{stem}_{w}{unit}")))
    }

    /// The truth of a source at a time of the run that `began` then.
    fn was(&self, source: &Source<'_>, time: f64, began: f64) -> Option<f64> {
        match source.known {
            Some(known) => self.history.at(known, time.max(began), 0.0),
            // Not a state: straight between rows, never across a reset.
            None => between(&self.truth.time, source.values, time.max(began)),
        }
    }

    /// The truth as late as sensor and effects have it: by a delay, and by the time constant of a filter that begins each run at rest.
    fn late<'v>(&self, source: &Source<'v>, delay: f64, constant: f64) -> Cow<'v, [f64]> {
        if delay <= 0.0 && constant <= 0.0 {
            return Cow::Borrowed(source.values);
        }
        let mut filter = Filter::new(constant);
        let rows = self.truth.time.iter().zip(source.values);
        let late = rows.map(|(&t, &now)| {
            let began = self.history.began(t).unwrap_or(t);
            let at = |time: f64| self.was(source, time - delay, began).unwrap_or(now);
            filter.follow(t, began, at)
        });
        Cow::Owned(late.collect())
    }

    fn series(&self, source: &Source<'_>) -> Result<Series, SimError> {
        let settings = self.settings(source);
        let scale = self.scenario.noise_scale;
        let sd = match settings.noise {
            Some(sd) => sd * scale,
            // A channel that only its own table asks for is as good as that table says.
            None if !USUAL.contains(&source.key) => {
                self.rover.noise.get(source.key).unwrap_or(0.0) * scale
            }
            None => sd_of(&self.rover.noise, source.key, scale)?,
        };
        let (seed, run) = (self.scenario.seed, self.scenario.run);
        let mut white = White::new(seed, run, source.stream, sd);
        let mut faults = Faults::new(seed, run, source.stream);
        let behind = |late| {
            let of = |c| self.effects.behind(c, late);
            source.channel.map_or(0.0, of)
        };
        let delay = behind(Late::Shifted) + settings.delay;
        let late = self.late(source, delay, behind(Late::Following));
        let plain = settings == SensorSettings::default();
        let mut last_tick = None;
        let readings = late.iter().zip(&self.truth.time).map(|(&v, &t)| {
            let report = source.channel.map_or(v, |c| self.effects.report(c, v));
            if plain {
                return Some(report + white.draw());
            }
            let [missing, off, sign] = faults.draw();
            let mut x = settings.scale * report + settings.bias + white.draw();
            if off < settings.outliers {
                x += if sign < 0.5 { -1.0 } else { 1.0 } * settings.outlier_size;
            }
            x = x.max(settings.min).min(settings.max);
            if settings.step > 0.0 {
                x = settings.step * (x / settings.step).round();
            }
            let ticks = settings.rate.is_none_or(|rate| {
                let tick = (t * rate + 1e-6).floor();
                last_tick.replace(tick) != Some(tick)
            });
            (ticks && missing >= settings.dropout).then_some(x)
        });
        Ok(readings.collect())
    }

    /// One channel of all wheels.
    fn wheels(
        &self,
        key: &'static str,
        values: &[Vec<f64>; 4],
        known: Option<fn(usize) -> Known>,
        channel: Option<Channel>,
        stream: fn(usize) -> Stream,
    ) -> Result<[Series; 4], SimError> {
        let (stem, unit) = wheel_column(key);
        let one = |q: usize| {
            self.series(&Source {
                key,
                column: format!("{stem}_{}{unit}", WHEELS[q]),
                values: &values[q],
                known: known.map(|k| k(q)),
                channel,
                stream: stream(q),
            })
        };
        Ok([one(0)?, one(1)?, one(2)?, one(3)?])
    }

    /// One channel of the body.
    fn body(
        &self,
        key: &'static str,
        values: &[f64],
        known: Option<Known>,
        channel: Option<Channel>,
        stream: Stream,
    ) -> Result<Series, SimError> {
        self.series(&Source {
            key,
            column: key.to_owned(),
            values,
            known,
            channel,
            stream,
        })
    }
}

/// Where the wheel's name stands in a column of each wheel.
fn wheel_column(key: &str) -> (&str, &str) {
    ["wheel_speed", "wheel_torque", "sinkage", "normal_load"]
        .iter()
        .find_map(|stem| key.split_at_checked(stem.len()).filter(|(s, _)| s == stem))
        .unwrap_or((key, ""))
}

/// Straight between rows.
fn between(time: &[f64], values: &[f64], wanted: f64) -> Option<f64> {
    let after = time.partition_point(|t| *t <= wanted);
    let row = |i: usize| Some((*time.get(i)?, *values.get(i)?));
    match (after.checked_sub(1).and_then(row), row(after)) {
        (Some((t0, a)), Some((t1, b))) => Some(a + (b - a) * (wanted - t0) / (t1 - t0)),
        (Some((_, v)), None) | (None, Some((_, v))) => Some(v),
        (None, None) => None,
    }
}

/// The log of a drive.
pub(crate) fn log(
    truth: &DriveTruth,
    history: &History,
    declared: Declared,
    scenario: &Scenario,
    rover: &Rover,
    effects: &ActiveEffects,
) -> Result<DriveLog, SimError> {
    let bench = Bench {
        truth,
        history,
        scenario,
        rover,
        effects,
    };
    let wheel_speed = bench.wheels(
        "wheel_speed_rad_s",
        &truth.speed_reading,
        // An encoder that an effect bends is late between rows; a sound one between steps.
        effects.unlisted().next().is_none().then_some(Known::Wheel),
        Some(Channel::WheelSpeed),
        Stream::WheelSpeed,
    )?;
    let wheel_torque = bench.wheels(
        "wheel_torque_N_m",
        &truth.torque_reading,
        None,
        Some(Channel::WheelTorque),
        Stream::WheelTorque,
    )?;
    let ground_speed = match rover.filter.ground_speed {
        GroundSpeedSource::None => None,
        GroundSpeedSource::Log => Some(bench.body(
            "ground_speed_m_s",
            &truth.ground_speed,
            Some(Known::Speed),
            Some(Channel::GroundSpeed),
            Stream::GroundSpeed,
        )?),
    };
    let yaw_rate = bench.body(
        "yaw_rate_rad_s",
        &truth.yaw_rate,
        Some(Known::YawRate),
        Some(Channel::YawRate),
        Stream::YawRate,
    )?;
    let accel_x = bench.body(
        "accel_x_m_s2",
        &truth.accel_x,
        None,
        Some(Channel::AccelX),
        Stream::AccelX,
    )?;
    let sinkage_key = "sinkage_m";
    let sinkage = match &truth.sinkage {
        Some(z) if rover.noise.get(sinkage_key).is_some() || bench.named(sinkage_key) => {
            Some(bench.wheels(
                sinkage_key,
                z,
                None,
                Some(Channel::Sinkage),
                Stream::Sinkage,
            )?)
        }
        _ => None,
    };
    let normal_load = if bench.named("normal_load_N") {
        Some(bench.wheels(
            "normal_load_N",
            &truth.normal_load,
            None,
            Some(Channel::NormalLoad),
            Stream::NormalLoad,
        )?)
    } else {
        None
    };
    let extra = |key: &'static str, values: &[f64], known, stream| {
        bench
            .named(key)
            .then(|| bench.body(key, values, known, None, stream))
            .transpose()
    };
    Ok(DriveLog {
        time: truth.time.clone(),
        segments: truth.segments.clone(),
        wheel_speed,
        wheel_torque: Some(wheel_torque),
        ground_speed,
        yaw_rate: Some(yaw_rate),
        accel_x: Some(accel_x),
        accel_y: extra("accel_y_m_s2", &truth.accel_y, None, Stream::AccelY)?,
        lateral_speed: extra(
            "lateral_speed_m_s",
            &truth.lateral_speed,
            Some(Known::LateralSpeed),
            Stream::LateralSpeed,
        )?,
        distance: extra(
            "distance_m",
            &truth.distance,
            Some(Known::Path),
            Stream::Distance,
        )?,
        sinkage,
        normal_load,
        pitch: declared.pitch,
        roll: declared.roll,
        payload: declared.payload,
        pass: declared.pass,
        ..DriveLog::default()
    })
}
