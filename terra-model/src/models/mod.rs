//! The terrain models, one file each.

mod bekker;
mod linear_stress;
mod wong_reece;

pub use linear_stress::LinearStress;
pub use wong_reece::{Accuracy, WongReece};

use crate::registry::Registry;

/// Registers every model of this folder. A new model is one file and one line here.
pub(crate) fn register(registry: Registry) -> Registry {
    registry
        .with_model::<WongReece>()
        .with_model::<LinearStress>()
}
