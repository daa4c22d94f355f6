//! Soils for other simulators, what is weighed, and whom to cite.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use terra_cli::tasks::{self, ComplianceOptions, ExportOptions, Soil, Source};

use crate::convert::{Given, table, to_python};
use crate::error::{ConfigurationError, raise};
use crate::interrupt;
use crate::own::Registry;

/// The column of words in a table of slip compliances.
const TEXT: &[&str] = &["status"];

/// A soil by its name or file, or the text of an identification.
#[derive(FromPyObject)]
pub(crate) enum Exported {
    Identified((String, String)),
    Named(String),
}

impl Exported {
    fn soil(self) -> PyResult<Soil> {
        Ok(match self {
            Exported::Named(name) => Soil::Named(name),
            Exported::Identified((name, text)) => {
                let json = serde_json::from_str(&text)
                    .map_err(|e| ConfigurationError::new_err(format!("{name}: {e}")))?;
                Soil::Identified(json)
            }
        })
    }
}

#[pyfunction]
#[pyo3(signature = (soil, catalogue=None, group=None))]
pub(crate) fn scm_json<'py>(
    py: Python<'py>,
    soil: Exported,
    catalogue: Option<PathBuf>,
    group: Option<String>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = ExportOptions { catalogue, group };
    to_python(
        py,
        &tasks::scm_json(&soil.soil()?, &options).map_err(raise)?,
    )
}

#[pyfunction]
#[pyo3(signature = (source, out=None))]
pub(crate) fn import_scm_json(
    py: Python<'_>,
    source: PathBuf,
    out: Option<PathBuf>,
) -> PyResult<Bound<'_, PyAny>> {
    to_python(
        py,
        &tasks::import_scm_json(&source, out.as_deref()).map_err(raise)?,
    )
}

#[pyfunction]
#[pyo3(signature = (soil, loads, radius, width, model, values, tolerance, catalogue, group))]
pub(crate) fn slip_compliance<'py>(
    py: Python<'py>,
    soil: Exported,
    loads: Vec<f64>,
    radius: f64,
    width: f64,
    model: String,
    values: Vec<(String, f64)>,
    tolerance: f64,
    catalogue: Option<PathBuf>,
    group: Option<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let soil = soil.soil()?;
    let options = ExportOptions { catalogue, group };
    let wheel = ComplianceOptions {
        radius,
        width,
        model,
        values,
        tolerance,
    };
    let done = interrupt::run(py, move || {
        tasks::slip_compliance(&soil, &loads, &wheel, &options)
    })?;
    table(py, &done.map_err(raise)?, TEXT)
}

#[pyfunction]
#[pyo3(signature = (rover, named=None, registry=None))]
pub(crate) fn hypotheses<'py>(
    py: Python<'py>,
    rover: Given,
    named: Option<&str>,
    registry: Option<&Registry>,
) -> PyResult<Bound<'py, PyAny>> {
    let rover: Source = rover.into();
    let (registry, trouble) = Registry::of(registry);
    let found = tasks::hypotheses(&rover, &registry, named).map_err(raise);
    to_python(py, &trouble.settle(py, found)?)
}

#[pyfunction]
pub(crate) fn cite(py: Python<'_>, file: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &tasks::cite(&file).map_err(raise)?)
}
