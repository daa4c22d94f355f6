//! A TOML table that is asked for its keys one by one and then tells which ones nobody asked for.

use std::cell::RefCell;
use std::ops::Range;

use terra_model::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::ScenarioError;

/// The text a place in it is counted in.
#[derive(Clone, Copy)]
pub(super) struct Source<'t> {
    pub(super) text: &'t str,
    pub(super) file: &'t str,
}

impl Source<'_> {
    /// An error at a byte of the text.
    pub(super) fn error(&self, at: usize, message: impl Into<String>) -> ScenarioError {
        let before = self.text.get(..at).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        ScenarioError {
            file: self.file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before.get(line_start..).unwrap_or("").chars().count() + 1,
            message: message.into(),
        }
    }
}

/// A table with a memory of the keys it was asked for.
pub(super) struct Table<'t, 'v> {
    source: Source<'t>,
    table: &'v DeTable<'t>,
    span: Range<usize>,
    known: RefCell<Vec<&'static str>>,
}

/// A value with its place.
#[derive(Clone, Copy)]
pub(super) struct Value<'t, 'v> {
    source: Source<'t>,
    value: &'v Spanned<DeValue<'t>>,
}

impl<'t, 'v> Table<'t, 'v> {
    pub(super) fn new(source: Source<'t>, table: &'v DeTable<'t>, span: Range<usize>) -> Self {
        Table {
            source,
            table,
            span,
            known: RefCell::default(),
        }
    }

    /// The value of a key, if it is there.
    pub(super) fn get(&self, key: &'static str) -> Option<Value<'t, 'v>> {
        self.known.borrow_mut().push(key);
        self.table.get(key).map(|value| Value {
            source: self.source,
            value,
        })
    }

    /// The value of a key that must be there.
    pub(super) fn require(&self, key: &'static str) -> Result<Value<'t, 'v>, ScenarioError> {
        self.get(key)
            .ok_or_else(|| self.error(format!("missing key '{key}'")))
    }

    /// An error at the table's head.
    pub(super) fn error(&self, message: impl Into<String>) -> ScenarioError {
        self.source.error(self.span.start, message)
    }

    /// All keys, whatever they are called.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&'v str, Value<'t, 'v>)> + use<'t, 'v> {
        let source = self.source;
        self.table
            .iter()
            .map(move |(key, value)| (key.get_ref().as_ref(), Value { source, value }))
    }

    /// True when one of these keys is there.
    pub(super) fn has_any(&self, keys: &[&str]) -> bool {
        keys.iter().any(|k| self.table.contains_key(*k))
    }

    /// An error for the first key nobody asked for.
    pub(super) fn finish(self) -> Result<(), ScenarioError> {
        let known = self.known.borrow();
        for (key, _) in self.table.iter() {
            let name = key.get_ref().as_ref();
            if !known.contains(&name) {
                let hint = match nearest(name, known.iter().copied()) {
                    Some(near) => format!(", did you mean '{near}'?"),
                    None => format!(", expected one of {}", known.join(", ")),
                };
                return Err(self
                    .source
                    .error(key.span().start, format!("unknown key '{name}'{hint}")));
            }
        }
        Ok(())
    }
}

impl<'t, 'v> Value<'t, 'v> {
    /// An error at the value.
    pub(super) fn error(&self, message: impl Into<String>) -> ScenarioError {
        self.source.error(self.value.span().start, message)
    }

    fn expected(&self, what: &str) -> ScenarioError {
        self.error(format!(
            "expected {what}, found {}",
            self.value.get_ref().type_str()
        ))
    }

    /// A finite number.
    pub(super) fn number(&self) -> Result<f64, ScenarioError> {
        let value = match self.value.get_ref() {
            DeValue::Float(f) => f.as_str().replace('_', "").parse::<f64>().ok(),
            DeValue::Integer(i) => i64::from_str_radix(&i.as_str().replace('_', ""), i.radix())
                .ok()
                .map(|i| i as f64),
            _ => None,
        };
        match value {
            Some(v) if v.is_finite() => Ok(v),
            Some(v) => Err(self.error(format!("expected a finite number, found {v}"))),
            None => Err(self.expected("a finite number")),
        }
    }

    /// A number that `legal` accepts.
    pub(super) fn number_where(
        &self,
        what: &str,
        legal: impl Fn(f64) -> bool,
    ) -> Result<f64, ScenarioError> {
        let value = self.number()?;
        if legal(value) {
            Ok(value)
        } else {
            Err(self.error(format!("{value}: expected {what}")))
        }
    }

    /// A whole number, not negative.
    pub(super) fn whole(&self) -> Result<u64, ScenarioError> {
        match self.value.get_ref() {
            DeValue::Integer(i) => {
                u64::from_str_radix(&i.as_str().replace('_', ""), i.radix()).ok()
            }
            _ => None,
        }
        .ok_or_else(|| self.error("expected a whole number, not negative"))
    }

    /// A pass or a number of repeats: from 1.
    pub(super) fn count(&self) -> Result<u32, ScenarioError> {
        u32::try_from(self.whole()?)
            .ok()
            .filter(|n| *n >= 1)
            .ok_or_else(|| self.error("expected a whole number from 1"))
    }

    pub(super) fn text(&self) -> Result<String, ScenarioError> {
        self.value
            .get_ref()
            .as_str()
            .map(str::to_owned)
            .ok_or_else(|| self.expected("text"))
    }

    pub(super) fn flag(&self) -> Result<bool, ScenarioError> {
        self.value
            .get_ref()
            .as_bool()
            .ok_or_else(|| self.expected("true or false"))
    }

    pub(super) fn table(&self) -> Result<Table<'t, 'v>, ScenarioError> {
        match self.value.get_ref() {
            DeValue::Table(table) => Ok(Table::new(self.source, table, self.value.span())),
            _ => Err(self.expected("a table")),
        }
    }

    /// The items of an array.
    pub(super) fn items(&self) -> Result<Vec<Value<'t, 'v>>, ScenarioError> {
        match self.value.get_ref() {
            DeValue::Array(items) => Ok(items
                .iter()
                .map(|value| Value {
                    source: self.source,
                    value,
                })
                .collect()),
            _ => Err(self.expected("an array")),
        }
    }

    pub(super) fn is_text(&self) -> bool {
        self.value.get_ref().is_str()
    }

    pub(super) fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    pub(super) fn is_array(&self) -> bool {
        self.value.get_ref().is_array()
    }
}
