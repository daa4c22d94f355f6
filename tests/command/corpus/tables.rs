//! Logs gone wrong: cells, rows, headers, whole files.

use std::fs;

use super::{Corpus, File};
use crate::support::logs;

/// A table as rows of cells, header first.
#[derive(Clone)]
struct Table(Vec<Vec<String>>);

impl Table {
    fn of(text: &str) -> Self {
        let row = |line: &str| line.split(',').map(str::to_owned).collect();
        Table(text.lines().map(row).collect())
    }

    fn text(&self) -> String {
        let lines: Vec<String> = self.0.iter().map(|row| row.join(",")).collect();
        lines.join("\n") + "\n"
    }

    fn column(&self, name: &str) -> usize {
        self.0[0].iter().position(|n| n == name).unwrap()
    }

    fn with(&self, change: impl FnOnce(&mut Vec<Vec<String>>)) -> String {
        let mut table = self.clone();
        change(&mut table.0);
        table.text()
    }

    /// First, middle and last row of numbers, as indices.
    fn rows(&self) -> [usize; 3] {
        [1, self.0.len() / 2, self.0.len() - 1]
    }
}

/// No number in anybody's notation of a CSV file with a decimal point.
const NO_NUMBERS: [(&str, &str); 11] = [
    ("decimal comma", "\"1,5\""),
    ("letters after digits", "12abc"),
    ("hexadecimal", "0x1F"),
    ("thousands", "1_000"),
    ("a unit", "1 m/s"),
    ("a question mark", "?"),
    ("two numbers", "1 2"),
    ("per cent", "5%"),
    ("two signs", "--1"),
    ("two points", "1.2.3"),
    ("a word", "fast"),
];

/// Cells and rows of a log whose column `numbers[k]` holds numbers.
fn rows(corpus: &mut Corpus, file: File, good: &Table, numbers: &[usize]) {
    let width = good.0[0].len() as u64;
    for (k, row) in good.rows().into_iter().enumerate() {
        // Rows count from the header, which is line 1.
        let line = row as u64 + 1;
        for (m, (name, text)) in NO_NUMBERS.iter().enumerate() {
            let at = numbers[(m + 5 * k) % numbers.len()];
            let bytes = good.with(|t| t[row][at] = (*text).to_owned());
            corpus.add(
                file,
                format!("{name} in row {row}"),
                bytes,
                "BadNumber",
                line,
                at as u64 + 1,
            );
        }
        let at = numbers[k % numbers.len()];
        let column = at as u64 + 1;
        let bytes = good.with(|t| t[row][at].insert(1, '\0'));
        corpus.add(
            file,
            format!("a NUL in row {row}"),
            bytes,
            "Nul",
            line,
            column,
        );
        let bytes = good.with(|t| t[row][at].insert(0, '"'));
        corpus.add(
            file,
            format!("an open quote in row {row}"),
            bytes,
            "UnclosedQuote",
            line,
            column,
        );
        let bytes = good.with(|t| t[row][at] = "\u{1}".to_owned()).into_bytes();
        let bytes: Vec<u8> = bytes
            .into_iter()
            .map(|b| if b == 1 { 0xe9 } else { b })
            .collect();
        corpus.add(
            file,
            format!("Latin-1 in row {row}"),
            bytes,
            "NotUtf8",
            line,
            column,
        );
        let bytes = good.with(|t| t[row].truncate(width as usize - 1));
        corpus.add(
            file,
            format!("a cell too few in row {row}"),
            bytes,
            "RaggedRow",
            line,
            width,
        );
        let bytes = good.with(|t| t[row].push("7".to_owned()));
        corpus.add(
            file,
            format!("a cell too many in row {row}"),
            bytes,
            "RaggedRow",
            line,
            width + 1,
        );
        let bytes = good.with(|t| {
            let header = t[0].clone();
            t.insert(row, header);
        });
        corpus.add(
            file,
            format!("the header again before row {row}"),
            bytes,
            "BadNumber",
            line,
            numbers.iter().min().unwrap().to_owned() as u64 + 1,
        );
    }
}

/// The whole file, cut or in another form.
fn files(corpus: &mut Corpus, file: File, good: &Table) {
    let text = good.text();
    let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    corpus.add(file, "no bytes", "", "Empty", None, None);
    corpus.add(file, "blank lines", "\n\n\r\n", "Empty", None, None);
    corpus.add(
        file,
        "header only",
        good.0[0].join(",") + "\n",
        "NoRows",
        1,
        None,
    );
    corpus.add(file, "UTF-16", utf16, "Utf16", None, None);
    corpus.add(
        file,
        "gzip",
        [b"\x1f\x8b\x08".as_slice(), text.as_bytes()].concat(),
        "Compressed",
        None,
        None,
    );
    corpus.add(
        file,
        "zip",
        [b"PK\x03\x04".as_slice(), text.as_bytes()].concat(),
        "Compressed",
        None,
        None,
    );
    corpus.add(
        file,
        "Parquet",
        [b"PAR1".as_slice(), text.as_bytes()].concat(),
        "Binary",
        None,
        None,
    );
    corpus.add(
        file,
        "a bag",
        [b"\x89MCAP0\r\n".as_slice(), text.as_bytes()].concat(),
        "Binary",
        None,
        None,
    );
    corpus.add(
        file,
        "semicolons",
        text.replace(',', ";"),
        "WrongDelimiter",
        1,
        None,
    );
    corpus.add(
        file,
        "tabs",
        text.replace(',', "\t"),
        "WrongDelimiter",
        1,
        None,
    );
    // Cut inside the last row, behind the k-th cell.
    let last = good.0.len();
    for cells in 1..good.0[0].len().min(6) {
        let bytes = good.with(|t| t[last - 1].truncate(cells));
        let bytes = bytes.trim_end_matches('\n');
        corpus.add(
            file,
            format!("cut behind cell {cells}"),
            bytes,
            "CutLastLine",
            last as u64,
            cells as u64,
        );
    }
}

/// Columns that must be there: gone, misspelt, or there twice.
fn header(corpus: &mut Corpus, file: File, good: &Table, required: &[&str]) {
    for name in required {
        let at = good.column(name);
        let bytes = good.with(|t| t.iter_mut().for_each(|row| drop(row.remove(at))));
        corpus.add(file, format!("no {name}"), bytes, "MissingColumn", 1, None);
        let bytes = good.with(|t| t[0][at].push('x'));
        corpus.add(
            file,
            format!("{name}x"),
            bytes,
            "MissingColumn",
            1,
            at as u64 + 1,
        );
        let bytes = good.with(|t| t.iter_mut().for_each(|row| row.push(row[at].clone())));
        corpus.add(
            file,
            format!("{name} twice"),
            bytes,
            "DuplicateColumn",
            1,
            good.0[0].len() as u64 + 1,
        );
    }
}

pub(super) fn drive(corpus: &mut Corpus) {
    let good = Table::of(&fs::read_to_string(logs().join("drive.csv")).unwrap());
    let text = ["segment"];
    let numbers: Vec<usize> = (0..good.0[0].len())
        .filter(|k| !text.contains(&good.0[0][*k].as_str()))
        .collect();
    rows(corpus, File::Drive, &good, &numbers);
    files(corpus, File::Drive, &good);
    let speeds = ["fl", "fr", "rl", "rr"].map(|w| format!("wheel_speed_{w}_rad_s"));
    let mut required: Vec<&str> = speeds.iter().map(String::as_str).collect();
    required.extend(["time_s", "ground_speed_m_s"]);
    header(corpus, File::Drive, &good, &required);

    let at = good.column("time_s");
    let column = at as u64 + 1;
    for row in good.rows() {
        let line = row as u64 + 1;
        for (name, cell) in [
            ("no time", ""),
            ("no time (NaN)", "nan"),
            ("endless time", "1e999"),
        ] {
            let bytes = good.with(|t| t[row][at] = cell.to_owned());
            corpus.add(
                File::Drive,
                format!("{name} in row {row}"),
                bytes,
                "MissingTime",
                line,
                column,
            );
        }
        let bytes = good.with(|t| t.insert(row, t[row].clone()));
        corpus.add(
            File::Drive,
            format!("row {row} twice"),
            bytes,
            "TimeNotIncreasing",
            line + 1,
            column,
        );
        if row > 1 {
            let bytes = good.with(|t| t.swap(row, row - 1));
            corpus.add(
                File::Drive,
                format!("rows {} and {row} swapped", row - 1),
                bytes,
                "TimeNotIncreasing",
                line,
                column,
            );
            let bytes = good.with(|t| t[row][at] = "-3600".to_owned());
            corpus.add(
                File::Drive,
                format!("the clock back an hour in row {row}"),
                bytes,
                "TimeNotIncreasing",
                line,
                column,
            );
        }
    }
}

pub(super) fn rig(corpus: &mut Corpus) {
    let good = Table::of(&fs::read_to_string(logs().join("rig.csv")).unwrap());
    let numbers: Vec<usize> = (0..good.0[0].len())
        .filter(|k| !["trial", "condition"].contains(&good.0[0][*k].as_str()))
        .collect();
    rows(corpus, File::Rig, &good, &numbers);
    files(corpus, File::Rig, &good);
    header(corpus, File::Rig, &good, &["normal_load_N"]);
    let pass = good.column("pass");
    for row in good.rows() {
        for (name, cell) in [("half a pass", "1.5"), ("pass 0", "0"), ("pass -1", "-1")] {
            let bytes = good.with(|t| t[row][pass] = cell.to_owned());
            corpus.add(
                File::Rig,
                format!("{name} in row {row}"),
                bytes,
                "BadValue",
                row as u64 + 1,
                pass as u64 + 1,
            );
        }
    }
}
