//! `rover.toml` / `rig.toml` in memory: the nominal simulator, its noise, and how its logs are read.

use std::collections::BTreeMap;

use terra_model::catalogue::Terrain;
use terra_model::{SlipConvention, Vehicle};

/// `[vehicle]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleData {
    /// m \[kg\].
    pub mass: f64,
    /// I_zz \[kg m²\].
    pub yaw_inertia: f64,
    /// t_w \[m\].
    pub track: f64,
    /// L \[m\].
    pub wheelbase: f64,
    /// l_f \[m\].
    pub cg_to_front_axle: f64,
    /// h \[m\].
    pub cg_height: f64,
    /// M_res \[N m s\].
    pub yaw_damping: f64,
}

/// `[wheel]`, or a condition's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelData {
    /// R \[m\].
    pub radius: f64,
    /// b \[m\].
    pub width: f64,
    /// I_w \[kg m²\]; 0 on a rig that does not give it.
    pub inertia: f64,
    /// b_w \[N m s\]; 0 on a rig that does not give it.
    pub damping: f64,
    /// Grouser height \[m\], 0 on a smooth wheel.
    pub grouser_height: f64,
    /// Number of grousers.
    pub grouser_count: u32,
}

/// `[drivetrain]`: wheel torque = current x torque constant x gear ratio x efficiency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drivetrain {
    /// N m/A.
    pub torque_constant: f64,
    /// Motor turns a wheel turn.
    pub gear_ratio: f64,
    /// In (0, 1].
    pub efficiency: f64,
}

/// Prior centre of the soil.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// An id of the built-in catalogue.
    Id(String),
    /// A soil of the user's own catalogue, the file that `hypotheses` names: looked up where the rover file is read.
    Own(Box<Terrain>),
    /// Parameter values by name, SI and rad; `k_eq` is allowed for k_c/b + k_phi.
    Values(BTreeMap<String, f64>),
}

/// `[terrain]`.
#[derive(Clone, Debug, PartialEq)]
pub struct TerrainSettings {
    /// Model, or model+effect+effect.
    pub model: String,
    /// Catalogue set or file that `identify` weighs.
    pub hypotheses: String,
    /// Prior centre; the winner of `hypotheses` when absent.
    pub start: Option<Start>,
    /// sd of ln(parameter), by name: only what the file overrides.
    pub prior_sd: BTreeMap<String, f64>,
    /// sd of a parameter whose start is 0, by name: only what the file overrides.
    pub prior_abs_sd: BTreeMap<String, f64>,
}

/// Whether a condition's rows share the soil of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoilSharing {
    /// One soil for all (default).
    Shared,
    /// Its own soil.
    Own,
}

/// `[condition.NAME]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// The wheel of this condition, overrides already merged.
    pub wheel: WheelData,
    /// Its soil.
    pub soil: SoilSharing,
}

/// Where ground speed comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundSpeedSource {
    /// The log.
    Log,
    /// Not measured.
    None,
}

/// `[filter]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSettings {
    /// Source of v.
    pub ground_speed: GroundSpeedSource,
    /// q_T \[N² m²/s³\].
    pub torque_walk: f64,
    /// q_F \[N²/s³\].
    pub force_walk: f64,
    /// Samples before hypotheses are weighed.
    pub start_wait: usize,
}

impl Default for FilterSettings {
    fn default() -> Self {
        FilterSettings {
            ground_speed: GroundSpeedSource::Log,
            torque_walk: 1e3,
            force_walk: 1e4,
            start_wait: 20,
        }
    }
}

/// `[gap]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSettings {
    /// Averaging window \[s\].
    pub window: f64,
    /// Whether the file states it: where it does not, a window may be wider for a slow sensor.
    pub window_given: bool,
    /// Library slips that are used.
    pub slip_range: (f64, f64),
    /// Prior probability that nothing is missing.
    pub prior_none: f64,
    /// Prior probability that something unknown is missing.
    pub prior_unknown: f64,
}

impl Default for GapSettings {
    fn default() -> Self {
        GapSettings {
            window: 0.2,
            window_given: false,
            slip_range: (-1.0, 1.0),
            prior_none: 0.25,
            prior_unknown: 0.10,
        }
    }
}

/// `[noise]`: 1-sigma per sample, SI, by the column's name without wheel suffix (`wheel_torque_N_m`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Noise(pub BTreeMap<String, f64>);

impl Noise {
    /// The 1-sigma of a channel, if the file gives it.
    pub fn get(&self, channel: &str) -> Option<f64> {
        self.0.get(channel).copied()
    }
}

/// One entry of `[columns]`: our column from theirs.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnMap {
    /// Column in the log.
    pub from: String,
    /// Its unit (`rpm`, `mm`, `deg`, ...); ours when absent.
    pub unit: Option<String>,
    /// Its slip convention.
    pub convention: Option<SlipConvention>,
}

/// The nominal simulator of a rover or a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Rover {
    /// Absent for a rig.
    pub vehicle: Option<VehicleData>,
    /// The wheel.
    pub wheel: WheelData,
    /// Only with motor currents.
    pub drivetrain: Option<Drivetrain>,
    /// Nominal soil.
    pub terrain: TerrainSettings,
    /// By name.
    pub conditions: BTreeMap<String, Condition>,
    /// Force filter.
    pub filter: FilterSettings,
    /// Diagnosis.
    pub gap: GapSettings,
    /// Sensors.
    pub noise: Noise,
    /// Names and units of the log, by our column name.
    pub columns: BTreeMap<String, ColumnMap>,
}

impl Rover {
    /// True without `[vehicle]`: the logs are rig logs.
    pub fn is_rig(&self) -> bool {
        self.vehicle.is_none()
    }

    /// The vehicle as effects see it, on level ground; `None` for a rig.
    pub fn nominal_vehicle(&self) -> Option<Vehicle<f64>> {
        let v = self.vehicle?;
        Some(Vehicle {
            mass: v.mass,
            yaw_inertia: v.yaw_inertia,
            track: v.track,
            wheelbase: v.wheelbase,
            cg_to_front_axle: v.cg_to_front_axle,
            cg_height: v.cg_height,
            yaw_damping: v.yaw_damping,
            wheel_radius: self.wheel.radius,
            wheel_width: self.wheel.width,
            wheel_inertia: self.wheel.inertia,
            wheel_damping: self.wheel.damping,
            pitch: 0.0,
        })
    }

    /// The wheel of a condition (the plain one for an unnamed or unlisted condition).
    pub fn wheel_of(&self, condition: &str) -> WheelData {
        self.conditions
            .get(condition)
            .map_or(self.wheel, |c| c.wheel)
    }
}
