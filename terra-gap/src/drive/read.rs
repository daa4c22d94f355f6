//! From drive logs to windows with their noise.

use std::collections::BTreeMap;

use terra_data::{DriveLog, Rover, Series};

use super::DrivePredictor;
use super::bend::{BENT, bends, usual};
use super::choice::{ALIKE, Choice};
use super::held::Held;
use super::own_noise::{self, OwnNoise};
use super::rounded;
use super::stream::Stream;
use super::window::{Sensors, Taken, channels, short_scatter};
use crate::dataset::DataSet;
use crate::error::GapError;
use crate::logs::Logs;
use crate::settings::Settings;

/// What a diagnosis keeps of one drive log: windows of motion, however long the log.
///
/// Pieces of the log go in one after the other; what is kept is a bounded number of windows and the rows of an unfinished
/// one. Where there are more windows than that, every kind of motion stays and the frequent kinds are thinned evenly.
#[derive(Clone, Debug)]
pub struct DriveWindows {
    held: Held,
    stream: Stream,
    choice: Choice,
    rows: usize,
    torques: bool,
    accelerations: bool,
    ground_speed: bool,
}

impl DriveWindows {
    /// At most `most` windows ([`Settings::windows`](crate::Settings::windows)) of a log of this vehicle.
    ///
    /// # Errors
    /// A rover file without vehicle.
    pub fn new(rover: &Rover, most: usize) -> Result<Self, GapError> {
        let stream = Stream::new(rover)?;
        let track = stream.reader.vehicle.track;
        Ok(DriveWindows {
            held: Held::default(),
            stream,
            choice: Choice::new(most, track),
            rows: 0,
            torques: false,
            accelerations: false,
            ground_speed: false,
        })
    }

    /// The next piece of the log, whose first segment goes on with the last one where it has its name and time increases.
    ///
    /// # Errors
    /// A used channel without noise level.
    pub fn push(&mut self, piece: &DriveLog) -> Result<(), GapError> {
        self.take(piece, false)
    }

    /// The end of the log, which ends its last window too.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn finish(&mut self) -> Result<(), GapError> {
        self.take(&DriveLog::default(), true)
    }

    /// Those of a log in memory.
    ///
    /// # Errors
    /// As [`new`](Self::new) and [`push`](Self::push).
    pub fn of(log: &DriveLog, rover: &Rover, most: usize) -> Result<Self, GapError> {
        let mut windows = Self::new(rover, most)?;
        windows.take(log, true)?;
        Ok(windows)
    }

    /// Whether the log holds wheel torques.
    pub fn has_torques(&self) -> bool {
        self.torques
    }

    /// Whether a log that begins like this tells of forces: by wheel torques, or by the accelerations that forces cause, where the
    /// rover file has their noise and names the soil, of which nothing can be said first. Otherwise it tells of motion alone
    /// ([`diagnose_kinematic`](crate::diagnose_kinematic)).
    pub(crate) fn tell_of_forces(log: &DriveLog, rover: &Rover, settings: &Settings) -> bool {
        let reads =
            |series: &Option<Series>| series.iter().flat_map(Series::iter).any(|v| v.is_some());
        let felt = reads(&log.accel_x) && reads(&log.ground_speed);
        let known = rover.noise.get("accel_x_m_s2").is_some() && rover.terrain.start.is_some();
        log.wheel_torque.is_some() || felt && known && !settings.motion_only
    }

    /// What to heed where the ground speed is held between readings.
    pub(crate) fn held(&self, prefix: &str) -> Option<String> {
        self.held.note(prefix)
    }

    /// What to heed where windows are longer than usual.
    pub(crate) fn widened(&self, prefix: &str) -> Option<String> {
        self.stream.widened(prefix)
    }

    /// What to heed where channels are rounded coarsely.
    pub(crate) fn rounded(&self, prefix: &str) -> impl Iterator<Item = String> {
        let (_, notes) = self.beside_their_digits();
        notes.into_iter().map(move |note| format!("{prefix}{note}"))
    }

    /// The windows kept, less sure by what their digits hide, and what is said of that.
    fn beside_their_digits(&self) -> (Vec<Taken>, Vec<String>) {
        let reader = &self.stream.reader;
        let mut kept: Vec<Taken> = self.choice.clone().into_windows().collect();
        let notes = rounded::raise(&mut kept, &reader.seen, &reader.sensors().of_series());
        (kept, notes)
    }

    /// How long they would be with three readings of every channel, where they hold two \[s\].
    pub(crate) fn roomier(&self) -> Option<f64> {
        self.stream.roomier()
    }

    /// How long windows are \[s\].
    pub(crate) fn window(&self) -> f64 {
        self.stream.window()
    }

    /// How many windows are kept.
    pub fn kept(&self) -> usize {
        self.choice.len()
    }

    fn take(&mut self, piece: &DriveLog, last: bool) -> Result<(), GapError> {
        self.rows += piece.len();
        self.torques |= piece.wheel_torque.is_some();
        self.accelerations |= piece.accel_x.is_some();
        self.ground_speed |= piece.ground_speed.is_some();
        if !self.ground_speed {
            return Ok(());
        }
        let piece = self.held.pass(piece, last);
        for slot in self.stream.push(&piece, last)? {
            if let Some(taken) = slot.taken {
                self.choice.offer(taken);
            }
        }
        Ok(())
    }
}

/// Turns the windows of drive logs into a data set of at most `most` of them, and their predictor.
pub(crate) fn from_logs(
    logs: &Logs<'_, DriveWindows>,
    rover: &Rover,
    most: usize,
) -> Result<(DataSet, DrivePredictor), GapError> {
    let (data, predictor, bent) = joined(logs, rover, most)?;
    Ok((without(data, &bent), predictor))
}

/// The same of one log.
///
/// # Errors
/// A rover file without vehicle, or without the noise of a used channel.
pub(crate) fn from_log(
    log: &DriveLog,
    rover: &Rover,
    most: usize,
) -> Result<(DataSet, DrivePredictor), GapError> {
    let windows = DriveWindows::of(log, rover, most)?;
    from_logs(&Logs::one(&windows), rover, most)
}

/// The same, all of them, those with a step or an outlier inside too.
///
/// # Errors
/// As there.
pub(crate) fn all_windows(
    log: &DriveLog,
    rover: &Rover,
) -> Result<(DataSet, DrivePredictor), GapError> {
    let windows = DriveWindows::of(log, rover, usize::MAX)?;
    joined(&Logs::one(&windows), rover, usize::MAX).map(|(data, predictor, _)| (data, predictor))
}

/// Leaves out, and counts, the bent windows.
fn without(mut data: DataSet, bent: &[bool]) -> DataSet {
    let before = data.observations.len();
    data.observations
        .retain(|o| !bent.get(o.index).copied().unwrap_or(false));
    if data.observations.len() < before {
        data.dropped
            .insert(BENT.to_owned(), before - data.observations.len());
    }
    data
}

/// All windows, and which of them are bent: a step or an outlier inside.
fn joined(
    logs: &Logs<'_, DriveWindows>,
    rover: &Rover,
    most: usize,
) -> Result<(DataSet, DrivePredictor, Vec<bool>), GapError> {
    let vehicle = DriveWindows::new(rover, most)?.stream.reader.vehicle;
    let forces = logs.iter().any(|(_, log)| log.torques || log.accelerations);
    let useful = forces && logs.iter().any(|(_, log)| log.ground_speed);
    let mut dropped: BTreeMap<String, usize> = BTreeMap::new();
    let mut leave_out = |reason: &str, n: usize| {
        if n > 0 {
            *dropped.entry(reason.to_owned()).or_default() += n;
        }
    };
    let mut notes = vec![];
    let mut sensors = Sensors::default();
    let mut choice = Choice::new(most, vehicle.track);
    for (number, (prefix, log)) in logs.iter().enumerate() {
        if !useful || !log.ground_speed {
            let reason = "no ground speed, or neither wheel torques, motor currents with [drivetrain] nor accelerations";
            leave_out(reason, log.rows);
            continue;
        }
        sensors = sensors.or(log.stream.reader.sensors());
        notes.extend(log.held(prefix));
        notes.extend(log.widened(prefix));
        for (reason, n) in &log.stream.reader.dropped {
            leave_out(reason, *n);
        }
        leave_out(ALIKE, log.choice.left_out());
        let (kept, rounded) = log.beside_their_digits();
        notes.extend(rounded.iter().map(|note| format!("{prefix}{note}")));
        for mut taken in kept {
            taken.window.log = number;
            let o = &mut taken.observation;
            for text in [&mut o.group, &mut o.place] {
                text.insert_str(0, prefix);
            }
            choice.offer(taken);
        }
    }
    leave_out(ALIKE, choice.left_out());
    let mut chosen: Vec<Taken> = choice.into_windows().collect();
    let rough = rover.noise.get("roughness_N").is_some();
    let follows_itself = own_noise::beyond_of_acceleration(&chosen);
    let own = OwnNoise::of(&chosen, rough);
    chosen.iter_mut().for_each(|taken| own.raise(taken));
    notes.extend(own.notes);
    let usual = usual(chosen.iter());
    let bent = chosen.iter().map(|taken| bends(taken, &usual)).collect();
    let (windows, mut observations): (Vec<_>, Vec<_>) = chosen
        .into_iter()
        .map(|taken| (taken.window, taken.observation))
        .unzip();
    for (index, o) in observations.iter_mut().enumerate() {
        o.index = index;
    }
    let data = DataSet {
        uneven: None,
        channels: if useful { channels(&vehicle) } else { vec![] },
        short_scatter: if useful {
            short_scatter(&usual, &sensors, follows_itself)
        } else {
            vec![]
        },
        observations,
        dropped,
        notes,
    };
    let predictor = DrivePredictor::new(vehicle, windows, logs.soils());
    Ok((data, predictor, bent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::ROVER;
    use crate::predictor::Predict;
    use std::ops::Range;
    use terra_data::{Segment, Series, parse_rover};

    fn numbered(rows: [Range<usize>; 3]) -> Vec<Segment> {
        let named = |(k, rows): (usize, _)| Segment {
            name: k.to_string(),
            rows,
        };
        rows.into_iter().enumerate().map(named).collect()
    }

    /// 1 m/s ahead, a new run at -1 m/s, and its continuation: x = t, then x = -t from its own start to the end. The first
    /// window of a manoeuvre is left out, but driven.
    #[test]
    fn the_path_is_signed_counts_what_is_left_out_and_starts_with_a_run() {
        let mut log = DriveLog::default();
        let mut speed = Series::with_capacity(600);
        let mut torque = Series::with_capacity(600);
        let mut wheel = Series::with_capacity(600);
        for k in 0..600 {
            let v = if k < 200 { 1.0 } else { -1.0 };
            log.time.push(0.01 * f64::from(k));
            speed.push(Some(v));
            wheel.push(Some(v / 0.25 * 1.1));
            torque.push(Some(1.0));
        }
        log.wheel_speed = std::array::from_fn(|_| wheel.clone());
        log.wheel_torque = Some(std::array::from_fn(|_| torque.clone()));
        log.ground_speed = Some(speed);
        log.segments = numbered([0..200, 200..400, 400..600]);
        let rover = parse_rover(ROVER, "rover.toml").unwrap();
        let (data, _) = all_windows(&log, &rover).unwrap();
        assert_eq!(data.observations.len(), 27);
        for o in &data.observations {
            let t = o.factors["time"];
            // A window of .2 s has its middle sample at .1 s, which is the middle of what it drives.
            let way = if t < 2.0 { t } else { 2.0 - t };
            assert!(
                (o.factors["path"] - way).abs() < 1e-9,
                "{} at {t}",
                o.factors["path"]
            );
        }
    }

    /// A vehicle that goes on at the same speed and with the same wheels, but with a payload that it did not have, in another pass
    /// or down the slope that it went up: a run of its own. Without that it goes on along its path.
    #[test]
    fn a_payload_a_pass_or_another_slope_begins_a_run() {
        let paths = |change: &dyn Fn(&mut DriveLog, Series)| {
            let mut log = DriveLog::default();
            let same = |v: f64| -> Series { std::iter::repeat_n(Some(v), 400).collect() };
            log.time = (0..400).map(|k| 0.01 * f64::from(k)).collect();
            log.wheel_speed = std::array::from_fn(|_| same(4.4));
            log.wheel_torque = Some(std::array::from_fn(|_| same(5.0)));
            log.ground_speed = Some(same(1.0));
            log.segments = numbered([0..200, 200..400, 400..400]);
            change(
                &mut log,
                (0..400).map(|k| Some(f64::from(k / 200))).collect(),
            );
            let (data, _) = all_windows(&log, &parse_rover(ROVER, "rover.toml").unwrap()).unwrap();
            data.observations.last().unwrap().factors["path"]
        };
        assert!((paths(&|_, _| ()) - 3.9).abs() < 1e-9);
        let scaled = |step: Series, from: f64, by: f64| -> Series {
            step.iter().map(|s| s.map(|s| from + by * s)).collect()
        };
        let payload = paths(&|log, step| log.payload = Some(step));
        let pass = paths(&|log, step| log.pass = Some(scaled(step, 1.0, 1.0)));
        let pitch = paths(&|log, step| log.pitch = Some(scaled(step, 0.1, -0.2)));
        for path in [payload, pass, pitch] {
            assert!((path - 1.9).abs() < 1e-9, "{path}");
        }
    }

    /// .2 m/s and .5 rad/s: the inner wheels of a track of .6 m travel at .05 m/s, where no slip is to be known, although the
    /// vehicle moves and every wheel turns. At .4 m/s they travel.
    #[test]
    fn a_window_whose_inner_wheels_stand_is_left_out() {
        let turn = |speed: f64| {
            let mut log = DriveLog::default();
            let same = |v: f64| -> Series { std::iter::repeat_n(Some(v), 200).collect() };
            log.time = (0..200).map(|k| 0.01 * f64::from(k)).collect();
            log.wheel_speed = std::array::from_fn(|_| same(1.2 * speed / 0.25));
            log.wheel_torque = Some(std::array::from_fn(|_| same(5.0)));
            log.ground_speed = Some(same(speed));
            log.yaw_rate = Some(same(0.5));
            log.segments = vec![Segment {
                name: "turn".to_owned(),
                rows: 0..200,
            }];
            from_log(&log, &parse_rover(ROVER, "rover.toml").unwrap(), usize::MAX)
        };
        let (data, _) = turn(0.4).unwrap();
        assert!(data.observations.len() > 5);
        assert!(!data.dropped.keys().any(|why| why.contains("standstill")));
        match turn(0.2) {
            Ok((data, _)) => assert!(data.observations.is_empty(), "{:?}", data.dropped),
            Err(e) => assert!(e.to_string().contains("standstill"), "{e}"),
        }
    }

    /// Wheels of the right side 30 % faster than those of the left: without a yaw rate the travel of either side is not known.
    /// Wheels that turn alike drive straight.
    #[test]
    fn a_turn_without_a_yaw_rate_is_left_out() {
        let windows = |right: f64| {
            let mut log = DriveLog::default();
            let same = |v: f64| -> Series { std::iter::repeat_n(Some(v), 200).collect() };
            log.time = (0..200).map(|k| 0.01 * f64::from(k)).collect();
            let turns = |q: usize| if q.is_multiple_of(2) { 3.0 } else { right };
            log.wheel_speed = std::array::from_fn(|q| same(turns(q)));
            log.wheel_torque = Some(std::array::from_fn(|_| same(5.0)));
            log.ground_speed = Some(same(0.7));
            log.segments = vec![Segment {
                name: "way".to_owned(),
                rows: 0..200,
            }];
            let rover = parse_rover(ROVER, "rover.toml").unwrap();
            all_windows(&log, &rover).unwrap().0
        };
        assert_eq!(windows(3.01).observations.len(), 9);
        let turn = windows(3.9);
        assert!(turn.observations.is_empty());
        let why: Vec<&String> = turn.dropped.keys().collect();
        assert!(why.iter().any(|w| w.contains("yaw_rate_rad_s")), "{why:?}");
    }

    /// A speed of 1 + .3 t + .2 t² m/s that is logged .2 s late, or behind a filter of .2 s: with that delay or time constant every
    /// window misfits by what the punctual log's window does without, to rounding. By the first order in the delay speed,
    /// acceleration and readings would be off.
    #[test]
    fn a_late_ground_speed_is_set_right() {
        const LATE: f64 = 0.2;
        let at = |t: f64| 1.0 + 0.3 * t + 0.2 * t * t;
        // The logged speed, and what makes it right.
        let residuals = |logged: &dyn Fn(f64) -> f64, form: Option<&str>| {
            let mut log = DriveLog::default();
            let mut speed = Series::default();
            let mut wheel = Series::default();
            let mut torque = Series::default();
            for k in 0..200 {
                let t = 0.01 * f64::from(k);
                log.time.push(t);
                speed.push(Some(logged(t)));
                wheel.push(Some(1.15 * at(t) / 0.25));
                torque.push(Some(5.0));
            }
            log.wheel_speed = std::array::from_fn(|_| wheel.clone());
            log.wheel_torque = Some(std::array::from_fn(|_| torque.clone()));
            log.ground_speed = Some(speed);
            log.segments = numbered([0..200, 200..200, 200..200]);
            let rover = parse_rover(ROVER, "rover.toml").unwrap();
            let (data, predictor) = all_windows(&log, &rover).unwrap();
            let registry = terra_model::Registry::builtin().with_forms();
            let effect = |form| registry.effect_form("ground-speed-delay", form).unwrap();
            let effects = form.map(effect);
            let law = registry.law("wong-reece").unwrap();
            let law = law.with_effects(effects).unwrap();
            let soil = [0.99e3, 1.528e6, 1.1, 1040.0, 0.49, 0.025, 0.18, 0.32];
            let p = [&soil[..], &vec![LATE; law.effects().len()]].concat();
            // The last two have no two windows after them.
            let within = &data.observations[..data.observations.len() - 2];
            let residual = |o: &crate::dataset::Observation| {
                let raw = predictor.raw(o.index);
                predictor.residual(&law, &p, o.index, &raw).unwrap()
            };
            within.iter().map(residual).collect::<Vec<_>>()
        };
        let punctual = residuals(&at, None);
        assert!(punctual.len() > 6);
        let late = residuals(&|t| at(t - LATE), Some("default"));
        // LATE u' = v - u, settled long ago.
        let settled = |t: f64| at(t) - LATE * (0.3 + 0.4 * t) + LATE * LATE * 0.4;
        let filtered = residuals(&settled, Some("first-order"));
        for late in [late, filtered] {
            for (a, b) in punctual.iter().flatten().zip(late.iter().flatten()) {
                assert!((a - b).abs() < 1e-9 * (1.0 + a.abs()), "{a} {b}");
            }
        }
    }

    /// Pieces of seven rows, of a thousand, and the whole give the same windows.
    #[test]
    fn where_the_pieces_of_a_log_end_does_not_matter() {
        let mut log = DriveLog::default();
        let mut wheel = Series::default();
        let (mut speed, mut torque) = (Series::default(), Series::default());
        for k in 0..3000 {
            log.time.push(0.01 * f64::from(k));
            wheel.push(Some(2.0 + (0.003 * f64::from(k)).sin()));
            speed.push((k % 50 != 3).then_some(0.4));
            torque.push(Some(5.0 + 0.001 * f64::from(k)));
        }
        log.wheel_speed = std::array::from_fn(|_| wheel.clone());
        log.wheel_torque = Some(std::array::from_fn(|_| torque.clone()));
        log.ground_speed = Some(speed);
        log.segments = numbered([0..800, 800..810, 810..3000]);
        let rover = parse_rover(ROVER, "rover.toml").unwrap();
        let said = |windows: &DriveWindows| {
            let (data, predictor) = from_logs(&Logs::one(windows), &rover, 40).unwrap();
            format!("{data:?} {predictor:?}")
        };
        let whole = said(&DriveWindows::of(&log, &rover, 40).unwrap());
        for rows in [7, 1000] {
            let mut windows = DriveWindows::new(&rover, 40).unwrap();
            for start in (0..3000).step_by(rows) {
                windows
                    .push(&crate::drive::stream::rows(
                        &log,
                        start..(start + rows).min(3000),
                    ))
                    .unwrap();
            }
            windows.finish().unwrap();
            assert_eq!(said(&windows), whole);
        }
    }
}
