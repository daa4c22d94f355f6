//! The braked or towed wheel with two shear zones: soil flows forward ahead of a point of the rim and back behind it.
//!
//! # Equation
//! Driven (s >= 0) it is the wheel of part I: θm = (c1 + c2 s) θ1, j = R \[(θ1 - θ) - (1 - i)(sin θ1 - sin θ)\]. Braked (s < 0,
//! 1 - i = 1/(1 + s)) the zones meet, and the normal stress is largest, where the rim's own motion lies along the slip
//! line of the soil: cos θ0 - (1 + s) = tan(45° - φ/2) sin θ0. There the shear displacement begins anew:
//! ahead, θ0 <= θ <= θ1, j = R (1 - i) \[(θ1 - θ)(sin θ1 - sin θ0)/(θ1 - θ0) - (sin θ1 - sin θ)\] >= 0, against the rotation;
//! behind, 0 <= θ <= θ0, j = R \[(θ0 - θ) - (1 - i)(sin θ0 - sin θ)\], mostly with it. σ and E as in part I.
//!
//! Part II is meant for skids above 5 %. Between -.05 and 0 apex and displacement pass into those of the driven wheel by the
//! weight (1 + s/.05)² (chosen), so that forces have no jump at zero slip. Where θ0 would lie ahead of the contact it is held
//! at 98 % of it, with a flag: one zone is left.
//!
//! # Reference
//! J. Y. Wong, A. R. Reece, "Prediction of rigid wheel performance based on the analysis of soil-wheel stresses, part II:
//! performance of towed rigid wheels", J. Terramechanics 4(2):7-25, 1967 (formulas checked against an open implementation of
//! the paper, not against its print).

pub(in crate::models) mod zones;

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Contributions, Flags, WheelForces};
use crate::model::{ForceSlopes, Soil, TerrainModel};
use crate::models::WongReece;
use crate::models::bekker::{self, Ground};
use crate::param::Param;
use crate::quadrature::rule;
use crate::real::{Real, Root};
use crate::root::{MAX_ENTRY_ANGLE, TOLERANCE, balanced, rises_to};
use crate::stress::{StressField, StressPoint};
use zones::{Places, SMALLEST, Zones};

/// A wheel with two shear zones when it is braked.
#[derive(Clone, Copy, Debug, Default)]
pub struct BrakedTwoZone;

/// Depth \[m\] below which nothing is told from the entry.
const SHALLOW: f64 = 1e-200;
/// Nodes a segment.
const NODES: usize = 24;
/// Largest j/K along the contact, about, that one panel resolves.
const STEEP: f64 = 20.0;

#[derive(Clone, Copy)]
struct Wheel<T> {
    ground: Ground<T>,
    zones: Zones<T>,
    radius: T,
    arm: T,
    width: T,
}

struct Sums<T> {
    load: T,
    thrust: T,
    compaction: T,
    turning: T,
}

impl<T: Real> Wheel<T> {
    fn read(p: &[T], at: &Contact<T>) -> Result<Self, ModelError> {
        let ground = Ground::read(BrakedTwoZone::NAME, p, at)?;
        Ok(Wheel {
            zones: Zones::new(ground.tan_friction, at.slip, ground.slip, ground.apex_ratio),
            ground,
            radius: at.radius * at.hooks.contact_radius,
            arm: at.radius,
            width: at.width,
        })
    }

    fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            ground: self.ground.map(f),
            zones: self.zones.map(f),
            radius: f(self.radius),
            arm: f(self.arm),
            width: f(self.width),
        }
    }

    /// σ and τ.
    fn stresses(&self, at: &Places<T>, angle: T) -> (T, T) {
        let g = &self.ground;
        let mirrored = at.entry - angle * (at.entry - at.apex) / at.apex;
        let place = angle.select_lt(at.apex, mirrored, angle);
        let (sum, _) = ((at.entry + place) * 0.5).sin_cos();
        let (difference, _) = ((at.entry - place) * 0.5).sin_cos();
        // At the entry itself a power of the depth has no derivative.
        let depth = (self.radius * sum * difference * 2.0).max_of(T::from(SHALLOW));
        let normal = g.stiffness * depth.pow_pos(g.exponent);
        let j = self.radius * self.zones.displacement(at, angle);
        let e = -(-(j.abs() / g.shear_modulus)).exp_m1();
        let e = j.select_lt(T::zero(), -e, e);
        (normal, (g.cohesion + normal * g.tan_friction) * e)
    }

    /// Ends of the panels of each piece. A nearly locked wheel has thin layers of shear beside the ends of its zones, and a
    /// change of sign may lie just behind the entry.
    fn panels(&self, entry: T) -> &'static [f64] {
        let (g, entry) = (&self.ground, entry.primal());
        let turned = T::Primal::one() - g.slip.primal();
        let per_modulus = self.radius.primal() / g.shear_modulus.primal();
        let steep = turned * entry.squared() * per_modulus;
        if self.zones.joins() || T::Primal::from(STEEP).any_lt(steep) {
            &[0.0, 0.015, 0.12, 1.0]
        } else {
            &[0.0, 1.0]
        }
    }

    /// Where the stresses bend, in rising order: at θm, at θ0, and where the shear changes its sign.
    fn breaks(&self, at: &Places<T>) -> [T; 3] {
        // Without a zone behind there is no bend, and the contact behind the apex is cut in half.
        let none = at.apex * 0.5;
        let bend = at.meeting.select_lt(at.entry * SMALLEST, none, at.meeting);
        let turn = self.zones.turn(at).map_or(bend, T::from_primal);
        let turn = turn.select_lt(at.entry * SMALLEST, none, turn);
        let (low, high) = (bend.min_of(at.apex), bend.max_of(at.apex));
        let middle = low.max_of(turn).min_of(high);
        [low.min_of(turn), middle, high.max_of(turn)]
    }

    fn sums(&self, entry: T) -> Sums<T> {
        let at = self.zones.places(entry);
        let [first, second, third] = self.breaks(&at);
        let zero = T::zero();
        let (mut load, mut thrust, mut compaction, mut turning) = (zero, zero, zero, zero);
        let mut add = |angle: T, weight: T| {
            let (normal, shear) = self.stresses(&at, angle);
            let (sin, cos) = angle.sin_cos();
            load += (normal * cos + shear * sin) * weight;
            thrust += shear * cos * weight;
            compaction += normal * sin * weight;
            turning += shear * weight;
        };
        let rule = rule::<NODES>();
        for ends in self.panels(entry).windows(2) {
            let (from, length) = (ends[0], ends[1] - ends[0]);
            for (x, w) in rule.nodes.iter().zip(&rule.weights).take(NODES) {
                let (x, w) = (from + length * x, length * w);
                let (square, slope) = (x * x, 2.0 * x * w);
                // Nodes gather where σ rises as a broken power, and where a zone of shear begins.
                let (fifth, steep) = (x.powi(5), 5.0 * x.powi(4) * w);
                let half = first * 0.5;
                add(half * fifth, half * steep);
                add(first - half * square, half * slope);
                for (low, high) in [(first, second), (second, third)] {
                    let half = (high - low) * 0.5;
                    if zero.primal().any_lt(half.primal()) {
                        add(low + half * square, half * slope);
                        add(high - half * square, half * slope);
                    }
                }
                let half = (entry - third) * 0.5;
                add(third + half * square, half * slope);
                add(entry - half * fifth, half * steep);
            }
        }
        Sums {
            load,
            thrust,
            compaction,
            turning,
        }
    }

    fn load(&self, entry: T) -> T {
        self.sums(entry).load * self.radius * self.width
    }

    fn entry(&self, at: &Contact<T>) -> Result<T, ModelError> {
        type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
        let primal = self.map(T::primal);
        let load = at.normal_load.primal();
        let guess = primal
            .ground
            .compaction_guess(load, primal.radius, primal.width);
        let tangent: Wheel<Tangent<T>> = primal.map(Tangent::<T>::from_primal);
        balanced(
            at.normal_load,
            guess,
            at.slip.primal(),
            rises_to(at.slip.primal(), MAX_ENTRY_ANGLE),
            TOLERANCE,
            |angle| tangent.load(angle),
            |angle| self.load(angle),
        )
    }
}

impl TerrainModel for BrakedTwoZone {
    const NAME: &'static str = "braked-two-zone";
    const SUMMARY: &'static str =
        "rigid wheel that, braked or towed, has two zones of shear whose soil flows apart";
    const PARAMS: &'static [Param] = bekker::PARAMS;
    const EQUATION: &'static str = "\
Driven (s >= 0) it is the wheel of part I: θm = (c1 + c2 s) θ1, j = R [(θ1 - θ) - (1 - i)(sin θ1 - sin θ)]. Braked (s < 0,
1 - i = 1/(1 + s)) the zones meet, and the normal stress is largest, where the rim's own motion lies along the slip
line of the soil: cos θ0 - (1 + s) = tan(45° - φ/2) sin θ0. There the shear displacement begins anew:
ahead, θ0 <= θ <= θ1, j = R (1 - i) [(θ1 - θ)(sin θ1 - sin θ0)/(θ1 - θ0) - (sin θ1 - sin θ)] >= 0, against the rotation;
behind, 0 <= θ <= θ0, j = R [(θ0 - θ) - (1 - i)(sin θ0 - sin θ)], mostly with it. σ and E as in part I.

Part II is meant for skids above 5 %. Between -.05 and 0 apex and displacement pass into those of the driven wheel by the
weight (1 + s/.05)² (chosen), so that forces have no jump at zero slip. Where θ0 would lie ahead of the contact it is held
at 98 % of it, with a flag: one zone is left.";
    const REFERENCE: &'static str = "J. Y. Wong, A. R. Reece, J. Terramechanics 4(2):7-25, 1967 (part II; formulas as an open code after that paper has them)";
    const HOOKS: &'static [Hook] = &[
        Hook::Stiffness,
        Hook::Cohesion,
        Hook::Friction,
        Hook::ShearModulus,
        Hook::SinkageExponent,
        Hook::ContactRadius,
    ];

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        let zero = T::Primal::zero();
        if !at.slip.primal().any_lt(zero) {
            return WongReece.wheel_forces(p, at);
        }
        let braked = braked_forces(p, at)?;
        if at.slip.primal().max_lane() < 0.0 {
            return Ok(braked);
        }
        // Lanes of both kinds.
        let driven = Contact {
            slip: at.slip.max_of(T::zero()),
            ..*at
        };
        Ok(either(at.slip, braked, WongReece.wheel_forces(p, &driven)?))
    }

    fn slopes(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<ForceSlopes>, ModelError> {
        if at.slip >= 0.0 {
            WongReece.slopes(p, at)
        } else {
            Ok(None)
        }
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        bekker::soil(p, at)
    }

    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        let wheel = Wheel::read(p, at)?;
        let entry = wheel.entry(at)?;
        let places = wheel.zones.places(entry);
        Ok(Some(StressField::new(
            0.0,
            places.apex,
            entry,
            move |angle| {
                let (normal_stress, shear_stress) = wheel.stresses(&places, angle);
                StressPoint {
                    angle,
                    normal_stress,
                    shear_stress,
                    shear_arm: wheel.arm,
                }
            },
        )))
    }
}

/// Forces of a braked wheel; a driven one's to the accuracy of this quadrature.
fn braked_forces<T: Real>(p: &[T], at: &Contact<T>) -> Result<WheelForces<T>, ModelError> {
    let wheel = Wheel::read(p, at)?;
    let entry = wheel.entry(at)?;
    let sums = wheel.sums(entry);
    let places = wheel.zones.places(entry);
    let area = wheel.radius * wheel.width;
    let mut forces = WheelForces::from_thrust(
        sums.thrust * area,
        sums.compaction * area,
        sums.turning * area * wheel.arm,
    );
    let (half, _) = (entry * 0.5).sin_cos();
    let sinkage = wheel.radius * half.squared() * 2.0;
    forces.sinkage = Some(sinkage);
    forces.angles = Some(Angles {
        entry,
        exit: T::zero(),
        max_stress: places.apex,
    });
    let braking = at.slip.primal().any_lt(T::Primal::zero());
    forces.flags = Flags {
        braking,
        apex_limited: braking && wheel.zones.held(entry),
        deep_sinkage: (at.radius * 0.5).primal().any_lt(sinkage.primal()),
    };
    Ok(forces)
}

/// Each lane of one or the other.
fn either<T: Real>(slip: T, braked: WheelForces<T>, driven: WheelForces<T>) -> WheelForces<T> {
    let zero = T::zero();
    let pick = |a: T, b: T| slip.select_lt(zero, a, b);
    let both = |a: Option<T>, b: Option<T>| a.zip(b).map(|(a, b)| pick(a, b));
    let (a, b) = (braked.parts, driven.parts);
    WheelForces {
        drawbar_pull: pick(braked.drawbar_pull, driven.drawbar_pull),
        resistive_torque: pick(braked.resistive_torque, driven.resistive_torque),
        lateral_force: pick(braked.lateral_force, driven.lateral_force),
        sinkage: both(braked.sinkage, driven.sinkage),
        angles: braked.angles.zip(driven.angles).map(|(a, b)| Angles {
            entry: pick(a.entry, b.entry),
            exit: pick(a.exit, b.exit),
            max_stress: pick(a.max_stress, b.max_stress),
        }),
        parts: Contributions {
            thrust: pick(a.thrust, b.thrust),
            lug_thrust: pick(a.lug_thrust, b.lug_thrust),
            compaction_resistance: pick(a.compaction_resistance, b.compaction_resistance),
            bulldozing_resistance: pick(a.bulldozing_resistance, b.bulldozing_resistance),
            other: pick(a.other, b.other),
        },
        flags: Flags {
            deep_sinkage: braked.flags.deep_sinkage || driven.flags.deep_sinkage,
            ..braked.flags
        },
    }
}

#[cfg(test)]
mod tests;
