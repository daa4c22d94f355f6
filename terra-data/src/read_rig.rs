//! Reads a rig log.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use terra_model::SlipConvention;

use crate::columns::{Binder, Bound, notes};
use crate::error::{DataError, Origin};
use crate::kind::LogKind;
use crate::names::nearest;
use crate::problem::Problem;
use crate::rig::{Measured, RigLog, RigRow};
use crate::rig_slip::{in_library_convention, rig_slip};
use crate::rover::Rover;
use crate::source::open;
use crate::table::{Row, Table};

/// Slip from the speeds may differ from logged slip by this much before it is worth a warning.
const SLIP_DISAGREEMENT: f64 = 0.02;
/// Trial of samples in a log with time and without a `trial` column.
const ONE_TRIAL: &str = "all";

/// Reads a rig log (CSV) with the names and units that the rover file declares; all values come out in SI.
///
/// Slip is taken from `slip` (in its declared convention), else from the rim speed (or wheel speed x radius) and the
/// travel speed; where both are there, `slip` counts and a disagreement above .02 is a warning. No standstill rule is
/// applied to testbeds: they creep at 10 mm/s by design. A row without load, slip or any measured force or sinkage, and
/// one whose wheel turns against its motion, goes to [`RigLog::dropped`] with its line and the reason.
///
/// Without a `trial` column each row is a trial of its own, named by its number from 1; with `time_s` all rows are then
/// samples of one trial. Time must increase inside a trial.
///
/// # Errors
/// [`DataError::Data`] with file, line and column: an unreadable file, a missing column, a cell that is no number, time
/// that does not increase inside a trial, or no usable row.
pub fn read_rig_log(path: impl AsRef<Path>, rover: &Rover) -> Result<RigLog, DataError> {
    let path = path.as_ref();
    let origin = Origin::data(&path.display().to_string());
    let file = open(path, &origin)?;
    read_rig_log_from(file, &origin.file, rover)
}

/// [`read_rig_log`] from a stream; `name` stands for the file in errors.
///
/// # Errors
/// As [`read_rig_log`].
pub fn read_rig_log_from(
    reader: impl Read,
    name: &str,
    rover: &Rover,
) -> Result<RigLog, DataError> {
    read(Box::new(reader), name, rover)
}

fn read(reader: Box<dyn Read + '_>, name: &str, rover: &Rover) -> Result<RigLog, DataError> {
    let mut table = Table::open(reader, Origin::data(name), None, "a rig log")?;
    let (mut columns, ignored) = Columns::find(&table, rover)?;
    let mut log = RigLog::default();
    let mut number = 0;
    while let Some(row) = table.next()? {
        number += 1;
        match columns.read(&row, number, rover)? {
            Ok((kept, warning)) => {
                check_time(&log, &kept, &row, &columns)?;
                log.warnings.extend(warning);
                log.rows.push(kept);
            }
            Err(reason) => log.dropped.push((row.line, reason)),
        }
    }
    if log.rows.is_empty()
        && let Some((line, reason)) = log.dropped.first()
    {
        let problem = Problem::NoUsableRows {
            rows: number,
            line: *line,
            reason: reason.clone(),
        };
        return Err(table.origin.fail(*line, None, problem));
    }
    log.warnings.extend(unlisted_conditions(&log, rover));
    if table.ends_inside_a_line() {
        log.warnings
            .push("the last line has no line end: its last value may be cut".to_owned());
    }
    log.notes = notes(ignored, columns.numbers());
    Ok(log)
}

/// A channel and its own 1-sigma.
struct Pair {
    value: Bound,
    sd: Option<Bound>,
}

impl Pair {
    fn find(binder: &mut Binder<'_>, value: &str, sd: &str) -> Result<Option<Pair>, DataError> {
        match binder.optional(value)? {
            Some(value) => Ok(Some(Pair {
                value,
                sd: binder.optional(sd)?,
            })),
            None => Ok(None),
        }
    }

    fn sd_convention(&self) -> SlipConvention {
        let sd = self.sd.as_ref();
        sd.map_or(SlipConvention::Library, |sd| sd.convention)
    }

    fn read(&mut self, row: &Row<'_>) -> Result<Option<Measured>, DataError> {
        let value = row.number(&mut self.value)?;
        let sd = match &mut self.sd {
            Some(column) => sigma(row, column)?,
            None => None,
        };
        Ok(value.map(|value| Measured { value, sd }))
    }
}

/// All columns of a rig log that the file has.
struct Columns {
    trial: Option<Bound>,
    condition: Option<Bound>,
    pass: Option<Bound>,
    time: Option<Bound>,
    slip: Option<Pair>,
    rim_speed: Option<Bound>,
    wheel_speed: Option<Bound>,
    travel_speed: Option<Bound>,
    normal_load: Pair,
    drawbar_pull: Option<Pair>,
    torque: Option<Pair>,
    sinkage: Option<Pair>,
    side_force: Option<Pair>,
    slip_angle: Option<Bound>,
}

impl Columns {
    fn find(table: &Table<'_>, rover: &Rover) -> Result<(Self, Vec<String>), DataError> {
        let mut b = Binder::new(table, rover, LogKind::Rig);
        let columns = Columns {
            trial: b.optional("trial")?,
            condition: b.optional("condition")?,
            pass: b.optional("pass")?,
            time: b.optional("time_s")?,
            slip: Pair::find(&mut b, "slip", "slip_sd")?,
            rim_speed: b.optional("rim_speed_m_s")?,
            wheel_speed: b.optional("wheel_speed_rad_s")?,
            travel_speed: b.optional("travel_speed_m_s")?,
            normal_load: Pair {
                value: b.required("normal_load_N")?,
                sd: b.optional("normal_load_sd_N")?,
            },
            drawbar_pull: Pair::find(&mut b, "drawbar_pull_N", "drawbar_pull_sd_N")?,
            torque: Pair::find(&mut b, "torque_N_m", "torque_sd_N_m")?,
            sinkage: Pair::find(&mut b, "sinkage_m", "sinkage_sd_m")?,
            side_force: Pair::find(&mut b, "side_force_N", "side_force_sd_N")?,
            slip_angle: b.optional("slip_angle_rad")?,
        };
        let turns = columns.rim_speed.is_some() || columns.wheel_speed.is_some();
        if columns.slip.is_none() && !(turns && columns.travel_speed.is_some()) {
            let expected =
                "it, or travel_speed_m_s with rim_speed_m_s or wheel_speed_rad_s, in every rig log";
            return Err(b.absent("slip", expected.to_owned()));
        }
        let measured = [&columns.drawbar_pull, &columns.torque, &columns.sinkage];
        if measured.iter().all(|c| c.is_none()) {
            let expected = "it, torque_N_m or sinkage_m in every rig log";
            return Err(b.absent("drawbar_pull_N", expected.to_owned()));
        }
        Ok((columns, b.ignored()))
    }

    /// A row with its warning, or the reason why it cannot be used.
    fn read(
        &mut self,
        row: &Row<'_>,
        number: usize,
        rover: &Rover,
    ) -> Result<Result<(RigRow, Option<String>), String>, DataError> {
        // Every cell is read before a row is dropped, so that a bad cell is an error wherever it stands.
        let condition = text(row, &self.condition)?.unwrap_or_default();
        let trial = match text(row, &self.trial)? {
            Some(trial) if !trial.is_empty() => trial,
            // Not the bare number: the log's own trials may be numbers.
            Some(_) => format!("row {number}"),
            None if self.time.is_some() => ONE_TRIAL.to_owned(),
            None => number.to_string(),
        };
        let pass = match &mut self.pass {
            Some(column) => row.count(column)?,
            None => Some(1),
        };
        let time = number_of(row, &mut self.time)?;
        let rim_speed = number_of(row, &mut self.rim_speed)?;
        let wheel_speed = number_of(row, &mut self.wheel_speed)?;
        let travel_speed = number_of(row, &mut self.travel_speed)?;
        let slip_angle = number_of(row, &mut self.slip_angle)?;
        let logged_slip = measured(row, &mut self.slip)?;
        let normal_load = self.normal_load.read(row)?;
        let drawbar_pull = measured(row, &mut self.drawbar_pull)?;
        let torque = measured(row, &mut self.torque)?;
        let sinkage = measured(row, &mut self.sinkage)?;
        let side_force = measured(row, &mut self.side_force)?;

        let radius = rover.wheel_of(&condition).radius;
        let rim = rim_speed.or(wheel_speed.map(|w| w * radius));
        let from_speeds = match (rim, travel_speed) {
            (Some(rim), Some(travel)) => Some(rig_slip(rim, travel)),
            _ => None,
        };
        let slip = match (logged_slip, &self.slip) {
            (Some(slip), Some(pair)) => {
                in_library_convention(slip, pair.value.convention, pair.sd_convention())
            }
            _ => match &from_speeds {
                Some(slip) => slip.clone().map(|value| Measured { value, sd: None }),
                None => Err("slip is missing".to_owned()),
            },
        };
        let slip = match slip {
            Ok(slip) => slip,
            Err(reason) => return Ok(Err(reason)),
        };
        let warning = match from_speeds {
            Some(Ok(other)) if (other - slip.value).abs() > SLIP_DISAGREEMENT => Some(format!(
                "line {}: slip {} but the speeds give {other:.4}; slip is used",
                row.line, slip.value
            )),
            // Slip counts, but speeds that contradict each other deserve a look.
            Some(Err(reason)) => Some(format!("line {}: {reason}; slip is used", row.line)),
            _ => None,
        };
        let reason = match (normal_load, pass) {
            (None, _) => Some("normal load is missing".to_owned()),
            (Some(w), _) if w.value <= 0.0 => Some(format!(
                "normal load {} N, expected a wheel on the ground",
                w.value
            )),
            (_, None) => Some("pass is missing".to_owned()),
            _ if self.time.is_some() && time.is_none() => Some("time is missing".to_owned()),
            _ if drawbar_pull.is_none() && torque.is_none() && sinkage.is_none() => {
                Some("drawbar pull, torque and sinkage are missing".to_owned())
            }
            _ => None,
        };
        let (Some(normal_load), Some(pass), None) = (normal_load, pass, &reason) else {
            return Ok(Err(reason.unwrap_or_default()));
        };
        let kept = RigRow {
            line: row.line,
            trial,
            condition,
            pass,
            time,
            slip,
            normal_load,
            drawbar_pull,
            torque,
            sinkage,
            side_force,
            slip_angle,
            travel_speed,
            wheel_speed: wheel_speed.or(rim_speed.map(|v| v / radius)),
        };
        Ok(Ok((kept, warning)))
    }

    /// All numeric columns.
    fn numbers(&self) -> impl Iterator<Item = &Bound> {
        let pairs = [
            self.slip.as_ref(),
            Some(&self.normal_load),
            self.drawbar_pull.as_ref(),
            self.torque.as_ref(),
            self.sinkage.as_ref(),
            self.side_force.as_ref(),
        ];
        let single = [
            &self.pass,
            &self.time,
            &self.rim_speed,
            &self.wheel_speed,
            &self.travel_speed,
            &self.slip_angle,
        ];
        let pairs = pairs.into_iter().flatten();
        pairs
            .flat_map(|p| std::iter::once(&p.value).chain(&p.sd))
            .chain(single.into_iter().flatten())
    }
}

fn text(row: &Row<'_>, column: &Option<Bound>) -> Result<Option<String>, DataError> {
    match column {
        Some(c) => Ok(Some(row.text(c.index)?.trim().to_owned())),
        None => Ok(None),
    }
}

fn number_of(row: &Row<'_>, column: &mut Option<Bound>) -> Result<Option<f64>, DataError> {
    match column {
        Some(c) => row.number(c),
        None => Ok(None),
    }
}

fn measured(row: &Row<'_>, pair: &mut Option<Pair>) -> Result<Option<Measured>, DataError> {
    match pair {
        Some(p) => p.read(row),
        None => Ok(None),
    }
}

/// A 1-sigma; a negative one is an error.
fn sigma(row: &Row<'_>, column: &mut Bound) -> Result<Option<f64>, DataError> {
    let sd = row.number(column)?;
    match sd.filter(|sd| *sd < 0.0) {
        Some(bad) => Err(row.bad_value(column, bad, "a standard deviation of at least 0")),
        None => Ok(sd),
    }
}

/// Time must increase inside a trial; another trial, condition or pass starts anew.
fn check_time(
    log: &RigLog,
    now: &RigRow,
    row: &Row<'_>,
    columns: &Columns,
) -> Result<(), DataError> {
    let (Some(before), Some(column)) = (log.rows.last(), &columns.time) else {
        return Ok(());
    };
    let same =
        before.trial == now.trial && before.condition == now.condition && before.pass == now.pass;
    match (before.time, now.time) {
        (Some(previous), Some(found)) if same && found <= previous => {
            let problem = Problem::TimeNotIncreasing {
                column: column.shown(),
                previous,
                found,
                group: now.trial.clone(),
            };
            Err(row.fail(column, problem))
        }
        _ => Ok(()),
    }
}

/// A condition that the rover file does not list gets the plain wheel; where others are listed, that may be a slip.
fn unlisted_conditions(log: &RigLog, rover: &Rover) -> Vec<String> {
    if rover.conditions.is_empty() {
        return Vec::new();
    }
    let conditions: BTreeSet<&str> = log.rows.iter().map(|r| r.condition.as_str()).collect();
    let unlisted = conditions
        .into_iter()
        .filter(|c| !c.is_empty() && !rover.conditions.contains_key(*c));
    unlisted
        .map(|c| {
            let known = rover.conditions.keys().map(String::as_str);
            let hint =
                nearest(c, known).map_or(String::new(), |n| format!(", did you mean '{n}'?"));
            format!(
                "condition '{c}' is not in the rover file: its rows get the plain [wheel]{hint}"
            )
        })
        .collect()
}
