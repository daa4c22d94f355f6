//! From a drive log to windows with their noise.

use std::collections::BTreeMap;

use terra_data::{DriveLog, Rover, Series, WHEELS};
use terra_model::library_slip;

use super::{
    ACCEL, DrivePredictor, GRAVITY, RAW, SPEED, SPEED_GATE, SPEED_RATE, TORQUE, VALUES, WHEEL,
    WHEEL_RATE, Window, YAW_ACCELERATION, YAW_RATE,
};
use crate::dataset::{ChannelInfo, DataSet, Factors, Observation};
use crate::error::GapError;
use crate::rig::median;

/// Share of a window's samples that a channel must have.
const PRESENT: f64 = 0.6;

/// How many times more than in the median window a channel may scatter around its line. A step inside a window has a mean
/// motion but not the mean forces of it.
const BENDS: f64 = 4.0;
/// Change of a wheel's slip within a window above which forces are averaged over it.
const SLIP_CHANGE: f64 = 0.03;
/// Time over which the ground's roughness stays alike \[s\]: tens of ms.
const CORRELATION: f64 = 0.05;
/// Jump of speed and wheels, in their noise, that begins a run of its own.
const JUMP: f64 = 3.5;
/// How fast wheels spin up under their motors \[rad/s²\].
const SPIN_UP: f64 = 30.0;
/// Channels whose scatter is looked at: four torques, a_x, v, r, four ω.
const SERIES: usize = 11;

/// Mean, slope and their 1-sigma of one channel over a window.
pub(crate) struct Line {
    pub(crate) mean: f64,
    pub(crate) slope: f64,
    pub(crate) mean_sd: f64,
    pub(crate) slope_sd: f64,
    /// Mean square around the line, in units of the sensor's variance.
    pub(crate) scatter: f64,
}

pub(crate) fn line(
    time: &[f64],
    series: &Series,
    rows: std::ops::Range<usize>,
    sd: f64,
) -> Option<Line> {
    let total = rows.len();
    let points: Vec<(f64, f64)> = rows
        .filter_map(|i| Some((*time.get(i)?, series.get(i)?)))
        .collect();
    let n = points.len() as f64;
    if n < 3.0 || n < PRESENT * total as f64 {
        return None;
    }
    let (t, y) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let stt: f64 = points.iter().map(|p| (p.0 - t).powi(2)).sum();
    let sty: f64 = points.iter().map(|p| (p.0 - t) * (p.1 - y)).sum();
    let slope = sty / stt;
    let around = |p: &(f64, f64)| (p.1 - y - slope * (p.0 - t)).powi(2);
    let square = points.iter().map(around).sum::<f64>() / (n - 2.0).max(1.0);
    Some(Line {
        mean: y,
        slope,
        mean_sd: sd / n.sqrt(),
        slope_sd: sd / stt.sqrt(),
        scatter: if sd > 0.0 { square / (sd * sd) } else { 0.0 },
    })
}

/// True where speed and wheels jump as no vehicle's do from one row to the next: a run of its own begins, on its own ground.
fn begins_anew(log: &DriveLog, speed: &Series, row: usize, speed_sd: f64, wheel_sd: f64) -> bool {
    let Some(last) = row.checked_sub(1) else {
        return false;
    };
    let jump = |series: &Series| Some(series.get(row)? - series.get(last)?);
    let two = std::f64::consts::SQRT_2;
    let rows = log.time.get(last).zip(log.time.get(row));
    let elapsed = rows.map_or(0.0, |(a, b)| b - a);
    let spun: Option<f64> = log.wheel_speed.iter().map(jump).sum();
    // The mean of four wheels, against its noise and what a motor does to them meanwhile.
    let wheels = spun.map_or(0.0, |sum| sum / 4.0 / (wheel_sd / two + SPIN_UP * elapsed));
    jump(speed).is_some_and(|v| (v / (speed_sd * two)).hypot(wheels) > JUMP)
}

/// Turns a drive log into windows and their predictor.
///
/// # Errors
/// A rover file without vehicle, or without the noise of a used channel.
pub(crate) fn from_log(
    log: &DriveLog,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor), GapError> {
    let (data, predictor, bent) = windows(log, rover)?;
    Ok((without(data, &bent), predictor))
}

/// The same, those with a step or an outlier inside too.
///
/// # Errors
/// As there.
pub(crate) fn all_windows(
    log: &DriveLog,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor), GapError> {
    windows(log, rover).map(|(data, predictor, _)| (data, predictor))
}

/// Leaves out, and counts, the bent windows.
fn without(mut data: DataSet, bent: &[bool]) -> DataSet {
    let before = data.observations.len();
    data.observations
        .retain(|o| !bent.get(o.index).copied().unwrap_or(false));
    if data.observations.len() < before {
        let reason = "a step or an outlier inside the window";
        data.dropped
            .insert(reason.to_owned(), before - data.observations.len());
    }
    data
}

/// All windows, and which of them are bent: a step or an outlier inside.
fn windows(
    log: &DriveLog,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor, Vec<bool>), GapError> {
    let vehicle = rover.nominal_vehicle().ok_or_else(|| {
        GapError::Mismatch("a drive log needs [vehicle] in the rover file".to_owned())
    })?;
    let noise = |name: &str| {
        rover.noise.get(name).ok_or_else(|| GapError::NoiseMissing {
            channel: name.to_owned(),
            sd_column: format!("{name} (drive logs have no sd columns)"),
        })
    };
    let (Some(ground_speed), Some(torque)) = (&log.ground_speed, &log.wheel_torque) else {
        return Ok((
            DataSet {
                channels: vec![],
                observations: vec![],
                dropped: BTreeMap::from([(
                    "no ground speed, or neither wheel torques nor motor currents with [drivetrain]".to_owned(),
                    log.len(),
                )]),
                notes: vec![],
                short_scatter: vec![],
            },
            DrivePredictor { vehicle, windows: vec![] },
            vec![],
        ));
    };
    let (speed_sd, wheel_sd, torque_sd) = (
        noise("ground_speed_m_s")?,
        noise("wheel_speed_rad_s")?,
        noise("wheel_torque_N_m")?,
    );
    let yaw_sd = if log.yaw_rate.is_some() {
        noise("yaw_rate_rad_s")?
    } else {
        0.0
    };
    let accel_sd = if log.accel_x.is_some() {
        noise("accel_x_m_s2")?
    } else {
        0.0
    };

    let weight = vehicle.mass * GRAVITY;
    let mut channels: Vec<ChannelInfo> = WHEELS
        .iter()
        .map(|w| ChannelInfo {
            name: format!("wheel_torque_{w}_N_m"),
            unit: "N m",
            scale: weight / 4.0 * vehicle.wheel_radius,
        })
        .collect();
    for (name, unit, scale) in [
        ("accel_x_m_s2", "m/s2", GRAVITY),
        ("ground_speed_rate_m_s2", "m/s2", GRAVITY),
        (
            "yaw_acceleration_rad_s2",
            "rad/s2",
            weight * vehicle.track / (2.0 * vehicle.yaw_inertia),
        ),
    ] {
        channels.push(ChannelInfo {
            name: name.to_owned(),
            unit,
            scale,
        });
    }

    let mut dropped: BTreeMap<String, usize> = BTreeMap::new();
    let mut windows = vec![];
    let mut observations = vec![];
    // Scatter around the line of every channel, window by window.
    let mut scatters: Vec<[f64; SERIES]> = vec![];
    let mut path = 0.0;
    for segment in &log.segments {
        let mut start = segment.rows.start;
        if begins_anew(log, ground_speed, start, speed_sd, wheel_sd) {
            path = 0.0;
        }
        let mut first = true;
        while start < segment.rows.end {
            let t0 = log.time[start];
            let mut end = start;
            while end < segment.rows.end && log.time[end] < t0 + rover.gap.window - 1e-9 {
                end += 1;
            }
            let rows = start..end;
            start = end;
            let mut drop = |reason: &str| *dropped.entry(reason.to_owned()).or_default() += 1;
            // Windows that are left out are driven all the same, and in reverse the way leads back.
            let v = line(&log.time, ground_speed, rows.clone(), speed_sd);
            let driven = v.as_ref().map_or(0.0, |v| v.mean) * rover.gap.window;
            let middle_path = path + 0.5 * driven;
            path += driven;
            // What was before a manoeuvre reaches into its beginning: sensors lag, controllers catch up.
            if std::mem::take(&mut first) {
                drop("the beginning of a manoeuvre");
                continue;
            }
            let Some(v) = v else {
                drop("window without ground speed");
                continue;
            };
            let wheels: Vec<Line> = log
                .wheel_speed
                .iter()
                .filter_map(|w| line(&log.time, w, rows.clone(), wheel_sd))
                .collect();
            if wheels.len() < 4 {
                drop("window without all wheel speeds");
                continue;
            }
            let yaw = log
                .yaw_rate
                .as_ref()
                .and_then(|r| line(&log.time, r, rows.clone(), yaw_sd));
            if v.mean.abs() < SPEED_GATE
                || wheels
                    .iter()
                    .any(|w| (w.mean * vehicle.wheel_radius).abs() < SPEED_GATE)
            {
                drop("standstill: below 0.12 m/s");
                continue;
            }
            if wheels.iter().any(|w| w.mean * v.mean < 0.0) {
                drop("a wheel turns against the motion");
                continue;
            }
            let mut raw = [0.0; RAW];
            let mut sd = [0.0; RAW];
            let mut measured = vec![];
            let mut scatter = [0.0; SERIES];
            for (q, series) in torque.iter().enumerate() {
                if let Some(l) = line(&log.time, series, rows.clone(), torque_sd) {
                    (raw[TORQUE + q], sd[TORQUE + q]) = (l.mean, l.mean_sd);
                    scatter[q] = l.scatter;
                    measured.push(TORQUE + q);
                }
            }
            if let Some(l) = log
                .accel_x
                .as_ref()
                .and_then(|a| line(&log.time, a, rows.clone(), accel_sd))
            {
                (raw[ACCEL], sd[ACCEL]) = (l.mean, l.mean_sd);
                scatter[4] = l.scatter;
                measured.push(ACCEL);
            }
            (raw[SPEED_RATE], sd[SPEED_RATE]) = (v.slope, v.slope_sd);
            measured.push(SPEED_RATE);
            (raw[SPEED], sd[SPEED]) = (v.mean, v.mean_sd);
            scatter[5] = v.scatter;
            // Without a yaw rate the vehicle is taken to drive straight; its yaw equation is then not used.
            if let Some(r) = yaw {
                (raw[YAW_ACCELERATION], sd[YAW_ACCELERATION]) = (r.slope, r.slope_sd);
                (raw[YAW_RATE], sd[YAW_RATE]) = (r.mean, r.mean_sd);
                scatter[6] = r.scatter;
                measured.push(YAW_ACCELERATION);
            }
            for (q, w) in wheels.iter().enumerate() {
                (raw[WHEEL + q], sd[WHEEL + q]) = (w.mean, w.mean_sd);
                scatter[7 + q] = w.scatter;
                (raw[WHEEL_RATE + q], sd[WHEEL_RATE + q]) = (w.slope, w.slope_sd);
            }
            let middle = rows.start + rows.len() / 2;
            let mean = |s: &Option<Series>| s.as_ref().and_then(|s| s.get(middle));
            let slips =
                (0..4).map(|q| library_slip(raw[WHEEL + q] * vehicle.wheel_radius, raw[SPEED]));
            let slip = slips.sum::<f64>() / 4.0;
            let (low, high) = rover.gap.slip_range;
            if !(low..=high).contains(&slip) {
                drop("slip outside [gap] slip_range");
                continue;
            }
            let pass = mean(&log.pass).unwrap_or(1.0);
            let payload = mean(&log.payload).unwrap_or(0.0);
            let ends = [-0.5, 0.5].map(|end| {
                let dt = end * rover.gap.window;
                let v = raw[SPEED] + raw[SPEED_RATE] * dt;
                [0, 1, 2, 3].map(|q| {
                    let rim = (raw[WHEEL + q] + raw[WHEEL_RATE + q] * dt) * vehicle.wheel_radius;
                    library_slip(rim, v)
                })
            });
            let change = (0..4).map(|q| (ends[1][q] - ends[0][q]).abs());
            let nodes = if change.fold(0.0, f64::max) > SLIP_CHANGE {
                // Gauss-Legendre, two points.
                let dt = rover.gap.window / 12f64.sqrt();
                vec![-dt, dt]
            } else {
                vec![0.0]
            };
            let window = Window {
                raw,
                nodes,
                measured: measured.clone(),
                pitch: mean(&log.pitch).unwrap_or(0.0),
                roll: mean(&log.roll).unwrap_or(0.0),
                payload,
                earlier_passes: (pass - 1.0).max(0.0),
                path: mean(&log.distance).unwrap_or(middle_path),
                time: log.time[middle],
            };
            observations.push(Observation {
                index: windows.len(),
                group: segment.name.clone(),
                condition: String::new(),
                place: format!("t = {:.2} s", log.time[middle]),
                channels: measured.clone(),
                values: measured.iter().map(|&k| raw[k]).collect(),
                raw_sd: sd.to_vec(),
                factors: Factors::from([
                    ("slip", slip),
                    ("speed", v.mean),
                    ("path", window.path),
                    ("time", window.time),
                    ("pass", pass),
                    ("load", weight + payload * GRAVITY),
                    ("yaw_rate", raw[YAW_RATE]),
                ]),
            });
            windows.push(window);
            scatters.push(scatter);
        }
    }
    let usual: [f64; SERIES] =
        std::array::from_fn(|k| median(scatters.iter().map(|s| s[k])).max(f64::MIN_POSITIVE));
    // White noise alone scatters by 1 in the mean; .963 is the median of chi2/n for the eighteen freedoms of twenty samples.
    let beyond = |k: usize, sd: f64| {
        let correlated = (CORRELATION / rover.gap.window).min(1.0);
        Some((usual[k] / 0.963 - 1.0).max(0.0) * sd * sd * correlated)
    };
    let mut short_scatter = vec![None; VALUES];
    for q in 0..4 {
        short_scatter[TORQUE + q] = beyond(q, torque_sd);
    }
    short_scatter[ACCEL] = log.accel_x.is_some().then(|| beyond(4, accel_sd)).flatten();
    let bends = |s: &[f64; SERIES]| s.iter().zip(&usual).any(|(s, usual)| *s > BENDS * usual);
    let bent = scatters.iter().map(bends).collect();
    Ok((
        DataSet {
            channels,
            observations,
            dropped,
            notes: vec![],
            short_scatter,
        },
        DrivePredictor { vehicle, windows },
        bent,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_data::{Segment, parse_rover};

    const ROVER: &str = r#"
[vehicle]
mass_kg = 100.0
yaw_inertia_kg_m2 = 10.0
track_m = 0.6
wheelbase_m = 0.6
cg_to_front_axle_m = 0.3
cg_height_m = 0.2
yaw_damping_N_m_s = 8.0

[wheel]
radius_m = 0.25
width_m = 0.15
inertia_kg_m2 = 0.25
damping_N_m_s = 0.1

[terrain]
model = "wong-reece"
start = "dry_sand"

[noise]
wheel_speed_rad_s = 0.02
wheel_torque_N_m = 0.5
ground_speed_m_s = 0.03
"#;

    /// 1 m/s ahead, a new run at -1 m/s, and its continuation: x = t, then x = -t from its own start to the end. The first
    /// window of a manoeuvre is left out, but driven.
    #[test]
    fn the_path_is_signed_counts_what_is_left_out_and_starts_with_a_run() {
        let mut log = DriveLog::default();
        let mut speed = Series::with_capacity(600);
        let mut torque = Series::with_capacity(600);
        let mut wheel = Series::with_capacity(600);
        for k in 0..600 {
            let v = if k < 200 { 1.0 } else { -1.0 };
            log.time.push(0.01 * f64::from(k));
            speed.push(Some(v));
            wheel.push(Some(v / 0.25 * 1.1));
            torque.push(Some(1.0));
        }
        log.wheel_speed = std::array::from_fn(|_| wheel.clone());
        log.wheel_torque = Some(std::array::from_fn(|_| torque.clone()));
        log.ground_speed = Some(speed);
        log.segments = [0..200, 200..400, 400..600]
            .into_iter()
            .enumerate()
            .map(|(k, rows)| Segment {
                name: k.to_string(),
                rows,
            })
            .collect();
        let rover = parse_rover(ROVER, "rover.toml").unwrap();
        let (data, _) = all_windows(&log, &rover).unwrap();
        assert_eq!(data.observations.len(), 27);
        for o in &data.observations {
            let t = o.factors["time"];
            // A window of .2 s has its middle sample at .1 s, which is the middle of what it drives.
            let way = if t < 2.0 { t } else { 2.0 - t };
            assert!(
                (o.factors["path"] - way).abs() < 1e-9,
                "{} at {t}",
                o.factors["path"]
            );
        }
    }
}
