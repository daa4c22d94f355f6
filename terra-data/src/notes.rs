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
    /// Cells that were numbers but not finite, over all columns.
    pub fn not_finite(&self) -> usize {
        self.missing.values().map(|m| m.not_finite).sum()
    }
}
