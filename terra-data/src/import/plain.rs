//! A table whose columns are a log's already, or become one by `[columns]` of the rover file.

use super::frame::{Column, Frame};
use super::{Cell, ImportedLog};

/// All columns as they are.
pub(crate) fn log(frame: Frame) -> ImportedLog {
    let mut rows: Vec<Vec<Cell>> = (0..frame.rows).map(|_| vec![]).collect();
    let mut header = vec![];
    for (name, column) in frame.columns {
        header.push(name);
        let cells: Box<dyn Iterator<Item = Cell>> = match column {
            Column::Text(texts) => Box::new(texts.into_iter().map(Cell::Text)),
            Column::Number(values) => Box::new(values.into_iter().map(Cell::Number)),
        };
        for (row, cell) in rows.iter_mut().zip(cells) {
            row.push(cell);
        }
    }
    ImportedLog {
        header,
        rows,
        notes: frame.notes,
    }
}
