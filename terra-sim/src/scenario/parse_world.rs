//! The optional tables of a drive: `[motor]`, `[sensor.<channel>]`, `[[patch]]`.

use std::collections::BTreeMap;

use terra_data::WHEELS;
use terra_model::nearest;

use super::parse::{Parsed, four_soils};
use super::toml_table::{Table, Value};
use super::{Motor, Patch, SensorSettings, SideSlip, World};

/// Columns a drive log can have, without wheels.
const CHANNELS: [&str; 5] = [
    "ground_speed_m_s",
    "yaw_rate_rad_s",
    "accel_x_m_s2",
    "accel_y_m_s2",
    "lateral_speed_m_s",
];
const PATH_CHANNEL: &str = "distance_m";
/// Columns of each wheel: stem and unit.
const WHEEL_CHANNELS: [(&str, &str); 4] = [
    ("wheel_speed", "_rad_s"),
    ("wheel_torque", "_N_m"),
    ("sinkage", "_m"),
    ("normal_load", "_N"),
];

/// Reads what the root table says of the world; the soils of the wheels come from `terrain`.
pub(super) fn world(root: &Table<'_, '_>) -> Parsed<World> {
    let side_slip = match root.get("side_slip") {
        Some(v) => match v.text()?.as_str() {
            "held" => SideSlip::Held,
            "free" => SideSlip::Free,
            other => return Err(v.error(format!("'{other}': expected held or free"))),
        },
        None => SideSlip::Held,
    };
    let upright = root.get("upright").map_or(Ok(false), |v| v.flag())?;
    let ruts = root.get("rut_memory").map_or(Ok(false), |v| v.flag())?;
    let patches = match root.get("patch") {
        Some(list) => patches(&list)?,
        None => Vec::new(),
    };
    let motor = root
        .get("motor")
        .map_or(Ok(Motor::default()), |v| motor(&v))?;
    let sensors = root
        .get("sensor")
        .map_or(Ok(BTreeMap::new()), |v| sensors(&v))?;
    let load_hold = root.get("load_hold").map_or(Ok(0.0), |v| {
        v.number_where("a share from 0, below .3", |s| (0.0..0.3).contains(&s))
    })?;
    Ok(World {
        load_hold,
        side_slip,
        upright,
        wheels: None,
        patches,
        ruts,
        motor,
        sensors,
    })
}

fn patches(list: &Value<'_, '_>) -> Parsed<Vec<Patch>> {
    let mut patches: Vec<Patch> = Vec::new();
    for item in list.items()? {
        let table = item.table()?;
        let from = table.get("from_m");
        let blend = table
            .get("blend_m")
            .map_or(Ok(0.0), |v| v.number_where("a length from 0", |b| b >= 0.0))?;
        let terrain = table.get("terrain");
        let missing = |key: &str| table.error(format!("missing key '{key}'"));
        let (no_from, no_terrain) = (missing("from_m"), missing("terrain"));
        table.finish()?;
        let free = patches
            .last()
            .map_or(f64::NEG_INFINITY, |p| p.from + p.blend);
        patches.push(Patch {
            from: from
                .ok_or(no_from)?
                .number_where("a place not before the end of the patch above", |x| {
                    x >= free
                })?,
            blend,
            terrain: four_soils(&terrain.ok_or(no_terrain)?)?,
        });
    }
    Ok(patches)
}

fn motor(value: &Value<'_, '_>) -> Parsed<Motor> {
    let table = value.table()?;
    let nominal = Motor::default();
    let read = |key: &'static str, absent: f64, what: &str, legal: fn(f64) -> bool| {
        table
            .get(key)
            .map_or(Ok(absent), |v| v.number_where(what, legal))
    };
    let positive: fn(f64) -> bool = |x| x > 0.0;
    let not_negative: fn(f64) -> bool = |x| x >= 0.0;
    let motor = Motor {
        torque_limit: read(
            "torque_limit_N_m",
            nominal.torque_limit,
            "a torque above 0",
            positive,
        )?,
        no_load_speed: read(
            "no_load_speed_rad_s",
            nominal.no_load_speed,
            "a speed above 0",
            positive,
        )?,
        droop: read("droop_N_m_s", nominal.droop, "a droop from 0", not_negative)?,
        delay: read("delay_s", nominal.delay, "a delay from 0", not_negative)?,
        lag: read("lag_s", nominal.lag, "a time constant from 0", not_negative)?,
        efficiency: read(
            "efficiency",
            nominal.efficiency,
            "a share above 0, at most 1",
            |x| x > 0.0 && x <= 1.0,
        )?,
        coulomb: read(
            "coulomb_N_m",
            nominal.coulomb,
            "a torque from 0",
            not_negative,
        )?,
        viscous: read(
            "viscous_N_m_s",
            nominal.viscous,
            "a friction from 0",
            not_negative,
        )?,
        torque_constant: read(
            "torque_constant_N_m_A",
            nominal.torque_constant,
            "a constant above 0",
            positive,
        )?,
        control_frequency: read(
            "control_frequency_rad_s",
            nominal.control_frequency,
            "a frequency above 0",
            positive,
        )?,
    };
    let lonely = motor.no_load_speed.is_finite() && motor.torque_limit.is_infinite();
    let complaint = table.error("no_load_speed_rad_s needs torque_limit_N_m");
    table.finish()?;
    if lonely { Err(complaint) } else { Ok(motor) }
}

/// All names a `[sensor.<channel>]` may have.
fn channel_names() -> Vec<String> {
    let mut names: Vec<String> = CHANNELS.iter().map(|c| (*c).to_owned()).collect();
    names.push(PATH_CHANNEL.to_owned());
    for (stem, unit) in WHEEL_CHANNELS {
        names.push(format!("{stem}{unit}"));
        names.extend(WHEELS.iter().map(|w| format!("{stem}_{w}{unit}")));
    }
    names
}

fn sensors(value: &Value<'_, '_>) -> Parsed<BTreeMap<String, SensorSettings>> {
    let known = channel_names();
    let mut sensors = BTreeMap::new();
    for (channel, settings) in value.table()?.entries() {
        if !known.iter().any(|k| k == channel) {
            let hint = match nearest(channel, known.iter().map(String::as_str)) {
                Some(near) => format!(", did you mean '{near}'?"),
                None => format!(", expected a column such as {}", CHANNELS.join(", ")),
            };
            return Err(settings.error(format!("unknown channel '{channel}'{hint}")));
        }
        sensors.insert(channel.to_owned(), sensor(&settings)?);
    }
    Ok(sensors)
}

fn sensor(value: &Value<'_, '_>) -> Parsed<SensorSettings> {
    let table = value.table()?;
    let nominal = SensorSettings::default();
    let read = |key: &'static str, absent: f64, what: &str, legal: fn(f64) -> bool| {
        table
            .get(key)
            .map_or(Ok(absent), |v| v.number_where(what, legal))
    };
    let any: fn(f64) -> bool = |_| true;
    let not_negative: fn(f64) -> bool = |x| x >= 0.0;
    let share: fn(f64) -> bool = |x| (0.0..=1.0).contains(&x);
    let settings = SensorSettings {
        scale: read("scale", nominal.scale, "a factor", any)?,
        bias: read("bias", nominal.bias, "a number", any)?,
        noise: table
            .get("noise")
            .map(|v| v.number_where("a standard deviation from 0", not_negative))
            .transpose()?,
        delay: read("delay_s", nominal.delay, "a delay from 0", not_negative)?,
        rate: table
            .get("rate_hz")
            .map(|v| v.number_where("a rate above 0", |x| x > 0.0))
            .transpose()?,
        dropout: read("dropout", nominal.dropout, "a share from 0 to 1", share)?,
        outliers: read("outliers", nominal.outliers, "a share from 0 to 1", share)?,
        outlier_size: read("outlier_size", nominal.outlier_size, "a number", any)?,
        min: read("min", nominal.min, "a number", any)?,
        max: read("max", nominal.max, "a number", any)?,
        step: read("step", nominal.step, "a step from 0", not_negative)?,
    };
    let crossed = table.error("min lies above max");
    table.finish()?;
    if settings.min > settings.max {
        return Err(crossed);
    }
    Ok(settings)
}
