//! Reads a drive log.

use std::io::Read;
use std::path::Path;

use crate::columns::{Binder, Bound, notes};
use crate::drive::{DriveLog, Segment};
use crate::error::{DataError, Origin};
use crate::kind::LogKind;
use crate::problem::Problem;
use crate::rover::{GroundSpeedSource, Rover};
use crate::series::Series;
use crate::source::open;
use crate::table::{Row, Table};

/// Name of the segment of a log without segments.
pub(crate) const ONE_SEGMENT: &str = "all";

/// Reads a drive log (CSV) with the names and units that the rover file declares; all values come out in SI.
///
/// Missing cells stay missing and are counted in [`DriveLog::notes`]. Wheel torque comes from `wheel_torque_*`, or from
/// `motor_current_*` with `[drivetrain]`: torque = current x torque constant x gear ratio x efficiency.
///
/// # Errors
/// [`DataError::Data`] with file, line and column: an unreadable file, a missing column, a cell that is no number, time
/// that does not increase inside a segment.
pub fn read_drive_log(path: impl AsRef<Path>, rover: &Rover) -> Result<DriveLog, DataError> {
    let path = path.as_ref();
    let origin = Origin::data(&path.display().to_string());
    let file = open(path, &origin)?;
    read_drive_log_from(file, &origin.file, rover)
}

/// [`read_drive_log`] from a stream; `name` stands for the file in errors.
///
/// # Errors
/// As [`read_drive_log`].
pub fn read_drive_log_from(
    reader: impl Read,
    name: &str,
    rover: &Rover,
) -> Result<DriveLog, DataError> {
    read(Box::new(reader), name, rover)
}

fn read(reader: Box<dyn Read + '_>, name: &str, rover: &Rover) -> Result<DriveLog, DataError> {
    let mut table = Table::open(reader, Origin::data(name), None, "a drive log")?;
    let mut warnings = Vec::new();
    let (mut channels, ignored) = Channels::find(&table, rover, &mut warnings)?;
    let mut clock = Clock::default();
    while let Some(row) = table.next()? {
        clock.read(&row, &mut channels)?;
        for track in channels.tracks() {
            track.read(&row)?;
        }
        if let Some(pass) = &mut channels.pass {
            let value = row.count(&mut pass.column)?;
            pass.series.push(value.map(f64::from));
        }
    }
    if table.ends_inside_a_line() {
        warnings.push("the last line has no line end: its last value may be cut".to_owned());
    }
    Ok(channels.into_log(clock, ignored, warnings))
}

/// One column on its way into a series.
struct Track {
    column: Bound,
    factor: f64,
    series: Series,
}

impl Track {
    fn new(column: Bound) -> Self {
        Track {
            column,
            factor: 1.0,
            series: Series::default(),
        }
    }

    fn read(&mut self, row: &Row<'_>) -> Result<(), DataError> {
        let value = row.number(&mut self.column)?;
        self.series.push(value.map(|v| v * self.factor));
        Ok(())
    }
}

/// All columns of a drive log that the file has.
struct Channels {
    time: Bound,
    segment: Option<Bound>,
    wheel_speed: [Track; 4],
    wheel_torque: Option<[Track; 4]>,
    ground_speed: Option<Track>,
    yaw_rate: Option<Track>,
    accel_x: Option<Track>,
    accel_y: Option<Track>,
    lateral_speed: Option<Track>,
    pitch: Option<Track>,
    roll: Option<Track>,
    distance: Option<Track>,
    sinkage: Option<[Track; 4]>,
    normal_load: Option<[Track; 4]>,
    payload: Option<Track>,
    pass: Option<Track>,
}

impl Channels {
    fn find(
        table: &Table<'_>,
        rover: &Rover,
        warnings: &mut Vec<String>,
    ) -> Result<(Self, Vec<String>), DataError> {
        let mut binder = Binder::new(table, rover, LogKind::Drive);
        let time = binder.required("time_s")?;
        let segment = binder.optional("segment")?;
        let wheel_speed = binder
            .required_wheels("wheel_speed", "rad_s")?
            .map(Track::new);
        let wheel_torque = torque(&mut binder, rover, warnings)?;
        let ground_speed = match rover.filter.ground_speed {
            GroundSpeedSource::Log => Some(binder.required("ground_speed_m_s")?),
            GroundSpeedSource::None => binder.optional("ground_speed_m_s")?,
        };
        let mut optional = |name: &str| Ok::<_, DataError>(binder.optional(name)?.map(Track::new));
        let channels = Channels {
            time,
            segment,
            wheel_speed,
            wheel_torque,
            ground_speed: ground_speed.map(Track::new),
            yaw_rate: optional("yaw_rate_rad_s")?,
            accel_x: optional("accel_x_m_s2")?,
            accel_y: optional("accel_y_m_s2")?,
            lateral_speed: optional("lateral_speed_m_s")?,
            pitch: optional("pitch_rad")?,
            roll: optional("roll_rad")?,
            distance: optional("distance_m")?,
            payload: optional("payload_kg")?,
            pass: optional("pass")?,
            sinkage: wheels(&mut binder, "sinkage", "m")?,
            normal_load: wheels(&mut binder, "normal_load", "N")?,
        };
        Ok((channels, binder.ignored()))
    }

    /// The columns that are plain numbers (`pass` is checked on its own).
    fn tracks(&mut self) -> impl Iterator<Item = &mut Track> {
        let single = [
            &mut self.ground_speed,
            &mut self.yaw_rate,
            &mut self.accel_x,
            &mut self.accel_y,
            &mut self.lateral_speed,
            &mut self.pitch,
            &mut self.roll,
            &mut self.distance,
            &mut self.payload,
        ];
        let fours = [
            &mut self.wheel_torque,
            &mut self.sinkage,
            &mut self.normal_load,
        ];
        self.wheel_speed
            .iter_mut()
            .chain(fours.into_iter().flatten().flatten())
            .chain(single.into_iter().flatten())
    }

    fn into_log(mut self, clock: Clock, ignored: Vec<String>, warnings: Vec<String>) -> DriveLog {
        let mut columns: Vec<Bound> = self.tracks().map(|t| t.column.clone()).collect();
        columns.extend(self.pass.iter().map(|t| t.column.clone()));
        let one = |track: Option<Track>| track.map(|t| t.series);
        let four = |tracks: Option<[Track; 4]>| tracks.map(|t| t.map(|t| t.series));
        DriveLog {
            time: clock.time,
            segments: clock.segments,
            wheel_speed: self.wheel_speed.map(|t| t.series),
            wheel_torque: four(self.wheel_torque),
            ground_speed: one(self.ground_speed),
            yaw_rate: one(self.yaw_rate),
            accel_x: one(self.accel_x),
            accel_y: one(self.accel_y),
            lateral_speed: one(self.lateral_speed),
            pitch: one(self.pitch),
            roll: one(self.roll),
            distance: one(self.distance),
            sinkage: four(self.sinkage),
            normal_load: four(self.normal_load),
            payload: one(self.payload),
            pass: one(self.pass),
            notes: notes(ignored, &columns),
            warnings,
        }
    }
}

fn wheels(
    binder: &mut Binder<'_>,
    before: &str,
    after: &str,
) -> Result<Option<[Track; 4]>, DataError> {
    Ok(binder
        .optional_wheels(before, after)?
        .map(|four| four.map(Track::new)))
}

/// Wheel torque as logged, or from motor currents.
fn torque(
    binder: &mut Binder<'_>,
    rover: &Rover,
    warnings: &mut Vec<String>,
) -> Result<Option<[Track; 4]>, DataError> {
    if let Some(tracks) = wheels(binder, "wheel_torque", "N_m")? {
        return Ok(Some(tracks));
    }
    let Some(mut tracks) = wheels(binder, "motor_current", "A")? else {
        return Ok(None);
    };
    let Some(d) = rover.drivetrain else {
        warnings.push(
            "motor currents are not used: the rover file has no [drivetrain] to turn them into wheel torques"
                .to_owned(),
        );
        return Ok(None);
    };
    for track in &mut tracks {
        track.factor = d.torque_constant * d.gear_ratio * d.efficiency;
    }
    Ok(Some(tracks))
}

/// Time and segments so far.
#[derive(Default)]
struct Clock {
    time: Vec<f64>,
    segments: Vec<Segment>,
}

impl Clock {
    fn read(&mut self, row: &Row<'_>, channels: &mut Channels) -> Result<(), DataError> {
        let column = &mut channels.time;
        let Some(now) = row.number(column)? else {
            let column_name = column.shown();
            return Err(row.fail(
                column,
                Problem::MissingTime {
                    column: column_name,
                },
            ));
        };
        let name = match &channels.segment {
            Some(segment) => row.text(segment.index)?.trim(),
            None => ONE_SEGMENT,
        };
        let index = self.time.len();
        match self.segments.last_mut().filter(|s| s.name == name) {
            Some(segment) => {
                if let Some(previous) = self.time.last().copied().filter(|p| now <= *p) {
                    let problem = Problem::TimeNotIncreasing {
                        column: column.shown(),
                        previous,
                        found: now,
                        group: segment.name.clone(),
                    };
                    return Err(row.fail(column, problem));
                }
                segment.rows.end = index + 1;
            }
            None => self.segments.push(Segment {
                name: name.to_owned(),
                rows: index..index + 1,
            }),
        }
        self.time.push(now);
        Ok(())
    }
}
