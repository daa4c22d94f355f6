//! The free soil parameters of a law around the rover file's start.

use terra_data::{Rover, SoilSharing, Start};
use terra_mme::{Centre, FitSpace, Priors};
use terra_model::{Law, catalogue};

use crate::error::GapError;

/// Widths of the wheels that share one soil \[m\].
pub(crate) fn widths(rover: &Rover) -> Vec<f64> {
    let shared = rover
        .conditions
        .values()
        .filter(|c| c.soil == SoilSharing::Shared);
    std::iter::once(rover.wheel.width)
        .chain(shared.map(|c| c.wheel.width))
        .collect()
}

/// The fit space of a law: prior centre and spreads of `[terrain]`, one stiffness `k_eq` where one width is used.
///
/// # Errors
/// A start that the law cannot use, by name.
pub(crate) fn free_soil(law: &Law, rover: &Rover) -> Result<FitSpace, GapError> {
    let widths = widths(rover);
    let priors = Priors::default().with(&rover.terrain.prior_sd, &rover.terrain.prior_abs_sd);
    let start = rover.terrain.start.as_ref().ok_or_else(|| {
        GapError::Soil(
            "[terrain] start is missing: identify the soil first, or name a catalogue id"
                .to_owned(),
        )
    })?;
    let space = match start {
        Start::Id(id) => {
            FitSpace::new(law, Centre::Terrain(catalogue::find(id)?), &widths, &priors)
        }
        Start::Own(soil) => FitSpace::new(law, Centre::Terrain(soil), &widths, &priors),
        Start::Values(values) => FitSpace::new(law, Centre::Values(values), &widths, &priors),
    };
    space.map_err(|e| GapError::Soil(e.to_string()))
}
