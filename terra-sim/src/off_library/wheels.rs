//! Wheels that are not what they were built to be.

use std::f64::consts::TAU;

use terra_model::{Contact, Scope};

use super::{TruthOnly, Unlisted, WheelView};

pub(super) const WHEEL_OUT_OF_ROUND: TruthOnly = TruthOnly {
    name: "wheel-out-of-round",
    form: "default",
    magnitude: (0.02, 0.1),
    unit: "1",
    scope: Scope::Drive,
    summary: "the front left wheel is an egg: R (1 + e cos(2 angle))",
    reference: "chosen form: an ellipse to first order in its flattening",
};

/// One wheel whose radius changes twice a turn.
pub(super) struct WheelOutOfRound;

impl Unlisted for WheelOutOfRound {
    fn entry(&self) -> &TruthOnly {
        &WHEEL_OUT_OF_ROUND
    }
    fn radius(&self, e: f64, at: &WheelView) -> f64 {
        if at.wheel == 0 {
            1.0 + e * (2.0 * at.angle).cos()
        } else {
            1.0
        }
    }
}

pub(super) const WHEEL_HOP: TruthOnly = TruthOnly {
    name: "wheel-hop",
    form: "default",
    magnitude: (0.1, 0.4),
    unit: "1",
    scope: Scope::Drive,
    summary: "the body bounces in pitch: W (1 ± e sin(2π 2.5 Hz t) tanh(v/.5 m/s)), + front, - rear",
    reference: "J. Y. Wong, Theory of Ground Vehicles, 4th ed., 2008, ch. 7 (ride); frequency and size chosen",
};

/// Loads that swing between the axles as the body pitches.
pub(super) struct WheelHop;

impl Unlisted for WheelHop {
    fn entry(&self) -> &TruthOnly {
        &WHEEL_HOP
    }
    fn contact(&self, e: f64, at: &WheelView, mut contact: Contact<f64>) -> Contact<f64> {
        let swing = e * (TAU * 2.5 * at.time).sin() * (at.speed.abs() / 0.5).tanh();
        // What an axle gains the other loses; beyond 90 % the wheel would leave the ground.
        let swing = swing.clamp(-0.9, 0.9);
        contact.normal_load *= 1.0 + if at.wheel < 2 { swing } else { -swing };
        contact
    }
}

pub(super) const PUNCTURED_WHEEL: TruthOnly = TruthOnly {
    name: "punctured-wheel",
    form: "default",
    magnitude: (0.03, 0.12),
    unit: "1",
    scope: Scope::Drive,
    summary: "the rear left wheel is flat: R (1 - e), a contact as of a wheel (1 + 4 e) times as large, rolling loss 30 N m e tanh(w/.1 rad/s)",
    reference: "chosen form: smaller rolling radius, longer contact, rolling loss",
};

/// One soft wheel.
pub(super) struct PuncturedWheel;

impl Unlisted for PuncturedWheel {
    fn entry(&self) -> &TruthOnly {
        &PUNCTURED_WHEEL
    }
    fn radius(&self, e: f64, at: &WheelView) -> f64 {
        if at.wheel == 2 { 1.0 - e.min(0.9) } else { 1.0 }
    }
    fn contact(&self, e: f64, at: &WheelView, mut contact: Contact<f64>) -> Contact<f64> {
        if at.wheel == 2 {
            contact.hooks.contact_radius *= 1.0 + 4.0 * e;
        }
        contact
    }
    fn loss(&self, e: f64, at: &WheelView) -> f64 {
        if at.wheel == 2 {
            30.0 * e * (at.wheel_speed / 0.1).tanh()
        } else {
            0.0
        }
    }
}
