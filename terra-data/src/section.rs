//! A table of a TOML file, key by key, each with its place.

use std::fmt;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{DataError, Origin};
use crate::names::{nearest, short};
use crate::problem::Problem;
use crate::source::position;

/// The file: errors are made from byte ranges of it.
pub(crate) struct Document<'a> {
    pub(crate) origin: Origin,
    pub(crate) text: &'a str,
}

impl Document<'_> {
    /// An error at the beginning of a byte range.
    pub(crate) fn fail(&self, at: &Range<usize>, problem: Problem) -> DataError {
        let (line, column) = position(self.text, at.start);
        self.origin.fail(line, column, problem)
    }
}

/// Where a number may lie.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Legal {
    Positive,
    NotNegative,
    /// Both ends belong to it.
    Within(f64, f64),
    /// Above 0, up to 1.
    Share,
}

impl Legal {
    fn allows(self, v: f64) -> bool {
        match self {
            Legal::Positive => v > 0.0,
            Legal::NotNegative => v >= 0.0,
            Legal::Within(low, high) => (low..=high).contains(&v),
            Legal::Share => v > 0.0 && v <= 1.0,
        }
    }
}

impl fmt::Display for Legal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Legal::Positive => f.write_str("a number above 0"),
            Legal::NotNegative => f.write_str("a number of at least 0"),
            Legal::Within(low, high) => write!(f, "a number from {low} to {high}"),
            Legal::Share => f.write_str("a number above 0, up to 1"),
        }
    }
}

/// A key with its value and the places of both.
#[derive(Clone)]
pub(crate) struct Entry<'a> {
    pub(crate) key: &'a str,
    /// `[wheel] radius_m`, for errors.
    pub(crate) shown: String,
    pub(crate) key_at: Range<usize>,
    pub(crate) at: Range<usize>,
    pub(crate) value: &'a DeValue<'a>,
}

/// One table of the file.
pub(crate) struct Section<'a> {
    pub(crate) document: &'a Document<'a>,
    /// `[wheel]`, `[condition.grousered] wheel`, or `the file`.
    pub(crate) name: String,
    /// Where its name stands.
    pub(crate) at: Range<usize>,
    table: &'a DeTable<'a>,
}

impl<'a> Section<'a> {
    /// The whole file as a table.
    pub(crate) fn root(document: &'a Document<'a>, table: &'a DeTable<'a>) -> Self {
        Section {
            document,
            name: "the file".to_owned(),
            at: 0..0,
            table,
        }
    }

    /// All entries, in the order of the file.
    pub(crate) fn entries(&self) -> Vec<Entry<'a>> {
        let mut all: Vec<Entry<'a>> = self.table.iter().map(|(k, v)| self.entry(k, v)).collect();
        all.sort_by_key(|e| e.key_at.start);
        all
    }

    /// Refuses keys that nobody reads.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), DataError> {
        let unknown = self.entries().into_iter().find(|e| !known.contains(&e.key));
        match unknown {
            None => Ok(()),
            Some(e) => Err(self.document.fail(
                &e.key_at,
                Problem::UnknownKey {
                    key: short(e.key),
                    table: self.name.clone(),
                    known: known.iter().map(|k| (*k).to_owned()).collect(),
                    nearest: nearest(e.key, known.iter().copied()),
                },
            )),
        }
    }

    /// A key, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<Entry<'a>> {
        self.table.get_key_value(key).map(|(k, v)| self.entry(k, v))
    }

    /// A table under this one, if it is there.
    pub(crate) fn table(&self, key: &str) -> Result<Option<Section<'a>>, DataError> {
        self.get(key).map(|e| self.table_of(&e)).transpose()
    }

    /// An entry as a table.
    pub(crate) fn table_of(&self, entry: &Entry<'a>) -> Result<Section<'a>, DataError> {
        let DeValue::Table(table) = entry.value else {
            return Err(self.wrong_type(entry, "a table"));
        };
        let name = if self.name == "the file" {
            format!("[{}]", entry.key)
        } else {
            entry.shown.clone()
        };
        let (document, at) = (self.document, entry.key_at.clone());
        Ok(Section {
            document,
            name,
            at,
            table,
        })
    }

    /// A number, if the key is there.
    pub(crate) fn optional_number(
        &self,
        key: &str,
        legal: Legal,
    ) -> Result<Option<f64>, DataError> {
        self.get(key).map(|e| self.number_of(&e, legal)).transpose()
    }

    /// A number that must be there.
    pub(crate) fn number(&self, key: &str, legal: Legal) -> Result<f64, DataError> {
        match self.optional_number(key, legal)? {
            Some(v) => Ok(v),
            None => Err(self.missing(key, &legal.to_string())),
        }
    }

    /// An entry as a number.
    pub(crate) fn number_of(&self, entry: &Entry<'a>, legal: Legal) -> Result<f64, DataError> {
        self.number_at(entry, entry.value, &entry.at, legal)
    }

    /// A value inside an entry (of an array) as a number.
    pub(crate) fn number_at(
        &self,
        entry: &Entry<'a>,
        value: &DeValue<'_>,
        at: &Range<usize>,
        legal: Legal,
    ) -> Result<f64, DataError> {
        let parsed = match value {
            DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix())
                .ok()
                .map(|v| v as f64),
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            _ => return Err(self.wrong_type(entry, "a number")),
        };
        let found = written(value);
        match parsed {
            Some(v) if v.is_finite() && legal.allows(v) => Ok(v),
            Some(v) if v.is_finite() => Err(self.document.fail(
                at,
                Problem::OutOfRange {
                    key: entry.shown.clone(),
                    found,
                    expected: legal.to_string(),
                },
            )),
            _ => Err(self.document.fail(
                at,
                Problem::NotFinite {
                    key: entry.shown.clone(),
                    found,
                },
            )),
        }
    }

    /// A whole number from 0, if the key is there.
    pub(crate) fn optional_count(&self, key: &str) -> Result<Option<u32>, DataError> {
        let Some(entry) = self.get(key) else {
            return Ok(None);
        };
        let DeValue::Integer(i) = entry.value else {
            return Err(self.wrong_type(&entry, "a whole number"));
        };
        match u32::from_str_radix(i.as_str(), i.radix()) {
            Ok(v) => Ok(Some(v)),
            Err(_) => Err(self.document.fail(
                &entry.at,
                Problem::OutOfRange {
                    key: entry.shown.clone(),
                    found: written(entry.value),
                    expected: format!("a whole number from 0 to {}", u32::MAX),
                },
            )),
        }
    }

    /// A text, if the key is there, with its place.
    pub(crate) fn optional_text(
        &self,
        key: &str,
    ) -> Result<Option<(&'a str, Range<usize>)>, DataError> {
        match self.get(key) {
            None => Ok(None),
            Some(entry) => match entry.value {
                DeValue::String(text) => Ok(Some((text, entry.at))),
                _ => Err(self.wrong_type(&entry, "a text")),
            },
        }
    }

    /// One of a few words; the first is the default.
    pub(crate) fn choice<T: Copy>(
        &self,
        key: &str,
        choices: &[(&'static str, T)],
        default: T,
    ) -> Result<T, DataError> {
        let Some((text, at)) = self.optional_text(key)? else {
            return Ok(default);
        };
        match choices.iter().find(|(name, _)| *name == text) {
            Some((_, value)) => Ok(*value),
            None => {
                let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
                let problem = Problem::UnknownName {
                    kind: "value",
                    name: short(text),
                    expected: names.join(" or "),
                    nearest: nearest(text, names),
                };
                Err(self.document.fail(&at, problem))
            }
        }
    }

    /// The error of a missing key.
    pub(crate) fn missing(&self, key: &str, expected: &str) -> DataError {
        self.document.fail(
            &self.at,
            Problem::MissingKey {
                key: key.to_owned(),
                table: self.name.clone(),
                expected: expected.to_owned(),
            },
        )
    }

    /// The error of a value of another type.
    pub(crate) fn wrong_type(&self, entry: &Entry<'_>, expected: &'static str) -> DataError {
        self.document.fail(
            &entry.at,
            Problem::WrongType {
                key: entry.shown.clone(),
                found: kind_of(entry.value).to_owned(),
                expected,
            },
        )
    }

    fn entry(
        &self,
        key: &'a Spanned<std::borrow::Cow<'a, str>>,
        value: &'a Spanned<DeValue<'a>>,
    ) -> Entry<'a> {
        let name: &str = key.get_ref();
        let shown = if self.name == "the file" {
            name.to_owned()
        } else if self.name.ends_with(']') {
            format!("{} {name}", self.name)
        } else {
            format!("{}.{name}", self.name)
        };
        Entry {
            key: name,
            shown,
            key_at: key.span(),
            at: value.span(),
            value: value.get_ref(),
        }
    }
}

/// The type of a value in words.
fn kind_of(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

fn written(value: &DeValue<'_>) -> String {
    match value {
        DeValue::Integer(i) => i.as_str().to_owned(),
        DeValue::Float(f) => f.as_str().to_owned(),
        other => kind_of(other).to_owned(),
    }
}
