//! Reads `[columns]`: the log's own names, units and slip convention.

use std::collections::BTreeMap;

use terra_model::SlipConvention;

use crate::columns::{contract_columns, find};
use crate::error::DataError;
use crate::names::{nearest, short};
use crate::problem::Problem;
use crate::rover::ColumnMap;
use crate::section::Section;
use crate::units::{Dimension, Unit};

pub(crate) fn read_columns(s: &Section<'_>) -> Result<BTreeMap<String, ColumnMap>, DataError> {
    let mut columns = BTreeMap::new();
    for entry in s.entries() {
        let Some(contract) = find(entry.key) else {
            let known = contract_columns().iter().map(|c| c.name.as_str());
            let problem = Problem::UnknownName {
                kind: "column",
                name: short(entry.key),
                expected: "a column of a drive or a rig log, with its wheel and unit".to_owned(),
                nearest: nearest(entry.key, known),
            };
            return Err(s.document.fail(&entry.key_at, problem));
        };
        let one = s.table_of(&entry)?;
        one.only(&["from", "unit", "convention"])?;
        let from = match one.optional_text("from")? {
            Some((from, _)) => from.trim().to_owned(),
            None => return Err(one.missing("from", "the column's name in the log")),
        };
        let unit = read_unit(&one, &contract.name, contract.dimension)?;
        let convention = read_convention(&one, &contract.name)?;
        // 100 i is said once: as a unit or as a convention.
        if let (Some(_), Some(SlipConvention::Percent)) = (&unit, convention) {
            let problem = Problem::Conflict {
                key: format!("{} unit", one.name),
                other: "convention = \"percent\"".to_owned(),
            };
            return Err(s.document.fail(&one.at, problem));
        }
        columns.insert(
            contract.name.clone(),
            ColumnMap {
                from,
                unit,
                convention,
            },
        );
    }
    Ok(columns)
}

fn read_unit(
    one: &Section<'_>,
    column: &str,
    dimension: Option<Dimension>,
) -> Result<Option<String>, DataError> {
    let Some((name, at)) = one.optional_text("unit")? else {
        return Ok(None);
    };
    let Some(dimension) = dimension else {
        let problem = Problem::UnknownName {
            kind: "unit",
            name: short(name),
            expected: format!("none: {column} has no unit"),
            nearest: None,
        };
        return Err(one.document.fail(&at, problem));
    };
    if let Some(unit) = Unit::find(dimension, name) {
        return Ok(Some(unit.name.to_owned()));
    }
    let legal: Vec<&'static str> = dimension.units().iter().map(|u| u.name).collect();
    let of = Dimension::all()
        .into_iter()
        .find(|d| Unit::find(*d, name).is_some());
    let problem = match of {
        Some(of) => Problem::WrongDimension {
            column: column.to_owned(),
            unit: name.to_owned(),
            of: of.words(),
            legal,
        },
        None => Problem::UnknownName {
            kind: "unit",
            name: short(name),
            expected: format!("one of {}", legal.join(", ")),
            nearest: nearest(name, legal),
        },
    };
    Err(one.document.fail(&at, problem))
}

fn read_convention(one: &Section<'_>, column: &str) -> Result<Option<SlipConvention>, DataError> {
    let Some((name, at)) = one.optional_text("convention")? else {
        return Ok(None);
    };
    if !matches!(column, "slip" | "slip_sd") {
        let problem = Problem::UnknownName {
            kind: "convention",
            name: short(name),
            expected: format!("none: only slip and slip_sd have one, not {column}"),
            nearest: None,
        };
        return Err(one.document.fail(&at, problem));
    }
    let expected = "library, percent, unbounded, driving or braking";
    SlipConvention::from_name(name)
        .map(Some)
        .map_err(|e| one.document.fail(&at, Problem::from_model(e, expected)))
}
