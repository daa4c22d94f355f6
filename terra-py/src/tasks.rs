//! Lists, simulation, estimation, identification and diagnosis.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use terra_cli::IdentifyOptions;
use terra_cli::tasks::{
    self, GapOptions, IdentifiabilityOptions, IdentifyAsked, Source, WatchOptions,
};

use crate::convert::{Given, report, table, to_python};
use crate::error::raise;
use crate::interrupt;
use crate::own::Registry;

/// Columns of text in the tables of the contract.
const TEXT: &[&str] = &["segment", "flag", "trial", "condition"];

#[pyfunction]
#[pyo3(signature = (registry=None))]
pub(crate) fn models<'py>(
    py: Python<'py>,
    registry: Option<&Registry>,
) -> PyResult<Bound<'py, PyAny>> {
    to_python(py, &tasks::models(&Registry::of(registry).0))
}

#[pyfunction]
#[pyo3(signature = (registry=None))]
pub(crate) fn effects<'py>(
    py: Python<'py>,
    registry: Option<&Registry>,
) -> PyResult<Bound<'py, PyAny>> {
    to_python(py, &tasks::effects(&Registry::of(registry).0))
}

#[pyfunction]
pub(crate) fn terrains(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &tasks::terrains())
}

#[pyfunction]
pub(crate) fn filters(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &tasks::filters())
}

#[pyfunction]
pub(crate) fn scenario_effects(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &tasks::scenario_effects())
}

#[pyfunction]
pub(crate) fn estimators(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    to_python(py, &tasks::estimators())
}

/// Runs a command line.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, args: Vec<OsString>) -> u8 {
    py.detach(|| terra_cli::run_with(args))
}

#[pyfunction]
#[pyo3(signature = (log, rover=None))]
pub(crate) fn inspect<'py>(
    py: Python<'py>,
    log: Given,
    rover: Option<Given>,
) -> PyResult<Bound<'py, PyAny>> {
    let log: Source = log.into();
    let rover: Option<Source> = rover.map(Given::into);
    let done = interrupt::run(py, move || tasks::inspect(&log, rover.as_ref()))?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
#[pyo3(signature = (log, kind, columns=None, html=None, figures=None))]
pub(crate) fn bevameter<'py>(
    py: Python<'py>,
    log: Given,
    kind: String,
    columns: Option<PathBuf>,
    html: Option<PathBuf>,
    figures: Option<PathBuf>,
) -> PyResult<Bound<'py, PyAny>> {
    let log: Source = log.into();
    let done = interrupt::run(py, move || {
        tasks::bevameter(&log, &kind, columns.as_deref(), &report(html, figures))
    })?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
#[pyo3(signature = (terrain, slips, loads, widths, radius, model, noise, values, set, catalogue, add, html=None, figures=None))]
pub(crate) fn identifiability<'py>(
    py: Python<'py>,
    terrain: String,
    slips: Vec<f64>,
    loads: Vec<f64>,
    widths: Vec<f64>,
    radius: f64,
    model: String,
    noise: Vec<(String, f64)>,
    values: Vec<(String, f64)>,
    set: String,
    catalogue: Option<PathBuf>,
    add: usize,
    html: Option<PathBuf>,
    figures: Option<PathBuf>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = IdentifiabilityOptions {
        model,
        catalogue,
        values,
        noise,
        set,
        add,
        report: report(html, figures),
    };
    let done = interrupt::run(py, move || {
        tasks::identifiability(&terrain, radius, &widths, &loads, &slips, &options)
    })?;
    to_python(py, &done.map_err(raise)?)
}

#[pyfunction]
#[pyo3(signature = (kind, source, map=None))]
pub(crate) fn import_log<'py>(
    py: Python<'py>,
    kind: String,
    source: PathBuf,
    map: Option<PathBuf>,
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let done = interrupt::run(py, move || tasks::import(&kind, &source, map.as_deref()))?;
    let (csv, notes) = done.map_err(raise)?;
    Ok((table(py, &csv, TEXT)?, notes))
}

#[pyfunction]
#[pyo3(signature = (scenario, seed=None, registry=None))]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    scenario: PathBuf,
    seed: Option<u64>,
    registry: Option<&Registry>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let (registry, trouble) = Registry::of(registry);
    let done = interrupt::run(py, move || tasks::simulate(&scenario, seed, &registry))?;
    let run = trouble.settle(py, done.map_err(raise))?;
    Ok((
        table(py, &run.log, TEXT)?,
        table(py, run.truth.as_bytes(), TEXT)?,
    ))
}

#[pyfunction]
#[pyo3(signature = (log, rover, filter="block", smooth=false, html=None, figures=None))]
pub(crate) fn estimate<'py>(
    py: Python<'py>,
    log: Given,
    rover: Given,
    filter: &str,
    smooth: bool,
    html: Option<PathBuf>,
    figures: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let (log, rover): (Source, Source) = (log.into(), rover.into());
    let filter = filter.to_owned();
    let done = interrupt::run(py, move || {
        tasks::estimate(&log, &rover, &filter, smooth, &report(html, figures))
    })?;
    table(py, done.map_err(raise)?.as_bytes(), TEXT)
}

#[pyfunction]
#[pyo3(signature = (log, rover, hypotheses=None, estimator=None, choice="none", join=false, history=false, refine=true, filter="block", rows=None, registry=None, html=None, figures=None))]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    log: Given,
    rover: Given,
    hypotheses: Option<String>,
    estimator: Option<String>,
    choice: &str,
    join: bool,
    history: bool,
    refine: bool,
    filter: &str,
    rows: Option<(usize, usize)>,
    registry: Option<&Registry>,
    html: Option<PathBuf>,
    figures: Option<PathBuf>,
) -> PyResult<Bound<'py, PyAny>> {
    let (log, rover): (Source, Source) = (log.into(), rover.into());
    let options = IdentifyOptions {
        estimator,
        choice: tasks::choice(choice).map_err(raise)?,
        join,
        history,
        refine,
        filter: filter.to_owned(),
        ..IdentifyOptions::default()
    };
    let asked = IdentifyAsked {
        hypotheses,
        rows,
        report: report(html, figures),
    };
    let (registry, trouble) = Registry::of(registry);
    let done = interrupt::run(py, move || {
        tasks::identify(&log, &rover, &registry, &asked, &options)
    })?;
    to_python(py, &trouble.settle(py, done.map_err(raise))?)
}

#[pyfunction]
#[pyo3(signature = (logs, rover, effects=None, hold_out=None, combine=2, windows=512, calibrate=0, seed=1, soil="shared".to_owned(), sim=None, same_bed=false, motion_only=false, registry=None, html=None, figures=None))]
pub(crate) fn gap<'py>(
    py: Python<'py>,
    logs: Vec<Given>,
    rover: Given,
    effects: Option<Vec<String>>,
    hold_out: Option<String>,
    combine: usize,
    windows: usize,
    calibrate: usize,
    seed: u64,
    soil: String,
    sim: Option<Given>,
    same_bed: bool,
    motion_only: bool,
    registry: Option<&Registry>,
    html: Option<PathBuf>,
    figures: Option<PathBuf>,
) -> PyResult<Bound<'py, PyAny>> {
    let logs: Vec<Source> = logs.into_iter().map(Source::from).collect();
    let rover: Source = rover.into();
    let options = GapOptions {
        effects,
        hold_out,
        combine,
        windows,
        calibrate,
        seed,
        soil,
        sim: sim.map(Source::from),
        same_bed,
        motion_only,
        report: report(html, figures),
    };
    let (registry, trouble) = Registry::of(registry);
    let done = interrupt::run(py, move || tasks::gap(&logs, &rover, &registry, &options))?;
    to_python(py, &trouble.settle(py, done.map_err(raise))?)
}

#[pyfunction]
#[pyo3(signature = (log, rover, baseline, false_alarms, effects, registry=None))]
pub(crate) fn watch<'py>(
    py: Python<'py>,
    log: Given,
    rover: Given,
    baseline: String,
    false_alarms: f64,
    effects: Option<Vec<String>>,
    registry: Option<&Registry>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyDict>)> {
    let (log, rover): (Source, Source) = (log.into(), rover.into());
    let options = WatchOptions {
        baseline,
        false_alarms,
        effects,
    };
    let (registry, trouble) = Registry::of(registry);
    let done = interrupt::run(py, move || tasks::watch(&log, &rover, &registry, &options))?;
    let watched = trouble.settle(py, done.map_err(raise))?;
    let track = table(py, watched.track.as_bytes(), TEXT)?;
    Ok((to_python(py, &watched.verdict)?, track))
}
