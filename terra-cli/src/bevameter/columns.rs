//! The file that says what a bevameter log calls its columns, and in which units.
//!
//! ```toml
//! [columns]
//! test = { from = "test_id" }
//! soil = { from = "method" }                             # tests of one soil are fitted together
//! sinkage_m = { from = "sinkage", unit = "mm" }
//! pressure_Pa = { from = "pressure", unit = "kPa" }
//! plate_diameter_m = { value = 0.1514 }                  # the same in every row, or by a text column:
//! # plate_diameter_m = { from = "body", values = { plate_d60 = 0.06, plate_d80 = 0.08 } }
//! [fit]
//! from_m = 0.002
//! to_m = 0.08
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use terra_data::{Dimension, Unit};
use terra_model::nearest;

use crate::error::CliError;

/// How one column is found.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Column {
    /// Its name in the log.
    pub(crate) from: Option<String>,
    /// Its unit there.
    pub(crate) unit: Option<String>,
    /// One value for all rows.
    pub(crate) value: Option<f64>,
    /// A value for each text; rows with another text are left out.
    pub(crate) values: Option<BTreeMap<String, f64>>,
}

/// The part of each test that is fitted.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Range {
    from_m: Option<f64>,
    to_m: Option<f64>,
}

/// The file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Columns {
    #[serde(default)]
    columns: BTreeMap<String, toml::Spanned<Column>>,
    #[serde(default)]
    fit: Range,
}

/// All names a log can have.
pub(crate) const NAMES: [&str; 8] = [
    "test",
    "soil",
    "plate_diameter_m",
    "sinkage_m",
    "pressure_Pa",
    "normal_stress_Pa",
    "shear_displacement_m",
    "shear_stress_Pa",
];

impl Columns {
    /// Reads the file.
    ///
    /// # Errors
    /// Configuration errors with file, line and column.
    pub(crate) fn read(path: &Path) -> Result<Self, CliError> {
        let file = path.display();
        let text = std::fs::read_to_string(path).map_err(|e| {
            CliError::usage(
                format!("{file}: cannot be read: {e}"),
                "--columns FILE names the columns of the log",
            )
        })?;
        let fail = |at: usize, message: &str| CliError::Usage {
            message: format!("{file}:{}: {message}", place(&text, at)),
            help: None,
        };
        let columns: Columns = toml::from_str(&text)
            .map_err(|e| fail(e.span().map_or(0, |s| s.start), e.message()))?;
        for (name, column) in &columns.columns {
            let at = column.span().start;
            if !NAMES.contains(&name.as_str()) {
                let near = nearest(name, NAMES)
                    .map_or(format!("one of {}", NAMES.join(", ")), |n| format!("'{n}'"));
                return Err(fail(
                    at,
                    &format!("unknown column '{name}', expected {near}"),
                ));
            }
            let column = column.get_ref();
            if column.from.is_some() == column.value.is_some() {
                return Err(fail(at, &format!("{name}: expected either from or value")));
            }
            if let Some(unit) = &column.unit
                && factor(name, unit).is_none()
            {
                return Err(fail(at, &format!("{name}: unknown unit '{unit}'")));
            }
        }
        let (from, to) = columns.range();
        if !(from >= 0.0 && from < to) {
            return Err(fail(
                text.find("[fit]").unwrap_or(0),
                &format!("from_m = {from}, to_m = {to}: expected 0 <= from_m < to_m"),
            ));
        }
        Ok(columns)
    }

    pub(crate) fn get(&self, name: &str) -> Column {
        self.columns
            .get(name)
            .map(|c| c.get_ref().clone())
            .unwrap_or_else(|| Column {
                from: Some(name.to_owned()),
                ..Column::default()
            })
    }

    /// Whether the file itself asks for a column.
    pub(crate) fn names(&self, name: &str) -> bool {
        self.columns.contains_key(name)
    }

    /// Sinkages or displacements that are fitted \[m\].
    pub(crate) fn range(&self) -> (f64, f64) {
        (
            self.fit.from_m.unwrap_or(0.0),
            self.fit.to_m.unwrap_or(f64::INFINITY),
        )
    }
}

/// What a value in a unit is multiplied by; none for a unit nobody knows.
pub(crate) fn factor(column: &str, unit: &str) -> Option<f64> {
    if column.ends_with("_Pa") {
        return match unit {
            "Pa" => Some(1.0),
            "kPa" => Some(1e3),
            "MPa" => Some(1e6),
            "bar" => Some(1e5),
            "psi" => Some(6_894.757_293_168),
            _ => None,
        };
    }
    Unit::find(Dimension::Length, unit).map(|u| u.to_si(1.0))
}

/// Line and column of a byte, from 1.
fn place(text: &str, at: usize) -> String {
    let before = text.get(..at).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    let line = before.matches('\n').count() + 1;
    let column = before.get(line_start..).unwrap_or("").chars().count() + 1;
    format!("{line}:{column}")
}
