//! The effects, one file each: physics that models leave out, and errors of instruments.
//!
//! Priors are judgements, not measurements. e = 0 is the nominal world.

mod accel_bias;
mod aero_drag;
mod bulldozing;
mod cg_offset;
mod drawbar_bias;
mod drawbar_gain;
mod drivetrain_coulomb_friction;
mod drivetrain_viscous_friction;
pub mod forms;
mod ground_speed_bias;
mod ground_speed_delay;
mod ground_speed_scale;
mod grousers;
mod interface_friction;
mod lateral_bulldozing;
mod lateral_contrast;
mod layered_soil;
mod load_error;
mod mass_error;
mod multipass;
mod rate_stiffening;
mod rear_contact;
mod shear_hump;
mod sinkage_bias;
mod skid_steer_lateral_slip;
mod slip_sinkage;
mod slope;
mod terrain_drift;
mod torque_bias;
mod torque_droop;
mod torque_scale;
mod tow_load;
mod track_width_error;
mod wheel_compliance;
mod wheel_radius_error;
mod yaw_rate_bias;

pub use accel_bias::AccelBias;
pub use aero_drag::AeroDrag;
pub use bulldozing::Bulldozing;
pub use cg_offset::CgOffset;
pub use drawbar_bias::DrawbarBias;
pub use drawbar_gain::DrawbarGain;
pub use drivetrain_coulomb_friction::DrivetrainCoulombFriction;
pub use drivetrain_viscous_friction::DrivetrainViscousFriction;
pub use ground_speed_bias::GroundSpeedBias;
pub use ground_speed_delay::GroundSpeedDelay;
pub use ground_speed_scale::GroundSpeedScale;
pub use grousers::Grousers;
pub use interface_friction::InterfaceFriction;
pub use lateral_bulldozing::LateralBulldozing;
pub use lateral_contrast::LateralContrast;
pub use layered_soil::LayeredSoil;
pub use load_error::LoadError;
pub use mass_error::MassError;
pub use multipass::Multipass;
pub use rate_stiffening::RateStiffening;
pub use rear_contact::RearContact;
pub use shear_hump::ShearHump;
pub use sinkage_bias::SinkageBias;
pub use skid_steer_lateral_slip::SkidSteerLateralSlip;
pub use slip_sinkage::SlipSinkage;
pub use slope::Slope;
pub use terrain_drift::TerrainDrift;
pub use torque_bias::TorqueBias;
pub use torque_droop::TorqueDroop;
pub use torque_scale::TorqueScale;
pub use tow_load::TowLoad;
pub use track_width_error::TrackWidthError;
pub use wheel_compliance::WheelCompliance;
pub use wheel_radius_error::WheelRadiusError;
pub use yaw_rate_bias::YawRateBias;

use crate::registry::Registry;

/// Registers every effect of this folder. A new effect is one file and one line here.
pub(crate) fn register(registry: Registry) -> Registry {
    registry
        .with_effect::<SlipSinkage>()
        .with_effect::<Multipass>()
        .with_effect::<Grousers>()
        .with_effect::<Bulldozing>()
        .with_effect::<RearContact>()
        .with_effect::<RateStiffening>()
        .with_effect::<ShearHump>()
        .with_effect::<WheelCompliance>()
        .with_effect::<LayeredSoil>()
        .with_effect::<InterfaceFriction>()
        .with_effect::<TerrainDrift>()
        .with_effect::<LateralContrast>()
        .with_effect::<LateralBulldozing>()
        .with_effect::<SkidSteerLateralSlip>()
        .with_effect::<DrivetrainCoulombFriction>()
        .with_effect::<DrivetrainViscousFriction>()
        .with_effect::<TorqueScale>()
        .with_effect::<TorqueBias>()
        .with_effect::<TorqueDroop>()
        .with_effect::<WheelRadiusError>()
        .with_effect::<TrackWidthError>()
        .with_effect::<CgOffset>()
        .with_effect::<MassError>()
        .with_effect::<GroundSpeedScale>()
        .with_effect::<GroundSpeedBias>()
        .with_effect::<GroundSpeedDelay>()
        .with_effect::<AccelBias>()
        .with_effect::<YawRateBias>()
        .with_effect::<Slope>()
        .with_effect::<TowLoad>()
        .with_effect::<AeroDrag>()
        .with_effect::<LoadError>()
        .with_effect::<DrawbarGain>()
        .with_effect::<DrawbarBias>()
        .with_effect::<SinkageBias>()
}
