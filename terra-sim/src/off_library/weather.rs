//! What the air does.

use std::f64::consts::TAU;

use terra_model::Scope;

use super::{TruthOnly, Unlisted};

pub(super) const WIND_GUSTS: TruthOnly = TruthOnly {
    name: "wind-gusts",
    form: "default",
    magnitude: (10.0, 60.0),
    unit: "N",
    scope: Scope::Drive,
    summary: "gusts from ahead and aside: force -e g(t), moment .2 m e g(t + .4 s), g = (sin(2π .31 Hz t) + sin(2π .83 Hz t))/2",
    reference: "chosen form: two sines without a common period",
};

/// A force and a moment that come and go.
pub(super) struct WindGusts;

fn gust(time: f64) -> f64 {
    0.5 * ((TAU * 0.31 * time).sin() + (TAU * 0.83 * time).sin())
}

impl Unlisted for WindGusts {
    fn entry(&self) -> &TruthOnly {
        &WIND_GUSTS
    }
    fn body(&self, e: f64, _speed: f64, time: f64) -> (f64, f64) {
        (0.0 - e * gust(time), 0.2 * e * gust(time + 0.4))
    }
}
