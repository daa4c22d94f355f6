//! From the text of a scenario file to a [`Scenario`].

use std::collections::BTreeMap;

use terra_data::{Start, WHEELS};
use toml::de::DeTable;

use super::parse_world;
use super::toml_table::{Source, Table, Value};
use super::{Command, DriveSegment, EffectSetting, Profile, Scenario, StartMotion, Trial};
use crate::error::ScenarioError;

pub(super) type Parsed<T> = Result<T, ScenarioError>;

/// Most numbers that the trials of a file hold: a few short lists multiply to any number.
const MOST_NUMBERS: usize = 10_000_000;
/// Numbers of a trial beside its slips and loads, at most.
const BESIDE: usize = 24;

/// Model of a scenario that names none.
const DEFAULT_MODEL: &str = "wong-reece";

pub(super) fn scenario(text: &str, file: &str) -> Parsed<Scenario> {
    let source = Source { text, file };
    let document = DeTable::parse(text)
        .map_err(|e| source.error(e.span().map_or(0, |s| s.start), e.message().to_owned()))?;
    let root = Table::new(source, document.get_ref(), 0..0);
    let has = |key: &str| document.get_ref().contains_key(key);
    if !has("rover") && (has("vehicle") || has("noise")) {
        return Err(root.error(
            "is a rover file, expected a scenario: seed, rover = \"the rover file\", rate_hz, terrain, and [[segment]] or [[trial]]",
        ));
    }

    let segments = match root.get("segment") {
        Some(list) => {
            let mut found: Vec<DriveSegment> = Vec::new();
            for (i, v) in list.items()?.iter().enumerate() {
                let next = segment(i, v)?;
                // In a log the two would be one.
                if found.last().is_some_and(|before| before.name == next.name) {
                    return Err(v.error(format!(
                        "the segment before is called '{}' too, expected a name of its own",
                        next.name
                    )));
                }
                found.push(next);
            }
            found
        }
        None => Vec::new(),
    };
    let trials = match root.get("trial") {
        Some(list) => all_trials(&list)?,
        None => Vec::new(),
    };
    let effects = match root.get("effect") {
        Some(list) => list
            .items()?
            .iter()
            .map(effect)
            .collect::<Parsed<Vec<_>>>()?,
        None => Vec::new(),
    };
    // Keys are asked for before anything is required, so that a misspelt key is named before its absence is.
    let seed = root.get("seed");
    let rover = root.get("rover");
    let rate = root.get("rate_hz");
    let terrain = root.get("terrain");
    let model = root.get("model");
    let noise_scale = root.get("noise_scale");
    let world = parse_world::world(&root)?;
    let missing = |key: &str| root.error(format!("missing key '{key}'"));
    let head = Scenario {
        seed: seed.map_or(Ok(0), |v| v.whole())?,
        run: 0,
        rover: rover.map_or(Ok(String::new()), |v| v.text())?,
        rate: rate.map_or(Ok(0.0), |v| v.number_where("a rate above 0", |r| r > 0.0))?,
        left: Start::Id(String::new()),
        right: Start::Id(String::new()),
        model: model.map_or(Ok(DEFAULT_MODEL.to_owned()), |v| v.text())?,
        noise_scale: noise_scale
            .map_or(Ok(1.0), |v| v.number_where("a factor from 0", |s| s >= 0.0))?,
        segments,
        trials,
        effects,
        world,
    };
    let soils = terrain.map(|v| four_soils(&v)).transpose()?;
    let complaint = if seed.is_none() {
        Some(missing("seed"))
    } else if rover.is_none() {
        Some(missing("rover"))
    } else if head.segments.is_empty() && head.trials.is_empty() {
        Some(root.error("expected at least one [[segment]] (drive) or [[trial]] (rig)"))
    } else if !head.segments.is_empty() && !head.trials.is_empty() {
        Some(root.error("[[segment]] and [[trial]] in one file: a scenario is a drive or a rig"))
    } else if rate.is_none() && !head.segments.is_empty() {
        Some(missing("rate_hz"))
    } else {
        None
    };
    let no_terrain = missing("terrain");
    root.finish()?;
    if let Some(error) = complaint {
        return Err(error);
    }
    let soils = soils.ok_or(no_terrain)?;
    let [fl, fr, rl, rr] = &soils;
    let mut scenario = Scenario {
        left: fl.clone(),
        right: fr.clone(),
        ..head
    };
    if fl != rl || fr != rr {
        scenario.world.wheels = Some(soils);
    }
    Ok(scenario)
}

/// An id, a parameter table, or one of them for each side or each wheel.
pub(super) fn four_soils(value: &Value<'_, '_>) -> Parsed<[Start; 4]> {
    if value.is_table() {
        let table = value.table()?;
        if table.has_any(&["left", "right"]) {
            let (left, right) = (table.require("left")?, table.require("right")?);
            table.finish()?;
            let (left, right) = (soil(&left)?, soil(&right)?);
            return Ok([left.clone(), right.clone(), left, right]);
        }
        if table.has_any(&WHEELS) {
            let [fl, fr, rl, rr] = WHEELS;
            let all = [
                table.require(fl)?,
                table.require(fr)?,
                table.require(rl)?,
                table.require(rr)?,
            ];
            table.finish()?;
            let [fl, fr, rl, rr] = all;
            return Ok([soil(&fl)?, soil(&fr)?, soil(&rl)?, soil(&rr)?]);
        }
    }
    let all = soil(value)?;
    Ok([all.clone(), all.clone(), all.clone(), all])
}

fn soil(value: &Value<'_, '_>) -> Parsed<Start> {
    if value.is_text() {
        return Ok(Start::Id(value.text()?));
    }
    if !value.is_table() {
        return Err(value
            .error("expected a terrain id, a table of parameters, or { left = .., right = .. }"));
    }
    let mut values = BTreeMap::new();
    for (key, number) in value.table()?.entries() {
        values.insert(key.to_owned(), number.number()?);
    }
    Ok(Start::Values(values))
}

fn segment(index: usize, value: &Value<'_, '_>) -> Parsed<DriveSegment> {
    let table = value.table()?;
    let name = table
        .get("name")
        .map_or(Ok(format!("segment_{}", index + 1)), |v| v.text())?;
    let duration = table.get("duration_s");
    let torque = table.get("torque_N_m");
    let speed = table.get("wheel_speed_rad_s");
    let start = table.get("start");
    let reset = table.get("reset").map_or(Ok(false), |v| v.flag())?;
    let pitch = table
        .get("pitch_rad")
        .map(|v| v.number_where("an angle between -1.5 and 1.5 rad", |a| a.abs() < 1.5))
        .transpose()?;
    let roll = table
        .get("roll_rad")
        .map(|v| v.number_where("an angle between -1.5 and 1.5 rad", |a| a.abs() < 1.5))
        .transpose()?;
    let payload = table.get("payload_kg").map(|v| v.number()).transpose()?;
    let payload_at = table.get("payload_at_m").map(|v| place(&v)).transpose()?;
    let tow_load = table.get("tow_load_N").map_or(Ok(0.0), |v| v.number())?;
    let pass = table.get("pass").map(|v| v.count()).transpose()?;
    let no_duration = table.error("missing key 'duration_s'");
    let no_command = table.error("expected one of torque_N_m, wheel_speed_rad_s");
    table.finish()?;
    let duration = duration
        .ok_or(no_duration)?
        .number_where("a duration above 0", |d| d > 0.0)?;
    let command = match (torque, speed) {
        (Some(torque), None) => Command::Torque(wheels(&torque, &profile)?),
        (None, Some(speed)) => Command::WheelSpeed(wheels(&speed, &profile)?),
        _ => return Err(no_command),
    };
    let start = match start {
        Some(v) if index > 0 && !reset => {
            return Err(v.error("start is for the first segment or after reset = true"));
        }
        Some(v) => Some(motion(&v)?),
        None => None,
    };
    Ok(DriveSegment {
        name,
        duration,
        command,
        start,
        reset,
        pitch,
        roll,
        payload,
        payload_at,
        tow_load,
        pass,
    })
}

/// { forward, left, up } of the centre of mass \[m\].
fn place(value: &Value<'_, '_>) -> Parsed<[f64; 3]> {
    let table = value.table()?;
    let mut at = [0.0; 3];
    for (slot, key) in at.iter_mut().zip(["forward", "left", "up"]) {
        *slot = table.get(key).map_or(Ok(0.0), |v| v.number())?;
    }
    table.finish()?;
    Ok(at)
}

fn motion(value: &Value<'_, '_>) -> Parsed<StartMotion> {
    let table = value.table()?;
    let ground_speed = table
        .get("ground_speed_m_s")
        .map_or(Ok(0.0), |v| v.number())?;
    let wheel_speed = match table.get("wheel_speed_rad_s") {
        Some(v) => wheels(&v, &|v| v.number())?,
        None => [0.0; 4],
    };
    table.finish()?;
    Ok(StartMotion {
        ground_speed,
        wheel_speed,
    })
}

/// One for all wheels, or { fl = .., fr = .., rl = .., rr = .. }.
fn wheels<T: Copy>(
    value: &Value<'_, '_>,
    one: &impl Fn(&Value<'_, '_>) -> Parsed<T>,
) -> Parsed<[T; 4]> {
    if value.is_table() {
        let table = value.table()?;
        if table.has_any(&WHEELS) {
            let [fl, fr, rl, rr] = WHEELS;
            let all = [
                table.require(fl)?,
                table.require(fr)?,
                table.require(rl)?,
                table.require(rr)?,
            ];
            table.finish()?;
            let [fl, fr, rl, rr] = all;
            return Ok([one(&fl)?, one(&fr)?, one(&rl)?, one(&rr)?]);
        }
    }
    Ok([one(value)?; 4])
}

fn profile(value: &Value<'_, '_>) -> Parsed<Profile> {
    if !value.is_table() {
        return Ok(Profile::constant(value.number()?));
    }
    let table = value.table()?;
    let (from, to) = (
        table.require("from")?.number()?,
        table.require("to")?.number()?,
    );
    table.finish()?;
    Ok(Profile { from, to })
}

/// A number or an array of them.
fn numbers(value: &Value<'_, '_>, what: &str, legal: impl Fn(f64) -> bool) -> Parsed<Vec<f64>> {
    if !value.is_array() {
        return Ok(vec![value.number_where(what, legal)?]);
    }
    let items = value.items()?;
    if items.is_empty() {
        return Err(value.error("expected at least one number"));
    }
    items.iter().map(|v| v.number_where(what, &legal)).collect()
}

/// The trials of all `[[trial]]`, as many as a log can hold.
fn all_trials(list: &Value<'_, '_>) -> Parsed<Vec<Trial>> {
    let mut all = Vec::new();
    let mut left = MOST_NUMBERS;
    for item in list.items()? {
        all.extend(trials(&item, &mut left)?);
    }
    Ok(all)
}

/// The trials of one `[[trial]]`: speeds and passes multiply, pass innermost, so that a programme can drive each rut
/// again at each speed. What they are is taken off what is left.
fn trials(value: &Value<'_, '_>, left: &mut usize) -> Parsed<Vec<Trial>> {
    let table = value.table()?;
    let slip = table.get("slip");
    let load = table.get("normal_load_N");
    let travel = table.get("travel_speed_m_s");
    let repeats = table.get("repeats").map_or(Ok(1), |v| v.count())?;
    let condition = table
        .get("condition")
        .map_or(Ok(String::new()), |v| v.text())?;
    let passes = match table.get("pass") {
        Some(v) if v.is_array() => v
            .items()?
            .iter()
            .map(|p| p.count())
            .collect::<Parsed<_>>()?,
        Some(v) => vec![v.count()?],
        None => vec![1],
    };
    let ramp = match table.get("ramp_s") {
        Some(v) => Some(v.number_where("a duration above 0", |t| t > 0.0)?),
        None => None,
    };
    let missing = |key: &str| table.error(format!("missing key '{key}'"));
    let (no_slip, no_load, no_travel) = (
        missing("slip"),
        missing("normal_load_N"),
        missing("travel_speed_m_s"),
    );
    table.finish()?;
    let one = Trial {
        slip: slips(&slip.ok_or(no_slip)?)?,
        normal_load: numbers(&load.ok_or(no_load)?, "a load above 0", |w| w > 0.0)?,
        repeats,
        travel_speed: 0.0,
        condition,
        pass: 1,
        ramp,
    };
    let speeds = numbers(&travel.ok_or(no_travel)?, "a speed above 0", |v| v > 0.0)?;
    let each = one.slip.len() + one.normal_load.len() + BESIDE;
    let numbers = each.saturating_mul(speeds.len().saturating_mul(passes.len()));
    *left = left.checked_sub(numbers).ok_or_else(|| {
        let trials = speeds.len().saturating_mul(passes.len());
        value.error(format!(
            "speeds x passes are {trials} trials of {} slips and {} loads: too many for one file",
            one.slip.len(),
            one.normal_load.len()
        ))
    })?;
    Ok(speeds
        .iter()
        .flat_map(|&travel_speed| {
            let one = &one;
            passes.iter().map(move |&pass| Trial {
                travel_speed,
                pass,
                ..one.clone()
            })
        })
        .collect())
}

/// Slips: a number, a list, or { from, to, steps }, a ramp in equal steps.
fn slips(value: &Value<'_, '_>) -> Parsed<Vec<f64>> {
    const WHAT: &str = "a slip in [-1, 1]";
    let legal = |s: f64| (-1.0..=1.0).contains(&s);
    if !value.is_table() {
        return numbers(value, WHAT, legal);
    }
    let table = value.table()?;
    let from = table.require("from")?.number_where(WHAT, legal)?;
    let to = table.require("to")?.number_where(WHAT, legal)?;
    let steps = table.require("steps")?;
    table.finish()?;
    let n = steps.count()?;
    if !(2..=100_000).contains(&n) {
        return Err(steps.error(format!("{n}: expected 2 to 100000 steps")));
    }
    Ok((0..n)
        .map(|k| from + (to - from) * f64::from(k) / f64::from(n - 1))
        .collect())
}

fn effect(value: &Value<'_, '_>) -> Parsed<EffectSetting> {
    let table = value.table()?;
    let name = table.get("name");
    let magnitude = table.get("magnitude");
    let form = table.get("form").map(|v| v.text()).transpose()?;
    let (no_name, no_magnitude) = (
        table.error("missing key 'name'"),
        table.error("missing key 'magnitude'"),
    );
    table.finish()?;
    Ok(EffectSetting {
        name: name.ok_or(no_name)?.text()?,
        magnitude: numbers(&magnitude.ok_or(no_magnitude)?, "a number", |_| true)?,
        form,
    })
}
