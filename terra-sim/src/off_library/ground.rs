//! Soils that no parameter set describes.

use std::f64::consts::TAU;

use terra_model::{Contact, STANDSTILL_SPEED, Scope};

use super::{TruthOnly, Unlisted, WheelView, smooth_step};

pub(super) const MOISTURE_CRUST: TruthOnly = TruthOnly {
    name: "moisture-crust",
    form: "default",
    magnitude: (0.3, 2.0),
    unit: "1",
    scope: Scope::Any,
    summary: "a damp skin in patches of 1.5 m that breaks at slip .2 to .35: k (1 + e w), c (1 + 2 e w), w = patch x unbroken",
    reference: "chosen form: a skin in patches that breaks under slip",
};

/// A stiff skin that is there in patches and breaks under slip.
pub(super) struct MoistureCrust;

impl Unlisted for MoistureCrust {
    fn entry(&self) -> &TruthOnly {
        &MOISTURE_CRUST
    }
    fn contact(&self, e: f64, _at: &WheelView, mut contact: Contact<f64>) -> Contact<f64> {
        let patch = smooth_step(0.5 + 1.5 * (TAU * contact.path / 3.0 + 0.7).sin());
        let unbroken = 1.0 - smooth_step((contact.slip.abs() - 0.2) / 0.15);
        let share = e * patch * unbroken;
        contact.hooks.stiffness *= 1.0 + share;
        contact.hooks.cohesion *= 1.0 + 2.0 * share;
        contact
    }
}

pub(super) const FORCE_RELAXATION: TruthOnly = TruthOnly {
    name: "force-relaxation",
    form: "default",
    magnitude: (0.1, 0.6),
    unit: "m",
    scope: Scope::Drive,
    summary: "the pull builds up over a length: dF/dt = max(|v|, R |w|, .05 m/s) (D - F)/e",
    reference: "H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., 2012 (relaxation length); size chosen",
};

/// A pull that follows slip late, over a length.
pub(super) struct ForceRelaxation;

impl Unlisted for ForceRelaxation {
    fn entry(&self) -> &TruthOnly {
        &FORCE_RELAXATION
    }
    fn pull(&self, _e: f64, at: &WheelView, _pull: f64) -> f64 {
        at.memory
    }
    fn remembers(&self) -> bool {
        true
    }
    fn memory_rate(&self, e: f64, at: &WheelView, pull: f64) -> f64 {
        let speed = at.speed.abs().max((at.radius * at.wheel_speed).abs());
        speed.max(STANDSTILL_SPEED) * (pull - at.memory) / e
    }
}

pub(super) const BURIED_STONES: TruthOnly = TruthOnly {
    name: "buried-stones",
    form: "default",
    magnitude: (20.0, 100.0),
    unit: "N",
    scope: Scope::Drive,
    summary: "the right wheels climb stones .25 m long every .9 m: pull - e sin(2π share of the stone), up and then down",
    reference: "chosen form: up and down a bump without loss",
};

/// Stones under the right wheels: a force back, then forward.
pub(super) struct BuriedStones;

impl Unlisted for BuriedStones {
    fn entry(&self) -> &TruthOnly {
        &BURIED_STONES
    }
    fn pull(&self, e: f64, at: &WheelView, pull: f64) -> f64 {
        if at.wheel.is_multiple_of(2) {
            return pull;
        }
        let share = (at.radius * at.angle).rem_euclid(0.9) / 0.25;
        if share < 1.0 {
            pull - e * (TAU * share).sin() * (at.speed / STANDSTILL_SPEED).tanh().abs()
        } else {
            pull
        }
    }
}
