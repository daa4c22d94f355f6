//! Writes logs with the contract's columns, so that reading gives the same bits again.

use std::io::{self, Write};
use std::path::Path;

use crate::atomic::atomic_write;
use crate::drive::DriveLog;
use crate::error::DataError;
use crate::problem::Problem;
use crate::rig::{Measured, RigLog, RigRow};

/// Writes a drive log as CSV, atomically. Missing samples are empty cells; numbers have the fewest digits that read back
/// to the same bits.
///
/// # Errors
/// [`DataError::Write`]: the file cannot be written, or the log would not be read back as it is (time that is not finite
/// or does not increase inside a segment, two segments of one name in a row).
pub fn write_drive_log(path: impl AsRef<Path>, log: &DriveLog) -> Result<(), DataError> {
    let path = path.as_ref();
    check_drive(log).map_err(|reason| DataError::write(path, Problem::NotALog { reason }))?;
    atomic_write(path, |w| write_drive_log_to(w, log))
}

/// [`write_drive_log`] to a stream, unchecked.
///
/// # Errors
/// Those of the stream.
pub fn write_drive_log_to(mut out: impl Write, log: &DriveLog) -> io::Result<()> {
    drive(&mut out, log)
}

fn drive(out: &mut dyn Write, log: &DriveLog) -> io::Result<()> {
    let channels = log.channels();
    let mut csv = csv::Writer::from_writer(out);
    let segmented = !log.segments.is_empty();
    let mut record = vec!["time_s".to_owned()];
    record.extend(segmented.then(|| "segment".to_owned()));
    record.extend(channels.iter().map(|(name, _)| name.clone()));
    csv.write_record(&record)?;
    let mut segments = log.segments.iter().peekable();
    for (row, time) in log.time.iter().enumerate() {
        while segments.peek().is_some_and(|s| s.rows.end <= row) {
            segments.next();
        }
        record.clear();
        record.push(number(Some(*time)));
        if segmented {
            record.push(segments.peek().map(|s| s.name.clone()).unwrap_or_default());
        }
        record.extend(channels.iter().map(|(_, series)| number(series.get(row))));
        csv.write_record(&record)?;
    }
    csv.flush()
}

/// Writes a rig log as CSV, atomically; dropped rows are not written.
///
/// # Errors
/// [`DataError::Write`]: the file cannot be written.
pub fn write_rig_log(path: impl AsRef<Path>, log: &RigLog) -> Result<(), DataError> {
    atomic_write(path, |w| write_rig_log_to(w, log))
}

/// [`write_rig_log`] to a stream.
///
/// # Errors
/// Those of the stream.
pub fn write_rig_log_to(mut out: impl Write, log: &RigLog) -> io::Result<()> {
    rig(&mut out, log)
}

fn rig(out: &mut dyn Write, log: &RigLog) -> io::Result<()> {
    // A column is written when a row has a value for it; slip and load always.
    let columns: Vec<_> = RIG_NUMBERS
        .iter()
        .filter(|(name, value)| {
            matches!(*name, "slip" | "normal_load_N") || log.rows.iter().any(|r| value(r).is_some())
        })
        .collect();
    let mut csv = csv::Writer::from_writer(out);
    let mut record: Vec<String> = ["trial", "condition", "pass"].map(str::to_owned).to_vec();
    record.extend(columns.iter().map(|(name, _)| (*name).to_owned()));
    csv.write_record(&record)?;
    for row in &log.rows {
        record.clear();
        record.extend([
            row.trial.clone(),
            row.condition.clone(),
            row.pass.to_string(),
        ]);
        record.extend(columns.iter().map(|(_, value)| number(value(row))));
        csv.write_record(&record)?;
    }
    csv.flush()
}

/// The fewest digits that read back to the same double; empty for a missing or non-finite value.
pub(crate) fn number(value: Option<f64>) -> String {
    // `{:?}` has the shortest digits and an exponent where that is shorter; its `.0` is no digit of the value.
    let text = match value {
        Some(v) if v.is_finite() => format!("{v:?}"),
        _ => return String::new(),
    };
    match text.strip_suffix(".0") {
        Some(whole) => whole.to_owned(),
        None => text,
    }
}

/// Why a drive log would not be read back as it is.
fn check_drive(log: &DriveLog) -> Result<(), String> {
    let mut next = 0;
    let mut before: Option<&str> = None;
    for segment in &log.segments {
        let name = segment.name.as_str();
        if before == Some(name) || name.trim() != name {
            return Err(format!(
                "segment '{name}' needs a name of its own, without blanks around it"
            ));
        }
        if segment.rows.start != next || segment.rows.end <= next {
            return Err(format!(
                "segment '{name}' does not begin where the one before it ends"
            ));
        }
        (next, before) = (segment.rows.end, Some(name));
    }
    if !log.segments.is_empty() && next != log.time.len() {
        return Err(format!("segments end at row {next} of {}", log.time.len()));
    }
    if let Some((name, series)) = log
        .channels()
        .iter()
        .find(|(_, s)| s.len() != log.time.len())
    {
        let (found, rows) = (series.len(), log.time.len());
        return Err(format!("{name} has {found} samples for {rows} rows"));
    }
    for (row, pair) in log.time.windows(2).enumerate() {
        let begins = log.segments.iter().any(|s| s.rows.start == row + 1);
        if let [a, b] = pair
            && !(begins || b > a)
        {
            return Err(format!("time {b} s follows {a} s"));
        }
    }
    match log.time.iter().find(|t| !t.is_finite()) {
        Some(t) => Err(format!("a time is {t}")),
        None => Ok(()),
    }
}

type RigNumber = (&'static str, fn(&RigRow) -> Option<f64>);

const RIG_NUMBERS: [RigNumber; 16] = [
    ("time_s", |r| r.time),
    ("slip", |r| Some(r.slip.value)),
    ("slip_sd", |r| r.slip.sd),
    ("normal_load_N", |r| Some(r.normal_load.value)),
    ("normal_load_sd_N", |r| r.normal_load.sd),
    ("drawbar_pull_N", |r| value(r.drawbar_pull)),
    ("drawbar_pull_sd_N", |r| sd(r.drawbar_pull)),
    ("torque_N_m", |r| value(r.torque)),
    ("torque_sd_N_m", |r| sd(r.torque)),
    ("sinkage_m", |r| value(r.sinkage)),
    ("sinkage_sd_m", |r| sd(r.sinkage)),
    ("side_force_N", |r| value(r.side_force)),
    ("side_force_sd_N", |r| sd(r.side_force)),
    ("slip_angle_rad", |r| r.slip_angle),
    ("travel_speed_m_s", |r| r.travel_speed),
    ("wheel_speed_rad_s", |r| r.wheel_speed),
];

fn value(m: Option<Measured>) -> Option<f64> {
    m.map(|m| m.value)
}

fn sd(m: Option<Measured>) -> Option<f64> {
    m.and_then(|m| m.sd)
}
