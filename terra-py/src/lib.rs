//! The Python package `terra`: what the command does, with numpy in and out.
//!
//! This is the boundary alone. Answers come from the same functions as those of the command line, so both give the same
//! numbers; the Python half (`python/terra`) has the signatures, the docs and the broadcasting.

mod convert;
mod error;
mod interrupt;
mod own;
mod soils;
mod tasks;
mod wheel;

use pyo3::prelude::*;

/// The native half of the package.
#[pymodule]
mod _terra {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::error::{BadData, ConfigurationError, TerraError};
    #[pymodule_export]
    use crate::own::Contact;
    #[pymodule_export]
    use crate::own::NoEquilibrium;
    #[pymodule_export]
    use crate::own::Registry;
    #[pymodule_export]
    use crate::soils::{cite, hypotheses, scm_json, slip_compliance};
    #[pymodule_export]
    use crate::tasks::{
        bevameter, command, effects, estimate, estimators, filters, gap, identifiability, identify,
        import_log, inspect, models, simulate, terrains, watch,
    };
    #[pymodule_export]
    use crate::wheel::{wheel_forces, wheel_stresses};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
