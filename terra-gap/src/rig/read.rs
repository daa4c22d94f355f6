//! From a rig log to rows with their noise.

use std::collections::{BTreeMap, BTreeSet};

use terra_data::{RigLog, RigRow, Rover, SoilSharing, slip_against_speeds};
use terra_model::order::ascending;

use super::{Output, RigPredictor, Row};
use crate::dataset::{ChannelInfo, DataSet, Factors, Observation};
use crate::error::GapError;
use crate::logs::Logs;

/// Name of the soil of conditions that share one where others have their own.
const SHARED: &str = "shared";

/// A row of one of several logs.
#[derive(Clone, Copy)]
struct Given<'a> {
    row: &'a RigRow,
    path: Option<f64>,
    log: usize,
    prefix: &'a str,
}

/// A reason without the row's own numbers, so that rows can be counted.
fn without_numbers(reason: &str) -> String {
    let words = reason.split(' ').map(|word| {
        let number = word.trim_end_matches([',', ':', ')']);
        match number.parse::<f64>() {
            Ok(_) => word.replacen(number, "…", 1),
            Err(_) => word.to_owned(),
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

/// Turns a rig log into a data set and its predictor.
///
/// # Errors
/// [`GapError::NoiseMissing`] for a used channel without any noise level.
pub(crate) fn from_log(log: &RigLog, rover: &Rover) -> Result<(DataSet, RigPredictor), GapError> {
    from_logs(&Logs::one(log), rover)
}

/// The same of several, their trials prefixed by the log's name.
///
/// # Errors
/// As there.
pub(crate) fn from_logs(
    logs: &Logs<'_, RigLog>,
    rover: &Rover,
) -> Result<(DataSet, RigPredictor), GapError> {
    let mut dropped: BTreeMap<String, usize> = BTreeMap::new();
    for (_, reason) in logs.iter().flat_map(|(_, log)| &log.dropped) {
        *dropped.entry(without_numbers(reason)).or_default() += 1;
    }
    // Forces would be laid to wrong slips, or to a wheel of another size.
    let contradicted: Vec<Option<String>> = logs
        .iter()
        .map(|(_, log)| slip_against_speeds(log, rover).map(|s| s.message))
        .collect();
    let given = logs.iter().enumerate().flat_map(|(log, (prefix, l))| {
        let given = move |(row, path)| Given {
            row,
            path,
            log,
            prefix,
        };
        l.rows.iter().zip(paths(&l.rows)).map(given)
    });
    let used: Vec<Given<'_>> = given
        .filter(|Given { row, log, .. }| {
            let (low, high) = rover.gap.slip_range;
            let reason = if let Some(why) = &contradicted[*log] {
                Some(why.as_str())
            } else if !(low..=high).contains(&row.slip.value) {
                Some("slip outside [gap] slip_range")
            } else if row.slip_angle.is_some_and(|a| a.abs() > 1e-6) {
                Some("slip angle outside the model")
            } else if row.normal_load.value <= 0.0 {
                Some("no load on the wheel")
            } else {
                None
            };
            if let Some(reason) = reason {
                *dropped.entry(reason.to_owned()).or_default() += 1;
            }
            reason.is_none()
        })
        .collect();

    let outputs: Vec<Output> = Output::ALL
        .into_iter()
        .filter(|o| used.iter().any(|g| o.of(g.row).is_some()))
        .collect();
    let load = median(used.iter().map(|g| g.row.normal_load.value));
    let channels: Vec<ChannelInfo> = outputs
        .iter()
        .map(|o| ChannelInfo {
            name: o.name().to_owned(),
            unit: o.unit(),
            scale: match o {
                Output::DrawbarPull => load,
                Output::Torque => load * rover.wheel.radius,
                Output::Sinkage => {
                    2.0 * median(
                        used.iter()
                            .filter_map(|g| g.row.sinkage)
                            .map(|m| m.value.abs()),
                    )
                }
            },
        })
        .collect();

    let noise = |name: &str,
                 row_sd: Option<f64>,
                 of: &dyn Fn(&RigRow) -> Option<f64>|
     -> Result<f64, GapError> {
        row_sd
            .or_else(|| rover.noise.get(name))
            .or_else(|| repeat_scatter(&used, logs.soils() > 1, of))
            .ok_or_else(|| GapError::NoiseMissing {
                channel: name.to_owned(),
                or: format!(
                    ", or a column '{}', or repeats of each trial",
                    sd_column(name)
                ),
            })
    };

    let soils = soils(logs, rover);
    let lugs = used.iter().any(|g| has_lugs(rover, &g.row.condition));
    let mut rows = Vec::with_capacity(used.len());
    let mut observations = Vec::with_capacity(used.len());
    for &Given {
        row,
        path,
        log,
        prefix,
    } in &used
    {
        let wheel = rover.wheel_of(&row.condition);
        let mut r = Row {
            outputs: vec![],
            values: vec![],
            slip: row.slip.value,
            load: row.normal_load.value,
            wheel,
            earlier_passes: f64::from(row.pass.max(1)) - 1.0,
            speed: row.travel_speed.unwrap_or(0.0),
            wheel_speed: row
                .wheel_speed
                .or_else(|| wheel_speed(row, wheel.radius))
                .unwrap_or(0.0),
            path: path.unwrap_or(0.0),
            soil: {
                let own = soil_of(logs, rover, log, &row.condition);
                soils.binary_search(&own).unwrap_or(0)
            },
            bare: is_bare(rover, lugs, &row.condition),
        };
        let mut raw_sd = vec![];
        let mut present = vec![];
        for (c, output) in outputs.iter().enumerate() {
            if let Some(m) = output.of(row) {
                r.outputs.push(*output);
                r.values.push(m.value);
                let sensor = noise(output.name(), m.sd, &|row| output.of(row).map(|m| m.value))?;
                if m.sd == Some(0.0) {
                    return Err(GapError::Mismatch(format!(
                        "{prefix}line {}: {} is 0, expected a noise above 0: nothing is measured without",
                        row.line,
                        sd_column(output.name())
                    )));
                }
                // A sensor's stated noise says nothing of the ground; what rows or repeats scatter by holds both.
                let stated = m.sd.is_none() && rover.noise.get(output.name()).is_some();
                let ground = output.roughness().filter(|_| stated);
                let ground = ground.and_then(|key| rover.noise.get(key));
                raw_sd.push(sensor.hypot(ground.unwrap_or(0.0)));
                present.push(c);
            }
        }
        if present.is_empty() {
            *dropped
                .entry("no pull, torque or sinkage".to_owned())
                .or_default() += 1;
            continue;
        }
        raw_sd.push(noise("slip", row.slip.sd, &|_| None).or_else(|_| speed_noise(row, rover))?);
        raw_sd.push(noise("normal_load_N", row.normal_load.sd, &|row| {
            Some(row.normal_load.value)
        })?);
        let mut factors = Factors::from([
            ("slip", row.slip.value),
            ("load", row.normal_load.value),
            ("pass", f64::from(row.pass.max(1))),
        ]);
        if let Some(v) = row.travel_speed {
            factors.insert("speed", v);
        }
        if let Some(t) = row.time {
            factors.insert("time", t);
        }
        if let Some(x) = path {
            factors.insert("path", x);
        }
        observations.push(Observation {
            index: rows.len(),
            group: format!("{prefix}{}", row.trial),
            condition: row.condition.clone(),
            place: format!("{prefix}line {}", row.line),
            channels: present,
            values: r.values.clone(),
            raw_sd,
            shift: Default::default(),
            carried: vec![],
            factors,
        });
        rows.push(r);
    }
    let mut notes = vec![];
    for (prefix, log) in logs.iter() {
        let name = prefix.strip_suffix('/').map(|n| format!("{n}: "));
        let name = name.unwrap_or_default();
        notes.extend(log.warnings.iter().map(|w| format!("{name}{w}")));
    }
    let braking = rows.iter().filter(|r| r.slip < 0.0).count();
    if braking > 0 {
        notes.push(format!(
            "{braking} rows are braking (slip < 0), where the wheel models are extensions without experimental support"
        ));
    }
    Ok((
        DataSet {
            channels,
            observations,
            dropped,
            notes,
            short_scatter: vec![],
            uneven: None,
        },
        RigPredictor {
            rows,
            soils: soils.len().max(1),
        },
    ))
}

/// The name of the soil of a log's rows of one condition.
fn soil_of(logs: &Logs<'_, RigLog>, rover: &Rover, log: usize, condition: &str) -> String {
    let own = rover.conditions.get(condition);
    let own = own.is_some_and(|c| c.soil == SoilSharing::Own);
    match (logs.labels().get(log), own) {
        (Some(log), true) => format!("{log}/{condition}"),
        (Some(log), false) => log.clone(),
        (None, true) => condition.to_owned(),
        (None, false) => SHARED.to_owned(),
    }
}

/// The names of the soils in alphabetical order; empty where there is one.
pub(crate) fn soils(logs: &Logs<'_, RigLog>, rover: &Rover) -> Vec<String> {
    let mut names = BTreeSet::new();
    for (log, (_, l)) in logs.iter().enumerate() {
        let of = |row: &RigRow| soil_of(logs, rover, log, &row.condition);
        names.extend(l.rows.iter().map(of));
    }
    let several = names.len() > 1;
    names.into_iter().filter(|_| several).collect()
}

/// A rig of which every condition has the same soil.
pub(crate) fn on_one_soil(rover: &Rover) -> Rover {
    let mut rover = rover.clone();
    for condition in rover.conditions.values_mut() {
        condition.soil = SoilSharing::Shared;
    }
    rover
}

/// Whether the wheel of a condition is said to have lugs.
fn has_lugs(rover: &Rover, condition: &str) -> bool {
    rover.wheel_of(condition).grouser_height > 0.0
}

/// Whether it is said to have none: by its name, or where the wheel of another condition is said to have some.
pub(crate) fn is_bare(rover: &Rover, others: bool, condition: &str) -> bool {
    !has_lugs(rover, condition) && (others || condition.contains("smooth"))
}

/// Path of each row since its trial, or its pass, began \[m\], where every row tells time and travel speed.
fn paths(rows: &[RigRow]) -> Vec<Option<f64>> {
    let mut last: Option<(&RigRow, f64)> = None;
    let path = |row: &RigRow| row.time.zip(row.travel_speed);
    if rows.iter().any(|row| path(row).is_none()) {
        return vec![None; rows.len()];
    }
    let found = rows.iter().map(|row| {
        let (time, speed) = path(row)?;
        let on = last.and_then(|(before, x)| {
            let (t, v) = path(before)?;
            let same = (&before.trial, before.pass) == (&row.trial, row.pass) && time > t;
            same.then_some(x + (time - t) * 0.5 * (speed + v))
        });
        let x = on.unwrap_or(0.0);
        last = Some((row, x));
        Some(x)
    });
    found.collect()
}

/// ω \[rad/s\] that slip and travel speed tell of a wheel that does not stand or spin in place.
fn wheel_speed(row: &RigRow, radius: f64) -> Option<f64> {
    let v = row.travel_speed.filter(|v| *v > 0.0)?;
    let rim = rim_speed(v, row.slip.value, 0.0);
    rim.is_finite().then_some(rim / radius)
}

/// R ω of a wheel that travels at v with a slip, whose size is held at 1 less this: driving 1 - s = v/(R ω), braking 1 + s = R ω/v.
fn rim_speed(v: f64, slip: f64, least: f64) -> f64 {
    let ratio = 1.0 - slip.abs();
    if slip < 0.0 {
        v * ratio
    } else {
        v / ratio.max(least)
    }
}

fn sd_column(name: &str) -> String {
    match name.split_once("_N") {
        Some((stem, rest)) => format!("{stem}_sd_N{rest}"),
        None => match name.strip_suffix("_m") {
            Some(stem) => format!("{stem}_sd_m"),
            None => format!("{name}_sd"),
        },
    }
}

/// Slip noise from the noise of the two speeds, where the file gives those instead.
fn speed_noise(row: &RigRow, rover: &Rover) -> Result<f64, GapError> {
    let missing = || GapError::NoiseMissing {
        channel: "slip".to_owned(),
        or: ", or a column 'slip_sd', or travel_speed_m_s and wheel_speed_rad_s to both".to_owned(),
    };
    let travel = rover.noise.get("travel_speed_m_s").ok_or_else(missing)?;
    let v = row.travel_speed.filter(|v| *v != 0.0).ok_or_else(missing)?;
    let rim_noise = rover
        .noise
        .get("rim_speed_m_s")
        .or_else(|| {
            rover
                .noise
                .get("wheel_speed_rad_s")
                .map(|w| w * rover.wheel.radius)
        })
        .unwrap_or(0.0);
    // 1 - s (driving) or 1 + s (braking) is a ratio of the two speeds.
    let ratio = 1.0 - row.slip.value.abs();
    let rim = rim_speed(v, row.slip.value, 1e-3);
    Ok(ratio * ((travel / v).powi(2) + (rim_noise / rim.abs().max(1e-9)).powi(2)).sqrt())
}

/// Standard deviation of repeats: rows of equal condition and pass whose slip and load agree within 2 %. On another soil
/// (`own`) a row repeats nothing.
fn repeat_scatter(
    rows: &[Given<'_>],
    own: bool,
    of: &dyn Fn(&RigRow) -> Option<f64>,
) -> Option<f64> {
    let (mut sum, mut dof) = (0.0, 0usize);
    let mut used = vec![false; rows.len()];
    for i in 0..rows.len() {
        if used[i] {
            continue;
        }
        let alike: Vec<usize> = (i..rows.len())
            .filter(|&j| {
                let (a, b) = (rows[i].row, rows[j].row);
                (!own || rows[i].log == rows[j].log)
                    && a.condition == b.condition
                    && a.pass == b.pass
                    && (a.slip.value - b.slip.value).abs() < 0.02
                    && (a.normal_load.value / b.normal_load.value - 1.0).abs() < 0.02
            })
            .collect();
        let values: Vec<f64> = alike.iter().filter_map(|&j| of(rows[j].row)).collect();
        alike.iter().for_each(|&j| used[j] = true);
        if values.len() > 1 {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            sum += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            dof += values.len() - 1;
        }
    }
    (dof >= 3 && sum > 0.0).then(|| (sum / dof as f64).sqrt())
}

pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut v: Vec<f64> = values.collect();
    ascending(&mut v, |v| *v);
    match v.len() {
        0 => 0.0,
        n if n % 2 == 1 => v[n / 2],
        n => 0.5 * (v[n / 2 - 1] + v[n / 2]),
    }
}

#[cfg(test)]
mod reasons {
    use super::without_numbers;

    /// Rows that are left out by one rule are counted together, whatever their numbers.
    #[test]
    fn a_reason_has_no_numbers_of_a_row() {
        let load = |w: &str| {
            without_numbers(&format!(
                "normal load {w} N, expected a wheel on the ground"
            ))
        };
        assert_eq!(load("-2.458"), load("-10"));
        assert_eq!(
            load("-2.458"),
            "normal load … N, expected a wheel on the ground"
        );
        let slip =
            |x: &str| without_numbers(&format!("slip {x}: the wheel turns against its motion"));
        assert_eq!(slip("1.0078"), slip("1.02"));
    }
}
