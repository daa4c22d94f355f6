//! `terra export`: a soil, known or identified, for another simulator.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use serde_json::Value;
use terra_data::{scm_json, slip_compliance, write_slip_compliance};
use terra_model::Registry;
use terra_model::catalogue::{Confidence, Missing, Terrain};

use crate::args::{Export, ExportSoil};
use crate::error::CliError;
use crate::output;
use crate::soils::{Soils, parameters, values};

/// A soil that is asked for.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    /// An id, or the file of an identification.
    pub(crate) soil: &'a str,
    /// What that file holds, where it is in memory.
    pub(crate) identified: Option<&'a Value>,
    /// A file with soils of the user's own.
    pub(crate) catalogue: Option<&'a Path>,
    /// Group of the identification.
    pub(crate) group: Option<&'a str>,
}

impl<'a> From<&'a ExportSoil> for Asked<'a> {
    fn from(args: &'a ExportSoil) -> Self {
        Asked {
            soil: &args.soil,
            identified: None,
            catalogue: args.catalogue.as_deref(),
            group: args.group.as_deref(),
        }
    }
}

/// The wheel of a slip compliance, and how it is fitted.
pub(crate) struct Wheel<'a> {
    pub(crate) radius: f64,
    pub(crate) width: f64,
    pub(crate) loads: &'a [f64],
    pub(crate) model: &'a str,
    pub(crate) values: &'a [(&'a str, f64)],
    pub(crate) tolerance: f64,
}

pub(crate) fn run(what: &Export) -> Result<(), CliError> {
    match what {
        Export::ScmJson { soil, out } => {
            claim(soil, out.as_deref())?;
            output::json(out.as_deref(), &scm(&soil.into())?)
        }
        Export::SlipCompliance {
            soil,
            radius,
            width,
            load,
            model,
            value,
            tolerance,
            out,
        } => {
            claim(soil, out.as_deref())?;
            let wheel = Wheel {
                radius: *radius,
                width: *width,
                loads: load,
                model,
                values: &values(value)?,
                tolerance: *tolerance,
            };
            let csv = compliance(&soil.into(), &wheel)?;
            output::text(out.as_deref(), &String::from_utf8_lossy(&csv))
        }
    }
}

/// `terra export scm-json`.
pub(crate) fn scm(asked: &Asked<'_>) -> Result<Value, CliError> {
    chrono(&terrain(asked)?)
}

/// `terra export slip-compliance`, as CSV.
pub(crate) fn compliance(asked: &Asked<'_>, wheel: &Wheel<'_>) -> Result<Vec<u8>, CliError> {
    if !(wheel.tolerance > 0.0 && wheel.tolerance < 1.0) {
        return Err(CliError::usage(
            format!("--tolerance {}", wheel.tolerance),
            "a share between 0 and 1, for example 0.1",
        ));
    }
    let law = Registry::builtin().law(wheel.model)?;
    let p = parameters(&terrain(asked)?, law.model(), wheel.values)?;
    let table = slip_compliance(
        &law,
        &p,
        wheel.radius,
        wheel.width,
        wheel.loads,
        wheel.tolerance,
    )?;
    let mut csv = vec![];
    write_slip_compliance(&mut csv, &table).map_err(|reason| CliError::Write {
        target: "the table".to_owned(),
        reason,
    })?;
    Ok(csv)
}

/// A soil as Chrono's JSON.
pub(super) fn chrono(soil: &Terrain) -> Result<Value, CliError> {
    if soil.shear_modulus.is_none() {
        return Err(CliError::usage(
            format!(
                "'{}' has no shear modulus, which Chrono needs: {}",
                soil.id,
                Missing::NoSource
            ),
            "`terra terrains` shows which soils have one (K)",
        ));
    }
    Ok(scm_json(soil))
}

fn claim(soil: &ExportSoil, out: Option<&Path>) -> Result<(), CliError> {
    let identified = is_file(&soil.soil).then(|| Path::new(&soil.soil));
    let own = soil.catalogue.as_deref();
    let inputs: Vec<&Path> = identified.into_iter().chain(own).collect();
    output::claim(&[out], &inputs)
}

fn is_file(soil: &str) -> bool {
    Path::new(soil)
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// A soil of the catalogues, or the refined one of an identification.
fn terrain(asked: &Asked<'_>) -> Result<Terrain, CliError> {
    let soils = Soils::open(asked.catalogue)?;
    if asked.identified.is_none() && !is_file(asked.soil) {
        return Ok(soils.find(asked.soil)?.clone());
    }
    let bad = |why: String| {
        CliError::data(
            format!("{}: {why}", asked.soil),
            "a file that `terra identify --json` wrote, or an id of `terra terrains`",
        )
    };
    let read;
    let json = match asked.identified {
        Some(json) => json,
        None => {
            let text = std::fs::read_to_string(asked.soil).map_err(|e| bad(e.to_string()))?;
            read = serde_json::from_str(&text).map_err(|e| bad(e.to_string()))?;
            &read
        }
    };
    if json["schema"] != "terra-identify/1" {
        return Err(bad(
            "is no identification (schema terra-identify/1)".to_owned()
        ));
    }
    let groups = json["groups"].as_array().map_or(&[][..], Vec::as_slice);
    let name = |g: &Value| g["group"].as_str().unwrap_or_default().to_owned();
    let group = match (asked.group, groups) {
        (None, [one]) => one,
        (asked_for, all) => all
            .iter()
            .find(|g| asked_for.is_some_and(|n| name(g) == n))
            .ok_or_else(|| {
                let names: Vec<String> = all.iter().map(&name).collect();
                CliError::usage(
                    format!("{} has the groups {}", asked.soil, names.join(", ")),
                    "name one: --group NAME",
                )
            })?,
    };
    refined(group, &soils).map_err(|why| bad(format!("group '{}': {why}", name(group))))
}

/// The refined soil of a group: what was fitted, over the soil it started from. A wheel knows only
/// k_eq = k_c/b + k_phi, so a soil for its own width has it all as k_phi.
fn refined(group: &Value, soils: &Soils) -> Result<Terrain, String> {
    let refined = &group["refined"];
    let start = refined["start"]
        .as_str()
        .ok_or("was not refined, so it has no soil of its own")?;
    let mut soil = soils.find(start).map_err(|e| e.to_string())?.clone();
    let parameters = refined["parameters"]
        .as_object()
        .ok_or("no parameters in it")?;
    for (parameter, found) in parameters {
        let value = found["mean"]
            .as_f64()
            .ok_or_else(|| format!("{parameter} has no mean"))?;
        if !possible(parameter, value) {
            return Err(format!("{parameter} = {value} is that of no soil"));
        }
        match parameter.as_str() {
            "k_eq" => (soil.k_c, soil.k_phi) = (0.0, value),
            "k_c" => soil.k_c = value,
            "k_phi" => soil.k_phi = value,
            "sinkage_exponent" => soil.sinkage_exponent = value,
            "cohesion" => soil.cohesion = value,
            "friction_angle" => soil.friction_angle = value,
            "shear_modulus" => soil.shear_modulus = Some(value),
            "c1" => soil.c1 = Some(value),
            "c2" => soil.c2 = Some(value),
            other => return Err(format!("{other} is no parameter of a catalogue's soil")),
        }
    }
    soil.id = format!("{start}_refined").into();
    soil.set = "own".into();
    soil.confidence = Confidence::Own;
    soil.source = format!("refined by `terra identify` from {start} ({})", soil.source).into();
    Ok(soil)
}

/// Whether a soil can have that value \[SI, rad\]: what the readers of soils take.
fn possible(parameter: &str, value: f64) -> bool {
    match parameter {
        "k_eq" | "k_phi" | "cohesion" => value >= 0.0,
        "sinkage_exponent" | "shear_modulus" => value > 0.0,
        "friction_angle" => (0.0..FRAC_PI_2).contains(&value),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// What is exported can be read again, so a file that claims an impossible soil is refused by the parameter.
    #[test]
    fn an_impossible_soil_is_not_exported() {
        let soils = Soils::open(None).unwrap();
        let group = |parameter: &str, mean: f64| json!({ "refined": { "start": "dry_sand", "parameters": { parameter: { "mean": mean } } } });
        assert!(refined(&group("cohesion", 0.0), &soils).is_ok());
        for (parameter, mean) in [
            ("cohesion", -1.0),
            ("k_eq", -1.0),
            ("sinkage_exponent", 0.0),
            ("shear_modulus", 0.0),
            ("friction_angle", 1.6),
        ] {
            let why = refined(&group(parameter, mean), &soils).unwrap_err();
            assert!(why.contains(parameter), "{why}");
        }
    }
}
