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

use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Contributions, Flags, StressPoint, StressProfile, WheelForces};
use crate::model::{ForceSlopes, Soil, TerrainModel};
use crate::models::WongReece;
use crate::models::bekker::{self, Ground};
use crate::param::Param;
use crate::quadrature::{rule, t_minus_sin};
use crate::real::{Real, Root};
use crate::root::{MAX_ENTRY_ANGLE, balanced, rises_to};

/// A wheel with two shear zones when it is braked.
#[derive(Clone, Copy, Debug, Default)]
pub struct BrakedTwoZone;

/// Skid below which the driven wheel takes over.
const JOIN: f64 = 0.05;
/// Largest share of the contact behind the point where the zones meet.
const LARGEST: f64 = 0.98;
/// Share of the contact below which a zone behind is none to the quadrature.
const SMALLEST: f64 = 1e-3;
/// Nodes a segment.
const NODES: usize = 24;

#[derive(Clone, Copy)]
struct Wheel<T> {
    ground: Ground<T>,
    /// θ0, not held inside the contact.
    meeting: T,
    /// Weight of the driven wheel.
    driven: T,
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

/// Where stresses change their form: θ0, θm, both inside the contact.
#[derive(Clone, Copy)]
struct Places<T> {
    entry: T,
    meeting: T,
    apex: T,
}

impl<T: Real> Wheel<T> {
    fn read(p: &[T], at: &Contact<T>) -> Result<Self, ModelError> {
        let ground = Ground::read(BrakedTwoZone::NAME, p, at)?;
        let (zero, one) = (T::zero(), T::one());
        // cos(θ0 + χ) = (1 + s) cos χ, χ = 45° - φ/2; by tan²(x/2) = (1 - cos x)/(1 + cos x).
        let chi = T::from(std::f64::consts::FRAC_PI_4) - ground.tan_friction.atan() * 0.5;
        let (_, cos_chi) = chi.sin_cos();
        let skid = at.slip.select_lt(zero, at.slip, zero);
        let cos = (skid + 1.0) * cos_chi;
        let meeting = ((one - cos) / (cos + 1.0)).sqrt().atan() * 2.0 - chi;
        let share = (skid / JOIN + 1.0).max_of(zero);
        Ok(Wheel {
            ground,
            meeting: meeting.max_of(zero),
            driven: share.squared(),
            radius: at.radius * at.hooks.contact_radius,
            arm: at.radius,
            width: at.width,
        })
    }

    fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            ground: self.ground.map(f),
            meeting: f(self.meeting),
            driven: f(self.driven),
            radius: f(self.radius),
            arm: f(self.arm),
            width: f(self.width),
        }
    }

    fn places(&self, entry: T) -> Places<T> {
        let held = self.meeting.min_of(entry * LARGEST);
        let own = self.ground.apex_ratio * entry;
        // The contact ends at the bottom; σ behind it needs some of it left.
        let apex = (own * self.driven + held * (T::one() - self.driven)).max_of(entry * 1e-3);
        Places {
            entry,
            meeting: held,
            apex,
        }
    }

    /// j at an angle; what a driven wheel has, what each zone has, weighed.
    fn displacement(&self, at: &Places<T>, angle: T) -> T {
        let i = self.ground.slip;
        let one = T::one();
        let (x_entry, x_meeting, x) = (
            t_minus_sin(at.entry),
            t_minus_sin(at.meeting),
            t_minus_sin(angle),
        );
        let driven = i * (at.entry - angle) + (one - i) * (x_entry - x);
        let chord = (x_entry - x_meeting) / (at.entry - at.meeting);
        let ahead = (one - i) * ((x_entry - x) - (at.entry - angle) * chord);
        let behind = i * (at.meeting - angle) + (one - i) * (x_meeting - x);
        let two = angle.select_lt(at.meeting, behind, ahead);
        // A wheel that is not braked has one zone, whatever a locked one would have.
        let rest = one - self.driven;
        self.radius * (driven * self.driven + two * rest)
    }

    /// σ and τ.
    fn stresses(&self, at: &Places<T>, angle: T) -> (T, T) {
        let g = &self.ground;
        let mirrored = at.entry - angle * (at.entry - at.apex) / at.apex;
        let place = angle.select_lt(at.apex, mirrored, angle);
        let (sum, _) = ((at.entry + place) * 0.5).sin_cos();
        let (difference, _) = ((at.entry - place) * 0.5).sin_cos();
        let normal = g.stiffness * (self.radius * sum * difference * 2.0).pow_pos(g.exponent);
        let j = self.displacement(at, angle);
        let e = -(-(j.abs() / g.shear_modulus)).exp_m1();
        let e = j.select_lt(T::zero(), -e, e);
        (normal, (g.cohesion + normal * g.tan_friction) * e)
    }

    fn sums(&self, entry: T) -> Sums<T> {
        let at = self.places(entry);
        // Without a zone behind there is no bend, and the contact behind the apex is cut in half.
        let bend = at
            .meeting
            .select_lt(entry * SMALLEST, at.apex * 0.5, at.meeting);
        let (low, high) = (bend.min_of(at.apex), bend.max_of(at.apex));
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
        for (x, w) in rule.nodes.iter().zip(&rule.weights).take(NODES) {
            let (cube, slope) = (x * x * x, 3.0 * x * x * w);
            // Nodes gather where σ rises as a broken power, and where a zone of shear begins.
            let half = low * 0.5;
            add(half * cube, half * slope);
            add(low - half * (x * x), half * (2.0 * x * w));
            add(low + (high - low) * *x, (high - low) * *w);
            let span = (entry - high) * 0.5;
            add(high + span * (x * x), span * (2.0 * x * w));
            add(entry - span * cube, span * slope);
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
    const REFERENCE: &'static str =
        "J. Y. Wong, A. R. Reece, J. Terramechanics 4(2):7-25, 1967 (part II; formulas recalled)";
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

    fn stresses(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        points: usize,
    ) -> Result<Option<StressProfile>, ModelError> {
        let wheel = Wheel::read(p, at)?;
        let entry = wheel.entry(at)?;
        let places = wheel.places(entry);
        Ok(Some(StressProfile::sample(
            0.0,
            places.apex,
            entry,
            points,
            |angle| {
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
    let places = wheel.places(entry);
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
        apex_limited: braking && (entry * LARGEST).primal().any_lt(wheel.meeting.primal()),
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
