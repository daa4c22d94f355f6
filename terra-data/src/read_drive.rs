//! Reads a drive log.

use std::io::Read;
use std::path::Path;

use crate::columns::{Binder, Bound, notes};
use crate::drive::{DriveLog, Segment};
use crate::error::{DataError, Origin};
use crate::kind::LogKind;
use crate::notes::MissingCells;
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
    whole(DriveReader::open(path, rover)?)
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
    whole(DriveReader::from_reader(reader, name, rover)?)
}

fn whole(mut reader: DriveReader<'_>) -> Result<DriveLog, DataError> {
    Ok(reader.next_block(usize::MAX)?.unwrap_or_default().log)
}

/// Rows of a drive log that follow each other.
#[derive(Clone, Debug, Default)]
pub struct DriveBlock {
    /// The rows, counted from 0 within the block. Cells are counted in the notes of the block they are missing from; a
    /// warning stands in the block where it arose.
    pub log: DriveLog,
    /// The row of the whole log at which the block begins.
    pub first_row: usize,
    /// True when the block's first segment is the last one of the block before, gone on.
    pub continues: bool,
}

/// Reads a drive log as [`read_drive_log`] does, block by block: a log longer than memory. All blocks together are the
/// log, with the same checks and the same first error.
pub struct DriveReader<'r> {
    table: Table<'r>,
    channels: Channels,
    clock: Clock,
    ignored: Vec<String>,
    warnings: Vec<String>,
    failed: bool,
}

impl<'r> DriveReader<'r> {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// [`DataError::Data`] with file, line and column: an unreadable file, a missing column.
    pub fn open(path: impl AsRef<Path>, rover: &Rover) -> Result<Self, DataError> {
        let path = path.as_ref();
        let origin = Origin::data(&path.display().to_string());
        let file = open(path, &origin)?;
        Self::from_reader(file, &origin.file, rover)
    }

    /// [`DriveReader::open`] on a stream; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`DriveReader::open`].
    pub fn from_reader(
        reader: impl Read + 'r,
        name: &str,
        rover: &Rover,
    ) -> Result<Self, DataError> {
        Self::over(Box::new(reader), name, rover)
    }

    fn over(reader: Box<dyn Read + 'r>, name: &str, rover: &Rover) -> Result<Self, DataError> {
        let table = Table::open(reader, Origin::data(name), None, "a drive log")?;
        let mut warnings = Vec::new();
        let (channels, ignored) = Channels::find(&table, rover, &mut warnings)?;
        Ok(DriveReader {
            table,
            channels,
            clock: Clock::default(),
            ignored,
            warnings,
            failed: false,
        })
    }

    /// The next rows, `most` of them (at least one) or as many as are left; `None` after the last. Memory: the block.
    ///
    /// # Errors
    /// As [`read_drive_log`], once its row is reached. The rows of the block before it are not given, and none after it.
    pub fn next_block(&mut self, most: usize) -> Result<Option<DriveBlock>, DataError> {
        if self.failed {
            return Ok(None);
        }
        self.failed = true;
        self.read(most.max(1))?;
        self.failed = false;
        if self.clock.time.is_empty() {
            return Ok(None);
        }
        if self.table.ends_inside_a_line() {
            self.warnings
                .push("the last line has no line end: its last value may be cut".to_owned());
        }
        let mut block = DriveBlock {
            log: self.channels.take(&self.ignored),
            ..DriveBlock::default()
        };
        self.clock.take(&mut block);
        block.log.warnings = std::mem::take(&mut self.warnings);
        Ok(Some(block))
    }

    fn read(&mut self, most: usize) -> Result<(), DataError> {
        while self.clock.time.len() < most
            && let Some(row) = self.table.next()?
        {
            self.clock.read(&row, &mut self.channels)?;
            for track in self.channels.tracks() {
                track.read(&row)?;
            }
            if let Some(pass) = &mut self.channels.pass {
                let value = row.count(&mut pass.column)?;
                pass.series.push(value.map(f64::from));
            }
        }
        Ok(())
    }
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

    /// The samples read since the last time; the column, with the cells missing among them, goes to `seen`.
    fn take(&mut self, seen: &mut Vec<Bound>) -> Series {
        seen.push(self.column.clone());
        self.column.missing = MissingCells::default();
        std::mem::take(&mut self.series)
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

    /// What was read since the last time, without its clock.
    fn take(&mut self, ignored: &[String]) -> DriveLog {
        let mut columns: Vec<Bound> = Vec::new();
        let seen = &mut columns;
        let mut log = DriveLog {
            wheel_speed: self.wheel_speed.each_mut().map(|t| t.take(seen)),
            ..DriveLog::default()
        };
        let fours = [
            (&mut self.wheel_torque, &mut log.wheel_torque),
            (&mut self.sinkage, &mut log.sinkage),
            (&mut self.normal_load, &mut log.normal_load),
        ];
        for (from, to) in fours {
            *to = from.as_mut().map(|f| f.each_mut().map(|t| t.take(seen)));
        }
        let single = [
            (&mut self.ground_speed, &mut log.ground_speed),
            (&mut self.yaw_rate, &mut log.yaw_rate),
            (&mut self.accel_x, &mut log.accel_x),
            (&mut self.accel_y, &mut log.accel_y),
            (&mut self.lateral_speed, &mut log.lateral_speed),
            (&mut self.pitch, &mut log.pitch),
            (&mut self.roll, &mut log.roll),
            (&mut self.distance, &mut log.distance),
            (&mut self.payload, &mut log.payload),
            (&mut self.pass, &mut log.pass),
        ];
        for (from, to) in single {
            *to = from.as_mut().map(|t| t.take(seen));
        }
        log.notes = notes(ignored.to_vec(), &columns);
        log
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

/// Time and segments of the block, and where the log stands.
#[derive(Default)]
struct Clock {
    time: Vec<f64>,
    segments: Vec<Segment>,
    continues: bool,
    /// Rows of the blocks before this one.
    before: usize,
    /// Segment and time of the last row, of this block or the one before.
    last: Option<(String, f64)>,
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
        let goes_on = match self.last.as_mut().filter(|last| last.0 == name) {
            Some((segment, previous)) => {
                if now <= *previous {
                    let problem = Problem::TimeNotIncreasing {
                        column: column.shown(),
                        previous: *previous,
                        found: now,
                        group: segment.clone(),
                    };
                    return Err(row.fail(column, problem));
                }
                *previous = now;
                true
            }
            None => {
                self.last = Some((name.to_owned(), now));
                false
            }
        };
        self.continues |= goes_on && self.segments.is_empty();
        match self.segments.last_mut().filter(|_| goes_on) {
            Some(segment) => segment.rows.end = index + 1,
            None => self.segments.push(Segment {
                name: name.to_owned(),
                rows: index..index + 1,
            }),
        }
        self.time.push(now);
        Ok(())
    }

    /// Hands the rows over and begins the next block.
    fn take(&mut self, block: &mut DriveBlock) {
        block.first_row = self.before;
        block.continues = std::mem::take(&mut self.continues);
        self.before += self.time.len();
        block.log.time = std::mem::take(&mut self.time);
        block.log.segments = std::mem::take(&mut self.segments);
    }
}
