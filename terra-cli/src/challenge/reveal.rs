//! Opens a challenge: do the answers match what was committed to?

use std::collections::BTreeMap;
use std::path::Path;

use super::key::{CaseKey, KeyFile, digest};
use crate::error::CliError;

/// The truth of one case.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Name of the case.
    pub case: String,
    /// What was withheld.
    pub key: CaseKey,
}

/// Checks each digest of `COMMIT.txt` against the key.
///
/// # Errors
/// Bad data naming the case: a digest that differs, a case on one side only, a line that is no commitment.
pub fn reveal(key: &KeyFile, folder: &Path) -> Result<Vec<Answer>, CliError> {
    let path = folder.join("COMMIT.txt");
    let bad = |line: usize, column: usize, message: String| CliError::BadData {
        message: format!("{}:{line}:{column}: {message}", path.display()),
        help: None,
    };
    let text = std::fs::read_to_string(&path).map_err(|e| CliError::BadData {
        message: format!("{}: cannot be read: {e}", path.display()),
        help: None,
    })?;
    let mut committed: BTreeMap<&str, (usize, &str)> = BTreeMap::new();
    for (k, line) in text.lines().enumerate() {
        let Some((case, hex)) = line.split_once(' ') else {
            return Err(bad(k + 1, 1, "expected a case and its digest".to_owned()));
        };
        if hex.len() != 64 || !hex.bytes().all(|b| b.is_ascii_hexdigit()) {
            let column = case.chars().count() + 2;
            return Err(bad(
                k + 1,
                column,
                format!("{case}: expected 64 hexadecimal digits"),
            ));
        }
        if committed.insert(case, (k + 1, hex)).is_some() {
            return Err(bad(k + 1, 1, format!("{case} is there twice")));
        }
    }
    let mut answers = vec![];
    for case in &key.cases {
        let Some((line, hex)) = committed.remove(case.case.as_str()) else {
            return Err(bad(
                1,
                1,
                format!("{} is in the key and was never committed to", case.case),
            ));
        };
        let found = digest(case);
        if !found.eq_ignore_ascii_case(hex) {
            return Err(bad(
                line,
                1,
                format!(
                    "{}: the key does not match its commitment: committed {hex}, the key gives {found}",
                    case.case
                ),
            ));
        }
        answers.push(Answer {
            case: case.case.clone(),
            key: case.read()?,
        });
    }
    if let Some((case, (line, _))) = committed.into_iter().next() {
        return Err(bad(
            line,
            1,
            format!("{case} was committed to and is not in the key"),
        ));
    }
    Ok(answers)
}
