//! The topic map: `[rows]` says when a row is, `[columns]` which field of which topic each column is.

use std::collections::BTreeSet;

use toml::de::DeTable;

use super::path::FieldPath;
use super::resample::Method;
use crate::columns::{contract_columns, find};
use crate::error::{DataError, Origin};
use crate::kind::LogKind;
use crate::names::{nearest, short};
use crate::problem::Problem;
use crate::section::{Document, Entry, Legal, Section};
use crate::units::{Dimension, Unit};

/// When a row is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Rows {
    /// At each message of a topic.
    At(String),
    /// At a fixed rate \[Hz\].
    Rate(f64),
}

/// Whose time a message has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// Its header's stamp; where it has none, as `Log`.
    Header,
    /// When it was recorded.
    Log,
}

/// One column of the log.
#[derive(Clone, Debug)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) topic: String,
    pub(crate) field: FieldPath,
    pub(crate) unit: Unit,
    /// For a sensor that is mounted the other way round.
    pub(crate) factor: f64,
}

impl Column {
    /// Whether it holds text.
    pub(crate) fn is_text(&self) -> bool {
        self.name == "segment"
    }
}

/// The map.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) rows: Rows,
    pub(crate) method: Method,
    /// ns.
    pub(crate) max_gap: i64,
    pub(crate) clock: Clock,
    /// In the order of the file.
    pub(crate) columns: Vec<Column>,
}

impl Map {
    pub(crate) fn parse(text: &str, origin: Origin) -> Result<Self, DataError> {
        let document = Document { origin, text };
        let parsed = DeTable::parse(text).map_err(|e| {
            let message = e.message().to_owned();
            document.fail(&e.span().unwrap_or(0..0), Problem::Syntax { message })
        })?;
        let file = Section::root(&document, parsed.get_ref());
        file.only(&["rows", "columns"])?;
        let needed = |table: &'static str| {
            let missing = || document.origin.fail_file(Problem::MissingTable { table });
            file.table(table)?.ok_or_else(missing)
        };
        let rows = needed("rows")?;
        rows.only(&["at", "rate_hz", "method", "max_gap_s", "clock"])?;
        let columns = needed("columns")?
            .entries()
            .iter()
            .map(|e| column(&file, e))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Map {
            rows: when(&rows)?,
            method: rows.choice(
                "method",
                &[
                    ("linear", Method::Linear),
                    ("nearest", Method::Nearest),
                    ("previous", Method::Previous),
                ],
                Method::Linear,
            )?,
            max_gap: (rows
                .optional_number("max_gap_s", Legal::Within(0.0, 1e6))?
                .unwrap_or(0.1)
                * 1e9)
                .round() as i64,
            clock: rows.choice(
                "clock",
                &[("header", Clock::Header), ("log", Clock::Log)],
                Clock::Header,
            )?,
            columns,
        })
    }

    /// The topics it names, each once.
    pub(crate) fn topics(&self) -> BTreeSet<&str> {
        let mut all: BTreeSet<&str> = self.columns.iter().map(|c| c.topic.as_str()).collect();
        if let Rows::At(topic) = &self.rows {
            all.insert(topic);
        }
        all
    }
}

fn when(rows: &Section<'_>) -> Result<Rows, DataError> {
    let at = rows.optional_text("at")?;
    let rate = rows.optional_number("rate_hz", Legal::Within(1e-3, 1e6))?;
    match (at, rate) {
        (Some((topic, _)), None) => Ok(Rows::At(topic.to_owned())),
        (None, Some(rate)) => Ok(Rows::Rate(rate)),
        (None, None) => Err(rows.missing(
            "rate_hz",
            "rate_hz, or at = the topic whose messages are the rows",
        )),
        (Some((_, place)), Some(_)) => Err(rows.document.fail(
            &place,
            Problem::Conflict {
                key: "[rows] at".to_owned(),
                other: "rate_hz".to_owned(),
            },
        )),
    }
}

fn column(file: &Section<'_>, entry: &Entry<'_>) -> Result<Column, DataError> {
    let document = file.document;
    let dimension = match find(entry.key).filter(|c| c.logs.contains(&LogKind::Drive)) {
        Some(known) if known.name != "time_s" => known.dimension,
        _ => {
            let names = contract_columns()
                .iter()
                .filter(|c| c.logs.contains(&LogKind::Drive) && c.name != "time_s")
                .map(|c| c.name.as_str());
            return Err(document.fail(
                &entry.key_at,
                Problem::UnknownName {
                    kind: "column",
                    name: short(entry.key),
                    expected: "a column of a drive log other than its time".to_owned(),
                    nearest: nearest(entry.key, names),
                },
            ));
        }
    };
    let section = file.table_of(entry)?;
    section.only(&["topic", "field", "unit", "factor"])?;
    let text = |key: &str, expected: &str| {
        let found = section.optional_text(key)?;
        found.ok_or_else(|| section.missing(key, expected))
    };
    let (topic, _) = text("topic", "the topic's name")?;
    let (field, at) = text("field", "a path such as twist.twist.linear.x")?;
    let field = FieldPath::parse(field).ok_or_else(|| {
        document.fail(
            &at,
            Problem::UnknownName {
                kind: "field",
                name: short(field),
                expected:
                    "a path such as twist.twist.linear.x, velocity[2] or velocity[joint name]"
                        .to_owned(),
                nearest: None,
            },
        )
    })?;
    let dimension = dimension.unwrap_or(Dimension::Ratio);
    let unit = match section.optional_text("unit")? {
        None => Unit::si(dimension),
        Some((name, at)) => Unit::find(dimension, name).ok_or_else(|| {
            document.fail(
                &at,
                Problem::UnknownName {
                    kind: "unit",
                    name: short(name),
                    expected: format!("a unit of {}", dimension.words()),
                    nearest: None,
                },
            )
        })?,
    };
    Ok(Column {
        name: entry.key.to_owned(),
        topic: topic.to_owned(),
        field,
        unit,
        factor: section
            .optional_number("factor", Legal::Within(-1e12, 1e12))?
            .unwrap_or(1.0),
    })
}
