//! Errors of the command: what went wrong, what to do about it, and the exit status.

use std::io::{self, IsTerminal, Write};
use std::path::Path;

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use terra_data::{DataError, Problem};
use terra_ekf::FilterError;
use terra_gap::GapError;
use terra_mme::EstimatorError;
use terra_model::ModelError;
use terra_sim::SimError;

use crate::report::ReportError;

/// Any error of the command.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Wrong usage or configuration (2).
    #[error("{message}")]
    Usage {
        /// What is wrong.
        message: String,
        /// What to do.
        help: Option<String>,
    },
    /// A rover file that does not do for this log (2).
    #[error("{message}")]
    Rover {
        /// What is wrong.
        message: String,
        /// What to do.
        help: Option<String>,
    },
    /// Bad data (3).
    #[error("{message}")]
    BadData {
        /// What is wrong.
        message: String,
        /// What to do.
        help: Option<String>,
    },
    /// Reading or writing a file.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A result cannot be written (4).
    #[error("cannot write {target}: {reason}")]
    Write {
        /// File or `standard output`.
        target: String,
        /// The system's refusal.
        reason: io::Error,
    },
    /// The caller asked for an end ([`Stop`](crate::tasks::Stop)) (130).
    #[error("stopped before the end")]
    Stopped,
    /// The reader of standard output went away: no error.
    #[error("standard output was closed")]
    PipeClosed,
}

impl CliError {
    /// Wrong usage, with what to do about it.
    pub fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        CliError::Usage {
            message: message.into(),
            help: Some(help.into()),
        }
    }

    /// A rover file that does not do for this log, with what to do about it.
    pub fn rover(message: impl Into<String>, help: impl Into<String>) -> Self {
        CliError::Rover {
            message: message.into(),
            help: Some(help.into()),
        }
    }

    /// Bad data, with what to do about it.
    pub fn data(message: impl Into<String>, help: impl Into<String>) -> Self {
        CliError::BadData {
            message: message.into(),
            help: Some(help.into()),
        }
    }

    /// The same error naming the file it is about: the log, or the rover file.
    pub(crate) fn in_files(self, log: &Path, rover: &Path) -> Self {
        match self {
            CliError::BadData { message, help } => CliError::BadData {
                message: format!("{}: {message}", log.display()),
                help,
            },
            CliError::Rover { message, help } => CliError::Rover {
                message: format!("{}: {message}", rover.display()),
                help,
            },
            other => other,
        }
    }

    /// The same error naming the one file it is about.
    pub(crate) fn within(self, path: &Path) -> Self {
        let named = |message: String| format!("{}: {message}", path.display());
        match self {
            CliError::Usage { message, help } => CliError::Usage {
                message: named(message),
                help,
            },
            CliError::Rover { message, help } => CliError::Rover {
                message: named(message),
                help,
            },
            CliError::BadData { message, help } => CliError::BadData {
                message: named(message),
                help,
            },
            other => other,
        }
    }

    /// The process's exit status.
    pub fn exit_code(&self) -> u8 {
        match self {
            CliError::Usage { .. } | CliError::Rover { .. } => 2,
            CliError::BadData { .. } => 3,
            CliError::Data(e) if e.is_configuration() => 2,
            CliError::Data(e) if e.is_write() => 4,
            CliError::Data(_) => 3,
            CliError::Write { .. } => 4,
            CliError::Stopped => 130,
            CliError::PipeClosed => 0,
        }
    }
}

impl Diagnostic for CliError {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        match self {
            CliError::Usage { help, .. }
            | CliError::Rover { help, .. }
            | CliError::BadData { help, .. } => help
                .as_ref()
                .map(|h| Box::new(h) as Box<dyn std::fmt::Display>),
            CliError::Data(e) => help_of_file(e).map(|h| Box::new(h) as Box<dyn std::fmt::Display>),
            CliError::Write { reason, .. } if reason.kind() == io::ErrorKind::NotFound => Some(
                Box::new("its folder is not there: make it first, or write elsewhere"),
            ),
            _ => None,
        }
    }
}

/// What to do about a file that cannot be used as it is.
fn help_of_file(e: &DataError) -> Option<String> {
    match e.problem() {
        Problem::NotFound => {
            let from = std::env::current_dir().ok()?;
            let looked = format!("paths are taken from {}", from.display());
            Some(if e.is_configuration() {
                format!("{looked}; `terra init husky` writes a rover file to start from")
            } else {
                looked
            })
        }
        Problem::Binary { format } => {
            let kind = match *format {
                "Parquet" => "parquet",
                "MCAP" => "mcap",
                "MATLAB file" => "mat",
                _ => return None,
            };
            let map = if kind == "mcap" {
                " --map topics.toml"
            } else {
                ""
            };
            Some(format!(
                "`terra import {kind} {}{map} --out log.csv` makes a log of it",
                e.file()
            ))
        }
        _ => None,
    }
}

impl From<ModelError> for CliError {
    fn from(e: ModelError) -> Self {
        let help = match &e {
            ModelError::UnknownName {
                kind: "terrain model" | "parameter",
                ..
            } => Some("`terra models` lists them"),
            ModelError::UnknownName {
                kind: "effect" | "form",
                ..
            } => Some("`terra effects` lists them"),
            ModelError::UnknownName {
                kind: "terrain" | "terrain set",
                ..
            } => Some("`terra terrains` lists them"),
            ModelError::MissingValue { .. } => Some(INCOMPLETE),
            _ => None,
        };
        CliError::Usage {
            message: e.to_string(),
            help: help.map(str::to_owned),
        }
    }
}

/// What to do about a soil that lacks what a model needs, where a file names the soil.
const INCOMPLETE: &str = "write the soil as a table of parameters that names it (start = { ... }), or take another soil: \
                          `terra terrains` shows what each gives";

/// True for what a model finds out only while it runs: the soil, not the file, is to blame.
fn happened(e: &ModelError) -> bool {
    matches!(
        e,
        ModelError::NoEquilibrium { .. }
            | ModelError::NotConverged { .. }
            | ModelError::NotAResultant { .. }
    )
}

impl From<GapError> for CliError {
    fn from(e: GapError) -> Self {
        let message = e.to_string();
        match e {
            GapError::Model(e) if happened(&e) => CliError::BadData {
                message,
                help: None,
            },
            // What a log reports lies outside every model.
            GapError::Model(ModelError::Contact { .. })
            | GapError::NotPositiveDefinite { .. }
            | GapError::Log(_)
            | GapError::Simulator(_) => CliError::BadData {
                message,
                help: None,
            },
            GapError::Model(e) => e.into(),
            GapError::NoiseMissing { .. }
            | GapError::Mismatch(_)
            | GapError::Calibration(_)
            | GapError::Soil(_) => CliError::Rover {
                message,
                help: None,
            },
            GapError::Segment { .. } => CliError::BadData {
                message,
                help: Some(
                    "a baseline is so many seconds, --baseline 30, or a segment of the log".into(),
                ),
            },
            GapError::Option { .. } => CliError::Usage {
                message,
                help: None,
            },
        }
    }
}

impl From<FilterError> for CliError {
    fn from(e: FilterError) -> Self {
        let message = e.to_string();
        match e {
            FilterError::UnknownName { .. } => {
                CliError::usage(message, "`terra filters` lists them")
            }
            FilterError::NotLinear { .. } => {
                CliError::usage(message, "another --filter: `terra filters` lists them")
            }
            // The numbers of the state space and of the filter come from the rover file.
            FilterError::Config { .. } | FilterError::NotACovariance { .. } => CliError::Rover {
                message,
                help: None,
            },
            _ => CliError::BadData {
                message,
                help: None,
            },
        }
    }
}

impl From<EstimatorError> for CliError {
    fn from(e: EstimatorError) -> Self {
        let message = e.to_string();
        match e {
            EstimatorError::Name(e) => match e {
                ModelError::UnknownName {
                    kind: "estimator", ..
                } => CliError::usage(message, "`terra estimators` lists them"),
                other => other.into(),
            },
            EstimatorError::Model { source, .. } if happened(&source) => CliError::BadData {
                message,
                help: None,
            },
            EstimatorError::Model {
                source: ModelError::MissingValue { .. },
                ..
            } => CliError::usage(message, INCOMPLETE),
            EstimatorError::Observation { .. }
            | EstimatorError::TimeOrder { .. }
            | EstimatorError::NotPositiveDefinite { .. }
            | EstimatorError::AllInfeasible { .. }
            | EstimatorError::Impossible
            | EstimatorError::OutsideTable { .. }
            | EstimatorError::NoObservations
            | EstimatorError::Decomposition { .. } => CliError::BadData {
                message,
                help: None,
            },
            // Choices, sizes of a transition matrix, sets of hypotheses, laws an estimator cannot take.
            _ => CliError::Usage {
                message,
                help: None,
            },
        }
    }
}

impl From<SimError> for CliError {
    /// A scenario that makes no sense is configuration; one that makes sense and comes to a bad end is data.
    fn from(e: SimError) -> Self {
        let message = e.to_string();
        match e {
            SimError::Model(e) => e.into(),
            SimError::Wheel { source, .. } | SimError::Trial { source, .. }
                if happened(&source) =>
            {
                CliError::BadData {
                    message,
                    help: None,
                }
            }
            SimError::NoEquilibrium { .. }
            | SimError::AgainstMotion { .. }
            | SimError::WheelLift { .. }
            | SimError::LoadTransfer { .. }
            | SimError::StepTooSmall { .. }
            | SimError::NotFinite { .. } => CliError::BadData {
                message,
                help: None,
            },
            _ => CliError::Usage {
                message,
                help: None,
            },
        }
    }
}

impl From<ReportError> for CliError {
    fn from(e: ReportError) -> Self {
        CliError::Usage {
            message: e.to_string(),
            help: None,
        }
    }
}

/// Writes an error to standard error: drawn on a terminal, plain lines otherwise.
pub(crate) fn show(error: &CliError) {
    let stderr = io::stderr();
    let mut text = String::new();
    let drawn = stderr.is_terminal()
        && GraphicalReportHandler::new_themed(GraphicalTheme::unicode())
            .with_links(false)
            .render_report(&mut text, error)
            .is_ok();
    if !drawn {
        text = error.to_string();
        if let Some(help) = error.help() {
            text.push_str(&format!("\n  help: {help}"));
        }
    }
    // Nothing better can be done when standard error is gone.
    let _ = writeln!(stderr.lock(), "error: {}", text.trim());
}
