//! From a drive log to windows of motion with their noise.

use std::collections::BTreeMap;

use super::predict::{
    KinematicPredictor, LATERAL, RAW, SPEED, VALUES, WHEEL, WHEEL_RATE, Window, YAW_RATE,
};
use super::scatter::{APART, NEXT, Place, pairs, scatter};
use crate::dataset::{ChannelInfo, DataSet, Factors, Observation};
use crate::drive::{Held, Line, SPEED_GATE, cells, declared, line, wider};
use crate::error::GapError;
use crate::logs::Logs;
use terra_data::{DriveLog, Rover, Series};
use terra_model::Vehicle;

/// How the reason of a standing window begins.
pub(crate) const STANDSTILL: &str = "standstill";

/// Standard deviations of its noise by which a window's motion must change otherwise than its wheels do to be on its way to where they
/// drive it.
const ON_ITS_WAY: f64 = 3.0;

/// Turns drive logs into windows and their predictor; where they are compared with another's, those of steady motion only: a simulator
/// and a real vehicle get under way differently, and no error of an ideal drive is smooth there.
///
/// # Errors
/// A rover file without vehicle, or without the noise of a used channel.
pub(crate) fn from_logs(
    logs: &Logs<'_, DriveLog>,
    rover: &Rover,
    compared: bool,
) -> Result<(DataSet, KinematicPredictor), GapError> {
    let vehicle = rover.nominal_vehicle().ok_or_else(|| {
        GapError::Mismatch("a drive log needs [vehicle] in the rover file".to_owned())
    })?;
    let noise = |name: &str| {
        rover.noise.get(name).ok_or_else(|| GapError::NoiseMissing {
            channel: name.to_owned(),
            or: String::new(),
        })
    };
    let wheel_sd = noise("wheel_speed_rad_s")?;
    let mut dropped: BTreeMap<String, usize> = BTreeMap::new();
    let mut windows: Vec<Window> = vec![];
    let mut observations: Vec<Observation> = vec![];
    let mut places: Vec<Place> = vec![];
    let mut group = 0;
    let mut notes = vec![];
    for (number, (prefix, log)) in logs.iter().enumerate() {
        let mut held = Held::default();
        let log = held.pass(log, true);
        notes.extend(held.note(prefix));
        let usual = rover.gap.window;
        let longer = wider(&log, usual).filter(|_| !rover.gap.window_given);
        notes.extend(longer.as_ref().map(|longer| longer.note(prefix)));
        let length = longer.map_or(usual, |longer| longer.window);
        let mut path = 0.0;
        let mut sources: Vec<(usize, &Series, f64)> = vec![];
        for (k, name, series) in [
            (SPEED, "ground_speed_m_s", &log.ground_speed),
            (YAW_RATE, "yaw_rate_rad_s", &log.yaw_rate),
            (LATERAL, "lateral_speed_m_s", &log.lateral_speed),
        ] {
            if let Some(series) = series {
                sources.push((k, series, noise(name)?));
            }
        }
        for segment in &log.segments {
            let mut start = segment.rows.start;
            let mut first = compared;
            while start < segment.rows.end {
                let t0 = log.time[start];
                let mut end = start;
                while end < segment.rows.end && log.time[end] < t0 + length - 1e-9 {
                    end += 1;
                }
                let rows = start..end;
                start = end;
                let mut drop = |reason: &str| *dropped.entry(reason.to_owned()).or_default() += 1;
                let wheels: Vec<Line> = log
                    .wheel_speed
                    .iter()
                    .filter_map(|w| line(&log.time, w, rows.clone(), wheel_sd))
                    .collect();
                if wheels.len() < 4 {
                    drop("window without all wheel speeds");
                    continue;
                }
                let (mut raw, mut sd) = ([0.0; RAW], [0.0; RAW]);
                for (q, w) in wheels.iter().enumerate() {
                    (raw[WHEEL + q], sd[WHEEL + q]) = (w.mean, w.mean_sd);
                    (raw[WHEEL_RATE + q], sd[WHEEL_RATE + q]) = (w.slope, w.slope_sd);
                }
                let rims: [f64; 4] = std::array::from_fn(|q| raw[WHEEL + q] * vehicle.wheel_radius);
                let sides = [0.5 * (rims[0] + rims[2]), 0.5 * (rims[1] + rims[3])];
                path += 0.5 * (sides[0] + sides[1]).abs() * length;
                if rims.iter().all(|rim| rim.abs() < SPEED_GATE) {
                    drop("standstill: all wheels below 0.12 m/s");
                    continue;
                }
                if std::mem::take(&mut first) {
                    drop("the beginning of a manoeuvre");
                    continue;
                }
                let mut measured = vec![];
                let mut on_its_way = false;
                for (k, series, channel_sd) in &sources {
                    if let Some(l) = line(&log.time, series, rows.clone(), *channel_sd) {
                        (raw[*k], sd[*k]) = (l.mean, l.mean_sd);
                        measured.push(*k);
                        let by_wheels = by_wheels(*k, &wheels, &vehicle);
                        on_its_way |= by_wheels.is_some_and(|w| l.leaves(&w, 0.5 * length));
                    }
                }
                if compared && on_its_way {
                    drop("motion that changes otherwise than its wheels turn");
                    continue;
                }
                if measured.is_empty() {
                    drop("window without ground speed and yaw rate");
                    continue;
                }
                let middle = rows.start + rows.len() / 2;
                let distance = log.distance.as_ref();
                let along = match declared(distance, rows.clone(), "window without distance_m") {
                    Ok(along) => along.unwrap_or(path),
                    Err(reason) => {
                        drop(reason);
                        continue;
                    }
                };
                let pitch = log.pitch.as_ref();
                let pitch = match cells(pitch, rows.clone(), "window without pitch_rad") {
                    Ok(pitch) => pitch.unwrap_or(0.0),
                    Err(reason) => {
                        drop(reason);
                        continue;
                    }
                };
                let ideal = (sides[1] - sides[0]) / vehicle.track;
                let yaw = if measured.contains(&YAW_RATE) {
                    raw[YAW_RATE]
                } else {
                    ideal
                };
                let window = Window {
                    raw,
                    measured: measured.clone(),
                    pitch,
                    path: along,
                    time: log.time[middle],
                    log: number,
                };
                observations.push(Observation {
                    index: windows.len(),
                    group: format!("{prefix}{}", segment.name),
                    condition: String::new(),
                    place: format!("{prefix}t = {:.2} s", log.time[middle]),
                    channels: measured.clone(),
                    values: measured.iter().map(|&k| raw[k]).collect(),
                    raw_sd: sd.to_vec(),
                    shift: Default::default(),
                    carried: vec![],
                    factors: Factors::from([
                        ("turning", turning(sides)),
                        ("speed", 0.5 * (sides[0] + sides[1])),
                        ("path", window.path),
                        ("time", window.time),
                        ("yaw_rate", ideal),
                        ("measured_yaw_rate", yaw),
                    ]),
                });
                windows.push(window);
                let ground = if logs.soils() > 1 { number } else { 0 };
                places.push(Place {
                    sides,
                    pitch,
                    group,
                    ground,
                });
            }
            group += 1;
        }
    }
    let mut data = DataSet {
        channels: channels(&places, vehicle.track),
        observations,
        dropped,
        notes,
        short_scatter: vec![],
        uneven: None,
    };
    add_scatter(&mut data, &windows, &places);
    let soils = logs.soils();
    Ok((
        data,
        KinematicPredictor {
            vehicle,
            windows,
            soils,
        },
    ))
}

/// What an ideal drive's wheels ask of a value: the mean and its change \[1/s\] with the noise of that.
fn by_wheels(value: usize, wheels: &[Line], vehicle: &Vehicle<f64>) -> Option<[f64; 3]> {
    let arm = match value {
        SPEED => [0.25; 2],
        YAW_RATE => [-0.5, 0.5].map(|side| side / vehicle.track),
        _ => return None,
    };
    let share = |q: usize| arm[q % 2] * vehicle.wheel_radius;
    let sum = |of: fn(&Line) -> f64| {
        let each = wheels.iter().enumerate();
        each.map(|(q, w)| share(q) * of(w)).sum::<f64>()
    };
    let each = wheels.iter().enumerate();
    let variance = each.map(|(q, w)| (share(q) * w.slope_sd).powi(2));
    Some([
        sum(|w| w.mean),
        sum(|w| w.slope),
        variance.sum::<f64>().sqrt(),
    ])
}

impl Line {
    /// Whether the motion changes otherwise than the wheels ask for, by more than noise and by more than matters within so much time.
    fn leaves(&self, [mean, slope, slope_sd]: &[f64; 3], time: f64) -> bool {
        // As much of it as the motion has of what they ask for.
        let share = (self.mean / mean).clamp(-2.0, 2.0);
        let share = if share.is_finite() { share } else { 1.0 };
        let change = (self.slope - share * slope).abs();
        change > ON_ITS_WAY * self.slope_sd.hypot(share * slope_sd)
            && change * time > ON_ITS_WAY * self.mean_sd
    }
}

/// How sharply the wheels of these sides' rim speeds turn: 0 straight on, 1 and -1 on the spot.
pub(super) fn turning([left, right]: [f64; 2]) -> f64 {
    (right - left) / (left.abs() + right.abs()).max(SPEED_GATE)
}

/// The channels, with the motion that typical wheel speeds would ideally give as their scale.
fn channels(places: &[Place], track: f64) -> Vec<ChannelInfo> {
    let n = places.len().max(1) as f64;
    let rms = |f: fn(&Place) -> f64| (places.iter().map(|p| f(p).powi(2)).sum::<f64>() / n).sqrt();
    let speed = rms(|p| 0.5 * (p.sides[0] + p.sides[1])).max(SPEED_GATE);
    let yaw = (rms(|p| p.sides[1] - p.sides[0]) / track).max(SPEED_GATE);
    let all: [(&str, &'static str, f64); VALUES] = [
        ("ground_speed_m_s", "m/s", speed),
        ("yaw_rate_rad_s", "rad/s", yaw),
        ("lateral_speed_m_s", "m/s", speed),
    ];
    all.into_iter()
        .map(|(name, unit, scale)| ChannelInfo {
            name: name.to_owned(),
            unit,
            scale,
        })
        .collect()
}

/// Raises each value's noise to the scatter between repeats, where the log has enough of them.
fn add_scatter(data: &mut DataSet, windows: &[Window], places: &[Place]) {
    let repeats = [(APART, ""), (NEXT, ", neighbours among them,")]
        .map(|(apart, which)| (pairs(places, apart), which));
    for k in 0..VALUES {
        let value = |i: usize| {
            let w: &Window = windows.get(i)?;
            w.measured.contains(&k).then(|| w.raw[k])
        };
        let Some(channel) = data.channels.get(k).cloned() else {
            continue;
        };
        let mut found = repeats.iter().filter_map(|(pairs, which)| {
            let (sd, n) = scatter(pairs, value)?;
            Some((sd, n, which))
        });
        match found.next() {
            Some((sd, n, which)) => {
                for o in &mut data.observations {
                    if let Some(own) = o.raw_sd.get_mut(k) {
                        *own = own.max(sd);
                    }
                }
                data.notes.push(format!(
                    "scatter of {} between {n} pairs of windows{which} at the same wheel speeds: {sd:.3} {}",
                    channel.name, channel.unit
                ));
            }
            None if windows.iter().any(|w| w.measured.contains(&k)) => data.notes.push(format!(
                "too few windows at the same wheel speeds to see the scatter of {}: its noise is the sensor's alone",
                channel.name
            )),
            None => {}
        }
    }
}
