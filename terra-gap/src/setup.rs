//! What all steps of a diagnosis share: the nominal simulator with its rivals, the screen's rows, and the thresholds.

use std::sync::Arc;

use terra_data::Rover;
use terra_model::{Law, Registry};

use crate::noise::Inherited;
use crate::screen::Score;
use crate::settings::LogKind;
use crate::soil_space::SoilSpace;

/// |cosine| from which two signatures cannot be told apart.
pub const LOOK_ALIKE: f64 = 0.95;
/// The answer that the ground is other soil than a baseline's.
pub const OTHER_SOIL: &str = "soil-change";
/// Whitened misfit per value up to which a fit is adequate: what null contrasts of real rigs reach.
pub const ADEQUATE: f64 = 4.0;

/// The nominal simulator and its rivals, ready to be fitted.
pub(crate) struct Setup<'a> {
    /// Models and effects by name.
    pub registry: &'a Registry,
    /// The rover file.
    pub rover: &'a Rover,
    /// Nominal law.
    pub law: Law,
    /// Its free soil parameters.
    pub soil: Arc<SoilSpace>,
    /// Other terrain models, or other soil than a baseline's.
    pub structures: Vec<Rival>,
    /// Terrain models that cannot compete, with the reason.
    pub without: Vec<(String, String)>,
    /// Kind of log.
    pub kind: LogKind,
    /// What the nominal law was taught by another log.
    pub inherited: Option<Inherited>,
}

/// A law that competes as a whole.
pub(crate) struct Rival {
    /// `structure:<model>` or `soil-change`.
    pub name: String,
    /// Law.
    pub law: Law,
    /// Its free soil parameters.
    pub soil: Arc<SoilSpace>,
}

/// One effect as the screen saw it.
#[derive(Clone, Debug)]
pub struct Screened {
    /// Effect.
    pub name: String,
    /// Its form.
    pub form: String,
    /// Its score.
    pub score: Score,
}
