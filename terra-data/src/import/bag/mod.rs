//! MCAP bags of ROS 2: topics to the columns of a drive log, by a map that says which field of which topic each column is
//! and how channels of different rates meet in one row.
//!
//! The bag is read once, front to back; only the samples of mapped fields are kept, so its size does not matter.

mod cdr;
mod definition;
mod map;
mod path;
mod resample;
mod stream;

use std::path::Path;

use crate::error::{DataError, Origin};
use crate::import::{Cell, ImportedLog, guarded};
use crate::names::nearest;
use crate::problem::Problem;
use crate::source::{open, read_text};
use map::{Column, Map, Rows};
use resample::{Method, sample, text_at};
use stream::{Samples, Topic};

/// Most rows of a log made at a fixed rate, where that is more than [`MOST_ROWS_A_MESSAGE`] asks for.
const MOST_ROWS: usize = 100_000;
/// Most rows to one message: more come of a clock that jumps, not of a log, and would fill the memory.
const MOST_ROWS_A_MESSAGE: usize = 100;

/// Imports an MCAP bag by a topic map (TOML).
///
/// # Errors
/// [`DataError::Configuration`] with line and column: the map. [`DataError::Data`]: the bag cannot be read, a topic or a
/// field is not there, time goes back.
pub fn import_mcap(bag: impl AsRef<Path>, map: impl AsRef<Path>) -> Result<ImportedLog, DataError> {
    let (bag, map) = (bag.as_ref(), map.as_ref());
    let origin = Origin::configuration(&map.display().to_string());
    let text = read_text(map, &origin, "a topic map")?;
    let map = Map::parse(&text, origin)?;
    let origin = Origin::data(&bag.display().to_string());
    let file = open(bag, &origin)?;
    let topics = guarded(&origin, "bag", || stream::read(file, &origin, &map))?;
    log(&map, &topics, &origin)
}

fn log(map: &Map, topics: &[Topic], origin: &Origin) -> Result<ImportedLog, DataError> {
    let of = |name: &str| topics.iter().find(|t| t.name == name);
    let times = match &map.rows {
        Rows::At(topic) => of(topic).map(|t| t.times.clone()).unwrap_or_default(),
        Rows::Rate(rate) => steady(topics, *rate, origin)?,
    };
    let Some(first) = times.first().copied() else {
        return Err(origin.fail_file(Problem::NoRows));
    };
    let mut log = ImportedLog {
        header: vec!["time_s".to_owned()],
        rows: times
            .iter()
            .map(|t| vec![Cell::Number(Some(seconds(*t - first)))])
            .collect(),
        notes: notes(map, topics, first),
    };
    for column in &map.columns {
        let samples = of(&column.topic).and_then(|t| t.samples.get(&column.name));
        log.header.push(column.name.clone());
        fill(&mut log, map, column, samples, &times);
    }
    Ok(log)
}

/// One more cell a row.
fn fill(
    log: &mut ImportedLog,
    map: &Map,
    column: &Column,
    samples: Option<&Samples>,
    times: &[i64],
) {
    let mut missing = 0;
    for (row, t) in log.rows.iter_mut().zip(times) {
        row.push(match samples {
            Some(Samples::Text(times, texts)) => {
                Cell::Text(text_at(times, texts, *t).unwrap_or_default().to_owned())
            }
            Some(Samples::Numbers(times, values)) => {
                let value = sample(times, values, *t, map.method, map.max_gap);
                missing += usize::from(value.is_none());
                Cell::Number(value.map(|v| column.unit.to_si(v) * column.factor))
            }
            None => {
                missing += 1;
                Cell::Number(None)
            }
        });
    }
    if missing > 0 {
        log.notes.push(format!(
            "{}: no value in {missing} of {} rows",
            column.name,
            times.len()
        ));
    }
}

/// Rows at a fixed rate over the time that all topics cover.
fn steady(topics: &[Topic], rate: f64, origin: &Origin) -> Result<Vec<i64>, DataError> {
    let first = topics.iter().filter_map(|t| t.times.first()).max();
    let last = topics.iter().filter_map(|t| t.times.last()).min();
    let (Some(&first), Some(&last)) = (first, last) else {
        return Ok(vec![]);
    };
    let rows = seconds(last.saturating_sub(first)) * rate;
    let messages: usize = topics.iter().map(|t| t.times.len()).sum();
    let most = messages.saturating_mul(MOST_ROWS_A_MESSAGE).max(MOST_ROWS);
    if !(0.0..most as f64).contains(&rows) {
        return Err(origin.fail_file(Problem::Unreadable {
            reason: format!(
                "the topics share {} s, which is {rows:.0} rows at {rate} Hz for {messages} messages; look for a jump of \
                 the clock, or lower rate_hz",
                seconds(last.saturating_sub(first))
            ),
        }));
    }
    Ok((0..=(rows + 1e-6) as i64)
        .map(|k| first + (k as f64 * 1e9 / rate).round() as i64)
        .collect())
}

/// Nanoseconds as seconds, rounded once.
fn seconds(nanoseconds: i64) -> f64 {
    nanoseconds as f64 / 1e9
}

/// What there was of each topic, and how it was brought into rows.
fn notes(map: &Map, topics: &[Topic], first: i64) -> Vec<String> {
    let method = match map.method {
        Method::Linear => "linear between neighbours",
        Method::Nearest => "the nearest sample",
        Method::Previous => "the last sample before",
    };
    let mut notes = vec![format!(
        "resampled: {method}, at most {} s away; time starts at {} s of the bag's clock",
        seconds(map.max_gap),
        seconds(first)
    )];
    for t in topics {
        let longest = t.times.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(0);
        let span = t
            .times
            .last()
            .zip(t.times.first())
            .map_or(0, |(b, a)| b - a);
        notes.push(format!(
            "{} ({}): {} messages in {} s, longest gap {} s, clock: {}",
            t.name,
            t.kind,
            t.times.len(),
            seconds(span),
            seconds(longest),
            if t.by_header { "header" } else { "log" }
        ));
    }
    notes
}

/// The error of a name that the bag does not have.
fn unknown<'a>(
    origin: &Origin,
    kind: &'static str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> DataError {
    let mut list: Vec<&str> = known.clone().take(20).collect();
    if known.clone().count() > list.len() {
        list.push("...");
    }
    origin.fail_file(Problem::UnknownName {
        kind,
        name: crate::names::short(name),
        expected: format!("one of {}", list.join(", ")),
        nearest: nearest(name, known),
    })
}
