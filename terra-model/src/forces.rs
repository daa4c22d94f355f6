//! What the ground gives a wheel, with its named parts.

use crate::real::Real;

/// Entry, exit and maximum-stress angle of a contact, from the downward vertical, forward positive \[rad\].
#[derive(Clone, Copy, Debug)]
pub struct Angles<T> {
    /// θ1.
    pub entry: T,
    /// θ2.
    pub exit: T,
    /// θm.
    pub max_stress: T,
}

/// The named parts of the drawbar pull \[N\]:
/// drawbar pull = thrust + lug thrust - compaction resistance - bulldozing resistance + other.
#[derive(Clone, Copy, Debug)]
pub struct Contributions<T> {
    /// H: horizontal part of the shear stress on the rim.
    pub thrust: T,
    /// Horizontal part of what lugs push behind them, where a model or an effect has lugs that push; lugs that only shear the
    /// soil at their tips are part of the thrust.
    pub lug_thrust: T,
    /// Rc: horizontal part of the normal stress.
    pub compaction_resistance: T,
    /// Soil pushed ahead of the wheel.
    pub bulldozing_resistance: T,
    /// Anything an effect added under no other name.
    pub other: T,
}

/// What to think of a result that is a number all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Negative slip: an extension of the driving equations without experimental support.
    pub braking: bool,
    /// The angle of maximum stress was held at 2 % or 98 % of the entry angle (braking only).
    pub apex_limited: bool,
    /// Sinkage beyond half the radius: a stress test, not trustworthy physics.
    pub deep_sinkage: bool,
}

/// The forces of the ground on one wheel.
#[derive(Clone, Copy, Debug)]
pub struct WheelForces<T> {
    /// D = F_x, forward positive \[N\].
    pub drawbar_pull: T,
    /// T_r, positive when it resists the drive \[N m\].
    pub resistive_torque: T,
    /// F_y, left positive \[N\].
    pub lateral_force: T,
    /// z below the undisturbed surface \[m\]; none for models without one.
    pub sinkage: Option<T>,
    /// Angles of the contact; none for models without one.
    pub angles: Option<Angles<T>>,
    /// Named parts of the drawbar pull.
    pub parts: Contributions<T>,
    /// Validity.
    pub flags: Flags,
}

impl<T: Real> Contributions<T> {
    /// What drives: the shear of the rim and the push of the lugs \[N\].
    pub fn total_thrust(&self) -> T {
        self.thrust + self.lug_thrust
    }

    /// What resists: compaction and bulldozing \[N\].
    pub fn motion_resistance(&self) -> T {
        self.compaction_resistance + self.bulldozing_resistance
    }

    /// The drawbar pull, as far as effects have named what they add \[N\].
    pub fn sum(&self) -> T {
        self.total_thrust() - self.motion_resistance() + self.other
    }
}

impl<T: Real> WheelForces<T> {
    /// Forces whose pull is thrust less compaction resistance, without side force.
    pub fn from_thrust(thrust: T, compaction_resistance: T, resistive_torque: T) -> Self {
        WheelForces {
            drawbar_pull: thrust - compaction_resistance,
            resistive_torque,
            lateral_force: T::zero(),
            sinkage: None,
            angles: None,
            parts: Contributions {
                thrust,
                lug_thrust: T::zero(),
                compaction_resistance,
                bulldozing_resistance: T::zero(),
                other: T::zero(),
            },
            flags: Flags::default(),
        }
    }
}

impl<T: Copy> WheelForces<T> {
    /// The same values as another scalar.
    pub fn map<S>(self, f: impl Fn(T) -> S + Copy) -> WheelForces<S> {
        WheelForces {
            drawbar_pull: f(self.drawbar_pull),
            resistive_torque: f(self.resistive_torque),
            lateral_force: f(self.lateral_force),
            sinkage: self.sinkage.map(f),
            angles: self.angles.map(|a| Angles {
                entry: f(a.entry),
                exit: f(a.exit),
                max_stress: f(a.max_stress),
            }),
            parts: Contributions {
                thrust: f(self.parts.thrust),
                lug_thrust: f(self.parts.lug_thrust),
                compaction_resistance: f(self.parts.compaction_resistance),
                bulldozing_resistance: f(self.parts.bulldozing_resistance),
                other: f(self.parts.other),
            },
            flags: self.flags,
        }
    }
}
