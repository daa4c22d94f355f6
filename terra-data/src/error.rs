//! What can be wrong with a file, and where.

use std::fmt;
use std::path::Path;

use crate::problem::Problem;

/// A place in a file. In a configuration the column counts characters, in a table it counts columns; both from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// File as the user named it.
    pub file: String,
    /// Line, from 1; `None` when the whole file is meant.
    pub line: Option<u64>,
    /// Column, from 1; `None` when the whole line is meant.
    pub column: Option<u64>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        for number in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{number}")?;
        }
        Ok(())
    }
}

/// Error of a reader or a writer: `file:line:column: what was found, what was expected`.
///
/// The variant says whose mistake it is, because the command's exit status depends on that; [`Problem`] says what it is.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// In a rover file or a user catalogue (exit status 2).
    #[error("{at}: {problem}")]
    Configuration {
        /// Where.
        at: Place,
        /// What.
        problem: Box<Problem>,
    },
    /// In a log (exit status 3).
    #[error("{at}: {problem}")]
    Data {
        /// Where.
        at: Place,
        /// What.
        problem: Box<Problem>,
    },
    /// On writing (exit status 4).
    #[error("{at}: {problem}")]
    Write {
        /// Where.
        at: Place,
        /// What.
        problem: Box<Problem>,
    },
}

impl DataError {
    /// Where it is.
    pub fn place(&self) -> &Place {
        match self {
            DataError::Configuration { at, .. }
            | DataError::Data { at, .. }
            | DataError::Write { at, .. } => at,
        }
    }

    /// What it is.
    pub fn problem(&self) -> &Problem {
        match self {
            DataError::Configuration { problem, .. }
            | DataError::Data { problem, .. }
            | DataError::Write { problem, .. } => problem,
        }
    }

    /// The file as the user named it.
    pub fn file(&self) -> &str {
        &self.place().file
    }

    /// The line, from 1.
    pub fn line(&self) -> Option<u64> {
        self.place().line
    }

    /// The column, from 1: characters in a configuration, columns of the table in a log or a catalogue.
    pub fn column(&self) -> Option<u64> {
        self.place().column
    }

    /// True when a configuration is wrong rather than the data (exit status 2 rather than 3).
    pub fn is_configuration(&self) -> bool {
        matches!(self, DataError::Configuration { .. })
    }

    /// True when a result could not be written (exit status 4).
    pub fn is_write(&self) -> bool {
        matches!(self, DataError::Write { .. })
    }

    pub(crate) fn write(path: &Path, problem: Problem) -> Self {
        DataError::Write {
            at: Place {
                file: path.display().to_string(),
                ..Place::default()
            },
            problem: Box::new(problem),
        }
    }
}

/// What kind of input a file is: it decides between the two reading variants of [`DataError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Rover file, catalogue.
    Configuration,
    /// Log.
    Data,
}

/// A named input; makes errors that point into it.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub(crate) file: String,
    pub(crate) role: Role,
}

impl Origin {
    pub(crate) fn data(file: &str) -> Self {
        Origin {
            file: file.to_owned(),
            role: Role::Data,
        }
    }

    pub(crate) fn configuration(file: &str) -> Self {
        Origin {
            file: file.to_owned(),
            role: Role::Configuration,
        }
    }

    /// An error at a line and a column, both from 1.
    pub(crate) fn fail(
        &self,
        line: impl Into<Option<u64>>,
        column: impl Into<Option<u64>>,
        problem: Problem,
    ) -> DataError {
        let at = Place {
            file: self.file.clone(),
            line: line.into(),
            column: column.into(),
        };
        let problem = Box::new(problem);
        match self.role {
            Role::Configuration => DataError::Configuration { at, problem },
            Role::Data => DataError::Data { at, problem },
        }
    }

    /// An error of the whole file.
    pub(crate) fn fail_file(&self, problem: Problem) -> DataError {
        self.fail(None, None, problem)
    }
}
