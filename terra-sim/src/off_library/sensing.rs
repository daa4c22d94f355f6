//! Instruments.

use terra_model::Scope;

use super::{TruthOnly, Unlisted, WheelView};

pub(super) const ENCODER_ECCENTRICITY: TruthOnly = TruthOnly {
    name: "encoder-eccentricity",
    form: "default",
    magnitude: (0.03, 0.2),
    unit: "1",
    scope: Scope::Drive,
    summary: "encoder discs off centre: w_rep = w (1 + e cos(angle + wheel number))",
    reference: "chosen form: first harmonic of a disc that is off centre",
};

/// A reading of wheel speed that swings once a turn.
pub(super) struct EncoderEccentricity;

impl Unlisted for EncoderEccentricity {
    fn entry(&self) -> &TruthOnly {
        &ENCODER_ECCENTRICITY
    }
    fn speed_reading(&self, e: f64, at: &WheelView, speed: f64) -> f64 {
        speed * (1.0 + e * (at.angle + at.wheel as f64).cos())
    }
}
