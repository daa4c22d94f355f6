//! The columns of a source file, whatever its format.

use std::path::Path;

use crate::error::{DataError, Origin};
use crate::names::short;
use crate::problem::Problem;
use crate::source::open;
use crate::table::Table;

/// One column.
#[derive(Clone, Debug)]
pub(crate) enum Column {
    Text(Vec<String>),
    #[cfg_attr(not(any(feature = "parquet", feature = "mat")), allow(dead_code))]
    Number(Vec<Option<f64>>),
}

/// All columns of a source.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) columns: Vec<(String, Column)>,
    pub(crate) origin: Origin,
    pub(crate) rows: usize,
    /// What the user should know about the reading.
    pub(crate) notes: Vec<String>,
}

impl Frame {
    /// Reads a CSV file, or a Parquet file by its extension.
    pub(crate) fn read(path: &Path, origin: &Origin) -> Result<Self, DataError> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        if extension.is_some_and(|e| e == "parquet") {
            return Frame::parquet(path, origin);
        }
        let file = Box::new(open(path, origin)?);
        let mut table = Table::open(file, origin.clone(), None, "a table")?;
        let names = table.header.clone();
        let mut cells: Vec<Vec<String>> = vec![Vec::new(); names.len()];
        let mut rows = 0;
        while let Some(row) = table.next()? {
            for (k, column) in cells.iter_mut().enumerate() {
                column.push(row.text(k)?.trim().to_owned());
            }
            rows += 1;
        }
        Ok(Frame {
            columns: names
                .into_iter()
                .zip(cells.into_iter().map(Column::Text))
                .collect(),
            origin: origin.clone(),
            rows,
            notes: vec![],
        })
    }

    /// Reads a Parquet file.
    #[cfg(feature = "parquet")]
    pub(crate) fn parquet(path: &Path, origin: &Origin) -> Result<Self, DataError> {
        super::parquet::read(path, origin)
    }

    /// Says what this build lacks.
    #[cfg(not(feature = "parquet"))]
    pub(crate) fn parquet(path: &Path, origin: &Origin) -> Result<Self, DataError> {
        not_built(path, origin, "Parquet", "parquet")
    }

    /// Reads a MATLAB 5 file.
    #[cfg(feature = "mat")]
    pub(crate) fn mat(path: &Path, origin: &Origin) -> Result<Self, DataError> {
        super::mat::read(path, origin)
    }

    /// Says what this build lacks.
    #[cfg(not(feature = "mat"))]
    pub(crate) fn mat(path: &Path, origin: &Origin) -> Result<Self, DataError> {
        not_built(path, origin, "MATLAB", "mat")
    }

    fn column(&self, name: &str) -> Result<(usize, &Column), DataError> {
        let found = self.columns.iter().position(|(n, _)| n == name);
        match found.and_then(|k| Some((k, &self.columns.get(k)?.1))) {
            Some(found) => Ok(found),
            None => {
                let names = self.columns.iter().map(|(n, _)| n.as_str());
                Err(self.origin.fail(
                    1,
                    None,
                    Problem::MissingColumn {
                        name: name.to_owned(),
                        expected: "the column of the published data set".to_owned(),
                        nearest: terra_model::nearest(name, names).map(str::to_owned),
                    },
                ))
            }
        }
    }

    /// A numeric column times a factor; a blank or non-finite cell is missing.
    pub(crate) fn numbers(&self, name: &str, factor: f64) -> Result<Vec<Option<f64>>, DataError> {
        let (k, column) = self.column(name)?;
        let finite = |v: f64| Some(v * factor).filter(|v| v.is_finite());
        match column {
            Column::Number(values) => Ok(values.iter().map(|v| v.and_then(finite)).collect()),
            Column::Text(cells) => cells
                .iter()
                .enumerate()
                .map(|(row, cell)| {
                    if cell.is_empty() || cell.eq_ignore_ascii_case("na") {
                        return Ok(None);
                    }
                    cell.parse::<f64>().map(finite).map_err(|_| {
                        self.origin.fail(
                            row as u64 + 2,
                            k as u64 + 1,
                            Problem::BadNumber {
                                column: name.to_owned(),
                                found: short(cell),
                                expected: "a number",
                            },
                        )
                    })
                })
                .collect(),
        }
    }

    /// A column as text.
    pub(crate) fn texts(&self, name: &str) -> Result<Vec<String>, DataError> {
        Ok(match self.column(name)?.1 {
            Column::Text(cells) => cells.clone(),
            Column::Number(values) => values.iter().map(|v| crate::write::number(*v)).collect(),
        })
    }
}

#[cfg(not(all(feature = "parquet", feature = "mat")))]
fn not_built(
    path: &Path,
    origin: &Origin,
    format: &'static str,
    feature: &'static str,
) -> Result<Frame, DataError> {
    open(path, origin)?;
    Err(origin.fail_file(Problem::FormatNotBuilt { format, feature }))
}
