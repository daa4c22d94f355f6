//! Reads `rover.toml` / `rig.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use terra_model::Registry;
use toml::de::{DeTable, DeValue};

use crate::error::{DataError, Origin};
use crate::problem::Problem;
use crate::read_columns::read_columns;
use crate::read_soil::{own_start, read_terrain};
use crate::read_terrains::{names_a_file, read_terrains};
use crate::rover::{
    Condition, Drivetrain, FilterSettings, GapSettings, GroundSpeedSource, Noise, Rover,
    SoilSharing, Start, VehicleData, WheelData,
};
use crate::section::{Document, Legal, Section};
use crate::source::read_text;

/// Reads a rover (or rig) file; models and effects are those terra ships.
///
/// # Errors
/// [`DataError::Configuration`] with file, line and column (characters): an unreadable file, invalid TOML, an unknown or
/// missing key, a value of a wrong type or out of range, an unknown model, terrain, column or unit.
pub fn read_rover(path: impl AsRef<Path>) -> Result<Rover, DataError> {
    read_rover_with(path, &Registry::builtin())
}

/// [`read_rover`] with a user's own models and effects.
///
/// # Errors
/// As [`read_rover`].
pub fn read_rover_with(path: impl AsRef<Path>, registry: &Registry) -> Result<Rover, DataError> {
    let path = path.as_ref();
    let origin = Origin::configuration(&path.display().to_string());
    let text = read_text(path, &origin, "a rover file")?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse_rover_in(&text, &origin.file, folder, registry)
}

/// [`read_rover_with`] of a text, whose own references start at a folder; `name` stands for the file in errors.
///
/// # Errors
/// As [`read_rover`].
pub fn parse_rover_in(
    text: &str,
    name: &str,
    folder: &Path,
    registry: &Registry,
) -> Result<Rover, DataError> {
    let mut rover = parse_rover_with(text, name, registry)?;
    let origin = Origin::configuration(name);
    // An id of the user's own catalogue can only be looked up now that the folder is known.
    if let Some(Start::Id(id)) = &rover.terrain.start
        && names_a_file(&rover.terrain.hypotheses)
    {
        let own = read_terrains(folder.join(&rover.terrain.hypotheses))?;
        let law = registry.law(&rover.terrain.model).map_err(|e| {
            origin.fail_file(Problem::from_model(e, "a registered model or effect"))
        })?;
        rover.terrain.start = Some(own_start(text, &origin, id, &own, &law)?);
    }
    Ok(rover)
}

/// A rover (or rig) file given as text; `name` stands for the file in errors. No other file is read: a start in a
/// catalogue of the user's own stays an id.
///
/// # Errors
/// As [`read_rover`].
pub fn parse_rover(text: &str, name: &str) -> Result<Rover, DataError> {
    parse_rover_with(text, name, &Registry::builtin())
}

/// [`parse_rover`] with a user's own models and effects.
///
/// # Errors
/// As [`read_rover`].
pub fn parse_rover_with(text: &str, name: &str, registry: &Registry) -> Result<Rover, DataError> {
    let document = Document {
        origin: Origin::configuration(name),
        text,
    };
    let parsed = DeTable::parse(text).map_err(|e| {
        let at = e.span().unwrap_or(0..0);
        let message = e.message().to_owned();
        document.fail(&at, Problem::Syntax { message })
    })?;
    let file = Section::root(&document, parsed.get_ref());
    file.only(&[
        "vehicle",
        "wheel",
        "drivetrain",
        "terrain",
        "condition",
        "filter",
        "gap",
        "noise",
        "columns",
    ])?;
    let vehicle = file
        .table("vehicle")?
        .map(|s| read_vehicle(&s))
        .transpose()?;
    let wheel = read_wheel(&required(&file, "wheel")?, vehicle.is_none())?;
    Ok(Rover {
        vehicle,
        wheel,
        drivetrain: file
            .table("drivetrain")?
            .map(|s| read_drivetrain(&s))
            .transpose()?,
        terrain: read_terrain(&required(&file, "terrain")?, registry)?,
        conditions: match file.table("condition")? {
            Some(s) => read_conditions(&s, wheel)?,
            None => BTreeMap::new(),
        },
        filter: match file.table("filter")? {
            Some(s) => read_filter(&s)?,
            None => FilterSettings::default(),
        },
        gap: match file.table("gap")? {
            Some(s) => read_gap(&s)?,
            None => GapSettings::default(),
        },
        noise: match file.table("noise")? {
            Some(s) => read_noise(&s)?,
            None => Noise::default(),
        },
        columns: match file.table("columns")? {
            Some(s) => read_columns(&s)?,
            None => BTreeMap::new(),
        },
    })
}

fn required<'a>(file: &Section<'a>, table: &'static str) -> Result<Section<'a>, DataError> {
    match file.table(table)? {
        Some(section) => Ok(section),
        None => Err(file
            .document
            .origin
            .fail_file(Problem::MissingTable { table })),
    }
}

fn read_vehicle(s: &Section<'_>) -> Result<VehicleData, DataError> {
    s.only(&[
        "mass_kg",
        "yaw_inertia_kg_m2",
        "track_m",
        "wheelbase_m",
        "cg_to_front_axle_m",
        "cg_height_m",
        "yaw_damping_N_m_s",
    ])?;
    let wheelbase = s.number("wheelbase_m", Legal::Positive)?;
    Ok(VehicleData {
        mass: s.number("mass_kg", Legal::Positive)?,
        yaw_inertia: s.number("yaw_inertia_kg_m2", Legal::Positive)?,
        track: s.number("track_m", Legal::Positive)?,
        wheelbase,
        cg_to_front_axle: s.number("cg_to_front_axle_m", Legal::Within(0.0, wheelbase))?,
        cg_height: s.number("cg_height_m", Legal::NotNegative)?,
        yaw_damping: s.number("yaw_damping_N_m_s", Legal::NotNegative)?,
    })
}

const WHEEL_KEYS: [&str; 6] = [
    "radius_m",
    "width_m",
    "inertia_kg_m2",
    "damping_N_m_s",
    "grouser_height_m",
    "grouser_count",
];

/// On a rig inertia and damping may be absent: nothing accelerates there.
fn read_wheel(s: &Section<'_>, rig: bool) -> Result<WheelData, DataError> {
    s.only(&WHEEL_KEYS)?;
    s.number("radius_m", Legal::Positive)?;
    s.number("width_m", Legal::Positive)?;
    if !rig {
        s.number("inertia_kg_m2", Legal::Positive)?;
        s.number("damping_N_m_s", Legal::NotNegative)?;
    }
    override_wheel(
        s,
        WheelData {
            radius: 0.0,
            width: 0.0,
            inertia: 0.0,
            damping: 0.0,
            grouser_height: 0.0,
            grouser_count: 0,
        },
    )
}

/// A wheel with the values that a table gives.
fn override_wheel(s: &Section<'_>, base: WheelData) -> Result<WheelData, DataError> {
    s.only(&WHEEL_KEYS)?;
    let or = |key, legal, base| s.optional_number(key, legal).map(|v| v.unwrap_or(base));
    Ok(WheelData {
        radius: or("radius_m", Legal::Positive, base.radius)?,
        width: or("width_m", Legal::Positive, base.width)?,
        inertia: or("inertia_kg_m2", Legal::Positive, base.inertia)?,
        damping: or("damping_N_m_s", Legal::NotNegative, base.damping)?,
        grouser_height: or("grouser_height_m", Legal::NotNegative, base.grouser_height)?,
        grouser_count: s
            .optional_count("grouser_count")?
            .unwrap_or(base.grouser_count),
    })
}

fn read_drivetrain(s: &Section<'_>) -> Result<Drivetrain, DataError> {
    s.only(&["torque_constant_N_m_A", "gear_ratio", "efficiency"])?;
    Ok(Drivetrain {
        torque_constant: s.number("torque_constant_N_m_A", Legal::Positive)?,
        gear_ratio: s.number("gear_ratio", Legal::Positive)?,
        efficiency: s.number("efficiency", Legal::Share)?,
    })
}

fn read_conditions(
    s: &Section<'_>,
    base: WheelData,
) -> Result<BTreeMap<String, Condition>, DataError> {
    let mut conditions = BTreeMap::new();
    for entry in s.entries() {
        let mut one = s.table_of(&entry)?;
        one.name = format!("[condition.{}]", entry.key);
        one.only(&["wheel", "soil"])?;
        let wheel = match one.table("wheel")? {
            Some(wheel) => override_wheel(&wheel, base)?,
            None => base,
        };
        let sharing = [("shared", SoilSharing::Shared), ("own", SoilSharing::Own)];
        let soil = one.choice("soil", &sharing, SoilSharing::Shared)?;
        conditions.insert(entry.key.to_owned(), Condition { wheel, soil });
    }
    Ok(conditions)
}

fn read_filter(s: &Section<'_>) -> Result<FilterSettings, DataError> {
    s.only(&[
        "ground_speed",
        "torque_walk_N2_m2_s3",
        "force_walk_N2_s3",
        "start_wait_samples",
    ])?;
    let base = FilterSettings::default();
    let sources = [
        ("log", GroundSpeedSource::Log),
        ("none", GroundSpeedSource::None),
    ];
    let or = |key, base| {
        s.optional_number(key, Legal::Positive)
            .map(|v| v.unwrap_or(base))
    };
    Ok(FilterSettings {
        ground_speed: s.choice("ground_speed", &sources, base.ground_speed)?,
        torque_walk: or("torque_walk_N2_m2_s3", base.torque_walk)?,
        force_walk: or("force_walk_N2_s3", base.force_walk)?,
        start_wait: s
            .optional_count("start_wait_samples")?
            .map_or(base.start_wait, |n| n as usize),
    })
}

fn read_gap(s: &Section<'_>) -> Result<GapSettings, DataError> {
    s.only(&["window_s", "slip_range", "prior"])?;
    let mut gap = GapSettings::default();
    if let Some(v) = s.optional_number("window_s", Legal::Positive)? {
        (gap.window, gap.window_given) = (v, true);
    }
    if let Some(entry) = s.get("slip_range") {
        let DeValue::Array(values) = entry.value else {
            return Err(s.wrong_type(&entry, "an array of two numbers"));
        };
        let legal = Legal::Within(-1.0, 1.0);
        let mut ends = Vec::new();
        for value in values.iter() {
            ends.push(s.number_at(&entry, value.get_ref(), &value.span(), legal)?);
        }
        gap.slip_range = match ends.as_slice() {
            [low, high] if low < high => (*low, *high),
            _ => {
                let found = format!("{ends:?}");
                let expected = "two slips, the smaller one first".to_owned();
                let key = entry.shown.clone();
                return Err(s.document.fail(
                    &entry.at,
                    Problem::OutOfRange {
                        key,
                        found,
                        expected,
                    },
                ));
            }
        };
    }
    if let Some(prior) = s.table("prior")? {
        prior.only(&["none", "unknown"])?;
        let chance = Legal::Within(0.0, 1.0);
        if let Some(v) = prior.optional_number("none", chance)? {
            gap.prior_none = v;
        }
        if let Some(v) = prior.optional_number("unknown", chance)? {
            gap.prior_unknown = v;
        }
        let sum = gap.prior_none + gap.prior_unknown;
        if sum >= 1.0 {
            let problem = Problem::OutOfRange {
                key: format!("{}: none + unknown", prior.name),
                found: sum.to_string(),
                expected: "less than 1, so that an effect can be found".to_owned(),
            };
            return Err(s.document.fail(&prior.at, problem));
        }
    }
    Ok(gap)
}

/// Noise keys: a column's name without its wheel, and the two roughnesses.
const NOISE_KEYS: [&str; 22] = [
    "wheel_speed_rad_s",
    "wheel_torque_N_m",
    "motor_current_A",
    "ground_speed_m_s",
    "yaw_rate_rad_s",
    "accel_x_m_s2",
    "accel_y_m_s2",
    "lateral_speed_m_s",
    "pitch_rad",
    "roll_rad",
    "distance_m",
    "sinkage_m",
    "normal_load_N",
    "drawbar_pull_N",
    "torque_N_m",
    "side_force_N",
    "slip_angle_rad",
    "slip",
    "travel_speed_m_s",
    "rim_speed_m_s",
    "roughness_N",
    "roughness_N_m",
];

fn read_noise(s: &Section<'_>) -> Result<Noise, DataError> {
    s.only(&NOISE_KEYS)?;
    let mut noise = BTreeMap::new();
    for entry in s.entries() {
        // Roughness of 0 is a statement about the ground; a sensor without any noise is a mistake.
        let legal = if entry.key.starts_with("roughness") {
            Legal::NotNegative
        } else {
            Legal::Positive
        };
        noise.insert(entry.key.to_owned(), s.number_of(&entry, legal)?);
    }
    Ok(Noise(noise))
}
