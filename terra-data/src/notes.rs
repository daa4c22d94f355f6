//! What a reader saw beside the numbers.

use std::collections::BTreeMap;

/// Missing cells of one column, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissingCells {
    /// Empty, `nan` or `NA`.
    pub blank: usize,
    /// A number that is not finite (`1e999`, `inf`), also after conversion of its unit.
    pub not_finite: usize,
}

impl MissingCells {
    /// Both reasons together.
    pub fn total(self) -> usize {
        self.blank + self.not_finite
    }
}

/// What a reader saw beside the numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadNotes {
    /// Columns of the file that were not used, in order.
    pub ignored_columns: Vec<String>,
    /// Missing cells, by contract column; only columns that have some.
    pub missing: BTreeMap<String, MissingCells>,
}

impl ReadNotes {
    /// Takes in what was seen of the next rows of the same file.
    pub(crate) fn add(&mut self, next: &ReadNotes) {
        self.ignored_columns.clone_from(&next.ignored_columns);
        for (column, cells) in &next.missing {
            let all = self.missing.entry(column.clone()).or_default();
            all.blank += cells.blank;
            all.not_finite += cells.not_finite;
        }
    }

    /// Cells that were numbers but not finite, over all columns.
    pub fn not_finite(&self) -> usize {
        self.missing.values().map(|m| m.not_finite).sum()
    }
}
