//! Bad input ends with the promised status, names the place and what was expected, and leaves no trace.
//!
//! The cases are in `cases.rs`, a line or two each; here is how one is run.

use std::fs;
use std::path::{Path, PathBuf};

use crate::cases::{Case, DRIVE_LOGS, LINES, RIG_LOGS, RIGS, ROVERS, SCENARIOS};
use crate::support::{contents, folder, logs, terra};

/// A folder with the first rows of the simulated logs, their rovers and scenarios, which a case spoils.
pub(crate) struct Spoil(PathBuf);

impl Spoil {
    fn new(name: &str) -> Self {
        let path = folder(name);
        for (file, bytes) in contents(logs()) {
            let text = String::from_utf8(bytes).unwrap();
            let rows = if file.ends_with(".csv") {
                61
            } else {
                usize::MAX
            };
            let first: Vec<_> = text.lines().take(rows).collect();
            fs::write(path.join(file), first.join("\n") + "\n").unwrap();
        }
        Spoil(path)
    }

    fn read(&self, file: &str) -> String {
        fs::read_to_string(self.0.join(file)).unwrap()
    }

    /// Other content altogether.
    pub(crate) fn put(&self, file: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.0.join(file), bytes).unwrap();
    }

    /// Another text in place of one that must be there.
    pub(crate) fn swap(&self, file: &str, from: &str, to: &str) {
        let text = self.read(file);
        assert!(text.contains(from), "{file} has no {from:?}");
        self.put(file, text.replacen(from, to, 1));
    }

    /// Another cell, line and column from 1.
    pub(crate) fn cell(&self, file: &str, line: usize, column: usize, to: &str) {
        let text = self.read(file);
        let mut rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
        rows[line - 1][column - 1] = to;
        let lines: Vec<_> = rows.iter().map(|r| r.join(",")).collect();
        self.put(file, lines.join("\n") + "\n");
    }

    /// The first lines only.
    pub(crate) fn keep(&self, file: &str, lines: usize) {
        let text = self.read(file);
        let first: Vec<_> = text.lines().take(lines).collect();
        self.put(file, first.join("\n") + "\n");
    }

    /// The same file in other bytes.
    pub(crate) fn encode(&self, file: &str, bytes: fn(&str) -> Vec<u8>) {
        self.put(file, bytes(&self.read(file)));
    }

    pub(crate) fn remove(&self, file: &str) {
        fs::remove_file(self.0.join(file)).unwrap();
    }

    pub(crate) fn folder(&self, name: &str) {
        fs::create_dir(self.0.join(name)).unwrap();
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

/// Runs one command line in a spoiled folder, with and without old results in the places of the new ones.
fn check(name: &str, line: &str, case: &Case, complaints: &mut Vec<String>) {
    for old in [true, false] {
        let spoiled = Spoil::new(name);
        (case.spoil)(&spoiled);
        if old {
            for file in ["out.csv", "truth.csv", "out.json", "out.html"] {
                spoiled.put(file, "old");
            }
        }
        let before = contents(spoiled.path());
        let done = terra(spoiled.path(), line);
        let mut found = vec![];
        let mut complain = |what: String| found.push(what);
        if done.code != case.code {
            complain(format!(
                "status {}, expected {}: {}",
                done.code, case.code, done.err
            ));
        }
        // Where the message is wrapped is of no interest.
        let said = done.err.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in case.says.split('|').filter(|w| !w.is_empty()) {
            if !said.contains(word) {
                complain(format!("{word:?} is not in {said:?}"));
            }
        }
        if done.err.lines().count() > 40 {
            complain(format!("{} lines of complaint", done.err.lines().count()));
        }
        let after = contents(spoiled.path());
        for file in before.keys().chain(after.keys()) {
            if before.get(file) != after.get(file) {
                complain(format!("{file} was made, changed or removed"));
            }
        }
        if !found.is_empty() {
            found.dedup();
            let old = if old {
                "old results there"
            } else {
                "no old results"
            };
            complaints.push(format!(
                "terra {line}\n  {}, {old}: {}",
                case.what,
                found.join("\n    ")
            ));
            return;
        }
    }
}

/// Every case of a table with every command line that reads the file it spoils.
fn check_all(name: &str, cases: &[Case], lines: &[&str]) {
    let mut complaints = vec![];
    for case in cases {
        for line in lines {
            check(name, line, case, &mut complaints);
        }
    }
    assert!(
        complaints.is_empty(),
        "{} complaints:\n{}",
        complaints.len(),
        complaints.join("\n")
    );
}

#[test]
fn bad_drive_logs() {
    let estimate = "estimate drive.csv --rover rover.toml --out out.csv";
    let identify = "identify drive.csv --rover rover.toml --json out.json --html out.html";
    let gap = "gap drive.csv --rover rover.toml --json out.json --html out.html";
    check_all("bad_drive_logs", DRIVE_LOGS, &[estimate, identify, gap]);
}

#[test]
fn bad_rig_logs() {
    let identify = "identify rig.csv --rover rig.toml --json out.json --html out.html";
    check_all(
        "bad_rig_logs",
        RIG_LOGS,
        &[
            identify,
            "gap rig.csv --rover rig.toml --json out.json --html out.html",
        ],
    );
}

#[test]
fn bad_rovers() {
    let estimate = "estimate drive.csv --rover rover.toml --out out.csv";
    check_all(
        "bad_rovers",
        ROVERS,
        &[
            estimate,
            "identify drive.csv --rover rover.toml --json out.json",
        ],
    );
}

#[test]
fn bad_rigs() {
    let gap = "gap rig.csv --rover rig.toml --json out.json";
    check_all(
        "bad_rigs",
        RIGS,
        &[gap, "identify rig.csv --rover rig.toml --html out.html"],
    );
}

#[test]
fn bad_scenarios() {
    check_all(
        "bad_scenarios",
        SCENARIOS,
        &["simulate ramp.toml --out out.csv --truth truth.csv"],
    );
}

#[test]
fn bad_command_lines() {
    let mut complaints = vec![];
    for case in LINES {
        check("bad_command_lines", case.line, case, &mut complaints);
    }
    assert!(
        complaints.is_empty(),
        "{} complaints:\n{}",
        complaints.len(),
        complaints.join("\n")
    );
}
