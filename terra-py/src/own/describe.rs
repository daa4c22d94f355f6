//! What a Python object says of itself: name, parameters, source.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use terra_model::{Hook, Param, Scale};

use crate::error::ConfigurationError;

/// Text that lives as long as the process: a registry is made a few times, its names are asked for everywhere.
fn forever(text: String) -> &'static str {
    Box::leak(text.into_boxed_str())
}

/// A text attribute that must be there.
pub(super) fn text(object: &Bound<'_, PyAny>, name: &str) -> PyResult<&'static str> {
    Ok(forever(object.getattr(name)?.extract()?))
}

/// A text attribute that may be absent.
pub(super) fn text_or(
    object: &Bound<'_, PyAny>,
    name: &str,
    other: &str,
) -> PyResult<&'static str> {
    match object.getattr_opt(name)? {
        Some(value) => Ok(forever(value.extract()?)),
        None => Ok(forever(other.to_owned())),
    }
}

/// `parameters`, a list of `terra.Parameter`.
pub(super) fn parameters(object: &Bound<'_, PyAny>) -> PyResult<&'static [Param]> {
    let mut all = vec![];
    for given in object.getattr("parameters")?.try_iter()? {
        let given = given?;
        let scale: String = given.getattr("scale")?.extract()?;
        all.push(Param {
            name: text(&given, "name")?,
            symbol: text(&given, "symbol")?,
            unit: text(&given, "unit")?,
            min: given.getattr("min")?.extract()?,
            max: given.getattr("max")?.extract()?,
            scale: match scale.as_str() {
                "linear" => Scale::Linear,
                "log" => Scale::Log,
                other => {
                    return Err(ConfigurationError::new_err(format!(
                        "scale = '{other}', expected 'linear' or 'log'"
                    )));
                }
            },
            prior_sd: given.getattr("prior_sd")?.extract()?,
            doc: text(&given, "doc")?,
        });
    }
    if all.is_empty() {
        return Err(ConfigurationError::new_err(
            "parameters is empty, expected at least one terra.Parameter",
        ));
    }
    Ok(Box::leak(all.into_boxed_slice()))
}

/// `typical`, a dict of all parameters or a list of such dicts; nothing where it is absent.
pub(super) fn typical(object: &Bound<'_, PyAny>, params: &[Param]) -> PyResult<Vec<Vec<f64>>> {
    let Some(given) = object.getattr_opt("typical")? else {
        return Ok(vec![]);
    };
    let soils: Vec<BTreeMap<String, f64>> = match given.extract() {
        Ok(one) => vec![one],
        Err(_) => given.extract()?,
    };
    let vector = |soil: &BTreeMap<String, f64>| {
        let known = |name: &String| params.iter().any(|p| p.name == name);
        if let Some(name) = soil.keys().find(|name| !known(name)) {
            return Err(ConfigurationError::new_err(format!(
                "typical: '{name}' is no parameter of this model"
            )));
        }
        let value = |p: &Param| {
            let found = soil.get(p.name).copied();
            found.ok_or_else(|| {
                ConfigurationError::new_err(format!("typical: a value of '{}' is missing", p.name))
            })
        };
        params.iter().map(value).collect()
    };
    soils.iter().map(vector).collect()
}

/// `hooks` or `needs`: names of the places inside a stress integral.
pub(super) fn hooks(object: &Bound<'_, PyAny>, name: &str) -> PyResult<&'static [Hook]> {
    const ALL: [Hook; 11] = [
        Hook::Stiffness,
        Hook::Cohesion,
        Hook::Friction,
        Hook::ShearModulus,
        Hook::SinkageExponent,
        Hook::ContactRadius,
        Hook::ExitRatio,
        Hook::ShearHump,
        Hook::LugHeight,
        Hook::Layer,
        Hook::LateralSlip,
    ];
    let Some(given) = object.getattr_opt(name)? else {
        return Ok(&[]);
    };
    let names: Vec<String> = given.extract()?;
    let found = names
        .iter()
        .map(|n| {
            ALL.into_iter().find(|h| h.name() == n).ok_or_else(|| {
                let known: Vec<&str> = ALL.iter().map(|h| h.name()).collect();
                ConfigurationError::new_err(format!(
                    "{name}: unknown hook '{n}', expected one of {}",
                    known.join(", ")
                ))
            })
        })
        .collect::<PyResult<Vec<Hook>>>()?;
    Ok(Box::leak(found.into_boxed_slice()))
}
