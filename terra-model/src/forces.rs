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
    /// Samples `stress` from exit to entry and refines the peaks of σ and τ; `apex` is where branches meet, or near which σ
    /// peaks.
    pub fn sample(
        exit: f64,
        apex: f64,
        entry: f64,
        points: usize,
        stress: impl Fn(f64) -> StressPoint,
    ) -> Self {
        let points = points.max(2);
        // Rounding must not step over the entry, where there is no contact.
        let at =
            |i: usize, n: usize| (exit + (entry - exit) * i as f64 / (n - 1) as f64).min(entry);
        let profile: Vec<StressPoint> = (0..points).map(|i| stress(at(i, points))).collect();
        // No sample may be above the peak.
        let scan = points.max(201);
        let place = |i: usize| at(i, scan);
        // A peak on an end or on the apex is a corner that the search only approaches: braking wheels have it at
        // the entry, where the shear stress is exactly zero.
        let corners = [stress(apex), stress(exit), stress(entry)];
        let peak = |of: &dyn Fn(&StressPoint) -> f64| {
            let scanned: Vec<f64> = (0..scan).map(|i| of(&stress(place(i)))).collect();
            let best = (0..scan).max_by(|&a, &b| scanned[a].total_cmp(&scanned[b]));
            let best = best.unwrap_or(0);
            let (mut low, mut high) = (
                place(best.saturating_sub(1)),
                place((best + 1).min(scan - 1)),
            );
            for _ in 0..80 {
                let (a, b) = (
                    low + 0.381_966 * (high - low),
                    low + 0.618_034 * (high - low),
                );
                if of(&stress(a)) < of(&stress(b)) {
                    low = a
                } else {
                    high = b
                }
            }
            let found = stress(0.5 * (low + high));
            let highest = corners
                .into_iter()
                .reduce(|a, b| if of(&b) > of(&a) { b } else { a });
            // Beside a corner the search is no higher than by rounding.
            highest
                .filter(|corner| of(&found) <= of(corner) + 1e-13 * of(corner).abs())
                .unwrap_or(found)
        };
        let max_normal = peak(&|q| q.normal_stress);
        let max_shear = peak(&|q| q.shear_stress);
        StressProfile {
            points: profile,
            max_normal,
            max_shear,
            flat: None,
        }
    }
}
