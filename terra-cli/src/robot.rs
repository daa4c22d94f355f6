//! A drive log as the force filter wants it.

use std::ops::Range;

use terra_data::{DriveBlock, DriveLog, GroundSpeedSource, Rover, Series};
use terra_ekf::spaces::longitudinal_robot::{
    LongitudinalRobot, PriorSpread, ProcessNoise, SensorNoise,
};
use terra_ekf::{FilterError, ForceConfig, RobotLog, RobotRow, Step, estimate_forces};
use terra_model::Vehicle;

use crate::error::CliError;

/// Columns of a drive log, missing samples as `None`.
#[derive(Clone)]
pub(crate) struct Columns {
    pub(crate) time: Vec<f64>,
    pub(crate) segments: Vec<Range<usize>>,
    pub(crate) torque: [Vec<Option<f64>>; 4],
    pub(crate) channels: [Vec<Option<f64>>; 7],
    pitch: Vec<Option<f64>>,
    payload: Vec<Option<f64>>,
}

impl Columns {
    fn of(log: &DriveLog) -> Result<Self, CliError> {
        let torque = torques(log)?;
        let samples = |s: &Series| s.iter().collect::<Vec<_>>();
        let optional = |s: &Option<Series>| s.as_ref().map(samples).unwrap_or_default();
        let [fl, fr, rl, rr] = log.wheel_speed.each_ref().map(samples);
        Ok(Columns {
            time: log.time.clone(),
            segments: log.segments.iter().map(|s| s.rows.clone()).collect(),
            torque: torque.each_ref().map(samples),
            channels: [
                optional(&log.accel_x),
                fl,
                fr,
                rl,
                rr,
                optional(&log.ground_speed),
                optional(&log.yaw_rate),
            ],
            pitch: optional(&log.pitch),
            payload: optional(&log.payload),
        })
    }

    /// Runs the force filter.
    ///
    /// # Errors
    /// What the filter refuses.
    pub(crate) fn estimate(&self, config: &ForceConfig) -> Result<Vec<Step>, FilterError> {
        let robot = RobotLog {
            time: &self.time,
            segments: &self.segments,
            torque: self.torque.each_ref().map(Vec::as_slice),
            channels: self.channels.each_ref().map(Vec::as_slice),
            pitch: &self.pitch,
            payload: &self.payload,
        };
        estimate_forces(&robot, config)
    }
}

fn torques(log: &DriveLog) -> Result<&[Series; 4], CliError> {
    log.wheel_torque.as_ref().ok_or_else(|| {
        CliError::data(
            "the log has neither wheel torques nor motor currents, so the forces of the ground cannot be told from those of the motors",
            "log wheel_torque_fl_N_m ... rr, or motor_current_fl_A ... rr with [drivetrain] in the rover file",
        )
    })
}

/// The rows of a block as the force filter takes them, each with the name of the segment that begins at it.
pub(crate) fn rows(block: &DriveBlock) -> impl Iterator<Item = (Option<&str>, RobotRow)> {
    let log = &block.log;
    let at = |series: &Option<Series>, k: usize| series.as_ref().and_then(|s| s.get(k));
    let row = move |k: usize| {
        let [fl, fr, rl, rr] = log.wheel_speed.each_ref().map(|s| s.get(k));
        let torque = log.wheel_torque.as_ref();
        RobotRow {
            row: block.first_row + k,
            time: log.time.get(k).copied().unwrap_or(f64::NAN),
            torque: torque.map_or([None; 4], |t| t.each_ref().map(|s| s.get(k))),
            channels: [
                at(&log.accel_x, k),
                fl,
                fr,
                rl,
                rr,
                at(&log.ground_speed, k),
                at(&log.yaw_rate, k),
            ],
            pitch: at(&log.pitch, k),
            payload: at(&log.payload, k),
        }
    };
    log.segments
        .iter()
        .enumerate()
        .flat_map(move |(i, segment)| {
            let begins = (i > 0 || !block.continues).then_some(segment.name.as_str());
            let first = segment.rows.start;
            let named = move |k: usize| (begins.filter(|_| k == first), row(k));
            segment.rows.clone().map(named)
        })
}

/// The 1-sigma of a sensor. A channel the log lacks needs none; any number will do, as it is never used.
fn noise(rover: &Rover, key: &str, present: bool) -> Result<f64, CliError> {
    match rover.noise.get(key) {
        Some(sd) => Ok(sd),
        None if !present => Ok(1.0),
        None => Err(CliError::rover(
            format!("[noise] lacks {key}, and the log has that channel"),
            format!("add {key} = ... (1-sigma per sample) to [noise] of the rover file"),
        )),
    }
}

/// The vehicle, and what the filter says of each row.
pub(crate) struct Forces {
    pub(crate) vehicle: Vehicle<f64>,
    pub(crate) steps: Vec<Step>,
}

/// Runs the force filter over a log.
///
/// # Errors
/// A rover without vehicle, a channel without noise level, a log without torques, or what the filter refuses.
pub(crate) fn forces(
    log: &DriveLog,
    rover: &Rover,
    filter: &str,
    smooth: bool,
) -> Result<Forces, CliError> {
    let (columns, config) = prepare(log, rover, filter, smooth)?;
    let steps = columns.estimate(&config)?;
    Ok(Forces {
        vehicle: *config.space.vehicle(),
        steps,
    })
}

/// The columns of a log, and how they are to be run.
///
/// # Errors
/// A rover without vehicle, a channel without noise level, a log without torques, or numbers no robot has.
pub(crate) fn prepare(
    log: &DriveLog,
    rover: &Rover,
    filter: &str,
    smooth: bool,
) -> Result<(Columns, ForceConfig), CliError> {
    let config = config(log, rover, filter, smooth)?;
    Ok((Columns::of(log)?, config))
}

/// How the rows of a log are to be run; any block of it tells which channels it has.
///
/// # Errors
/// As [`prepare`].
pub(crate) fn config(
    log: &DriveLog,
    rover: &Rover,
    filter: &str,
    smooth: bool,
) -> Result<ForceConfig, CliError> {
    let vehicle = rover.nominal_vehicle().ok_or_else(|| {
        CliError::rover(
            "a drive log needs [vehicle] in the rover file",
            "see the examples folder",
        )
    })?;
    torques(log)?;
    let sensors = SensorNoise {
        accel_x: noise(rover, "accel_x_m_s2", log.accel_x.is_some())?,
        wheel_speed: noise(rover, "wheel_speed_rad_s", true)?,
        ground_speed: noise(rover, "ground_speed_m_s", log.ground_speed.is_some())?,
        yaw_rate: noise(rover, "yaw_rate_rad_s", log.yaw_rate.is_some())?,
    };
    let process = ProcessNoise {
        torque_walk: rover.filter.torque_walk,
        force_walk: [rover.filter.force_walk; 2],
        ..ProcessNoise::default()
    };
    let space = LongitudinalRobot::new(vehicle, sensors, process, PriorSpread::default())?;
    Ok(ForceConfig {
        filter: filter.to_owned(),
        smooth,
        no_ground_speed: rover.filter.ground_speed == GroundSpeedSource::None,
        start_wait: rover.filter.start_wait,
        ..ForceConfig::new(space)
    })
}
