//! The log of a vehicle: time series in SI units.

use std::ops::Range;

use crate::notes::ReadNotes;
use crate::series::Series;

/// The wheels, in the order of every array of four: front left, front right, rear left, rear right.
pub const WHEELS: [&str; 4] = ["fl", "fr", "rl", "rr"];

/// One manoeuvre: rows that belong together. Filters restart at each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its name in the log (or `all`).
    pub name: String,
    /// Its rows.
    pub rows: Range<usize>,
}

/// A vehicle's log. Every series has one sample a row; `None` for a channel the log does not have.
#[derive(Clone, Debug, Default)]
pub struct DriveLog {
    /// t \[s\], strictly increasing inside a segment.
    pub time: Vec<f64>,
    /// Manoeuvres, in order, covering all rows.
    pub segments: Vec<Segment>,
    /// ω of each wheel \[rad/s\].
    pub wheel_speed: [Series; 4],
    /// Torque applied at each wheel after the gearbox \[N m\] (from currents where the log has those).
    pub wheel_torque: Option<[Series; 4]>,
    /// v at the centre of mass \[m/s\].
    pub ground_speed: Option<Series>,
    /// r \[rad/s\], left positive.
    pub yaw_rate: Option<Series>,
    /// Specific force along x \[m/s²\].
    pub accel_x: Option<Series>,
    /// Specific force along y \[m/s²\].
    pub accel_y: Option<Series>,
    /// Speed along y \[m/s\].
    pub lateral_speed: Option<Series>,
    /// Nose-up positive \[rad\].
    pub pitch: Option<Series>,
    /// Left side up positive \[rad\].
    pub roll: Option<Series>,
    /// Path travelled \[m\].
    pub distance: Option<Series>,
    /// z of each wheel \[m\].
    pub sinkage: Option<[Series; 4]>,
    /// W of each wheel \[N\].
    pub normal_load: Option<[Series; 4]>,
    /// Known extra mass at the centre of mass \[kg\].
    pub payload: Option<Series>,
    /// Pass over the same track, 1 on virgin soil.
    pub pass: Option<Series>,
    /// What the reader saw beside the numbers: unused columns, missing cells.
    pub notes: ReadNotes,
    /// What a user of the log should know.
    pub warnings: Vec<String>,
}

impl DriveLog {
    /// The series that the log has, by contract column.
    pub fn channels(&self) -> Vec<(String, &Series)> {
        let mut all: Vec<(String, &Series)> = Vec::new();
        let fours = [
            ("wheel_speed", "rad_s", Some(&self.wheel_speed)),
            ("wheel_torque", "N_m", self.wheel_torque.as_ref()),
            ("sinkage", "m", self.sinkage.as_ref()),
            ("normal_load", "N", self.normal_load.as_ref()),
        ];
        for (before, after, four) in fours {
            for (wheel, series) in WHEELS.iter().zip(four.into_iter().flatten()) {
                all.push((format!("{before}_{wheel}_{after}"), series));
            }
        }
        let single = [
            ("ground_speed_m_s", &self.ground_speed),
            ("yaw_rate_rad_s", &self.yaw_rate),
            ("accel_x_m_s2", &self.accel_x),
            ("accel_y_m_s2", &self.accel_y),
            ("lateral_speed_m_s", &self.lateral_speed),
            ("pitch_rad", &self.pitch),
            ("roll_rad", &self.roll),
            ("distance_m", &self.distance),
            ("payload_kg", &self.payload),
            ("pass", &self.pass),
        ];
        for (name, series) in single {
            all.extend(series.as_ref().map(|s| (name.to_owned(), s)));
        }
        all
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// True without rows.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }
}
