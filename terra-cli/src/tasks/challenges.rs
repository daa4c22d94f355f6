//! Sealed blind cases: made, diagnosed, marked, opened.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::within;
use crate::args::ChallengeMake;
use crate::challenge::{KeyFile, reveal};
use crate::commands::{challenge as sealing, challenge_run as answering};
use crate::error::CliError;
use crate::progress::{Stop, Watch};

/// What is asked of [`challenge_make`].
#[derive(Clone, Debug)]
pub struct ChallengeOptions {
    /// `ramp`, `steps`, `flat`, `rich`, `rig`, or a scenario file.
    pub design: String,
    /// Number of cases, 1 to 100 000.
    pub cases: usize,
    /// Seed of everything that is drawn; a secret.
    pub seed: u64,
    /// Folder for the logs, the rover file and the commitments.
    pub out: PathBuf,
    /// Key file to write, outside that folder.
    pub key: PathBuf,
    /// Shares of the kinds of cases by name; the command's when absent.
    pub kinds: Option<Vec<(String, f64)>>,
}

/// `terra challenge make`: writes the challenge and its key; how many `cases` of which `kinds`, and which effects were
/// `not_carried`.
///
/// # Errors
/// As the command.
pub fn challenge_make(options: &ChallengeOptions, stop: &Stop) -> Result<Value, CliError> {
    within("cases", options.cases, 1, 100_000)?;
    let shares = |kinds: &Vec<(String, f64)>| {
        let all = kinds.iter().map(|(kind, share)| format!("{kind}={share}"));
        all.collect::<Vec<_>>().join(",")
    };
    let made = sealing::written(
        &ChallengeMake {
            design: options.design.clone(),
            cases: u32::try_from(options.cases).unwrap_or(u32::MAX),
            seed: options.seed,
            out: options.out.clone(),
            key: options.key.clone(),
            kinds: options.kinds.as_ref().map(shares),
        },
        &Watch::silent(stop),
    )?;
    let counts = made.counts.iter();
    let counts = counts.map(|(kind, n)| (kind.name().to_owned(), json!(n)));
    Ok(json!({
        "cases": options.cases,
        "kinds": counts.collect::<Map<String, Value>>(),
        "not_carried": made.not_carried,
    }))
}

/// `terra challenge run`: a verdict of every log of a challenge in a folder; how many `cases`, how many verdicts were
/// `kept`, how often each of the `verdicts` was given, how many cases `failed`, and why the `first_failure` did.
///
/// # Errors
/// As the command.
pub fn challenge_run(folder: &Path, out: &Path, stop: &Stop) -> Result<Value, CliError> {
    let done = answering::diagnose_all(folder, out, &|_| Some(None), &Watch::silent(stop))?;
    Ok(json!({
        "cases": done.cases,
        "kept": done.kept,
        "verdicts": done.verdicts,
        "failed": done.failed,
        "first_failure": done.first.map(|e| e.to_string()),
    }))
}

/// `terra challenge score --json`: verdicts marked against the key. `closing` simulates the cases again, to see how far the
/// gap truly closed.
///
/// # Errors
/// As the command.
pub fn challenge_score(verdicts: &Path, key: &Path, closing: bool) -> Result<Value, CliError> {
    let watch = Watch::silent(&Stop::default());
    Ok(sealing::marked(key, verdicts, closing, &watch)?.to_json())
}

/// `terra challenge reveal`: every commitment checked, and of each `case` what the key holds.
///
/// # Errors
/// As the command.
pub fn challenge_reveal(key: &Path, folder: &Path) -> Result<Value, CliError> {
    let answers = reveal(&KeyFile::open(key)?, folder)?;
    let all = answers.iter().map(|answer| {
        let mut one = Map::from_iter([("case".to_owned(), json!(answer.case))]);
        if let Value::Object(key) = json!(answer.key) {
            one.extend(key);
        }
        Value::Object(one)
    });
    Ok(all.collect())
}
