//! The lines of a sweep on disk: whole ones are kept, a torn one at the end is not.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;
use terra_data::atomic_write;

use super::plan::Plan;
use crate::error::CliError;

/// Bad data at a place of a file of lines.
pub(crate) fn bad(
    path: &Path,
    line: usize,
    column: usize,
    message: impl std::fmt::Display,
) -> CliError {
    CliError::BadData {
        message: format!("{}:{line}:{column}: {message}", path.display()),
        help: None,
    }
}

/// A line as JSON.
pub(crate) fn parse(path: &Path, number: usize, line: &str) -> Result<Value, CliError> {
    serde_json::from_str(line).map_err(|e| {
        let what = e.to_string();
        let what = what.split(" at line ").next().unwrap_or(&what).to_owned();
        let message = format!("is no line that `terra sweep` wrote: {what}");
        bad(path, number, e.column().max(1), message)
    })
}

/// The text of a file; none when there is no such file.
fn text(path: &Path) -> Result<Option<String>, CliError> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(CliError::BadData {
            message: format!("{}: cannot be read: {e}", path.display()),
            help: None,
        }),
    }
}

/// How many runs of a plan's shard a file already holds, and their bytes.
///
/// # Errors
/// A whole line that is another plan's, or none of a sweep.
fn finished(
    path: &Path,
    text: &str,
    plan: &Plan,
    runs: &[u64],
) -> Result<(usize, usize), CliError> {
    let (mut count, mut bytes) = (0, 0);
    for line in text.split_inclusive('\n') {
        // Torn by an interrupt: this run is done again.
        if !line.ends_with('\n') {
            break;
        }
        let number = count + 1;
        let found = parse(path, number, line)?;
        let Some(&run) = runs.get(count) else {
            return Err(bad(
                path,
                number,
                1,
                format!(
                    "the plan has {} runs here, and this is one more",
                    runs.len()
                ),
            ));
        };
        let (seed, vary) = plan.label(run);
        let same = found.get("run").and_then(Value::as_u64) == Some(run)
            && found.get("seed").and_then(Value::as_u64) == Some(seed)
            && found.get("vary") == Some(&vary);
        if !same {
            return Err(bad(
                path,
                number,
                1,
                format!(
                    "not run {run} of this plan with seed {seed} at {vary}: the file belongs to another plan or shard"
                ),
            ));
        }
        count += 1;
        bytes += line.len();
    }
    Ok((count, bytes))
}

/// A sweep's file while it grows, with `.partial` at its name's end.
pub(crate) struct Growing {
    out: PathBuf,
    part: PathBuf,
    file: Option<File>,
    /// Runs it holds already.
    pub(crate) done: usize,
}

impl Growing {
    /// Opens the file of a shard where it stopped.
    ///
    /// # Errors
    /// A file of another plan; one that cannot be written.
    pub(crate) fn open(out: &Path, plan: &Plan, runs: &[u64]) -> Result<Self, CliError> {
        let mut name = out.file_name().unwrap_or_default().to_owned();
        name.push(".partial");
        let part = out.with_file_name(name);
        let mut growing = Growing {
            out: out.to_owned(),
            part,
            file: None,
            done: 0,
        };
        let whole = text(out)?;
        let of_whole = match &whole {
            Some(text) => finished(out, text, plan, runs)?,
            None => (0, 0),
        };
        if whole.is_some() && of_whole.0 == runs.len() {
            growing.done = runs.len();
            return Ok(growing);
        }
        let torn = text(&growing.part)?;
        let of_torn = match &torn {
            Some(text) => finished(&growing.part, text, plan, runs)?,
            None => (0, 0),
        };
        let (kept, (done, bytes)) = if of_torn.0 >= of_whole.0 {
            (torn, of_torn)
        } else {
            (whole.clone(), of_whole)
        };
        let kept = kept.unwrap_or_default();
        let kept = kept.get(..bytes).unwrap_or_default();
        atomic_write(&growing.part, |w| w.write_all(kept.as_bytes()))?;
        if whole.is_some() {
            fs::remove_file(out).map_err(|reason| growing.failed(reason))?;
        }
        let file = OpenOptions::new()
            .append(true)
            .open(&growing.part)
            .map_err(|reason| growing.failed(reason))?;
        growing.file = Some(file);
        growing.done = done;
        Ok(growing)
    }

    fn failed(&self, reason: io::Error) -> CliError {
        CliError::Write {
            target: self.part.display().to_string(),
            reason,
        }
    }

    /// Appends whole lines in one piece.
    ///
    /// # Errors
    /// The system's refusal.
    pub(crate) fn append(&mut self, lines: &str) -> Result<(), CliError> {
        let outcome = match &mut self.file {
            Some(file) => file
                .write_all(lines.as_bytes())
                .and_then(|()| file.sync_data()),
            None => Ok(()),
        };
        outcome.map_err(|reason| self.failed(reason))
    }

    /// A run could not be made at all: what is there stays, an empty file does not.
    pub(crate) fn give_up(self) {
        if fs::metadata(&self.part).is_ok_and(|about| about.len() == 0) {
            // The error that led here is the one to tell.
            let _ = fs::remove_file(&self.part);
        }
    }

    /// All runs are there: the file gets its name.
    ///
    /// # Errors
    /// The system's refusal.
    pub(crate) fn finish(self) -> Result<(), CliError> {
        if self.file.is_some() {
            fs::rename(&self.part, &self.out).map_err(|reason| self.failed(reason))?;
        } else if self.part.exists() {
            // Left over from before the whole file was there.
            fs::remove_file(&self.part).map_err(|reason| self.failed(reason))?;
        }
        Ok(())
    }
}
