//! Effects with a kinematic reading, and those that only forces show.
//!
//! | effect | reading |
//! |---|---|
//! | track-width-error | t_w (1 + e) |
//! | wheel-radius-error | R (1 + e) |
//! | ground-speed-scale, -bias, -delay, yaw-rate-bias | as on any log |
//! | cg-offset | v_y = x_cg r with x_cg moved by e L |
//! | lateral-contrast | slip i e^(∓e/2), right - |
//! | skid-steer-lateral-slip | effective track χ t_w, χ = 1 + e |
//!
//! A user's own effect joins when it touches the vehicle or a sensor and nothing else.

use std::sync::Arc;

use terra_model::{AnyEffect, Effect, Param, Real, Registry, Scale, Scope, Touch, Vehicle};

/// Name shared by both forms.
pub(crate) const SKID: &str = "skid-steer-lateral-slip";
/// The form that also slows the vehicle down.
pub(crate) const DRAG: &str = "centres-drag";

const WIDENING: Param = Param {
    name: "magnitude",
    symbol: "e",
    unit: "1",
    min: 0.0,
    max: 9.0,
    scale: Scale::Linear,
    prior_sd: 1.0,
    doc: "effective over geometric track, less one: χ - 1",
};
/// The same beside a simulator that skids itself, and may do so more than the real vehicle.
const CHANGE: Param = Param {
    min: -0.9,
    prior_sd: 0.5,
    doc: "effective track over the simulator's, less one",
    ..WIDENING
};

/// A skid-steered vehicle's treads turn about centres farther apart than its wheels.
///
/// # Equation
/// χ = (y_l - y_r)/t_w = 1 + e, r = (V_r - V_l)/(χ t_w)
///
/// # Reference
/// A. Mandow et al., IROS 2007; J. L. Martínez et al., IJRR 24(10):867-878, 2005; prior chosen (1.5 to 2 is usual on firm
/// ground).
#[derive(Clone, Copy, Debug, Default)]
pub struct SkidSteerCentres;

/// The same, and the sideways slide takes up drive: its friction turns away from the wheel's plane.
///
/// # Equation
/// as [`SkidSteerCentres`], and v -> v - .1 e |V_r - V_l| sign(V): a tyre that slides with speed s sideways resists rolling
/// like one that also slides ahead by (rolling resistance over friction, about .1) of s.
///
/// # Reference
/// As [`SkidSteerCentres`]; the drag is a chosen form (Coulomb friction along the sliding direction, linearised).
#[derive(Clone, Copy, Debug, Default)]
pub struct SkidSteerDrag;

/// [`SkidSteerCentres`] farther apart, or nearer to each other, than a simulator's.
#[derive(Clone, Copy, Debug, Default)]
struct MovedCentres;

/// [`SkidSteerDrag`] beside a simulator's.
#[derive(Clone, Copy, Debug, Default)]
struct MovedDrag;

macro_rules! skid {
    ($effect:ty, $form:expr, $param:expr, $summary:expr) => {
        impl Effect for $effect {
            const NAME: &'static str = SKID;
            const FORM: &'static str = $form;
            const SUMMARY: &'static str = $summary;
            const PARAMS: &'static [Param] = &[$param];
            const REFERENCE: &'static str = "A. Mandow et al., IROS 2007; prior chosen";
            const TOUCHES: &'static [Touch] = &[Touch::Vehicle];
            const SCOPE: Scope = Scope::Drive;
            const REGIME: &'static str = "yaw rate below that of the wheel speeds, in every turn";
            const ISOLATED_BY: &'static str = "turn at several yaw rates at the same speed";

            fn vehicle<T: Real>(&self, e: &[T], mut vehicle: Vehicle<T>) -> Vehicle<T> {
                if let Some(e) = e.first() {
                    vehicle.track *= *e + 1.0;
                }
                vehicle
            }
        }
    };
}

skid!(
    SkidSteerCentres,
    "centres",
    WIDENING,
    "the treads turn about centres farther apart than the wheels"
);
skid!(
    SkidSteerDrag,
    DRAG,
    WIDENING,
    "the treads turn about centres farther apart than the wheels, and sliding sideways takes up drive"
);
skid!(
    MovedCentres,
    "centres",
    CHANGE,
    "the treads turn about centres farther apart than the simulator's"
);
skid!(
    MovedDrag,
    DRAG,
    CHANGE,
    "the treads turn about centres farther apart than the simulator's, and sliding sideways takes up drive"
);

/// Effects that act on the contact and have a reading there.
const READ_AT_CONTACT: [&str; 2] = ["wheel-radius-error", "lateral-contrast"];

/// The effects that can be asked of a log without torques, alone or `beside` a simulator's, and the others with the reason.
pub(crate) fn readable(registry: &Registry, beside: bool) -> (Registry, Vec<(String, String)>) {
    let reads = |effect: &Arc<dyn AnyEffect>| {
        READ_AT_CONTACT.contains(&effect.name())
            || (effect.name() != SKID
                && effect.scope() != Scope::Rig
                && effect
                    .touches()
                    .iter()
                    .all(|t| matches!(t, Touch::Vehicle | Touch::Sensor)))
    };
    let mut silent: Vec<(String, String)> = vec![];
    let mut known = Registry::empty();
    for effect in registry.effects() {
        if reads(effect) {
            known = known.with_shared_effect(Arc::clone(effect));
        } else if effect.name() != SKID && silent.iter().all(|(name, _)| name != effect.name()) {
            let reason = match effect.scope() {
                Scope::Rig => "shows only on a rig",
                _ => "shows in forces only: record wheel torques or motor currents",
            };
            silent.push((effect.name().to_owned(), reason.to_owned()));
        }
    }
    let known = match beside {
        true => known
            .with_effect::<MovedCentres>()
            .with_effect::<MovedDrag>(),
        false => known
            .with_effect::<SkidSteerCentres>()
            .with_effect::<SkidSteerDrag>(),
    };
    (known, silent)
}
