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
/// drawbar pull = thrust - compaction resistance - bulldozing resistance + other.
#[derive(Clone, Copy, Debug)]
pub struct Contributions<T> {
    /// H: horizontal part of the shear stress.
    pub thrust: T,
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
                compaction_resistance: f(self.parts.compaction_resistance),
                bulldozing_resistance: f(self.parts.bulldozing_resistance),
                other: f(self.parts.other),
            },
            flags: self.flags,
        }
    }
}

/// Stresses on the rim at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressPoint {
    /// θ \[rad\].
    pub angle: f64,
    /// σ \[Pa\].
    pub normal_stress: f64,
    /// τ \[Pa\]; where lugs push soil, with their push spread over the rim, as the mean over their places has it.
    pub shear_stress: f64,
    /// How far from the axle τ acts \[m\]: at the rim, or farther out where lugs carry a part of it. The torque is
    /// R b ∫ τ `shear_arm` dθ.
    pub shear_arm: f64,
}

/// The stresses of one contact, from exit to entry, with their peaks.
#[derive(Clone, Debug, PartialEq)]
pub struct StressProfile {
    /// Along the rim.
    pub points: Vec<StressPoint>,
    /// Where σ is largest, with both stresses there.
    pub max_normal: StressPoint,
    /// Where τ is largest (signed), with both stresses there.
    pub max_shear: StressPoint,
    /// Half the angle \[rad\] under which a tyre lies flat: points within it lie on the chord, where stresses push upwards
    /// and along it. None where the contact is round all along.
    pub flat: Option<f64>,
}

impl StressProfile {
    /// Samples `stress` from exit to entry and refines the peak of τ; σ peaks at `apex`.
    pub fn sample(
        exit: f64,
        apex: f64,
        entry: f64,
        points: usize,
        stress: impl Fn(f64) -> StressPoint,
    ) -> Self {
        let points = points.max(2);
        let at = |i: usize, n: usize| exit + (entry - exit) * i as f64 / (n - 1) as f64;
        let profile: Vec<StressPoint> = (0..points).map(|i| stress(at(i, points))).collect();
        const SCAN: usize = 201;
        let scan = |i: usize| stress(at(i, SCAN));
        let higher = |a: StressPoint, b: StressPoint| {
            if b.shear_stress > a.shear_stress {
                b
            } else {
                a
            }
        };
        let best = (0..SCAN)
            .max_by(|&a, &b| scan(a).shear_stress.total_cmp(&scan(b).shear_stress))
            .unwrap_or(0);
        let (mut low, mut high) = (
            at(best.saturating_sub(1), SCAN),
            at((best + 1).min(SCAN - 1), SCAN),
        );
        for _ in 0..80 {
            let (a, b) = (
                low + 0.381_966 * (high - low),
                low + 0.618_034 * (high - low),
            );
            if stress(a).shear_stress < stress(b).shear_stress {
                low = a
            } else {
                high = b
            }
        }
        // A peak on an end or on the apex is a corner that the search only approaches: braking wheels have it at
        // the entry, where the shear stress is exactly zero.
        let corners = [stress(exit), stress(apex), stress(entry)];
        let max_shear = corners.into_iter().fold(stress(0.5 * (low + high)), higher);
        StressProfile {
            points: profile,
            max_normal: stress(apex),
            max_shear,
            flat: None,
        }
    }
}
