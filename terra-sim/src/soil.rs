//! A scenario's terrain as the parameter vector of a model.

use terra_data::Start;
use terra_model::{AnyModel, ModelError, catalogue, nearest};

use crate::error::SimError;

/// The parameters of `model` on this terrain, in its order.
///
/// `k_eq` stands for k_c/b + k_φ: k_c = 0 and k_φ = k_eq give the same soil under one wheel width.
///
/// # Errors
/// An unknown id or name, a missing parameter.
pub(crate) fn parameters(terrain: &Start, model: &dyn AnyModel) -> Result<Vec<f64>, SimError> {
    let values = match terrain {
        Start::Id(id) => return Ok(catalogue::find(id)?.parameters(model)?),
        Start::Own(soil) => return Ok(soil.parameters(model)?),
        Start::Values(values) => values,
    };
    let names = || model.params().iter().map(|p| p.name);
    let has_modulus = names().any(|n| n == "k_phi") && !values.contains_key("k_phi");
    for name in values.keys() {
        if !(names().any(|n| n == name) || (name == "k_eq" && has_modulus)) {
            return Err(SimError::Model(ModelError::UnknownName {
                kind: "terrain parameter",
                name: name.clone(),
                nearest: nearest(name, names()).map(str::to_owned),
            }));
        }
    }
    model
        .params()
        .iter()
        .map(|p| {
            let value = match p.name {
                "k_phi" if has_modulus => values.get("k_eq").copied(),
                "k_c" if values.contains_key("k_eq") => Some(0.0),
                name => values.get(name).copied(),
            };
            let value = value.ok_or_else(|| SimError::TerrainParameter {
                model: model.name().to_owned(),
                parameter: p.name,
            })?;
            if (p.min..=p.max).contains(&value) {
                Ok(value)
            } else {
                Err(SimError::Value {
                    quantity: format!("terrain {}", p.name),
                    value,
                    expected: "a value in the model's range",
                })
            }
        })
        .collect()
}
