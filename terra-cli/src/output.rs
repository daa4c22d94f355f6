//! Where results go: standard output or a file, whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;
use terra_data::atomic_write;

use crate::args::ReportArgs;
use crate::error::CliError;
use crate::report::Page;

/// Writes text to standard output. A closed pipe ends the command without an error.
pub(crate) fn stdout(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|e| match e.kind() {
            io::ErrorKind::BrokenPipe => CliError::PipeClosed,
            _ => CliError::Write {
                target: "standard output".to_owned(),
                reason: e,
            },
        })
}

/// Refuses outputs that cannot be, before any work is done for them: a folder in a file's place, a file in a missing
/// folder, one file for two results, a result in place of an input.
pub(crate) fn claim(outputs: &[Option<&Path>], inputs: &[&Path]) -> Result<(), CliError> {
    let mut taken: Vec<PathBuf> = vec![];
    for path in outputs.iter().copied().flatten() {
        let refused = |reason: io::Error| CliError::Write {
            target: path.display().to_string(),
            reason,
        };
        if path.is_dir() {
            return Err(refused(io::ErrorKind::IsADirectory.into()));
        }
        let place = place(path).map_err(refused)?;
        // A device or a pipe keeps nothing that could be overwritten.
        if path.exists() && !path.is_file() {
            continue;
        }
        if let Some(input) = inputs
            .iter()
            .find(|i| i.canonicalize().is_ok_and(|i| i == place))
        {
            return Err(CliError::usage(
                format!(
                    "{} would replace the input {}",
                    path.display(),
                    input.display()
                ),
                "name another file for the result",
            ));
        }
        if taken.contains(&place) {
            return Err(CliError::usage(
                format!("{} is named for two results", path.display()),
                "name a file for each",
            ));
        }
        taken.push(place);
    }
    Ok(())
}

/// As [`claim`], with the page and the folder of a report.
pub(crate) fn claim_with(
    report: &ReportArgs,
    outputs: &[Option<&Path>],
    inputs: &[&Path],
) -> Result<(), CliError> {
    let all: Vec<Option<&Path>> = outputs
        .iter()
        .copied()
        .chain([report.html.as_deref()])
        .collect();
    claim(&all, inputs)?;
    match &report.figures {
        Some(folder) => std::fs::create_dir_all(folder).map_err(|reason| CliError::Write {
            target: folder.display().to_string(),
            reason,
        }),
        None => Ok(()),
    }
}

/// Writes a report: its page, and its figures one by one, where they were asked for.
pub(crate) fn report(args: &ReportArgs, page: impl FnOnce() -> Page) -> Result<(), CliError> {
    if !args.asked() {
        return Ok(());
    }
    let page = page();
    if let Some(path) = &args.html {
        text(Some(path), &page.render()?)?;
    }
    if let Some(folder) = &args.figures {
        for figure in page.figures() {
            let file = |ending: &str| folder.join(format!("{}.{ending}", figure.name));
            text(Some(&file("svg")), &figure.svg)?;
            text(Some(&file("csv")), &figure.csv)?;
        }
    }
    Ok(())
}

/// The file a path means, whether it exists or not; its folder must.
fn place(path: &Path) -> io::Result<PathBuf> {
    if let Ok(place) = path.canonicalize() {
        return Ok(place);
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    Ok(folder
        .canonicalize()?
        .join(path.file_name().unwrap_or_default()))
}

/// Writes text to a file, atomically, or to standard output without one.
pub(crate) fn text(path: Option<&Path>, text: &str) -> Result<(), CliError> {
    match path {
        Some(path) => Ok(atomic_write(path, |w| w.write_all(text.as_bytes()))?),
        None => stdout(text),
    }
}

/// Writes a text piece by piece, as it comes, to a file, atomically, or to standard output without one. The function given
/// is called with what takes a piece.
pub(crate) fn pieces(
    path: Option<&Path>,
    write: impl FnOnce(&mut dyn FnMut(&str) -> Result<(), CliError>) -> Result<(), CliError>,
) -> Result<(), CliError> {
    let Some(path) = path else {
        return write(&mut stdout);
    };
    let mut failed = None;
    let done = atomic_write(path, |w| {
        let target = path.display().to_string();
        let mut put = |text: &str| {
            w.write_all(text.as_bytes())
                .map_err(|reason| CliError::Write {
                    target: target.clone(),
                    reason,
                })
        };
        write(&mut put).map_err(|e| match e {
            CliError::Write { reason, .. } => reason,
            other => {
                failed = Some(other);
                io::Error::other("there is no more to write")
            }
        })
    });
    match failed {
        Some(e) => Err(e),
        None => Ok(done?),
    }
}

/// Writes JSON with a newline at its end.
pub(crate) fn json(path: Option<&Path>, value: &Value) -> Result<(), CliError> {
    text(path, &format!("{value:#}\n"))
}

/// A plain table: columns as wide as their widest cell, two spaces between, the last column free.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let columns = header.len();
    let width = |c: usize| {
        rows.iter()
            .filter_map(|r| r.get(c))
            .map(|s| s.chars().count())
            .chain([header[c].chars().count()])
            .max()
    };
    let widths: Vec<usize> = (0..columns).map(|c| width(c).unwrap_or(0)).collect();
    let line = |cells: Vec<&str>| {
        let mut out = String::new();
        for (c, cell) in cells.iter().enumerate() {
            out.push_str(cell);
            if c + 1 < columns {
                out.extend(std::iter::repeat_n(
                    ' ',
                    widths[c] + 2 - cell.chars().count(),
                ));
            }
        }
        out.truncate(out.trim_end().len());
        out.push('\n');
        out
    };
    let mut out = line(header.to_vec());
    out.push_str(&line(
        widths
            .iter()
            .map(|w| &DASHES[..(*w).min(DASHES.len())])
            .collect(),
    ));
    for row in rows {
        out.push_str(&line(row.iter().map(String::as_str).collect()));
    }
    out
}

const DASHES: &str =
    "--------------------------------------------------------------------------------";

/// A number for people: four significant digits.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let magnitude = x.abs().log10().floor();
    if (-3.0..5.0).contains(&magnitude) {
        let decimals = (3.0 - magnitude).max(0.0) as usize;
        let text = format!("{x:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{x:.3e}")
    }
}

/// A number of a CSV file, or an empty cell for one that does not exist.
pub(crate) fn csv_number(x: f64) -> String {
    if x.is_finite() {
        x.to_string()
    } else {
        String::new()
    }
}

/// A text of a CSV file, in quotes where it needs them.
pub(crate) fn csv_text(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_keeps_four_digits() {
        assert_eq!(short(0.123_456), "0.1235");
        assert_eq!(short(-28.2), "-28.2");
        assert_eq!(short(1_528_430.0), "1.528e6");
        assert_eq!(short(2452.7), "2453");
    }

    #[test]
    fn tables_line_up() {
        assert_eq!(
            table(&["a", "bb"], &[vec!["long".into(), "x".into()]]),
            "a     bb\n----  --\nlong  x\n"
        );
    }
}
