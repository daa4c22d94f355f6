//! Soils by name, the literature's and a user's own, and values that take the place of theirs.

use std::path::Path;

use terra_data::{names_a_file, read_terrains};
use terra_model::catalogue::{self, Missing, Terrain};
use terra_model::{AnyModel, ModelError, nearest};

use crate::error::CliError;

/// A user's own catalogue before the built-in one: what it names counts.
pub(crate) struct Soils {
    own: Vec<Terrain>,
}

impl Soils {
    /// The built-in catalogue, and a file's soils before it.
    pub(crate) fn open(catalogue: Option<&Path>) -> Result<Self, CliError> {
        Ok(Soils {
            own: catalogue
                .map(read_terrains)
                .transpose()?
                .unwrap_or_default(),
        })
    }

    /// The soil of that id.
    pub(crate) fn find(&self, id: &str) -> Result<&Terrain, CliError> {
        if let Some(own) = self.own.iter().find(|t| t.id == id) {
            return Ok(own);
        }
        let known = self.own.iter().chain(catalogue::terrains());
        Ok(catalogue::find(id).map_err(|_| ModelError::UnknownName {
            kind: "terrain",
            name: id.to_owned(),
            nearest: nearest(id, known.map(|t| t.id.as_ref())).map(str::to_owned),
        })?)
    }

    /// The soils of a set, or of a CSV file of their own.
    pub(crate) fn set(&self, name: &str) -> Result<Vec<Terrain>, CliError> {
        if names_a_file(name) {
            return Ok(read_terrains(name)?);
        }
        let own = self.own.iter().filter(|t| t.set == name);
        let own: Vec<Terrain> = own.cloned().collect();
        if !own.is_empty() {
            return Ok(own);
        }
        let known = self.own.iter().chain(catalogue::terrains());
        Ok(catalogue::set(name).map_err(|_| ModelError::UnknownName {
            kind: "terrain set",
            name: name.to_owned(),
            nearest: nearest(name, known.map(|t| t.set.as_ref())).map(str::to_owned),
        })?)
    }
}

/// `NAME=VALUE`, each name once.
pub(crate) fn values(given: &[String]) -> Result<Vec<(&str, f64)>, CliError> {
    let mut values: Vec<(&str, f64)> = vec![];
    for text in given {
        let (name, value) = text
            .split_once('=')
            .and_then(|(name, value)| Some((name.trim(), value.trim().parse::<f64>().ok()?)))
            .filter(|(_, value)| value.is_finite())
            .ok_or_else(|| {
                CliError::usage(
                    format!("--value {text}: expected NAME=VALUE"),
                    "write for example --value tyre_pressure=60000; `terra models` names parameters and units",
                )
            })?;
        if values.iter().any(|(known, _)| *known == name) {
            return Err(CliError::usage(
                format!("--value {text}: {name} has a value already"),
                "give each parameter once",
            ));
        }
        values.push((name, value));
    }
    Ok(values)
}

/// A soil as the parameters of a model, with values in the place of its own. All that is missing is named at once.
pub(crate) fn parameters(
    soil: &Terrain,
    model: &dyn AnyModel,
    given: &[(&str, f64)],
) -> Result<Vec<f64>, CliError> {
    let error = match soil.parameters_with(model, given) {
        Err(error @ ModelError::MissingValue { .. }) => error,
        found => return Ok(found?),
    };
    let mut said = vec![];
    let mut options = vec![];
    let mut another = "";
    for p in model.params() {
        if soil.value(p.name).is_some() || given.iter().any(|(name, _)| *name == p.name) {
            continue;
        }
        let reason = Missing::of(p.name);
        if reason == Missing::NoSource {
            another = "; or another soil: `terra terrains` shows what each gives";
        }
        said.push(format!("{} ({}): {reason}", p.name, p.doc));
        options.push(format!("--value {}=VALUE ({})", p.name, p.unit));
    }
    let message = match said.as_slice() {
        [_] => error.to_string(),
        all => format!(
            "terrain '{}' does not give all that model {} needs\n  {}",
            soil.id,
            model.name(),
            all.join("\n  ")
        ),
    };
    Err(CliError::usage(
        message,
        format!("add {}{another}", options.join(" ")),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_a_name_and_a_number_once() {
        let given = |all: &[&str]| all.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
        let good = given(&["tyre_pressure=6e4", " c3 = -0.2"]);
        assert_eq!(
            values(&good).unwrap(),
            [("tyre_pressure", 6e4), ("c3", -0.2)]
        );
        for bad in [
            &["c1"][..],
            &["c1=x"],
            &["c1=nan"],
            &["c1=inf"],
            &["c1="],
            &["c1=.4", "c1=.4"],
        ] {
            assert!(values(&given(bad)).is_err(), "{bad:?}");
        }
    }
}
