//! Errors as Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use terra_cli::CliError;

create_exception!(
    terra,
    TerraError,
    PyValueError,
    "Whatever terra refuses; the message says what was found, what was expected, and what to do."
);
create_exception!(
    terra,
    ConfigurationError,
    TerraError,
    "A wrong argument, rover file or scenario (the command would exit with status 2)."
);
create_exception!(
    terra,
    BadData,
    TerraError,
    "A log that cannot be used (the command would exit with status 3)."
);

/// The exception of an error of the command.
pub(crate) fn raise(error: CliError) -> PyErr {
    let help = match &error {
        CliError::Usage { help, .. }
        | CliError::Rover { help, .. }
        | CliError::BadData { help, .. } => help.clone(),
        _ => None,
    };
    let mut message = error.to_string();
    if let Some(help) = help {
        message.push_str("\n  help: ");
        message.push_str(&help);
    }
    match error.exit_code() {
        2 => ConfigurationError::new_err(message),
        3 => BadData::new_err(message),
        _ => TerraError::new_err(message),
    }
}
