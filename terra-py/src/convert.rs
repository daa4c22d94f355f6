//! Between Python's objects and terra's.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::Value;
use terra_cli::tasks::{ReportFiles, Source};

use crate::error::TerraError;

/// JSON as Python's own types; key order is kept.
///
/// # Errors
/// Those of the interpreter.
pub(crate) fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(b) => b.into_pyobject(py)?.to_owned().into_any(),
        Value::Number(n) => match (n.as_i64(), n.as_u64()) {
            (Some(whole), _) => whole.into_pyobject(py)?.into_any(),
            (_, Some(whole)) => whole.into_pyobject(py)?.into_any(),
            _ => n.as_f64().into_pyobject(py)?.into_any(),
        },
        Value::String(s) => s.into_pyobject(py)?.into_any(),
        Value::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(to_python(py, item)?)?;
            }
            list.into_any()
        }
        Value::Object(map) => {
            let dict = PyDict::new(py);
            for (key, item) in map {
                dict.set_item(key, to_python(py, item)?)?;
            }
            dict.into_any()
        }
    })
}

/// A table of terra's own CSV as `{column: array}`: numbers as float64 with NaN for an empty cell, the named columns as
/// lists of text.
///
/// # Errors
/// A row that is no row, which terra does not write.
pub(crate) fn table<'py>(
    py: Python<'py>,
    csv: &[u8],
    text: &[&str],
) -> PyResult<Bound<'py, PyDict>> {
    let broken = |e: csv::Error| TerraError::new_err(e.to_string());
    let mut reader = csv::Reader::from_reader(csv);
    let header: Vec<String> = reader
        .headers()
        .map_err(broken)?
        .iter()
        .map(str::to_owned)
        .collect();
    let mut words: Vec<Vec<String>> = vec![vec![]; header.len()];
    let mut numbers: Vec<Vec<f64>> = vec![vec![]; header.len()];
    for row in reader.records() {
        let row = row.map_err(broken)?;
        for (k, (name, cell)) in header.iter().zip(&row).enumerate() {
            if text.contains(&name.as_str()) {
                words[k].push(cell.to_owned());
            } else {
                numbers[k].push(cell.parse().unwrap_or(f64::NAN));
            }
        }
    }
    let out = PyDict::new(py);
    for ((name, words), numbers) in header.into_iter().zip(words).zip(numbers) {
        if text.contains(&name.as_str()) {
            out.set_item(name, words)?;
        } else {
            out.set_item(name, array(py, numbers))?;
        }
    }
    Ok(out)
}

/// Numbers as a numpy array.
pub(crate) fn array(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    values.into_pyarray(py)
}

/// Where a report goes, in the order of the functions' last arguments.
pub(crate) fn report(html: Option<PathBuf>, figures: Option<PathBuf>) -> ReportFiles {
    ReportFiles { html, figures }
}

/// A file by its path, or what it would hold, as bytes, with a name for messages.
#[derive(FromPyObject)]
pub(crate) enum Given {
    /// `(name, bytes)`.
    Memory(String, Vec<u8>),
    /// A path.
    File(PathBuf),
}

impl From<Given> for Source {
    fn from(given: Given) -> Self {
        match given {
            Given::Memory(name, bytes) => Source::Memory { name, bytes },
            Given::File(path) => Source::File(path),
        }
    }
}
