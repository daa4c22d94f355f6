//! The terrain models, one file each.

mod bekker;
mod bekker_compaction;
mod braked_two_zone;
mod compliant_tyre;
mod displacement;
mod granular_rft;
mod grid_scm;
mod hard_ground;
mod linear_stress;
pub(crate) mod slots;
mod wes_brixius;
mod wong_reece;

pub use bekker_compaction::BekkerCompaction;
pub use braked_two_zone::BrakedTwoZone;
pub use compliant_tyre::CompliantTyre;
pub use granular_rft::GranularRft;
pub use grid_scm::{GridScm, SoilGrid};
pub use hard_ground::HardGround;
pub use linear_stress::LinearStress;
pub use slots::{Filling, Slots};
pub use wes_brixius::WesBrixius;
pub use wong_reece::{Accuracy, WongReece};

use crate::registry::Registry;

/// Registers every model of this folder. A new model is one file and one line here; other combinations of slots are found
/// by name.
pub(crate) fn register(registry: Registry) -> Registry {
    let registry = registry
        .with_model::<WongReece>()
        .with_model::<LinearStress>();
    let registry = slots::presets().fold(registry, |r, model| r.with_shared(model.shared()));
    registry
        .with_model::<CompliantTyre>()
        .with_model::<GranularRft>()
        .with_model::<BekkerCompaction>()
        .with_model::<WesBrixius>()
        .with_model::<HardGround>()
        .with_named_model::<BrakedTwoZone>()
}
