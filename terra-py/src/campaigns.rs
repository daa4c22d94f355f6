//! Campaigns and sweeps: many runs with known truth.

use std::path::PathBuf;

use pyo3::prelude::*;
use terra_cli::tasks::{self, Cases};

use crate::convert::to_python;
use crate::error::{TerraError, raise};
use crate::interrupt;

#[pyfunction]
pub(crate) fn campaign_ramps(
    py: Python<'_>,
    runs: usize,
    seed: u64,
    terrains: Vec<String>,
) -> PyResult<Bound<'_, PyAny>> {
    let done = interrupt::run_until(py, move |stop| {
        tasks::campaign_ramps(&terrains, runs, seed, stop)
    })?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn campaign_faults(
    py: Python<'_>,
    runs: usize,
    seed: u64,
    filter: String,
) -> PyResult<Bound<'_, PyAny>> {
    let done = interrupt::run_until(py, move |stop| {
        tasks::campaign_faults(runs, seed, &filter, stop)
    })?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn campaign_reproduction(
    py: Python<'_>,
    runs: usize,
    seed: u64,
    tables: Vec<String>,
) -> PyResult<Bound<'_, PyAny>> {
    let done = interrupt::run_until(py, move |stop| {
        tasks::campaign_reproduction(runs, seed, &tables, stop)
    })?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn campaign_gap(
    py: Python<'_>,
    out: PathBuf,
    designs: Vec<String>,
    cases: usize,
    seed: u64,
    left_out: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let asked = Cases {
        designs,
        cases,
        seed,
        out,
    };
    let done = interrupt::run_until(py, move |stop| tasks::campaign_gap(&asked, left_out, stop))?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
pub(crate) fn campaign_gap_calibration(
    py: Python<'_>,
    out: PathBuf,
    designs: Vec<String>,
    cases: usize,
    seed: u64,
    nulls: usize,
) -> PyResult<String> {
    let asked = Cases {
        designs,
        cases,
        seed,
        out,
    };
    let done = interrupt::run_until(py, move |stop| {
        tasks::campaign_gap_calibration(&asked, nulls, stop)
    })?;
    done.map_err(raise)
}

#[pyfunction]
pub(crate) fn campaign_cross_structure(
    py: Python<'_>,
    out: PathBuf,
    design: String,
    cases: usize,
    seed: u64,
) -> PyResult<Bound<'_, PyAny>> {
    let done = interrupt::run_until(py, move |stop| {
        tasks::campaign_cross_structure(&design, cases, seed, &out, stop)
    })?;
    to_python(py, &done.map_err(raise)?)
}

/// Runs of the plan or shard, and how many of them were left to do.
#[pyfunction]
#[pyo3(signature = (plan, out, shard=None))]
pub(crate) fn sweep(
    py: Python<'_>,
    plan: PathBuf,
    out: PathBuf,
    shard: Option<String>,
) -> PyResult<(usize, usize)> {
    let done = interrupt::run_until(py, move |stop| {
        tasks::sweep(&plan, &out, shard.as_deref(), stop)
    })?;
    done.map_err(raise)
}

#[pyfunction]
pub(crate) fn merge(py: Python<'_>, files: Vec<PathBuf>) -> PyResult<Vec<Bound<'_, PyAny>>> {
    let lines = interrupt::run(py, move || tasks::merge(&files))?.map_err(raise)?;
    lines
        .lines()
        .map(|line| {
            let run = serde_json::from_str(line).map_err(|e| TerraError::new_err(e.to_string()))?;
            to_python(py, &run)
        })
        .collect()
}

#[pyfunction]
pub(crate) fn merge_into(py: Python<'_>, files: Vec<PathBuf>, out: PathBuf) -> PyResult<()> {
    interrupt::run(py, move || tasks::merge_into(&files, &out))?.map_err(raise)
}
