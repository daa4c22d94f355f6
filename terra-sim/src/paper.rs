//! The vehicles, sensors and torque ramp of the paper this library began with.
//!
//! Mass, wheel, and loads are the paper's; inertias, geometry, damping, sensor noise and the ramp are chosen where the
//! paper is silent.
//!
//! # Reference
//! L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", Proc. SPIE, 2008.

use std::collections::BTreeMap;

use terra_data::{
    FilterSettings, GapSettings, Noise, Rover, Start, TerrainSettings, VehicleData, WheelData,
};
use terra_model::{Contact, ForceLaw, Registry};

use crate::error::SimError;
use crate::robot::GRAVITY;
use crate::scenario::{Command, DriveSegment, Profile, Scenario, StartMotion, World};
use crate::soil;

/// The light robot: 100 kg, 245.25 N a wheel.
pub fn light_rover() -> Rover {
    rover(100.0, 10.0)
}

/// The heavy robot: 1000 kg, 2452.5 N a wheel, otherwise the light one.
pub fn heavy_rover() -> Rover {
    rover(1000.0, 100.0)
}

fn rover(mass: f64, yaw_inertia: f64) -> Rover {
    let noise = [
        ("accel_x_m_s2", 0.05),
        ("wheel_speed_rad_s", 0.05),
        ("ground_speed_m_s", 0.02),
        ("yaw_rate_rad_s", 0.005),
        ("wheel_torque_N_m", 0.1),
    ];
    Rover {
        vehicle: Some(VehicleData {
            mass,
            yaw_inertia,
            track: 0.6,
            wheelbase: 0.6,
            cg_to_front_axle: 0.3,
            cg_height: 0.22,
            yaw_damping: 8.0,
        }),
        wheel: WheelData {
            radius: 0.254,
            width: 0.15,
            inertia: 0.25,
            damping: 0.1,
            grouser_height: 0.0,
            grouser_count: 0,
        },
        drivetrain: None,
        terrain: TerrainSettings {
            model: "wong-reece".to_owned(),
            hypotheses: "wong21".to_owned(),
            start: None,
            prior_sd: BTreeMap::new(),
            prior_abs_sd: BTreeMap::new(),
        },
        conditions: BTreeMap::new(),
        filter: FilterSettings::default(),
        gap: GapSettings::default(),
        noise: Noise(noise.map(|(k, v)| (k.to_owned(), v)).into()),
        columns: BTreeMap::new(),
    }
}

/// The torque ramp of the light robot on a catalogue soil.
///
/// # Errors
/// An unknown terrain, or a soil that does not carry the wheel at slip 1 or .05.
pub fn torque_ramp(terrain: &str, seed: u64) -> Result<Scenario, SimError> {
    torque_ramp_of(&light_rover(), terrain, seed)
}

/// The torque ramp of any rover: from 1.15 T(s = 1) to 1.02 T(s = .05) at a quarter of its weight, linear in 2 s, from
/// v = 0 and ω = .2 rad/s, logged at 100 Hz.
///
/// # Errors
/// As [`torque_ramp`], and a rover without `[vehicle]`.
pub fn torque_ramp_of(rover: &Rover, terrain: &str, seed: u64) -> Result<Scenario, SimError> {
    let vehicle = rover.vehicle.ok_or(SimError::NotADrive {
        missing: "[vehicle]",
    })?;
    let registry = Registry::builtin();
    let law = registry.law(&rover.terrain.model)?;
    let start = Start::Id(terrain.to_owned());
    let p = soil::parameters(&start, law.model())?;
    let load = 0.25 * vehicle.mass * GRAVITY;
    let torque = |slip: f64| {
        law.forces(
            &p,
            &Contact::new(slip, load, rover.wheel.radius, rover.wheel.width),
        )
        .map(|f| f.resistive_torque)
    };
    let profile = Profile {
        from: 1.15 * torque(1.0)?,
        to: 1.02 * torque(0.05)?,
    };
    let mut ramp = DriveSegment::new("ramp", 2.0, Command::Torque([profile; 4]));
    ramp.start = Some(StartMotion {
        ground_speed: 0.0,
        wheel_speed: [0.2; 4],
    });
    Ok(Scenario {
        seed,
        run: 0,
        rover: "rover.toml".to_owned(),
        rate: 100.0,
        left: start.clone(),
        right: start,
        model: rover.terrain.model.clone(),
        noise_scale: 1.0,
        segments: vec![ramp],
        trials: Vec::new(),
        effects: Vec::new(),
        world: World::default(),
    })
}
