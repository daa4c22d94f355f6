//! `terra challenge`: sealed blind cases, made, marked, opened.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::time::{Duration, SystemTime};

use serde_json::Value;
use terra_data::atomic_write;

use crate::args::{ChallengeMake, ChallengeScore};
use crate::challenge::{
    Challenge, Design, KeyFile, Library, Score, ScoreOptions, Shares, make, reveal, score,
};
use crate::error::CliError;
use crate::output::{self, table};
use crate::progress::Watch;

/// Every file of a challenge has this time, so that none tells how long its case took: the start of 2000.
const WRITTEN: Duration = Duration::from_secs(946_684_800);

pub(crate) fn run_make(args: &ChallengeMake, quiet: bool) -> Result<(), CliError> {
    let challenge = written(args, &Watch::shown(quiet))?;
    output::stdout(&made(args, &challenge))
}

/// Makes the cases and writes them, with their key.
pub(crate) fn written(args: &ChallengeMake, watch: &Watch) -> Result<Challenge, CliError> {
    let (out, key) = (resolve(&args.out), resolve(&args.key));
    if key.starts_with(&out) {
        return Err(CliError::usage(
            format!(
                "the key {} lies inside the challenge {}",
                args.key.display(),
                args.out.display()
            ),
            "put it where those who answer cannot read it",
        ));
    }
    output::claim(&[Some(&args.key)], &[])?;
    let shares = args
        .kinds
        .as_deref()
        .map_or(Ok(Shares::default()), Shares::parse)?;
    let design = Design::named(&args.design)?;
    let library = Library::builtin();
    let cases = args.cases as usize;

    let fail = |target: &Path| {
        let target = target.display().to_string();
        move |reason| CliError::Write { target, reason }
    };
    refuse_strangers(&out)?;
    // Made beside its place and moved there whole.
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    let part = out.with_file_name(name);
    if part.exists() {
        fs::remove_dir_all(&part).map_err(fail(&part))?;
    }
    fs::create_dir_all(&part).map_err(fail(&part))?;
    let bar = watch.bar(cases, "simulating");
    let put = |name: &str, bytes: &[u8]| -> Result<(), CliError> {
        let path = part.join(name);
        let write = || {
            let mut file = File::create(&path)?;
            file.write_all(bytes)?;
            file.set_modified(SystemTime::UNIX_EPOCH + WRITTEN)
        };
        write().map_err(fail(&path))
    };
    let made = make(
        &design,
        &library,
        shares,
        cases,
        args.seed,
        &|| bar.step(),
        &mut |case| {
            watch.go_on()?;
            put(&format!("{}.csv", case.name), &case.log)
        },
    )
    .and_then(|challenge| {
        put("rover.toml", challenge.rover.as_bytes())?;
        put("COMMIT.txt", challenge.commitment.as_bytes())?;
        Ok(challenge)
    });
    drop(bar);
    let challenge = match made {
        Ok(challenge) => challenge,
        Err(e) => {
            // The first error is the one to tell.
            let _ = fs::remove_dir_all(&part);
            return Err(e);
        }
    };
    let text = serde_json::to_value(&challenge.key)
        .map(|v| format!("{v:#}\n"))
        .unwrap_or_default();
    atomic_write(&args.key, |w| w.write_all(text.as_bytes()))?;
    if out.exists() {
        fs::remove_dir_all(&out).map_err(fail(&out))?;
    }
    fs::rename(&part, &out).map_err(fail(&out))?;
    Ok(challenge)
}

/// What was made, in a line or two.
pub(crate) fn made(args: &ChallengeMake, challenge: &Challenge) -> String {
    let kinds: Vec<String> = challenge
        .counts
        .iter()
        .filter(|(_, n)| *n > 0)
        .map(|(kind, n)| format!("{n} {kind}"))
        .collect();
    let mut said = format!(
        "{} cases ({}) in {}, key in {}\n",
        args.cases,
        kinds.join(", "),
        args.out.display(),
        args.key.display()
    );
    if !challenge.not_carried.is_empty() {
        said.push_str(&format!(
            "not drawn, as this design cannot show them: {}\n",
            challenge.not_carried.join(", ")
        ));
    }
    said
}

/// An existing folder is replaced when it is a challenge or empty, and left alone otherwise.
fn refuse_strangers(out: &Path) -> Result<(), CliError> {
    let Ok(entries) = fs::read_dir(out) else {
        if out.exists() {
            return Err(CliError::Write {
                target: out.display().to_string(),
                reason: std::io::ErrorKind::NotADirectory.into(),
            });
        }
        return Ok(());
    };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let ours = matches!(name.as_str(), "COMMIT.txt" | "rover.toml")
            || (name.starts_with("case_") && name.ends_with(".csv"));
        if !ours {
            return Err(CliError::Write {
                target: out.display().to_string(),
                reason: std::io::Error::new(
                    std::io::ErrorKind::AlreadyExists,
                    format!("it holds {name}, which is no part of a challenge"),
                ),
            });
        }
    }
    Ok(())
}

/// Where a path leads, whether it exists or not: links of what exists are followed, `..` of the rest is taken away.
fn resolve(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut out = PathBuf::new();
    for part in absolute.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            other => out.push(other),
        }
        if let Ok(real) = out.canonicalize() {
            out = real;
        }
    }
    out
}

pub(crate) fn run_reveal(key: &Path, folder: &Path) -> Result<(), CliError> {
    let file = KeyFile::open(key)?;
    let answers = reveal(&file, folder)?;
    let rows: Vec<Vec<String>> = answers
        .iter()
        .map(|a| {
            let effects: Vec<String> = a
                .key
                .effects
                .iter()
                .map(|e| {
                    let form = if e.form == "default" {
                        String::new()
                    } else {
                        format!(" ({})", e.form)
                    };
                    format!("{} {}{form}", e.name, e.magnitude)
                })
                .collect();
            let terrain = match &a.key.terrain {
                Value::String(id) => id.clone(),
                other => other.to_string(),
            };
            vec![
                a.case.clone(),
                a.key.kind.clone(),
                effects.join(" + "),
                terrain,
                a.key.seed.to_string(),
            ]
        })
        .collect();
    let head = ["case", "kind", "effects", "around terrain", "seed"];
    output::stdout(&format!(
        "{}{} commitments hold\n",
        table(&head, &rows),
        answers.len()
    ))
}

pub(crate) fn run_score(args: &ChallengeScore, quiet: bool) -> Result<(), CliError> {
    output::claim(&[args.json.as_deref()], &[&args.key])?;
    let watch = Watch::shown(quiet);
    let score = marked(&args.key, &args.verdicts, !args.skip_closing, &watch)?;
    if args.json.is_some() {
        output::json(args.json.as_deref(), &score.to_json())?;
    }
    output::stdout(&score.summary())
}

/// Marks the verdicts of a folder against a key file.
pub(crate) fn marked(
    key: &Path,
    verdicts: &Path,
    closing: bool,
    watch: &Watch,
) -> Result<Score, CliError> {
    let key = KeyFile::open(key)?;
    let bar = watch.bar(key.cases.len(), "marking");
    score(&key, verdicts, &ScoreOptions { closing }, &|| bar.step())
}
