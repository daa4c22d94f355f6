//! A corpus of bad files, made from good ones by named mutations: each mutation knows where it struck, so it knows which
//! error, line and column a reader owes. Every file must be answered exactly.

use std::collections::BTreeMap;
use std::fs;

use terra::data::{
    DataError, LogKind, parse_rover, read_drive_log_from, read_rig_log_from, read_rover,
};
use terra::sim::{Scenario, SimError};

use crate::support::logs;

mod tables;
mod tomls;

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

fn corpus() -> Corpus {
    let mut corpus = Corpus::default();
    tables::drive(&mut corpus);
    tables::rig(&mut corpus);
    tomls::rover(&mut corpus);
    tomls::scenario(&mut corpus);
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
