//! Every kind of mistake a reader or a writer reports, with the numbers and names inside.

use terra_model::ModelError;

/// What is wrong, without the place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are named by the message beside them
pub enum Problem {
    // The file itself.
    /// Nothing there.
    #[error("no such file")]
    NotFound,
    /// A directory.
    #[error("is a directory, expected a file")]
    IsDirectory,
    /// Links that lead to themselves.
    #[error("symbolic links lead in a circle, expected a file")]
    SymlinkLoop,
    /// Any other failure of the operating system.
    #[error("cannot be read: {reason}")]
    Unreadable { reason: String },
    /// No bytes, or blank lines only.
    #[error("is empty, expected {expected}")]
    Empty { expected: &'static str },
    /// A configuration of many megabytes.
    #[error("is larger than {limit} bytes, expected a configuration of a few kilobytes")]
    TooLarge { limit: u64 },
    /// A compressed file.
    #[error("is compressed ({format}), expected plain text: decompress it first")]
    Compressed { format: &'static str },
    /// A format whose reader was not built in.
    #[error(
        "is a {format} file, which this build cannot read: build it with `--features {feature}` (cargo install --path . --features {feature})"
    )]
    FormatNotBuilt {
        format: &'static str,
        feature: &'static str,
    },
    /// UTF-16 text.
    #[error("is UTF-16 text, expected UTF-8: save it as UTF-8 (in a spreadsheet: 'CSV UTF-8')")]
    Utf16,
    /// No text.
    #[error("is binary ({format}), expected text in UTF-8")]
    Binary { format: &'static str },
    /// A NUL byte in text.
    #[error("holds a NUL byte, expected text: the file was damaged or cut while it was written")]
    Nul,
    /// Bytes that are no UTF-8.
    #[error("is not UTF-8 (byte {byte:#04x}), expected text in UTF-8")]
    NotUtf8 { byte: u8 },

    // Tables.
    /// Cells separated by something else than commas.
    #[error(
        "cells seem to be separated by {found:?}, expected commas (and '.' as the decimal mark)"
    )]
    WrongDelimiter { found: char },
    /// A column the reader needs.
    #[error("no column '{name}', expected {expected}{}", hint(nearest))]
    MissingColumn {
        name: String,
        expected: String,
        nearest: Option<String>,
    },
    /// The same column twice.
    #[error("column '{name}' again (first in column {first}), expected each name once")]
    DuplicateColumn { name: String, first: u64 },
    /// A header without rows.
    #[error("has a header and no rows, expected at least one row")]
    NoRows,
    /// A row of another length than the header.
    #[error(
        "row has {found} cells, expected {expected} as in the header (a decimal comma adds a cell)"
    )]
    RaggedRow { found: usize, expected: usize },
    /// The file ends inside a row.
    #[error(
        "last line is cut after {found} of {expected} cells and has no line end: remove it or copy the file again"
    )]
    CutLastLine { found: usize, expected: usize },
    /// A quote that is opened and never closed.
    #[error("a quoted cell is never closed, expected a second '\"'")]
    UnclosedQuote,
    /// Text where a number belongs.
    #[error(
        "column '{column}': found '{found}', expected {expected} (empty, nan or NA when missing)"
    )]
    BadNumber {
        column: String,
        found: String,
        expected: &'static str,
    },
    /// A number that this column cannot have.
    #[error("column '{column}': found {found}, expected {expected}")]
    BadValue {
        column: String,
        found: f64,
        expected: &'static str,
    },
    /// A mark that is none of the known ones.
    #[error("column '{column}': found '{found}', expected {expected}")]
    UnknownMark {
        column: String,
        found: String,
        expected: &'static str,
    },
    /// A value that this table cannot do without.
    #[error("column '{column}': no value, expected one in every row")]
    MissingValue { column: String },
    /// A row without time.
    #[error("column '{column}': no time, expected one in every row")]
    MissingTime { column: String },
    /// Time that stands still or goes back.
    #[error(
        "column '{column}': time {found} s after {previous} s, expected time to increase inside '{group}'"
    )]
    TimeNotIncreasing {
        column: String,
        previous: f64,
        found: f64,
        group: String,
    },
    /// All rows were dropped.
    #[error("none of the {rows} rows can be used; the first, line {line}: {reason}")]
    NoUsableRows {
        rows: usize,
        line: u64,
        reason: String,
    },
    /// Neither a drive log nor a rig log.
    #[error(
        "is neither log: a drive log needs {drive}; a rig log needs {rig}; found {}",
        list(found)
    )]
    UnknownLogKind {
        drive: String,
        rig: String,
        found: Vec<String>,
    },
    /// The same terrain twice.
    #[error("terrain '{id}' again (first in line {first}), expected each id once")]
    DuplicateTerrain { id: String, first: u64 },

    // Configuration.
    /// No TOML.
    #[error("{message}, expected valid TOML")]
    Syntax { message: String },
    /// A key nobody reads.
    #[error(
        "unknown key '{key}' in {table}, expected one of {}{}",
        list(known),
        hint(nearest)
    )]
    UnknownKey {
        key: String,
        table: String,
        known: Vec<String>,
        nearest: Option<String>,
    },
    /// A key that must be there.
    #[error("{table} has no '{key}', expected {expected}")]
    MissingKey {
        key: String,
        table: String,
        expected: String,
    },
    /// A table that must be there.
    #[error("no table [{table}], expected one")]
    MissingTable { table: &'static str },
    /// Text for a number, a number for a table, ...
    #[error("{key} is {found}, expected {expected}")]
    WrongType {
        key: String,
        found: String,
        expected: &'static str,
    },
    /// `nan` or `inf`.
    #[error("{key} = {found}, expected a finite number")]
    NotFinite { key: String, found: String },
    /// A number outside its legal range.
    #[error("{key} = {found}, expected {expected}")]
    OutOfRange {
        key: String,
        found: String,
        expected: String,
    },
    /// A name that is not one of the known ones.
    #[error("unknown {kind} '{name}', expected {expected}{}", hint(nearest))]
    UnknownName {
        kind: &'static str,
        name: String,
        expected: String,
        nearest: Option<String>,
    },
    /// A unit of another quantity.
    #[error(
        "{column} cannot be in '{unit}', a unit of {of}; expected one of {}",
        list(legal)
    )]
    WrongDimension {
        column: String,
        unit: String,
        of: &'static str,
        legal: Vec<&'static str>,
    },
    /// Two keys that exclude each other.
    #[error("{key} and {other} exclude each other, expected one of them")]
    Conflict { key: String, other: String },
    /// A combination the model cannot carry.
    #[error("{0}")]
    Model(ModelError),
    /// A soil that lacks a value of the model.
    #[error("{0}; write start as a table of parameters that names it, or take another soil")]
    IncompleteTerrain(ModelError),

    // Writing.
    /// The operating system refused.
    #[error("cannot be written: {reason}")]
    NotWritable { reason: String },
    /// A file that would be overwritten.
    #[error("exists already, expected a new file")]
    Exists,
    /// A log that would not be read back as it is.
    #[error("cannot be written: {reason}")]
    NotALog { reason: String },
}

fn hint(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|n| format!("; did you mean '{n}'?"))
        .unwrap_or_default()
}

fn list(names: &[impl AsRef<str>]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    names.join(", ")
}

impl Problem {
    /// A name error of a registry or a catalogue, any other model error as it is.
    pub(crate) fn from_model(error: ModelError, expected: &str) -> Self {
        match error {
            ModelError::UnknownName {
                kind,
                name,
                nearest,
            } => Problem::UnknownName {
                kind,
                name,
                expected: expected.to_owned(),
                nearest,
            },
            other => Problem::Model(other),
        }
    }
}
