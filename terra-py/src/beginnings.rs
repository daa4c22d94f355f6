//! What one begins with.

use std::path::PathBuf;

use pyo3::prelude::*;
use terra_cli::tasks;

use crate::convert::to_python;
use crate::error::raise;
use crate::interrupt;

#[pyfunction]
#[pyo3(signature = (robot, out=None, force=false))]
pub(crate) fn init(robot: &str, out: Option<PathBuf>, force: bool) -> PyResult<&'static str> {
    match out {
        Some(out) => tasks::init_into(robot, &out, force),
        None => tasks::init(robot),
    }
    .map_err(raise)
}

/// `identify.json` and `verdict.json`.
#[pyfunction]
#[pyo3(signature = (out, figures=None))]
pub(crate) fn demo(
    py: Python<'_>,
    out: PathBuf,
    figures: Option<PathBuf>,
) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let done = interrupt::run(py, move || tasks::demo(&out, figures))?;
    let done = done.map_err(raise)?;
    Ok((
        to_python(py, &done.identify)?,
        to_python(py, &done.verdict)?,
    ))
}
