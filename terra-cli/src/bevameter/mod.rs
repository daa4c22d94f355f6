//! Bevameter tests from files to soils: reading, fitting soil by soil, telling.

mod columns;
mod json;
mod read;

use terra_model::bevameter::{Fits, fit_plates, fit_shear};

pub(crate) use columns::Columns;
pub(crate) use json::to_json;
pub(crate) use read::{Tests, read};

use crate::error::CliError;

/// What was pressed or sheared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Plate,
    Shear,
}

impl Kind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Plate => "plate",
            Kind::Shear => "shear",
        }
    }
}

/// One soil with its tests fitted together.
pub(crate) struct Soil {
    pub(crate) name: String,
    pub(crate) fits: Fits,
}

/// Every soil of the file by itself.
///
/// # Errors
/// Tests with too few points, named.
pub(crate) fn fit(kind: Kind, tests: &Tests, columns: &Columns) -> Result<Vec<Soil>, CliError> {
    let (from, to) = columns.range();
    tests
        .soils
        .iter()
        .map(|(name, curves)| {
            let fits = match kind {
                Kind::Plate => fit_plates(curves, from, to),
                Kind::Shear => fit_shear(curves, from, to),
            };
            let fits = fits.map_err(|e| {
                CliError::data(
                    format!("{}: soil {name}: {e}", tests.file),
                    "rows count where a test goes deeper or farther than before and carries stress; [fit] from_m, to_m set the range",
                )
            })?;
            Ok(Soil {
                name: name.clone(),
                fits,
            })
        })
        .collect()
}
