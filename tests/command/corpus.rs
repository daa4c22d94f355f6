//! A corpus of bad files, made from good ones by named mutations: each mutation knows where it struck, so it knows which
//! error, line and column a reader owes. Every file must be answered exactly.

use std::collections::BTreeMap;
use std::fs;

use terra::data::{
    DataError, LogKind, parse_rover, read_drive_log_from, read_rig_log_from, read_rover,
};
use terra::sim::{Scenario, SimError};

use crate::support::{example, logs};

/// What is read how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum File {
    Drive,
    Rig,
    Rover,
    Scenario,
}

/// A bad file with the error it must give: kind, line, column.
struct Bad {
    file: File,
    mutation: String,
    bytes: Vec<u8>,
    kind: &'static str,
    line: Option<u64>,
    column: Option<u64>,
}

#[derive(Default)]
struct Corpus(Vec<Bad>);

impl Corpus {
    fn add(
        &mut self,
        file: File,
        mutation: impl Into<String>,
        bytes: impl Into<Vec<u8>>,
        kind: &'static str,
        line: impl Into<Option<u64>>,
        column: impl Into<Option<u64>>,
    ) {
        self.0.push(Bad {
            file,
            mutation: mutation.into(),
            bytes: bytes.into(),
            kind,
            line: line.into(),
            column: column.into(),
        });
    }
}

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

fn drive(corpus: &mut Corpus) {
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

fn rig(corpus: &mut Corpus) {
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

/// A line `key = number` of a TOML file: its table's line, its own (both from 1), the key, where the value begins.
struct Key<'t> {
    table: u64,
    line: u64,
    key: &'t str,
    value: u64,
}

fn keys(text: &str) -> Vec<Key<'_>> {
    let mut table = 1;
    let mut out = vec![];
    for (k, line) in text.lines().enumerate() {
        let here = k as u64 + 1;
        if line.starts_with('[') {
            table = here;
        }
        if let Some((key, value)) = line.split_once(" = ")
            && value.parse::<f64>().is_ok()
            && !key.starts_with('#')
        {
            out.push(Key {
                table,
                line: here,
                key,
                value: key.len() as u64 + 4,
            });
        }
    }
    out
}

/// The text with one line replaced; none takes it out.
fn with_line(text: &str, line: u64, new: Option<String>) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let at = line as usize - 1;
    match new {
        Some(new) => lines[at] = new,
        None => drop(lines.remove(at)),
    }
    lines.join("\n") + "\n"
}

fn rover(corpus: &mut Corpus) {
    for name in ["paper/rover.toml", "drive/rover.toml"] {
        let text = fs::read_to_string(example(name)).unwrap();
        parse_rover(&text, name).unwrap();
        let noise = text.lines().position(|l| l == "[noise]").unwrap() as u64 + 1;
        for Key {
            table,
            line,
            key,
            value,
        } in keys(&text)
        {
            let changed = |new: Option<String>| with_line(&text, line, new);
            let mut put = |what: &str, new: Option<String>, kind, line: u64, column: u64| {
                corpus.add(
                    File::Rover,
                    format!("{name}: {key} {what}"),
                    changed(new),
                    kind,
                    line,
                    column,
                );
            };
            put(
                "as text",
                Some(format!("{key} = \"1\"")),
                "WrongType",
                line,
                value,
            );
            put(
                "as a list",
                Some(format!("{key} = [1.0]")),
                "WrongType",
                line,
                value,
            );
            put(
                "not a number",
                Some(format!("{key} = nan")),
                "NotFinite",
                line,
                value,
            );
            put(
                "endless",
                Some(format!("{key} = -inf")),
                "NotFinite",
                line,
                value,
            );
            put(
                "twice",
                Some(format!("{key} = 1\n{key} = 1")),
                "Syntax",
                line + 1,
                1,
            );
            let length = ["mass", "inertia", "track", "wheelbase", "radius", "width"];
            if length.iter().any(|w| key.contains(w)) {
                put(
                    "negative",
                    Some(format!("{key} = -1.0")),
                    "OutOfRange",
                    line,
                    value,
                );
            }
            if table < noise {
                put(
                    "misspelt",
                    Some(format!("{key}x = 1.0")),
                    "UnknownKey",
                    line,
                    1,
                );
                // The table that lacks it, behind its bracket.
                put("gone", None, "MissingKey", table, 2);
            }
        }
    }
}

fn scenario(corpus: &mut Corpus) {
    for name in [
        "paper/lean_clay.toml",
        "paper/dry_sand.toml",
        "rig/slip_sinkage.toml",
    ] {
        let text = fs::read_to_string(example(name)).unwrap();
        Scenario::parse(&text, name).unwrap();
        for Key {
            line, key, value, ..
        } in keys(&text)
        {
            let changed = |new: &str| with_line(&text, line, Some(new.to_owned()));
            let mut put = |what: &str, new: String, kind, line: u64, column: u64| {
                corpus.add(
                    File::Scenario,
                    format!("{name}: {key} {what}"),
                    changed(&new),
                    kind,
                    line,
                    column,
                );
            };
            put("as text", format!("{key} = \"1\""), "expected", line, value);
            put("true", format!("{key} = true"), "expected", line, value);
            put("misspelt", format!("{key}x = 1"), "unknown key", line, 1);
            put(
                "twice",
                format!("{key} = 1\n{key} = 1"),
                "duplicate key",
                line + 1,
                1,
            );
            put("without a value", format!("{key} ="), "", line, value - 1);
        }
        for (line, text_line) in text.lines().enumerate() {
            let (line, Some((key, _))) = (line as u64 + 1, text_line.split_once(" = \"")) else {
                continue;
            };
            let bytes = with_line(&text, line, Some(format!("{key} = 3")));
            corpus.add(
                File::Scenario,
                format!("{name}: {key} as a number"),
                bytes,
                "expected",
                line,
                key.len() as u64 + 4,
            );
            let bytes = with_line(&text, line, Some(format!("{key} = \"open")));
            corpus.add(
                File::Scenario,
                format!("{name}: {key} never closed"),
                bytes,
                "",
                line,
                None,
            );
        }
        // What must be there, at the top of the file.
        for key in ["seed", "rover", "terrain"] {
            let line = text
                .lines()
                .position(|l| l.starts_with(&format!("{key} = ")))
                .unwrap();
            let bytes = with_line(&text, line as u64 + 1, None);
            corpus.add(
                File::Scenario,
                format!("{name}: no {key}"),
                bytes,
                "missing key",
                1,
                1,
            );
        }
    }
}

fn corpus() -> Corpus {
    let mut corpus = Corpus::default();
    drive(&mut corpus);
    rig(&mut corpus);
    rover(&mut corpus);
    scenario(&mut corpus);
    corpus
}

/// Kind, line, column and text of the error of a file, if there is one.
fn answer(bad: &Bad) -> Result<(), (String, Option<u64>, Option<u64>, String)> {
    let told = |e: DataError| {
        let kind = format!("{:?}", e.problem());
        let kind = kind.split([' ', '(', '{']).next().unwrap().to_owned();
        (kind, e.line(), e.column(), e.to_string())
    };
    let nominal = |file: &str| read_rover(logs().join(file)).unwrap();
    let bytes = bad.bytes.as_slice();
    let text = || std::str::from_utf8(bytes).unwrap();
    match bad.file {
        File::Drive => read_drive_log_from(bytes, "bad.csv", &nominal("rover.toml"))
            .map(drop)
            .map_err(told),
        File::Rig => read_rig_log_from(bytes, "bad.csv", &nominal("rig.toml"))
            .map(drop)
            .map_err(told),
        File::Rover => parse_rover(text(), "bad.toml").map(drop).map_err(told),
        File::Scenario => Scenario::parse(text(), "bad.toml")
            .map(drop)
            .map_err(|e| match e {
                SimError::Scenario(e) => (
                    e.message.clone(),
                    Some(e.line as u64),
                    Some(e.column as u64),
                    e.to_string(),
                ),
                other => (other.to_string(), None, None, other.to_string()),
            }),
    }
}

#[test]
fn every_bad_file_gets_its_error_line_and_column() {
    // The files the corpus is made from are good.
    let read = |file: &str| fs::read(logs().join(file)).unwrap();
    read_drive_log_from(
        read("drive.csv").as_slice(),
        "good",
        &read_rover(logs().join("rover.toml")).unwrap(),
    )
    .unwrap();
    read_rig_log_from(
        read("rig.csv").as_slice(),
        "good",
        &read_rover(logs().join("rig.toml")).unwrap(),
    )
    .unwrap();
    assert_eq!(LogKind::Drive.words(), "drive log");

    let corpus = corpus();
    let mut counts: BTreeMap<File, usize> = BTreeMap::new();
    let mut wrong = vec![];
    for bad in &corpus.0 {
        *counts.entry(bad.file).or_default() += 1;
        let name = format!("{:?}: {}", bad.file, bad.mutation);
        let expected = (bad.kind, bad.line, bad.column);
        match answer(bad) {
            Ok(()) => wrong.push(format!("{name}: no error, expected {expected:?}")),
            Err((kind, line, column, text)) => {
                let same_kind = match bad.file {
                    // A scenario's errors have no kinds but words.
                    File::Scenario => kind.contains(bad.kind),
                    _ => kind == bad.kind,
                };
                let same_column =
                    bad.file == File::Scenario && bad.column.is_none() || column == bad.column;
                if !same_kind || line != bad.line || !same_column {
                    wrong.push(format!(
                        "{name}: expected {expected:?}, found {line:?} {column:?}: {text}"
                    ));
                }
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {} ({counts:?}):\n{}",
        wrong.len(),
        corpus.0.len(),
        wrong.join("\n")
    );
    assert!(corpus.0.len() >= 200, "{counts:?}");
    assert!(
        counts.len() == 4 && counts.values().all(|n| *n >= 40),
        "{counts:?}"
    );
}
