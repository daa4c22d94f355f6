//! The Python package `terra`: what the command does, with numpy in and out.
//!
//! This is the boundary alone. Answers come from the same functions as those of the command line, so both give the same
//! numbers; the Python half (`python/terra`) has the signatures, the docs and the broadcasting.

mod beginnings;
mod campaigns;
mod challenges;
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
    use crate::beginnings::{demo, init};
    #[pymodule_export]
    use crate::campaigns::{
        campaign_cross_structure, campaign_faults, campaign_gap, campaign_gap_calibration,
        campaign_ramps, campaign_reproduction, merge, merge_into, sweep,
    };
    #[pymodule_export]
    use crate::challenges::{challenge_make, challenge_reveal, challenge_run, challenge_score};
    #[pymodule_export]
    use crate::error::{BadData, ConfigurationError, TerraError};
    #[pymodule_export]
    use crate::own::Contact;
    #[pymodule_export]
    use crate::own::NoEquilibrium;
    #[pymodule_export]
    use crate::own::Registry;
    #[pymodule_export]
    use crate::soils::{cite, hypotheses, import_scm_json, scm_json, slip_compliance};
    #[pymodule_export]
    use crate::tasks::{
        bevameter, command, effects, estimate, estimators, filters, gap, identifiability, identify,
        import_log, inspect, models, scenario_effects, simulate, terrains, watch,
    };
    #[pymodule_export]
    use crate::wheel::{wheel, wheel_forces, wheel_stresses};

    #[pymodule_init]
    fn complete(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
