//! From a drive log to windows with their noise.

use terra_data::{DriveLog, Rover};

use super::DrivePredictor;
use super::window::{BENT, Reader, bends, channels, is_full, usual};
use crate::dataset::DataSet;
use crate::error::GapError;
use crate::logs::Logs;

/// Turns drive logs into windows and their predictor.
///
/// # Errors
/// A rover file without vehicle, or without the noise of a used channel.
pub(crate) fn from_logs(
    logs: &Logs<'_, DriveLog>,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor), GapError> {
    let (data, predictor, bent) = windows(logs, rover)?;
    Ok((without(data, &bent), predictor))
}

/// The same of one log.
///
/// # Errors
/// As there.
pub(crate) fn from_log(
    log: &DriveLog,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor), GapError> {
    from_logs(&Logs::one(log), rover)
}

/// The same, those with a step or an outlier inside too.
///
/// # Errors
/// As there.
pub(crate) fn all_windows(
    log: &DriveLog,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor), GapError> {
    windows(&Logs::one(log), rover).map(|(data, predictor, _)| (data, predictor))
}

/// Leaves out, and counts, the bent windows.
fn without(mut data: DataSet, bent: &[bool]) -> DataSet {
    let before = data.observations.len();
    data.observations
        .retain(|o| !bent.get(o.index).copied().unwrap_or(false));
    if data.observations.len() < before {
        data.dropped
            .insert(BENT.to_owned(), before - data.observations.len());
    }
    data
}

/// All windows, and which of them are bent: a step or an outlier inside.
fn windows(
    logs: &Logs<'_, DriveLog>,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor, Vec<bool>), GapError> {
    let mut reader = Reader::new(rover)?;
    let has = |log: &DriveLog| log.ground_speed.is_some();
    let torque = logs.iter().any(|(_, log)| log.wheel_torque.is_some());
    let useful = torque && logs.iter().any(|(_, log)| has(log));
    for (_, log) in logs.iter() {
        if useful && has(log) {
            reader.needs_noise_of(log)?;
        }
    }
    for (number, (prefix, log)) in logs.iter().enumerate() {
        if !useful || !has(log) {
            let reason =
                "no ground speed, or neither wheel torques nor motor currents with [drivetrain]";
            *reader.dropped.entry(reason.to_owned()).or_default() += log.len();
            continue;
        }
        reader.begin_log(number, prefix);
        for segment in &log.segments {
            reader.begin_segment(log, &segment.name, segment.rows.start);
            let mut start = segment.rows.start;
            while start < segment.rows.end {
                let t0 = log.time[start];
                let mut end = start;
                while end < segment.rows.end && !is_full(t0, log.time[end], rover) {
                    end += 1;
                }
                reader.window(log, start..end);
                start = end;
            }
        }
    }
    let vehicle = reader.vehicle;
    if !useful {
        let empty = DataSet {
            channels: vec![],
            observations: vec![],
            dropped: reader.dropped,
            notes: vec![],
            short_scatter: vec![],
        };
        let predictor = DrivePredictor::new(vehicle, vec![], logs.soils());
        return Ok((empty, predictor, vec![]));
    }
    let usual = usual(&reader.scatters);
    let bent = reader.scatters.iter().map(|s| bends(s, &usual)).collect();
    let data = DataSet {
        channels: channels(&vehicle),
        short_scatter: reader.short_scatter(&usual),
        observations: reader.observations,
        dropped: reader.dropped,
        notes: vec![],
    };
    let predictor = DrivePredictor::new(vehicle, reader.windows, logs.soils());
    Ok((data, predictor, bent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::ROVER;
    use terra_data::{Segment, Series, parse_rover};

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

    /// .2 m/s and .5 rad/s: the inner wheels of a track of .6 m travel at .05 m/s, where no slip is to be known, although the
    /// vehicle moves and every wheel turns. At .4 m/s they travel.
    #[test]
    fn a_window_whose_inner_wheels_stand_is_left_out() {
        let turn = |speed: f64| {
            let mut log = DriveLog::default();
            let same = |v: f64| -> Series { std::iter::repeat_n(Some(v), 200).collect() };
            log.time = (0..200).map(|k| 0.01 * f64::from(k)).collect();
            log.wheel_speed = std::array::from_fn(|_| same(1.2 * speed / 0.25));
            log.wheel_torque = Some(std::array::from_fn(|_| same(5.0)));
            log.ground_speed = Some(same(speed));
            log.yaw_rate = Some(same(0.5));
            log.segments = vec![Segment {
                name: "turn".to_owned(),
                rows: 0..200,
            }];
            from_log(&log, &parse_rover(ROVER, "rover.toml").unwrap())
        };
        let (data, _) = turn(0.4).unwrap();
        assert!(data.observations.len() > 5);
        assert!(!data.dropped.keys().any(|why| why.contains("standstill")));
        match turn(0.2) {
            Ok((data, _)) => assert!(data.observations.is_empty(), "{:?}", data.dropped),
            Err(e) => assert!(e.to_string().contains("standstill"), "{e}"),
        }
    }
}
