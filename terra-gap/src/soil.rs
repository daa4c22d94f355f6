//! The free soil parameters of a law around the rover file's start.

use terra_data::{Rover, SoilSharing, Start};
use terra_mme::{Centre, FitSpace, Priors};
use terra_model::{ForceLaw, Law, catalogue};

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
    let start = rover.terrain.start.as_ref().ok_or_else(|| {
        GapError::Soil(
            "[terrain] start is missing: identify the soil first, or name a catalogue id"
                .to_owned(),
        )
    })?;
    match start {
        Start::Id(id) => around(law, rover, Centre::Terrain(catalogue::find(id)?)),
        Start::Own(soil) => around(law, rover, Centre::Terrain(soil)),
        Start::Values(values) => around(law, rover, Centre::Values(values)),
    }
}

/// The fit space of another law than the nominal one, whose start may hold more than this one has: of a table the values that it
/// has, and where the start does not give its parameters the first soil that its author holds for typical.
///
/// # Errors
/// As [`free_soil`], where there is none.
pub(crate) fn rival_soil(law: &Law, rover: &Rover) -> Result<FitSpace, GapError> {
    let has = |name: &str| law.params().iter().any(|p| p.name == name);
    let stiffness = has("k_c") && has("k_phi");
    let given = match &rover.terrain.start {
        Some(Start::Values(values)) => {
            let mut its = values.clone();
            its.retain(|name, _| has(name) || stiffness && name == "k_eq");
            around(law, rover, Centre::Values(&its))
        }
        _ => free_soil(law, rover),
    };
    given.or_else(|why| {
        let model = law.model();
        let typical = model.typical_parameters().into_iter().next();
        let Some(mut typical) = typical.filter(|_| model.is_rival()) else {
            return Err(why);
        };
        typical.resize(law.params().len(), 0.0);
        around(law, rover, Centre::Parameters(&typical))
    })
}

fn around(law: &Law, rover: &Rover, centre: Centre<'_>) -> Result<FitSpace, GapError> {
    let priors = Priors::default().with(&rover.terrain.prior_sd, &rover.terrain.prior_abs_sd);
    FitSpace::new(law, centre, &widths(rover), &priors).map_err(|e| GapError::Soil(e.to_string()))
}
