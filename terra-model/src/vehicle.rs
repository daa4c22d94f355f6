//! The vehicle as effects see it: what it is, how it moves, what pulls on it.

use crate::real::Real;

/// Geometry and inertia of a four-wheeled vehicle, and the ground's inclination.
#[derive(Clone, Copy, Debug)]
pub struct Vehicle<T> {
    /// m \[kg\].
    pub mass: T,
    /// I_zz \[kg m²\].
    pub yaw_inertia: T,
    /// Distance between the left and right wheels \[m\].
    pub track: T,
    /// Distance between the axles \[m\].
    pub wheelbase: T,
    /// Centre of mass behind the front axle \[m\].
    pub cg_to_front_axle: T,
    /// Centre of mass above the ground \[m\].
    pub cg_height: T,
    /// M_res in M_res r \[N m s\].
    pub yaw_damping: T,
    /// R \[m\].
    pub wheel_radius: T,
    /// b \[m\].
    pub wheel_width: T,
    /// I_w \[kg m²\].
    pub wheel_inertia: T,
    /// b_w \[N m s\].
    pub wheel_damping: T,
    /// Inclination of the ground, positive nose-up \[rad\].
    pub pitch: T,
}

/// How the vehicle moves at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Motion<T> {
    /// v \[m/s\], forward.
    pub speed: T,
    /// dv/dt \[m/s²\].
    pub acceleration: T,
    /// r \[rad/s\], left positive.
    pub yaw_rate: T,
    /// ω of fl, fr, rl, rr \[rad/s\].
    pub wheel_speed: [T; 4],
    /// Resistive plus inertial torque at each wheel before the drivetrain's own losses \[N m\].
    pub wheel_torque: [T; 4],
    /// Path travelled \[m\].
    pub path: T,
    /// Time \[s\].
    pub time: T,
}

/// Loads on the body and the drivetrain beside the wheel forces.
#[derive(Clone, Copy, Debug)]
pub struct BodyLoads<T> {
    /// Along x, forward positive \[N\].
    pub force_x: T,
    /// About z, left positive \[N m\].
    pub yaw_moment: T,
    /// Extra torque each motor must deliver at the wheel \[N m\].
    pub wheel_torque: [T; 4],
}

impl<T: Real> BodyLoads<T> {
    /// Nothing beside the wheel forces.
    pub fn none() -> Self {
        BodyLoads {
            force_x: T::zero(),
            yaw_moment: T::zero(),
            wheel_torque: [T::zero(); 4],
        }
    }
}
