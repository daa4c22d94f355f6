//! Running the command, folders to run it in, and reading what it wrote.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use serde_json::Value;

/// How a run of the command ended.
pub(crate) struct Done {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Done {
    /// The same, after the run is known to have gone well: status 0 and nothing on standard error.
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.err);
        assert_eq!(self.err, "");
        self
    }
}

/// The command in a folder, ready to be run. Backtraces are asked for, so that a panic cannot hide.
pub(crate) fn terra_in(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terra"));
    command
        .current_dir(folder)
        .env("RUST_BACKTRACE", "1")
        .stdin(Stdio::null());
    command
}

/// Runs it. A panic is a failure of the test whatever it asks for.
pub(crate) fn run<A: AsRef<OsStr>>(folder: &Path, args: impl IntoIterator<Item = A>) -> Done {
    finish(terra_in(folder).args(args))
}

/// Runs a command line without quoting.
pub(crate) fn terra(folder: &Path, line: &str) -> Done {
    run(folder, line.split_whitespace())
}

pub(crate) fn finish(command: &mut Command) -> Done {
    let label = format!("{command:?}");
    let output = command.output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    for word in ["panicked", "unwrap", "RUST_BACKTRACE", "stack backtrace"] {
        assert!(!err.contains(word), "{label}: {err}");
    }
    // No status: ended by a signal.
    let code = output.status.code().unwrap_or(-1);
    Done {
        code,
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err,
    }
}

/// An empty folder of that name, kept after the test for whoever wants to look.
pub(crate) fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("command")
        .join(name);
    if path.exists() {
        fs::remove_dir_all(&path).unwrap();
    }
    fs::create_dir_all(&path).unwrap();
    path
}

/// The examples as they ship.
pub(crate) fn example(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples")
        .join(file)
}

/// A folder with the paper's drive on lean clay and the rig with slip-sinkage, scenarios and logs, simulated once:
/// `rover.toml`, `ramp.toml`, `drive.csv`, `drive_truth.csv`, `rig.toml`, `trials.toml`, `rig.csv`, `rig_truth.csv`.
pub(crate) fn logs() -> &'static Path {
    static LOGS: OnceLock<PathBuf> = OnceLock::new();
    LOGS.get_or_init(|| {
        let to = folder("logs");
        for (from, name) in [
            ("paper/rover.toml", "rover.toml"),
            ("paper/lean_clay.toml", "ramp.toml"),
            ("rig/rig.toml", "rig.toml"),
            ("rig/slip_sinkage.toml", "trials.toml"),
        ] {
            fs::copy(example(from), to.join(name)).unwrap();
        }
        terra(
            &to,
            "simulate ramp.toml --out drive.csv --truth drive_truth.csv",
        )
        .ok();
        terra(
            &to,
            "simulate trials.toml --out rig.csv --truth rig_truth.csv",
        )
        .ok();
        to
    })
}

/// What lies in a folder, by name, with its bytes.
pub(crate) fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap());
    entries
        .filter(|e| e.file_type().unwrap().is_file())
        .map(|e| {
            (
                e.file_name().to_string_lossy().into_owned(),
                fs::read(e.path()).unwrap_or_default(),
            )
        })
        .collect()
}

/// A JSON file.
pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

pub(crate) fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("{v} is no number"))
}

pub(crate) fn text(v: &Value) -> &str {
    v.as_str().unwrap_or_else(|| panic!("{v} is no text"))
}

pub(crate) fn list(v: &Value) -> &[Value] {
    v.as_array().unwrap_or_else(|| panic!("{v} is no list"))
}

/// A table without quotes.
#[derive(Clone)]
pub(crate) struct Csv {
    pub(crate) header: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Csv {
    pub(crate) fn at(&self, column: &str) -> usize {
        self.header.iter().position(|h| h == column).unwrap()
    }

    /// One column changed value by value.
    pub(crate) fn with(mut self, column: &str, change: impl Fn(f64) -> f64) -> Self {
        let k = self.at(column);
        for row in &mut self.rows {
            row[k] = change(row[k].parse().unwrap()).to_string();
        }
        self
    }

    /// Two columns in each other's place.
    pub(crate) fn swapped(mut self, one: &str, other: &str) -> Self {
        let (a, b) = (self.at(one), self.at(other));
        self.rows.iter_mut().for_each(|row| row.swap(a, b));
        self
    }

    pub(crate) fn without(mut self, column: &str) -> Self {
        let k = self.at(column);
        self.header.remove(k);
        for row in &mut self.rows {
            row.remove(k);
        }
        self
    }

    pub(crate) fn write(&self, to: &Path) {
        let rows: Vec<String> = self.rows.iter().map(|r| r.join(",")).collect();
        fs::write(
            to,
            format!("{}\n{}\n", self.header.join(","), rows.join("\n")),
        )
        .unwrap();
    }
}

impl Csv {
    pub(crate) fn read(path: &Path) -> Self {
        Csv::parse(&fs::read_to_string(path).unwrap())
    }

    pub(crate) fn parse(text: &str) -> Self {
        assert!(text.ends_with('\n'), "the last line has no end");
        let mut lines = text
            .lines()
            .map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let rows: Vec<_> = lines.collect();
        assert!(rows.iter().all(|r| r.len() == header.len()), "ragged rows");
        for bad in ["nan", "inf"] {
            assert!(
                rows.iter()
                    .flatten()
                    .all(|c| !c.to_lowercase().starts_with(bad)),
                "{bad} in a table"
            );
        }
        Csv { header, rows }
    }

    pub(crate) fn text(&self, column: &str) -> Vec<&str> {
        let k = self.header.iter().position(|h| h == column);
        let k = k.unwrap_or_else(|| panic!("no column {column} in {:?}", self.header));
        self.rows.iter().map(|r| r[k].as_str()).collect()
    }

    /// Missing cells are none.
    pub(crate) fn numbers(&self, column: &str) -> Vec<Option<f64>> {
        let parse = |c: &&str| (!c.is_empty()).then(|| c.parse().unwrap());
        self.text(column).iter().map(parse).collect()
    }

    pub(crate) fn full(&self, column: &str) -> Vec<f64> {
        self.numbers(column)
            .into_iter()
            .map(|x| x.unwrap())
            .collect()
    }
}
