//! Forces and stresses of wheels.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use terra_cli::CliError;
use terra_cli::tasks::{self, WheelOptions};
use terra_model::{Contact, ForceLaw, Law, ModelError, WheelForces};

use crate::convert::{array, report, table};
use crate::error::{ConfigurationError, raise};
use crate::interrupt;
use crate::own::Registry;

/// A soil: an id of the catalogue, or values by the parameters' names.
#[derive(FromPyObject)]
pub(crate) enum Soil {
    Id(String),
    Values(BTreeMap<String, f64>),
}

/// The law and its parameters: those of the soil, then the effects' magnitudes. A soil by its id may be of a catalogue of
/// one's own, and `given` takes the place of its values.
fn law(
    registry: &terra_model::Registry,
    model: &str,
    soil: &Soil,
    catalogue: Option<&Path>,
    given: &[(String, f64)],
) -> PyResult<(Law, Vec<f64>)> {
    let values = match soil {
        Soil::Id(id) => {
            return tasks::law_on(registry, model, id, catalogue, given).map_err(raise);
        }
        Soil::Values(values) if catalogue.is_none() && given.is_empty() => values,
        Soil::Values(_) => {
            return Err(ConfigurationError::new_err(
                "catalogue and values are for a soil by its id, and this one is given by all its values",
            ));
        }
    };
    let (law, magnitudes) = tasks::law(registry, model).map_err(raise)?;
    let names: Vec<&str> = law.model().params().iter().map(|p| p.name).collect();
    let mut p: Vec<f64> = {
        if let Some(extra) = values.keys().find(|k| !names.contains(&k.as_str())) {
            return Err(ConfigurationError::new_err(format!(
                "{} has no parameter '{extra}', expected {}",
                law.model().name(),
                names.join(", ")
            )));
        }
        names
            .iter()
            .map(|name| {
                values.get(*name).copied().ok_or_else(|| {
                    ConfigurationError::new_err(format!(
                        "no '{name}', expected {}",
                        names.join(", ")
                    ))
                })
            })
            .collect::<PyResult<_>>()?
    };
    p.extend(magnitudes);
    Ok((law, p))
}

type Forces = Result<WheelForces<f64>, ModelError>;

#[pyfunction]
#[pyo3(signature = (terrain, slip, normal_load, radius, width, model="wong-reece", registry=None, catalogue=None, values=vec![]))]
pub(crate) fn wheel_forces<'py>(
    py: Python<'py>,
    terrain: Soil,
    slip: PyReadonlyArray1<'py, f64>,
    normal_load: PyReadonlyArray1<'py, f64>,
    radius: PyReadonlyArray1<'py, f64>,
    width: PyReadonlyArray1<'py, f64>,
    model: &str,
    registry: Option<&Registry>,
    catalogue: Option<PathBuf>,
    values: Vec<(String, f64)>,
) -> PyResult<Bound<'py, PyDict>> {
    let (registry, trouble) = Registry::of(registry);
    let (law, p) = law(
        &registry.with_forms(),
        model,
        &terrain,
        catalogue.as_deref(),
        &values,
    )?;
    let contacts: Vec<Contact<f64>> = slip
        .as_array()
        .iter()
        .zip(normal_load.as_array())
        .zip(radius.as_array().iter().zip(width.as_array()))
        .map(|((s, w), (r, b))| Contact::new(*s, *w, *r, *b))
        .collect();
    let found: Vec<Forces> = interrupt::run(py, move || {
        contacts.par_iter().map(|at| law.forces(&p, at)).collect()
    })?;
    trouble.settle(py, Ok(()))?;
    // A load that the soil cannot carry is an answer; anything else is a mistake.
    let bad = |e: &&ModelError| !matches!(e, ModelError::NoEquilibrium { .. });
    if let Some(e) = found
        .iter()
        .filter_map(|f| f.as_ref().err())
        .find(|e| bad(e))
    {
        return Err(raise(CliError::from(e.clone())));
    }
    let column = |value: fn(&WheelForces<f64>) -> Option<f64>| -> Vec<f64> {
        let value = |f: &Forces| f.as_ref().ok().and_then(value).unwrap_or(f64::NAN);
        found.iter().map(value).collect()
    };
    let out = PyDict::new(py);
    for (name, values) in [
        ("drawbar_pull_N", column(|f| Some(f.drawbar_pull))),
        ("torque_N_m", column(|f| Some(f.resistive_torque))),
        ("thrust_N", column(|f| Some(f.parts.total_thrust()))),
        (
            "motion_resistance_N",
            column(|f| Some(f.parts.motion_resistance())),
        ),
        ("rim_thrust_N", column(|f| Some(f.parts.thrust))),
        ("lug_thrust_N", column(|f| Some(f.parts.lug_thrust))),
        (
            "compaction_resistance_N",
            column(|f| Some(f.parts.compaction_resistance)),
        ),
        (
            "bulldozing_resistance_N",
            column(|f| Some(f.parts.bulldozing_resistance)),
        ),
        ("other_force_N", column(|f| Some(f.parts.other))),
        ("lateral_force_N", column(|f| Some(f.lateral_force))),
        ("sinkage_m", column(|f| f.sinkage)),
        ("entry_angle_rad", column(|f| f.angles.map(|a| a.entry))),
        (
            "max_stress_angle_rad",
            column(|f| f.angles.map(|a| a.max_stress)),
        ),
    ] {
        out.set_item(name, array(py, values))?;
    }
    let carried: Vec<bool> = found.iter().map(Result::is_ok).collect();
    out.set_item("carried", carried)?;
    Ok(out)
}

#[pyfunction]
#[pyo3(signature = (terrain, slip, normal_load, radius, width, model="wong-reece", points=101, catalogue=None, values=vec![]))]
pub(crate) fn wheel_stresses<'py>(
    py: Python<'py>,
    terrain: Soil,
    slip: f64,
    normal_load: f64,
    radius: f64,
    width: f64,
    model: &str,
    points: usize,
    catalogue: Option<PathBuf>,
    values: Vec<(String, f64)>,
) -> PyResult<Bound<'py, PyDict>> {
    let (law, p) = law(
        &terra_model::Registry::builtin().with_forms(),
        model,
        &terrain,
        catalogue.as_deref(),
        &values,
    )?;
    let profile = law
        .stresses(&p, &Contact::new(slip, normal_load, radius, width), points)
        .map_err(|e| raise(CliError::from(e)))?
        .ok_or_else(|| ConfigurationError::new_err(format!("{model} has no stresses")))?;
    let column = |value: fn(&terra_model::StressPoint) -> f64| {
        array(py, profile.points.iter().map(value).collect())
    };
    let out = PyDict::new(py);
    out.set_item("angle_rad", column(|p| p.angle))?;
    out.set_item("normal_stress_Pa", column(|p| p.normal_stress))?;
    out.set_item("shear_stress_Pa", column(|p| p.shear_stress))?;
    Ok(out)
}

/// The tables of `terra wheel`.
#[pyfunction]
#[pyo3(signature = (terrain, slips, load, radius, width, model, values, catalogue, contributions, stress, lugs, html=None, figures=None))]
pub(crate) fn wheel<'py>(
    py: Python<'py>,
    terrain: String,
    slips: Vec<f64>,
    load: f64,
    radius: f64,
    width: f64,
    model: String,
    values: Vec<(String, f64)>,
    catalogue: Option<PathBuf>,
    contributions: bool,
    stress: bool,
    lugs: bool,
    html: Option<PathBuf>,
    figures: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let options = WheelOptions {
        model,
        catalogue,
        values,
        contributions,
        stress,
        lugs,
        report: report(html, figures),
    };
    let done = interrupt::run(py, move || {
        tasks::wheel(&terrain, &slips, load, radius, width, &options)
    })?;
    let found = done.map_err(raise)?;
    let out = PyDict::new(py);
    for (name, csv) in [
        ("forces", Some(found.forces)),
        ("stress", found.stress),
        ("lugs", found.lugs),
    ] {
        if let Some(csv) = csv {
            out.set_item(name, table(py, csv.as_bytes(), &["status"])?)?;
        }
    }
    Ok(out)
}
