//! A CSV file row by row, each cell with its place.

use std::io::{self, Cursor, Read};

use csv::{ByteRecord, ReaderBuilder, Trim};

use crate::columns::Bound;
use crate::error::{DataError, Origin};
use crate::lines::LineWatch;
use crate::names::short;
use crate::problem::Problem;
use crate::source::{text_prefix, unreadable};

/// One kind of stream: readers are compiled once, here, and not again in every crate that reads from another.
type Stream<'r> = LineWatch<io::Chain<Cursor<Vec<u8>>, Box<dyn Read + 'r>>>;

/// A CSV table under its header. Memory: one row.
pub(crate) struct Table<'r> {
    csv: csv::Reader<Stream<'r>>,
    record: ByteRecord,
    line: u64,
    rows: usize,
    /// The file, for errors.
    pub(crate) origin: Origin,
    /// Column names, blanks around them removed.
    pub(crate) header: Vec<String>,
    /// The header's line.
    pub(crate) header_line: u64,
}

/// One row of a [`Table`].
pub(crate) struct Row<'t> {
    record: &'t ByteRecord,
    origin: &'t Origin,
    /// Its line in the file.
    pub(crate) line: u64,
}

impl<'r> Table<'r> {
    /// Reads the header. Lines that begin with `comment` are skipped.
    pub(crate) fn open(
        mut reader: Box<dyn Read + 'r>,
        origin: Origin,
        comment: Option<u8>,
        expected: &'static str,
    ) -> Result<Self, DataError> {
        let prefix = text_prefix(&mut reader, &origin, expected)?;
        let watch = LineWatch::new(Cursor::new(prefix).chain(reader), comment);
        // The header is read like a row, so that it has a line too; lengths are checked here, so that they have one.
        let csv = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::None)
            .comment(comment)
            .from_reader(watch);
        let mut table = Table {
            csv,
            record: ByteRecord::new(),
            line: 0,
            rows: 0,
            origin,
            header: Vec::new(),
            header_line: 0,
        };
        if !table.read()? {
            return Err(table.origin.fail_file(Problem::Empty { expected }));
        }
        table.header_line = table.line;
        let row = table.row();
        let header: Result<Vec<String>, DataError> = (0..row.record.len())
            .map(|i| row.text(i).map(|t| t.trim().to_owned()))
            .collect();
        table.header = header?;
        if let [only] = table.header.as_slice()
            && let Some(found) = only.chars().find(|c| matches!(c, ';' | '\t' | '|'))
        {
            return Err(table.fail_header(None, Problem::WrongDelimiter { found }));
        }
        Ok(table)
    }

    /// The next row, as long as the header.
    pub(crate) fn next(&mut self) -> Result<Option<Row<'_>>, DataError> {
        if !self.read()? {
            if self.rows == 0 {
                return Err(self.fail_header(None, Problem::NoRows));
            }
            return Ok(None);
        }
        self.rows += 1;
        let (found, expected) = (self.record.len(), self.header.len());
        if found != expected {
            let watch = self.csv.get_ref();
            let cut = watch.ended() && !watch.ends_a_line() && found < expected;
            let problem = if cut {
                Problem::CutLastLine { found, expected }
            } else {
                Problem::RaggedRow { found, expected }
            };
            let column = found.min(expected) as u64 + u64::from(!cut);
            return Err(self.origin.fail(self.line, column, problem));
        }
        Ok(Some(self.row()))
    }

    /// True once all rows are read of a file that does not end with a line end: its last value may be cut.
    pub(crate) fn ends_inside_a_line(&self) -> bool {
        let watch = self.csv.get_ref();
        // Such a row ends only with the file, so that the end is known as soon as the row is.
        watch.ended() && !watch.ends_a_line()
    }

    /// An error in the header, in the column of that index.
    pub(crate) fn fail_header(&self, index: Option<usize>, problem: Problem) -> DataError {
        self.origin
            .fail(self.header_line, index.map(|i| i as u64 + 1), problem)
    }

    /// The index of the column of that name; a name that is there twice is an error at the second.
    pub(crate) fn position(&self, name: &str) -> Result<Option<usize>, DataError> {
        let mut found = self
            .header
            .iter()
            .enumerate()
            .filter(|(_, h)| *h == name)
            .map(|(i, _)| i);
        let first = found.next();
        match (first, found.next()) {
            (Some(first), Some(second)) => Err(self.fail_header(
                Some(second),
                Problem::DuplicateColumn {
                    name: name.to_owned(),
                    first: first as u64 + 1,
                },
            )),
            _ => Ok(first),
        }
    }

    fn row(&self) -> Row<'_> {
        Row {
            record: &self.record,
            origin: &self.origin,
            line: self.line,
        }
    }

    fn read(&mut self) -> Result<bool, DataError> {
        let more =
            self.csv
                .read_byte_record(&mut self.record)
                .map_err(|e| match e.into_kind() {
                    csv::ErrorKind::Io(e) => unreadable(&self.origin, &e),
                    other => self.origin.fail_file(Problem::Unreadable {
                        reason: format!("{other:?}"),
                    }),
                })?;
        if !more {
            return Ok(false);
        }
        let end = self.csv.position().byte();
        let watch = self.csv.get_mut();
        let quotes = match watch.line_until(end) {
            Some(start) => {
                self.line = start.line;
                watch.quotes() - start.quotes
            }
            None => 0,
        };
        // Only the last record can hold a quote that is never closed: it swallows the rest of the file.
        let swallowed = !watch.ends_a_line()
            || self
                .record
                .iter()
                .any(|c| c.contains(&b'\n') || c.contains(&b'\r'));
        if watch.ended() && quotes % 2 == 1 && swallowed {
            let column = self.record.len() as u64;
            return Err(self.origin.fail(self.line, column, Problem::UnclosedQuote));
        }
        if let Some(i) = self.record.iter().position(|c| c.contains(&0)) {
            return Err(self.origin.fail(self.line, i as u64 + 1, Problem::Nul));
        }
        Ok(true)
    }
}

/// A cell of a numeric column.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    Value(f64),
    Blank,
    NotFinite,
}

impl Row<'_> {
    /// The text of a cell as it is.
    pub(crate) fn text(&self, index: usize) -> Result<&str, DataError> {
        let bytes = self.record.get(index).unwrap_or_default();
        std::str::from_utf8(bytes).map_err(|e| {
            let byte = bytes.get(e.valid_up_to()).copied().unwrap_or_default();
            self.origin
                .fail(self.line, index as u64 + 1, Problem::NotUtf8 { byte })
        })
    }

    /// A number in SI; a missing one is counted in the column and is `None`.
    pub(crate) fn number(&self, column: &mut Bound) -> Result<Option<f64>, DataError> {
        let cell = self.cell(column, "a number")?;
        Ok(match cell {
            Cell::Value(v) => {
                let si = column.unit.to_si(v);
                if !si.is_finite() {
                    column.missing.not_finite += 1;
                }
                Some(si).filter(|v| v.is_finite())
            }
            Cell::Blank => {
                column.missing.blank += 1;
                None
            }
            Cell::NotFinite => {
                column.missing.not_finite += 1;
                None
            }
        })
    }

    /// A whole number of at least 1.
    pub(crate) fn count(&self, column: &mut Bound) -> Result<Option<u32>, DataError> {
        const EXPECTED: &str = "a whole number from 1";
        let Some(v) = self.number(column)? else {
            return Ok(None);
        };
        if v.fract() != 0.0 || !(1.0..=f64::from(u32::MAX)).contains(&v) {
            return Err(self.bad_value(column, v, EXPECTED));
        }
        Ok(Some(v as u32))
    }

    /// The error of a number that the column cannot have.
    pub(crate) fn bad_value(
        &self,
        column: &Bound,
        found: f64,
        expected: &'static str,
    ) -> DataError {
        self.fail(
            column,
            Problem::BadValue {
                column: column.shown(),
                found,
                expected,
            },
        )
    }

    /// An error in a column of this row.
    pub(crate) fn fail(&self, column: &Bound, problem: Problem) -> DataError {
        self.origin
            .fail(self.line, column.index as u64 + 1, problem)
    }

    fn cell(&self, column: &Bound, expected: &'static str) -> Result<Cell, DataError> {
        let text = self.text(column.index)?.trim();
        if text.is_empty() || text.eq_ignore_ascii_case("nan") || text.eq_ignore_ascii_case("na") {
            return Ok(Cell::Blank);
        }
        match text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(Cell::Value(v)),
            Ok(_) => Ok(Cell::NotFinite),
            Err(_) => Err(self.fail(
                column,
                Problem::BadNumber {
                    column: column.shown(),
                    found: short(text),
                    expected,
                },
            )),
        }
    }
}
