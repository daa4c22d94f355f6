//! MATLAB 5 files (saved with -v6 or -v7): vectors of one length become columns, a structure gives its fields.

mod element;
mod matrix;

use std::path::Path;

use super::frame::{Column, Frame};
use crate::error::{DataError, Origin};
use crate::names::short;
use crate::problem::Problem;
use crate::source::open;
use element::Reader;
use matrix::{Array, Content};

/// Reads all vectors. A matrix of n rows and k columns is k columns `name_1` ... `name_k`, a text array or a cell array of
/// texts a column of text. Single numbers are left out with a note; vectors of two lengths are an error.
pub(crate) fn read(path: &Path, origin: &Origin) -> Result<Frame, DataError> {
    let bad = |reason: String| origin.fail_file(Problem::Unreadable { reason });
    let arrays = Reader::new(open(path, origin)?)
        .and_then(Reader::arrays)
        .map_err(|e| bad(format!("as MATLAB 5: {e}")))?;
    let mut table = Table::default();
    for array in arrays {
        table.add(array).map_err(&bad)?;
    }
    let Some((rows, _)) = table.length else {
        return Err(bad("no vector of numbers in it".to_owned()));
    };
    Ok(Frame {
        columns: table.columns,
        origin: origin.clone(),
        rows,
        notes: table.notes,
    })
}

/// Columns as they come, with the length that all must have and whose it was.
#[derive(Default)]
struct Table {
    columns: Vec<(String, Column)>,
    length: Option<(usize, String)>,
    notes: Vec<String>,
}

impl Table {
    fn add(&mut self, array: Array) -> Result<(), String> {
        let name = array.name;
        match array.content {
            Content::Fields(fields) => {
                for field in fields {
                    self.add(field)?;
                }
                Ok(())
            }
            Content::Numbers { rows, columns, .. } | Content::Texts { rows, columns, .. }
                if rows * columns <= 1 =>
            {
                self.notes
                    .push(format!("{}: a single value is left out", short(&name)));
                Ok(())
            }
            // Column by column, as MATLAB keeps them; a row vector is a column.
            Content::Numbers {
                rows,
                columns,
                values,
            } => {
                let (rows, columns) = upright(rows, columns);
                self.fits(rows, &name)?;
                for (k, part) in values.chunks(rows).enumerate() {
                    let name = match columns {
                        1 => name.clone(),
                        _ => format!("{name}_{}", k + 1),
                    };
                    let values = part.iter().map(|v| Some(*v)).collect();
                    self.put(name, Column::Number(values))?;
                }
                Ok(())
            }
            Content::Texts {
                rows,
                columns,
                texts,
            } => {
                if upright(rows, columns).1 != 1 {
                    self.notes
                        .push(format!("{}: a table of texts is left out", short(&name)));
                    return Ok(());
                }
                self.fits(texts.len(), &name)?;
                self.put(name, Column::Text(texts))
            }
            Content::Other(what) => {
                self.notes
                    .push(format!("{}: {what} is left out", short(&name)));
                Ok(())
            }
        }
    }

    fn fits(&mut self, rows: usize, name: &str) -> Result<(), String> {
        match &self.length {
            None => {
                self.length = Some((rows, name.to_owned()));
                Ok(())
            }
            Some((length, _)) if *length == rows => Ok(()),
            Some((length, first)) => Err(format!(
                "{} has {rows} rows and {} has {length}, expected one length",
                short(name),
                short(first)
            )),
        }
    }

    fn put(&mut self, name: String, column: Column) -> Result<(), String> {
        if self.columns.iter().any(|(n, _)| *n == name) {
            return Err(format!("two variables give a column '{}'", short(&name)));
        }
        self.columns.push((name, column));
        Ok(())
    }
}

/// A row vector stood up.
fn upright(rows: usize, columns: usize) -> (usize, usize) {
    if rows == 1 {
        (columns, 1)
    } else {
        (rows, columns)
    }
}
