//! Terrain models and effects written in Python, for exploration.
//!
//! They run wherever built-in ones do. Each call takes the interpreter's lock, and derivatives are central differences,
//! so what proves itself is worth its thirty lines of Rust.

mod describe;
mod effect;
mod model;
mod numbers;

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::create_exception;
use pyo3::prelude::*;
use terra_model::ModelError;

use crate::error::TerraError;

pub(crate) use numbers::Contact;

create_exception!(
    terra,
    NoEquilibrium,
    TerraError,
    "Raised by a model of one's own, as NoEquilibrium(load, max_load): the soil cannot carry the wheel."
);

/// The first exception that Python code of a model or an effect raised.
#[derive(Clone, Default)]
pub(crate) struct Trouble(Arc<Mutex<Option<PyErr>>>);

impl Trouble {
    /// Keeps an exception, and says what the solver is to be told of it.
    fn keep(&self, py: Python<'_>, name: &'static str, error: PyErr) -> ModelError {
        if error.is_instance_of::<NoEquilibrium>(py)
            && let Ok((load, max_load)) = error
                .value(py)
                .getattr("args")
                .and_then(|a| a.extract::<(f64, f64)>())
        {
            return ModelError::NoEquilibrium { load, max_load };
        }
        let reason = error.to_string();
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get_or_insert(error);
        ModelError::Combination {
            name: name.to_owned(),
            reason,
        }
    }

    /// The answer, unless Python code raised: then that exception, traceback included.
    pub(crate) fn settle<T>(&self, _py: Python<'_>, answer: PyResult<T>) -> PyResult<T> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        match kept {
            Some(e) => Err(e),
            None => answer,
        }
    }
}

/// Models and effects by name: the built-in ones and one's own.
#[pyclass(frozen, module = "terra")]
pub(crate) struct Registry {
    inner: terra_model::Registry,
    trouble: Trouble,
}

#[pymethods]
impl Registry {
    #[new]
    #[pyo3(signature = (models=vec![], effects=vec![]))]
    fn new(models: Vec<Bound<'_, PyAny>>, effects: Vec<Bound<'_, PyAny>>) -> PyResult<Self> {
        let trouble = Trouble::default();
        let mut inner = terra_model::Registry::builtin();
        for object in &models {
            inner = inner.with_shared(Arc::new(model::PythonModel::new(object, trouble.clone())?));
        }
        for object in &effects {
            let effect = effect::PythonEffect::new(object, trouble.clone())?;
            inner = inner.with_shared_effect(Arc::new(effect));
        }
        Ok(Registry { inner, trouble })
    }

    fn __repr__(&self) -> String {
        format!(
            "Registry({} models, {} effects)",
            self.inner.models().len(),
            self.inner.effects().len()
        )
    }
}

impl Registry {
    /// The registry given, or the built-in one.
    pub(crate) fn of(given: Option<&Registry>) -> (terra_model::Registry, Trouble) {
        match given {
            Some(r) => (r.inner.clone(), r.trouble.clone()),
            None => (terra_model::Registry::builtin(), Trouble::default()),
        }
    }
}
