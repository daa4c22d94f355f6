//! Rover files and scenarios gone wrong, key by key.

use std::fs;

use terra::data::parse_rover;
use terra::sim::Scenario;

use super::{Corpus, File};
use crate::support::example;

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

pub(super) fn rover(corpus: &mut Corpus) {
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

pub(super) fn scenario(corpus: &mut Corpus) {
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
