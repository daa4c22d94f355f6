//! Is a file a drive log or a rig log?

use std::io::Read;
use std::path::Path;

use crate::columns::Binder;
use crate::drive::WHEELS;
use crate::error::{DataError, Origin};
use crate::names::first_names;
use crate::problem::Problem;
use crate::rover::Rover;
use crate::source::open;
use crate::table::Table;

/// The two kinds of log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogKind {
    /// Time series of a vehicle.
    Drive,
    /// Trials or samples of one wheel on a testbed.
    Rig,
}

impl LogKind {
    /// `drive log` or `rig log`.
    pub fn words(self) -> &'static str {
        match self {
            LogKind::Drive => "drive log",
            LogKind::Rig => "rig log",
        }
    }
}

/// What kind of log a file is, by its columns (through `[columns]` of the rover file). Reads the header only.
///
/// # Errors
/// [`Problem::UnknownLogKind`] when it has the columns of neither, and every error of an unreadable file.
pub fn log_kind(path: impl AsRef<Path>, rover: &Rover) -> Result<LogKind, DataError> {
    let path = path.as_ref();
    let origin = Origin::data(&path.display().to_string());
    let file = open(path, &origin)?;
    log_kind_from(file, &origin.file, rover)
}

/// [`log_kind`] of a stream; `name` stands for the file in errors.
///
/// # Errors
/// As [`log_kind`].
pub fn log_kind_from(reader: impl Read, name: &str, rover: &Rover) -> Result<LogKind, DataError> {
    find(Box::new(reader), name, rover)
}

fn find(reader: Box<dyn Read + '_>, name: &str, rover: &Rover) -> Result<LogKind, DataError> {
    let table = Table::open(reader, Origin::data(name), None, "a log")?;
    let found = |kind: LogKind, wanted: &[&str]| {
        let mut binder = Binder::new(&table, rover, kind);
        wanted.iter().all(|name| match binder.optional(name) {
            Ok(column) => column.is_some(),
            // Mapped and absent: the file may be the other kind. There twice: its reader will say so.
            Err(e) => matches!(e.problem(), Problem::DuplicateColumn { .. }),
        })
    };
    let speeds = WHEELS.map(|w| format!("wheel_speed_{w}_rad_s"));
    if found(LogKind::Drive, &speeds.each_ref().map(String::as_str)) {
        return Ok(LogKind::Drive);
    }
    let rigs: [&[&str]; 3] = [
        &["normal_load_N", "slip"],
        &["normal_load_N", "rim_speed_m_s", "travel_speed_m_s"],
        &["normal_load_N", "wheel_speed_rad_s", "travel_speed_m_s"],
    ];
    if rigs.iter().any(|wanted| found(LogKind::Rig, wanted)) {
        return Ok(LogKind::Rig);
    }
    Err(table.fail_header(
        None,
        Problem::UnknownLogKind {
            drive: "wheel_speed_{fl,fr,rl,rr}_rad_s".to_owned(),
            rig: "normal_load_N with slip, or with travel_speed_m_s and rim_speed_m_s or wheel_speed_rad_s"
                .to_owned(),
            found: first_names(&table.header),
        },
    ))
}
