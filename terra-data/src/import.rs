//! Known data sets and formats, turned into logs with the contract's columns.
//!
//! An import renames, converts units and groups; it leaves nothing out silently and invents nothing. What a data set does
//! not say (whose radius, which repeat) is stated in the importer that needs it, and in its notes.

#[cfg(feature = "mcap")]
mod bag;
mod frame;
mod husky;
#[cfg(feature = "mat")]
mod mat;
#[cfg(feature = "parquet")]
mod parquet;
mod plain;
mod scm;
mod single_wheel;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::atomic::atomic_write;
use crate::error::{DataError, Origin};
use crate::problem::Problem;
use crate::write::number;
use frame::Frame;

#[cfg(feature = "mcap")]
pub use bag::import_mcap;
pub use scm::{parse_scm_json, read_scm_json, scm_json, write_terrains, write_terrains_to};

/// A data set that can be imported as a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImportKind {
    /// Single-wheel soil-bin trials of Carnegie Mellon University.
    CmuSingleWheel,
    /// Points digitised from published single-wheel tests.
    PublishedSingleWheel,
    /// Skid-steer windows of a Husky A200 (needs the feature `parquet`).
    NorlabDrive,
    /// Motor currents and wheel speeds of a Husky A200 on three surfaces (needs the feature `parquet`).
    BorealTc,
    /// Any flat Parquet file, its columns as they are (needs the feature `parquet`).
    Parquet,
    /// The vectors of a MATLAB 5 file, under their names (needs the feature `mat`).
    Mat,
}

impl ImportKind {
    /// All of them.
    pub const ALL: [ImportKind; 6] = [
        ImportKind::CmuSingleWheel,
        ImportKind::PublishedSingleWheel,
        ImportKind::NorlabDrive,
        ImportKind::BorealTc,
        ImportKind::Parquet,
        ImportKind::Mat,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            ImportKind::CmuSingleWheel => "cmu-single-wheel",
            ImportKind::PublishedSingleWheel => "published-single-wheel",
            ImportKind::NorlabDrive => "norlab-drive",
            ImportKind::BorealTc => "borealtc",
            ImportKind::Parquet => "parquet",
            ImportKind::Mat => "mat",
        }
    }

    /// The file meant when only its folder is given, for those that are one known file.
    fn file(self) -> Option<&'static str> {
        match self {
            ImportKind::CmuSingleWheel => Some("smooth_straight.csv"),
            ImportKind::PublishedSingleWheel => Some("points.csv"),
            ImportKind::NorlabDrive => Some("husky_windows.parquet"),
            ImportKind::BorealTc => Some("wheel_service.parquet"),
            ImportKind::Parquet | ImportKind::Mat => None,
        }
    }
}

/// One cell of an imported log.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    Text(String),
    Number(Option<f64>),
}

/// A data set in the columns of a log.
#[derive(Clone, Debug, Default)]
pub struct ImportedLog {
    header: Vec<String>,
    rows: Vec<Vec<Cell>>,
    /// What the user of the log should know about the import.
    pub notes: Vec<String>,
}

impl ImportedLog {
    /// Column names.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// True without rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Writes it as CSV, atomically.
    ///
    /// # Errors
    /// [`DataError::Write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), DataError> {
        atomic_write(path, |w| self.write_to(w))
    }

    /// [`write`](Self::write) to a stream.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn write_to(&self, mut out: impl Write) -> io::Result<()> {
        self.write_rows(&mut out)
    }

    fn write_rows(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(&self.header)?;
        for row in &self.rows {
            csv.write_record(row.iter().map(|cell| match cell {
                Cell::Text(text) => text.clone(),
                Cell::Number(value) => number(*value),
            }))?;
        }
        csv.flush()
    }
}

/// Runs another library's reader. Damaged files make some of them panic (on numbers that overflow, say): here that is an
/// error like any other.
#[cfg(any(feature = "parquet", feature = "mcap"))]
fn guarded<T>(
    origin: &Origin,
    format: &str,
    read: impl FnOnce() -> Result<T, DataError>,
) -> Result<T, DataError> {
    // What it had read is dropped, so nothing half done is left behind.
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(read)).unwrap_or_else(|_| {
        Err(origin.fail_file(Problem::Unreadable {
            reason: format!("the {format} is damaged"),
        }))
    })
}

/// Imports a data set from its file, or from the folder that holds it.
///
/// # Errors
/// [`DataError::Data`]: the file cannot be read, a column is missing, or it is a Parquet file and this build has no reader
/// for those.
pub fn import(kind: ImportKind, source: impl AsRef<Path>) -> Result<ImportedLog, DataError> {
    let source = source.as_ref();
    let path: PathBuf = match kind.file() {
        Some(file) if source.is_dir() => source.join(file),
        _ => source.to_owned(),
    };
    let origin = Origin::data(&path.display().to_string());
    let frame = match kind {
        ImportKind::Parquet => Frame::parquet(&path, &origin)?,
        ImportKind::Mat => Frame::mat(&path, &origin)?,
        _ => Frame::read(&path, &origin)?,
    };
    let log = match kind {
        ImportKind::CmuSingleWheel => single_wheel::cmu(&frame)?,
        ImportKind::PublishedSingleWheel => single_wheel::published(&frame)?,
        ImportKind::NorlabDrive => husky::norlab(&frame)?,
        ImportKind::BorealTc => husky::borealtc(&frame)?,
        ImportKind::Parquet | ImportKind::Mat => plain::log(frame),
    };
    if log.is_empty() {
        return Err(origin.fail_file(Problem::NoRows));
    }
    Ok(log)
}
