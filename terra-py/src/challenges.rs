//! Sealed blind cases.

use std::path::PathBuf;

use pyo3::prelude::*;
use terra_cli::tasks::{self, ChallengeOptions};

use crate::convert::to_python;
use crate::error::raise;
use crate::interrupt;

#[pyfunction]
#[pyo3(signature = (design, cases, seed, out, key, kinds=None))]
pub(crate) fn challenge_make(
    py: Python<'_>,
    design: String,
    cases: usize,
    seed: u64,
    out: PathBuf,
    key: PathBuf,
    kinds: Option<Vec<(String, f64)>>,
) -> PyResult<Bound<'_, PyAny>> {
    let options = ChallengeOptions {
        design,
        cases,
        seed,
        out,
        key,
        kinds,
    };
    let done = interrupt::run_until(py, move |stop| tasks::challenge_make(&options, stop))?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn challenge_run(
    py: Python<'_>,
    folder: PathBuf,
    out: PathBuf,
) -> PyResult<Bound<'_, PyAny>> {
    let done = interrupt::run_until(py, move |stop| tasks::challenge_run(&folder, &out, stop))?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn challenge_score(
    py: Python<'_>,
    verdicts: PathBuf,
    key: PathBuf,
    closing: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let done = interrupt::run(py, move || tasks::challenge_score(&verdicts, &key, closing))?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn challenge_reveal(
    py: Python<'_>,
    key: PathBuf,
    folder: PathBuf,
) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &tasks::challenge_reveal(&key, &folder).map_err(raise)?)
}
