//! The state spaces terra ships, one file each.

pub mod augmented;
pub mod longitudinal_robot;
pub mod planar_robot;
pub mod single_wheel_rig;

pub use augmented::{Augmented, Extra};
pub use longitudinal_robot::LongitudinalRobot;
pub use planar_robot::PlanarRobot;
pub use single_wheel_rig::SingleWheelRig;
