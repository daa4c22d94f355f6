//! The state spaces terra ships, one file each.

pub mod longitudinal_robot;
pub mod single_wheel_rig;

pub use longitudinal_robot::LongitudinalRobot;
pub use single_wheel_rig::SingleWheelRig;
