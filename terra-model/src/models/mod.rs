//! The terrain models, one file each.

mod bekker;
mod linear_stress;
pub(crate) mod slots;
mod wong_reece;

pub use linear_stress::LinearStress;
pub use wong_reece::WongReece;

use crate::registry::Registry;

/// Registers every model of this folder. A new model is one file and one line here; other combinations of slots are found
/// by name.
pub(crate) fn register(registry: Registry) -> Registry {
    let registry = registry
        .with_model::<WongReece>()
        .with_model::<LinearStress>();
    slots::presets().fold(registry, |r, model| r.with_shared(model.shared()))
}
