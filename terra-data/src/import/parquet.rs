//! Parquet files: flat tables of numbers and text.

mod headers;

use std::fs::File;
use std::path::Path;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use super::frame::{Column, Frame};
use crate::error::{DataError, Origin};
use crate::problem::Problem;
use crate::source::{open, unreadable};

/// Reads all columns.
pub(crate) fn read(path: &Path, origin: &Origin) -> Result<Frame, DataError> {
    super::guarded(origin, "Parquet file", || frame(path, origin))
}

/// The first column chunk that cannot be where the metadata says.
fn misplaced(reader: &SerializedFileReader<File>, length: u64) -> Option<String> {
    let metadata = reader.metadata();
    let chunks = metadata.row_groups().iter().flat_map(|g| g.columns());
    let within = |start: i64, size: i64| {
        let end = u64::try_from(start)
            .ok()?
            .checked_add(u64::try_from(size).ok()?)?;
        (end <= length).then_some(())
    };
    chunks
        .filter(|c| {
            let start = c.dictionary_page_offset().unwrap_or(c.data_page_offset());
            within(start, c.compressed_size()).is_none()
        })
        .map(|c| c.column_path().string())
        .next()
}

fn frame(path: &Path, origin: &Origin) -> Result<Frame, DataError> {
    let fail = |e: parquet::errors::ParquetError| {
        origin.fail_file(Problem::Unreadable {
            reason: e.to_string(),
        })
    };
    let refuse = |reason: String| origin.fail_file(Problem::Unreadable { reason });
    let mut file = open(path, origin)?;
    let length = file.metadata().map_err(|e| unreadable(origin, &e))?.len();
    headers::footer(&mut file).map_err(refuse)?;
    let again = file.try_clone().map_err(|e| unreadable(origin, &e))?;
    let reader = SerializedFileReader::new(again).map_err(fail)?;
    if let Some(column) = misplaced(&reader, length) {
        return Err(refuse(format!(
            "column '{}' lies outside the file",
            crate::names::short(&column)
        )));
    }
    for group in reader.metadata().row_groups() {
        for column in group.columns() {
            let (start, length) = column.byte_range();
            headers::pages(&mut file, start, length).map_err(refuse)?;
        }
    }
    let mut columns: Vec<(String, Column)> = vec![];
    let mut rows = 0;
    for row in reader.get_row_iter(None).map_err(fail)? {
        for (k, (name, field)) in row.map_err(fail)?.get_column_iter().enumerate() {
            if k == columns.len() {
                let column = match field {
                    Field::Str(_) => Column::Text(vec![]),
                    _ => Column::Number(vec![]),
                };
                columns.push((name.clone(), column));
            }
            match columns.get_mut(k) {
                Some((_, Column::Text(cells))) => cells.push(match field {
                    Field::Str(s) => s.clone(),
                    Field::Null => String::new(),
                    other => other.to_string(),
                }),
                Some((name, Column::Number(values))) => {
                    values.push(value(field).ok_or_else(|| {
                        origin.fail_file(Problem::BadNumber {
                            column: name.clone(),
                            found: crate::names::short(&field.to_string()),
                            expected: "a number",
                        })
                    })?);
                }
                None => {}
            }
        }
        rows += 1;
    }
    Ok(Frame {
        columns,
        origin: origin.clone(),
        rows,
        notes: vec![],
    })
}

/// A number, or none for a missing one; `None` for what is no number.
fn value(field: &Field) -> Option<Option<f64>> {
    Some(Some(match field {
        Field::Null => return Some(None),
        Field::Bool(b) => f64::from(u8::from(*b)),
        Field::Byte(v) => f64::from(*v),
        Field::Short(v) => f64::from(*v),
        Field::Int(v) => f64::from(*v),
        Field::Long(v) => *v as f64,
        Field::UByte(v) => f64::from(*v),
        Field::UShort(v) => f64::from(*v),
        Field::UInt(v) => f64::from(*v),
        Field::Float(v) => f64::from(*v),
        Field::Double(v) => *v,
        // A clock becomes seconds.
        Field::TimestampMillis(v) => *v as f64 / 1e3,
        Field::TimestampMicros(v) => *v as f64 / 1e6,
        _ => return None,
    }))
}
