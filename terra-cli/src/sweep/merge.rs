//! Joins shards into the bytes of an unsharded run.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

use super::file::{bad, parse};
use crate::error::CliError;

/// All lines in the order of their runs.
///
/// # Errors
/// A file that cannot be read or is not finished, a line that is none of a sweep, a run that is there twice or not at
/// all.
pub(crate) fn merge(files: &[PathBuf]) -> Result<String, CliError> {
    let mut lines: BTreeMap<u64, (String, &PathBuf)> = BTreeMap::new();
    for path in files {
        if path.extension().is_some_and(|e| e == "partial") {
            return Err(CliError::data(
                format!("{}: this shard is not finished", path.display()),
                "run its `terra sweep` again: it goes on where it stopped",
            ));
        }
        let text = std::fs::read_to_string(path).map_err(|e| CliError::BadData {
            message: format!("{}: cannot be read: {e}", path.display()),
            help: None,
        })?;
        for (k, line) in text.split_inclusive('\n').enumerate() {
            if !line.ends_with('\n') {
                return Err(bad(
                    path,
                    k + 1,
                    line.chars().count() + 1,
                    "the last line is torn: this shard is not finished",
                ));
            }
            let run = parse(path, k + 1, line)?.get("run").and_then(Value::as_u64);
            let Some(run) = run else {
                return Err(bad(
                    path,
                    k + 1,
                    1,
                    "no 'run' in this line: not a file of a sweep",
                ));
            };
            if let Some((_, other)) = lines.insert(run, (line.to_owned(), path)) {
                return Err(bad(
                    path,
                    k + 1,
                    1,
                    format!("run {run} is also in {}", other.display()),
                ));
            }
        }
    }
    let mut out = String::new();
    for (expected, (run, (line, _))) in (0u64..).zip(&lines) {
        if *run != expected {
            return Err(CliError::data(
                format!("run {expected} is in none of the files"),
                "name all shards",
            ));
        }
        out.push_str(line);
    }
    Ok(out)
}
