//! The ways in which an effect's formula may differ from the library's: one smooth factor each.

use terra_model::{
    AnyEffect, Channel, Circumstance, Contact, Hook, Param, Real, Scalar, Scale, Soil, Touch,
    WheelForces,
};

/// A dimensionless coordinate of the regime, about -1 to 1 over a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Regime {
    /// Usual load of a wheel \[N\].
    pub load: f64,
    /// Largest speed \[m/s\].
    pub speed: f64,
    /// Usual path since a run's start \[m\].
    pub path: f64,
    /// Largest wheel torque \[N m\].
    pub torque: f64,
    /// Largest wheel speed \[rad/s\].
    pub wheel_speed: f64,
}

/// Spread of wheel loads about the usual one by which the coordinate of the load grows by 1.
const LOAD_SPREAD: f64 = 0.3;
/// Slip that is small.
const NEAR: f64 = 0.1;
/// Prior sd of a term: over a log another formula is stronger here and weaker there by such a factor e.
const SPREAD: f64 = 1.0;
/// Slip at which its coordinate is 0, and by which it grows by 1.
const SLIP: f64 = 0.4;

impl Regime {
    /// Of a slip.
    pub(crate) fn slip<T: Real>(slip: T) -> T {
        slip.abs() / SLIP - 1.0
    }
    /// Of a wheel load.
    pub(crate) fn load<T: Real>(&self, load: T) -> T {
        (load / self.load - 1.0) / LOAD_SPREAD
    }
    /// Of a quantity from 0 to its largest.
    pub(crate) fn share<T: Real>(value: T, most: f64) -> T {
        value.abs() * (2.0 / most) - 1.0
    }
    /// Of a path: -1 at its start, 0 at the usual one, 1 far beyond, as most windows of a log lie in its first metres.
    pub(crate) fn path<T: Real>(&self, path: T) -> T {
        let path = path.abs();
        path * 2.0 / (path + self.path) - 1.0
    }
    /// Of a slip, where it is small: 1 at none, falling to -1.
    pub(crate) fn near_no_slip<T: Real>(slip: T) -> T {
        (-(slip.abs() / NEAR)).exp() * 2.0 - 1.0
    }
    /// Its bend: -1/2 in the middle, 1 at the ends. Legendre's second polynomial.
    pub(crate) fn bend<T: Real>(coordinate: T) -> T {
        coordinate.squared() * 1.5 - 0.5
    }
    /// Its twist: 0 in the middle, -1 and 1 at the ends. Legendre's third polynomial.
    pub(crate) fn twist<T: Real>(coordinate: T) -> T {
        coordinate * (coordinate.squared() * 2.5 - 1.5)
    }
}

/// One way to differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Term {
    /// Stronger or weaker with slip.
    Slip,
    /// Bent over slip.
    SlipBend,
    /// Where the wheel hardly slips.
    SlipNear,
    /// With load.
    Load,
    /// With speed.
    Speed,
    /// Bent over speed.
    SpeedBend,
    /// Along the path.
    Path,
    /// Bent along the path.
    PathBend,
    /// Bent twice along the path.
    PathTwist,
    /// With the slip angle.
    Aside,
    /// With earlier passes.
    Passes,
    /// Also in the stiffness.
    Stiffness,
    /// Also in the cohesion.
    Cohesion,
    /// Also in the friction.
    Friction,
    /// Also in the shear modulus.
    ShearModulus,
    /// More or less in the torque than in the pull.
    Torque,
    /// More or less in the side force than in the pull.
    SideForce,
    /// A share that does not depend on the motion.
    Offset,
    /// With the torque of the wheel.
    WheelTorque,
    /// Bent over the torque of the wheel.
    WheelTorqueBend,
    /// With the speed of the wheel.
    WheelSpeed,
}

use Term::{
    Aside, Cohesion, Friction, Load, Offset, Passes, Path, PathBend, PathTwist, ShearModulus,
    SideForce, Slip, SlipBend, SlipNear, Speed, SpeedBend, Stiffness, Torque, WheelSpeed,
    WheelTorque, WheelTorqueBend,
};

/// True where an instrument's torque is not a straight line of the true one: a line has one formula.
fn is_bent(effect: &dyn AnyEffect) -> bool {
    let e: Vec<f64> = effect.params().iter().map(|p| p.prior_sd).collect();
    let reads = |torque| f64::of_effect(effect).report_at(&e, Channel::WheelTorque, torque, 0.0);
    (reads(20.0) - 2.0 * reads(10.0) + reads(0.0)).abs() > 1e-9
}

/// True where an effect of the contact acts by how fast the wheel moves.
fn is_of_speed(effect: &dyn AnyEffect) -> bool {
    let e: Vec<f64> = effect.params().iter().map(|p| p.prior_sd).collect();
    let effect = f64::of_effect(effect);
    let soil = Soil {
        cohesion: Some(1e3),
        friction_angle: Some(0.5),
        stiffness: Some(1e6),
        sinkage_exponent: Some(1.0),
        shear_modulus: Some(0.02),
    };
    let at_speed = |speed: f64| {
        let mut at = Contact::new(0.2, 250.0, 0.25, 0.15);
        (at.speed, at.wheel_speed) = (speed, speed / (0.8 * 0.25));
        (at.slip_angle, at.path, at.earlier_passes) = (0.1, 5.0, 1.0);
        (at.side, at.wheelbase) = (1.0, 0.6);
        effect.alter_contact(&e, &soil, &mut at);
        let mut forces = WheelForces::from_thrust(100.0, 30.0, 20.0);
        forces.sinkage = Some(0.02);
        effect.alter_forces(&e, &soil, &at, &mut forces);
        let h = at.hooks;
        let soil = [
            h.stiffness,
            h.cohesion,
            h.friction,
            h.shear_modulus,
            h.sinkage_exponent,
        ];
        let wheel = [h.contact_radius, h.exit_ratio, h.shear_hump, h.lug_height];
        let pull = [
            forces.drawbar_pull,
            forces.resistive_torque,
            forces.lateral_force,
        ];
        (soil, wheel, pull)
    };
    at_speed(0.2) != at_speed(0.6)
}

impl Term {
    /// The terms that an effect may have on a model that honours these hooks. What an instrument or a ruler gets wrong has
    /// no other formula where it is a straight line, and neither has a contact that is changed in no hook.
    ///
    /// An effect of the ground may be stronger or weaker with slip and load, which every contact has, and with what its own
    /// formula acts by: bulldozed soil that appears on the second pass only would be another name for `multipass`.
    pub(crate) fn of(effect: &dyn AnyEffect, hooks: &[Hook]) -> Vec<Term> {
        let touches = effect.touches();
        let mut out: Vec<Term> = vec![];
        let of_contact = touches.contains(&Touch::Contact) && !effect.needs().is_empty();
        if of_contact || touches.contains(&Touch::Forces) {
            out.extend([Slip, SlipBend, SlipNear, Load]);
            if is_of_speed(effect) {
                out.extend([Speed, SpeedBend]);
            }
            for circumstance in effect.reads() {
                match circumstance {
                    Circumstance::Path => out.extend([Path, PathBend, PathTwist]),
                    Circumstance::SlipAngle => out.push(Aside),
                    Circumstance::EarlierPasses => out.push(Passes),
                    Circumstance::Side | Circumstance::Speed => {}
                }
            }
        }
        if of_contact {
            let mixed = [
                (Hook::Stiffness, Stiffness),
                (Hook::Cohesion, Cohesion),
                (Hook::Friction, Friction),
                (Hook::ShearModulus, ShearModulus),
            ];
            let honoured = mixed.into_iter().filter(|(hook, _)| hooks.contains(hook));
            out.extend(honoured.map(|(_, term)| term));
        }
        if touches.contains(&Touch::Forces) {
            out.extend([Torque, SideForce]);
        }
        if touches.contains(&Touch::Loads) {
            out.extend([
                Speed,
                SpeedBend,
                Path,
                PathBend,
                PathTwist,
                Offset,
                WheelTorque,
                WheelSpeed,
            ]);
        }
        if touches.contains(&Touch::Sensor) && is_bent(effect) {
            out.extend([WheelTorque, WheelTorqueBend]);
        }
        let mut seen = vec![];
        out.retain(|t| {
            let new = !seen.contains(t);
            seen.push(*t);
            new
        });
        out
    }

    /// The parameter of this term.
    pub(crate) fn param(self) -> Param {
        let (name, doc) = match self {
            Slip => ("by_slip", "ln growth of the effect with slip"),
            SlipBend => ("by_slip_bend", "its bend over slip"),
            SlipNear => ("near_no_slip", "ln growth where the wheel hardly slips"),
            Load => ("by_load", "ln growth with the wheel load"),
            Speed => ("by_speed", "ln growth with speed"),
            SpeedBend => ("by_speed_bend", "its bend over speed"),
            Path => ("by_path", "ln growth along the path"),
            PathBend => ("by_path_bend", "its bend along the path"),
            PathTwist => ("by_path_twist", "its twist along the path"),
            Aside => ("by_slip_angle", "ln growth with the slip angle"),
            Passes => ("by_passes", "ln growth with earlier passes"),
            Stiffness => ("in_stiffness", "share that acts on the stiffness too"),
            Cohesion => ("in_cohesion", "share that acts on the cohesion too"),
            Friction => ("in_friction", "share that acts on tan φ too"),
            ShearModulus => (
                "in_shear_modulus",
                "share that acts on the shear modulus too",
            ),
            Torque => ("in_torque", "ln of the torque's share"),
            SideForce => ("in_side_force", "ln of the side force's share"),
            Offset => ("offset", "share that does not depend on the motion"),
            WheelTorque => ("by_wheel_torque", "ln growth with the wheel's torque"),
            WheelTorqueBend => ("by_wheel_torque_bend", "its bend over the wheel's torque"),
            WheelSpeed => ("by_wheel_speed", "ln growth with the wheel's speed"),
        };
        Param {
            name,
            symbol: "a",
            unit: "1",
            min: -6.0,
            max: 6.0,
            scale: Scale::Linear,
            prior_sd: SPREAD,
            doc,
        }
    }
}
