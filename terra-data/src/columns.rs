//! The columns a log may have, and where a given file keeps them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use terra_model::SlipConvention;

use crate::drive::WHEELS;
use crate::error::DataError;
use crate::kind::LogKind;
use crate::names::{nearest, short};
use crate::notes::{MissingCells, ReadNotes};
use crate::problem::Problem;
use crate::rover::{ColumnMap, Rover};
use crate::table::Table;
use crate::units::{Dimension, Unit};

/// A column of the log contract.
#[derive(Clone, Debug, PartialEq)]
pub struct ContractColumn {
    /// Its name, wheel and unit suffix included.
    pub name: String,
    /// Its quantity; `None` for text and whole numbers, which have no unit.
    pub dimension: Option<Dimension>,
    /// The logs that have it.
    pub logs: &'static [LogKind],
}

/// All columns that the two kinds of log may have.
pub fn contract_columns() -> &'static [ContractColumn] {
    &CONTRACT
}

static CONTRACT: LazyLock<Vec<ContractColumn>> = LazyLock::new(|| {
    const DRIVE: &[LogKind] = &[LogKind::Drive];
    const RIG: &[LogKind] = &[LogKind::Rig];
    const BOTH: &[LogKind] = &[LogKind::Drive, LogKind::Rig];
    let mut all = Vec::new();
    let mut add = |name: String, logs| {
        let text = matches!(name.as_str(), "segment" | "trial" | "condition" | "pass");
        let dimension = (!text).then(|| Dimension::of_column(&name));
        all.push(ContractColumn {
            name,
            dimension,
            logs,
        });
    };
    for name in ["time_s", "pass"] {
        add(name.to_owned(), BOTH);
    }
    add("segment".to_owned(), DRIVE);
    for (before, after) in [
        ("wheel_speed", "rad_s"),
        ("wheel_torque", "N_m"),
        ("motor_current", "A"),
        ("sinkage", "m"),
        ("normal_load", "N"),
    ] {
        for wheel in WHEELS {
            add(format!("{before}_{wheel}_{after}"), DRIVE);
        }
    }
    for name in [
        "ground_speed_m_s",
        "yaw_rate_rad_s",
        "accel_x_m_s2",
        "accel_y_m_s2",
        "lateral_speed_m_s",
        "pitch_rad",
        "roll_rad",
        "distance_m",
        "payload_kg",
    ] {
        add(name.to_owned(), DRIVE);
    }
    for name in [
        "trial",
        "condition",
        "slip",
        "slip_sd",
        "rim_speed_m_s",
        "wheel_speed_rad_s",
        "travel_speed_m_s",
        "normal_load_N",
        "normal_load_sd_N",
        "drawbar_pull_N",
        "drawbar_pull_sd_N",
        "torque_N_m",
        "torque_sd_N_m",
        "sinkage_m",
        "sinkage_sd_m",
        "side_force_N",
        "side_force_sd_N",
        "slip_angle_rad",
    ] {
        add(name.to_owned(), RIG);
    }
    all
});

/// The contract column of that name.
pub(crate) fn find(name: &str) -> Option<&'static ContractColumn> {
    CONTRACT.iter().find(|c| c.name == name)
}

/// A contract column found in a file.
#[derive(Clone, Debug)]
pub(crate) struct Bound {
    /// Its index in the file.
    pub(crate) index: usize,
    /// Our name.
    contract: String,
    /// The file's name.
    header: String,
    /// The file's unit.
    pub(crate) unit: Unit,
    /// The file's slip convention.
    pub(crate) convention: SlipConvention,
    /// Missing cells so far.
    pub(crate) missing: MissingCells,
}

impl Bound {
    /// A column under its own name, without unit, that must be there.
    pub(crate) fn plain(table: &Table<'_>, name: &str, expected: &str) -> Result<Bound, DataError> {
        let Some(index) = table.position(name)? else {
            let close = nearest(name, table.header.iter().map(String::as_str));
            let at = close
                .as_ref()
                .and_then(|c| table.header.iter().position(|h| h == c));
            let problem = Problem::MissingColumn {
                name: name.to_owned(),
                expected: expected.to_owned(),
                nearest: close,
            };
            return Err(table.fail_header(at, problem));
        };
        Ok(Bound {
            index,
            contract: name.to_owned(),
            header: name.to_owned(),
            unit: Unit::si(Dimension::Ratio),
            convention: SlipConvention::Library,
            missing: MissingCells::default(),
        })
    }

    /// For errors: the file's name, and ours where it differs.
    pub(crate) fn shown(&self) -> String {
        if self.header == self.contract {
            self.header.clone()
        } else {
            format!("{} ({})", self.header, self.contract)
        }
    }
}

/// Finds contract columns in a header through `[columns]`.
pub(crate) struct Binder<'a> {
    table: &'a Table<'a>,
    rover: &'a Rover,
    // Whether [columns] speaks of this file. A log in our own names (one that terra simulated) may be read with the
    // rover file of a log in the user's names: then no mapped name is found, and the file is taken as it is.
    mapped: bool,
    used: BTreeSet<usize>,
}

impl<'a> Binder<'a> {
    pub(crate) fn new(table: &'a Table<'a>, rover: &'a Rover, kind: LogKind) -> Self {
        let of_kind = |name: &str| find(name).is_some_and(|c| c.logs.contains(&kind));
        let mapped = rover.columns.iter().any(|(name, map)| {
            of_kind(name) && find(&map.from).is_none() && table.header.contains(&map.from)
        });
        Binder {
            table,
            rover,
            mapped,
            used: BTreeSet::new(),
        }
    }

    /// A column that may be absent.
    pub(crate) fn optional(&mut self, contract: &str) -> Result<Option<Bound>, DataError> {
        let map = self.rover.columns.get(contract);
        if let Some(map) = map {
            if let Some(index) = self.position(&map.from)? {
                return Ok(Some(self.bind(index, contract, Some(map))));
            }
            if self.mapped {
                let expected =
                    format!("the column that [columns] in the rover file gives for {contract}");
                return Err(self.absent(&map.from, expected));
            }
        }
        let own = self.position(contract)?;
        if let (None, Some(map)) = (own, map)
            && self.nearly(&map.from).is_some()
        {
            let expected = format!("it for {contract}, as [columns] in the rover file says");
            return Err(self.absent(&map.from, expected));
        }
        Ok(own.map(|index| self.bind(index, contract, None)))
    }

    /// A column that must be there.
    pub(crate) fn required(&mut self, contract: &str) -> Result<Bound, DataError> {
        match self.optional(contract)? {
            Some(bound) => Ok(bound),
            None => {
                let kind = find(contract).and_then(|c| c.logs.first());
                let log = kind.map_or("the", |k| k.words());
                let expected = match self.rover.columns.get(contract) {
                    Some(map) => {
                        format!("it (or '{}', as [columns] says) in every {log}", map.from)
                    }
                    None => {
                        let how = if contract == "ground_speed_m_s" {
                            ", [filter] ground_speed = \"none\" says that there is none"
                        } else {
                            ""
                        };
                        format!(
                            "it in every {log}; [columns] in the rover file maps other names{how}"
                        )
                    }
                };
                Err(self.absent(contract, expected))
            }
        }
    }

    /// Four columns, one a wheel: all or none.
    pub(crate) fn optional_wheels(
        &mut self,
        before: &str,
        after: &str,
    ) -> Result<Option<[Bound; 4]>, DataError> {
        for wheel in WHEELS {
            if self
                .optional(&format!("{before}_{wheel}_{after}"))?
                .is_some()
            {
                return self.required_wheels(before, after).map(Some);
            }
        }
        Ok(None)
    }

    /// Four columns, one a wheel.
    pub(crate) fn required_wheels(
        &mut self,
        before: &str,
        after: &str,
    ) -> Result<[Bound; 4], DataError> {
        let mut one = |wheel: &str| self.required(&format!("{before}_{wheel}_{after}"));
        Ok([one("fl")?, one("fr")?, one("rl")?, one("rr")?])
    }

    /// The columns of the file that nothing was bound to.
    pub(crate) fn ignored(self) -> Vec<String> {
        let names = self.table.header.iter().enumerate();
        names
            .filter(|(i, _)| !self.used.contains(i))
            .map(|(_, n)| n.clone())
            .collect()
    }

    /// The error of an absent column, with the unused column of the file whose name comes closest.
    pub(crate) fn absent(&self, name: &str, expected: String) -> DataError {
        let close = self.nearly(name);
        let at = close
            .as_ref()
            .and_then(|c| self.table.header.iter().position(|h| h == c));
        self.table.fail_header(
            at,
            Problem::MissingColumn {
                name: short(name),
                expected,
                nearest: close,
            },
        )
    }

    /// The column of the file that nothing is bound to and that is nearly called so.
    fn nearly(&self, name: &str) -> Option<String> {
        let unused =
            self.table.header.iter().filter(|h| {
                find(h).is_none() && !self.rover.columns.values().any(|m| m.from == **h)
            });
        nearest(name, unused.map(String::as_str))
    }

    fn position(&self, name: &str) -> Result<Option<usize>, DataError> {
        self.table.position(name)
    }

    fn bind(&mut self, index: usize, contract: &str, map: Option<&ColumnMap>) -> Bound {
        self.used.insert(index);
        let dimension = Dimension::of_column(contract);
        let unit = map.and_then(|m| m.unit.as_deref());
        Bound {
            index,
            contract: contract.to_owned(),
            header: self
                .table
                .header
                .get(index)
                .cloned()
                .unwrap_or_else(|| contract.to_owned()),
            // A unit that this quantity does not have is refused when the rover file is read.
            unit: unit
                .and_then(|u| Unit::find(dimension, u))
                .unwrap_or(Unit::si(dimension)),
            convention: map
                .and_then(|m| m.convention)
                .unwrap_or(SlipConvention::Library),
            missing: MissingCells::default(),
        }
    }
}

/// The notes of a file from its bound columns.
pub(crate) fn notes<'b>(
    ignored_columns: Vec<String>,
    bound: impl IntoIterator<Item = &'b Bound>,
) -> ReadNotes {
    let missing: BTreeMap<String, MissingCells> = bound
        .into_iter()
        .filter(|b| b.missing.total() > 0)
        .map(|b| (b.contract.clone(), b.missing))
        .collect();
    ReadNotes {
        ignored_columns,
        missing,
    }
}
