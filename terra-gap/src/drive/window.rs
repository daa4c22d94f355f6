//! One window of a drive: its readings, their noise, and why it is left out.

use std::collections::BTreeMap;
use std::ops::Range;

use terra_data::{DriveLog, Rover, Series, WHEELS};
use terra_model::{STANDSTILL_SPEED, Vehicle, library_slip};

use super::cells::{Line, cells, declared, line};
use super::rounded::Values;
use super::way::{Along, Way};
use super::{
    ACCEL, AROUND, GRAVITY, NOISES, RAW, SPEED, SPEED_GATE, SPEED_RATE, TORQUE, VALUES, WHEEL,
    WHEEL_RATE, Window, YAW_ACCELERATION, YAW_RATE,
};
use crate::dataset::{ChannelInfo, Factors, Observation};
use crate::error::GapError;

/// Change of a wheel's slip within a window above which forces are averaged over it.
const SLIP_CHANGE: f64 = 0.03;
/// Variance of a window's mean by that inside it, of ground that forgets within 50 ms; one that fluctuates evenly up to 10 Hz has
/// half of it.
const LASTS: f64 = 0.82;
/// Jump of speed and wheels, in their noise, that begins a run of its own.
const JUMP: f64 = 3.5;
/// Slope by which no vehicle tips from one row to the next \[rad\].
const TIPPED: f64 = 0.1;
/// How fast wheels spin up under their motors \[rad/s²\].
const SPIN_UP: f64 = 30.0;
/// Why a window is left out whose slip no model covers.
pub(crate) const AGAINST_THE_MOTION: &str = "a wheel turns against the motion";
/// Channels whose scatter is looked at: four torques, a_x, v, r, four ω.
pub(crate) const SERIES: usize = 11;
/// Where they begin after the torques.
pub(super) const SCATTER_ACCEL: usize = 4;
pub(super) const SCATTER_SPEED: usize = 5;
pub(super) const SCATTER_YAW: usize = 6;
pub(super) const SCATTER_WHEEL: usize = 7;

/// True where something jumps as no vehicle's does from one row to the next, speed and wheels, payload and pass, or the slope it
/// stands on: a run of its own begins, on its own ground.
fn begins_anew(log: &DriveLog, speed: &Series, row: usize, speed_sd: f64, wheel_sd: f64) -> bool {
    let Some(last) = row.checked_sub(1) else {
        return false;
    };
    let jump = |series: &Series| Some(series.get(row)? - series.get(last)?);
    let declared = [(&log.payload, 0.0), (&log.pass, 0.0), (&log.pitch, TIPPED)];
    let jumps = |(series, least): (&Option<Series>, f64)| {
        let by = series.as_ref().and_then(jump);
        by.is_some_and(|by| by.abs() > least)
    };
    if declared.into_iter().any(jumps) {
        return true;
    }
    let two = std::f64::consts::SQRT_2;
    let rows = log.time.get(last).zip(log.time.get(row));
    let elapsed = rows.map_or(0.0, |(a, b)| b - a);
    let spun: Option<f64> = log.wheel_speed.iter().map(jump).sum();
    // The mean of four wheels, against its noise and what a motor does to them meanwhile.
    let wheels = spun.map_or(0.0, |sum| sum / 4.0 / (wheel_sd / two + SPIN_UP * elapsed));
    jump(speed).is_some_and(|v| (v / (speed_sd * two)).hypot(wheels) > JUMP)
}

/// True when a sample at `time` no longer belongs to the window that began at `t0`.
pub(crate) fn is_full(t0: f64, time: f64, rover: &Rover) -> bool {
    time >= t0 + rover.gap.window - 1e-9
}

/// True where samples take less than half a window: what bends the motion there has no room to show itself as a line's scatter.
fn is_stub(times: &[f64], window: f64) -> bool {
    let Some((first, last)) = times.first().zip(times.last()) else {
        return false;
    };
    let steps = times.len() as f64 - 1.0;
    steps > 0.0 && (last - first) * (1.0 + 1.0 / steps) < 0.5 * window - 1e-9
}

/// The seven channels of a drive, with their typical sizes.
pub(crate) fn channels(vehicle: &Vehicle<f64>) -> Vec<ChannelInfo> {
    let weight = vehicle.mass * GRAVITY;
    let torques = WHEELS.iter().map(|w| {
        (
            format!("wheel_torque_{w}_N_m"),
            "N m",
            weight / 4.0 * vehicle.wheel_radius,
        )
    });
    let turning = weight * vehicle.track / (2.0 * vehicle.yaw_inertia);
    let body = [
        ("accel_x_m_s2", "m/s2", GRAVITY),
        ("ground_speed_rate_m_s2", "m/s2", GRAVITY),
        ("yaw_acceleration_rad_s2", "rad/s2", turning),
    ]
    .map(|(name, unit, scale)| (name.to_owned(), unit, scale));
    torques
        .chain(body)
        .map(|(name, unit, scale)| ChannelInfo { name, unit, scale })
        .collect()
}

/// 1-sigma of each sensor, as far as it is used.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sensors {
    speed: f64,
    wheel: f64,
    torque: f64,
    yaw: f64,
    accel: Option<f64>,
}

impl Sensors {
    /// Speed from which a window says something about slip \[m/s\].
    fn least_speed(self) -> f64 {
        (NOISES * self.speed).clamp(STANDSTILL_SPEED, SPEED_GATE)
    }

    /// Of every series.
    pub(super) fn of_series(self) -> [f64; SERIES] {
        std::array::from_fn(|k| match k {
            SCATTER_ACCEL => self.accel.unwrap_or(0.0),
            SCATTER_SPEED => self.speed,
            SCATTER_YAW => self.yaw,
            k if k >= SCATTER_WHEEL => self.wheel,
            _ => self.torque,
        })
    }

    /// Those of two logs of one vehicle: where a log lacks a sensor, the other's.
    pub(crate) fn or(self, other: Sensors) -> Sensors {
        Sensors {
            speed: self.speed.max(other.speed),
            wheel: self.wheel.max(other.wheel),
            torque: self.torque.max(other.torque),
            yaw: self.yaw.max(other.yaw),
            accel: self.accel.or(other.accel),
        }
    }
}

/// A window that is used, of log 0 and without a number: its user gives it its place.
#[derive(Clone, Debug)]
pub(crate) struct Taken {
    pub(crate) window: Window,
    pub(crate) observation: Observation,
    /// Scatter around the line of every channel; NaN where it was not measured.
    pub(crate) scatter: [f64; SERIES],
    /// How far a sample of every channel follows the one before around the line, and of how many samples.
    pub(crate) lag: [(f64, usize); SERIES],
}

impl Taken {
    /// Takes the speeds of the windows around `own`. Where a manoeuvre ends before, the speed goes on straight, which is as
    /// uncertain as its rate changed last.
    pub(crate) fn lies_between(
        &mut self,
        before: Option<Going>,
        own: Going,
        next: [Option<Going>; 2],
        length: f64,
    ) {
        let (w, sd) = (&mut self.window, &mut self.observation.raw_sd);
        let near = next[0].unwrap_or_else(|| own.goes_on(before, length));
        let far = next[1].unwrap_or_else(|| near.goes_on(Some(own), length));
        let around = [
            near,
            far,
            before.unwrap_or_else(|| own.goes_on(next[0], -length)),
        ];
        let known = [next[0], next[1], before];
        w.known = known.iter().take_while(|n| n.is_some()).count();
        for (k, there) in around.into_iter().enumerate() {
            w.around[k] = there.time - own.time;
            (w.raw[AROUND + k], sd[AROUND + k]) = (there.mean, there.mean_sd);
        }
    }
}

impl Going {
    /// What a window would be like that follows after so long: its rate may change twice as much as it did last.
    fn goes_on(self, before: Option<Going>, after: f64) -> Going {
        let change = before.map_or(self.slope, |b| self.slope - b.slope);
        let slope_sd = 2.0 * change.hypot(self.slope_sd);
        Going {
            time: self.time + after,
            mean: self.mean + self.slope * after,
            slope: self.slope,
            mean_sd: 0.5 * after.abs() * slope_sd,
            slope_sd,
        }
    }
}

/// How a window goes: its speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Going {
    time: f64,
    mean: f64,
    slope: f64,
    mean_sd: f64,
    slope_sd: f64,
}

/// Share of the wheels' speed by which the two sides differ in a turn.
const TURNING: f64 = 0.03;

/// Share of the speed by which the travel of either side may differ where the wheels turn alike: grounds differ, and a turn dies
/// away.
const STRAIGHT: f64 = 0.01;

/// True where the wheels of one side turn faster than those of the other, by more than their noise and [`TURNING`] of `speed`.
fn sides_differ(wheels: &[Line], speed: f64) -> bool {
    let side = |k: usize| wheels.iter().skip(k).step_by(2);
    let mean = |k: usize| 0.5 * side(k).map(|w| w.mean).sum::<f64>();
    let variance: f64 = wheels.iter().map(|w| 0.25 * w.mean_sd * w.mean_sd).sum();
    (mean(1) - mean(0)).abs() > TURNING * speed + 3.0 * variance.sqrt()
}

/// Makes windows one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Reader {
    rover: Rover,
    pub(crate) vehicle: Vehicle<f64>,
    sd: Sensors,
    segment: String,
    /// True until a manoeuvre has had its first window.
    first: bool,
    way: Way,
    /// The speed of the window that was read last.
    pub(crate) going: Option<Going>,
    pub(crate) dropped: BTreeMap<String, usize>,
    /// The values that every series has had.
    pub(super) seen: [Values; SERIES],
}

impl Reader {
    /// # Errors
    /// A rover file without vehicle.
    pub(crate) fn new(rover: &Rover) -> Result<Self, GapError> {
        let vehicle = rover.nominal_vehicle().ok_or_else(|| {
            GapError::Mismatch("a drive log needs [vehicle] in the rover file".to_owned())
        })?;
        Ok(Reader {
            rover: rover.clone(),
            vehicle,
            sd: Sensors::default(),
            segment: String::new(),
            first: true,
            way: Way::default(),
            going: None,
            dropped: BTreeMap::new(),
            seen: Default::default(),
        })
    }

    /// Makes windows so long \[s\].
    pub(crate) fn widen(&mut self, window: f64) {
        self.rover.gap.window = window;
    }

    /// Looks up the noise of every channel that a log has.
    ///
    /// # Errors
    /// A used channel without noise.
    pub(crate) fn needs_noise_of(&mut self, log: &DriveLog) -> Result<(), GapError> {
        let noise = |name: &str| {
            self.rover
                .noise
                .get(name)
                .ok_or_else(|| GapError::NoiseMissing {
                    channel: name.to_owned(),
                    or: String::new(),
                })
        };
        self.sd.speed = noise("ground_speed_m_s")?;
        self.sd.wheel = noise("wheel_speed_rad_s")?;
        if log.wheel_torque.is_some() {
            self.sd.torque = noise("wheel_torque_N_m")?;
        }
        if log.yaw_rate.is_some() {
            self.sd.yaw = noise("yaw_rate_rad_s")?;
        }
        if log.accel_x.is_some() {
            self.sd.accel = Some(noise("accel_x_m_s2")?);
        }
        Ok(())
    }

    /// `row` is the segment's first.
    pub(crate) fn begin_segment(&mut self, log: &DriveLog, name: &str, row: usize) {
        name.clone_into(&mut self.segment);
        self.first = true;
        let speed = log.ground_speed.as_ref();
        let set_down = |v| begins_anew(log, v, row, self.sd.speed, self.sd.wheel);
        self.way.begin_segment(speed.is_some_and(set_down));
    }

    /// The next window by itself, kept by the caller; none where it is left out, which is counted.
    pub(crate) fn one(&mut self, log: &DriveLog, rows: Range<usize>) -> Option<Taken> {
        self.take(log, rows)
            .inspect_err(|reason| *self.dropped.entry(reason.clone()).or_default() += 1)
            .ok()
    }

    fn take(&mut self, log: &DriveLog, rows: Range<usize>) -> Result<Taken, String> {
        let (vehicle, sd_of, gap) = (self.vehicle, self.sd, self.rover.gap);
        let over = |series: &Series, sd: f64| -> Option<Line> {
            line(&log.time, series, rows.clone(), sd)
        };
        let v = log.ground_speed.as_ref().and_then(|v| over(v, sd_of.speed));
        let ends = log.time.get(rows.clone()).unwrap_or_default();
        let middle = ends.first().zip(ends.last()).map(|(a, b)| 0.5 * (a + b));
        self.going = v.as_ref().zip(middle).map(|(v, time)| Going {
            time,
            mean: v.mean,
            slope: v.slope,
            mean_sd: v.mean_sd,
            slope_sd: v.slope_sd,
        });
        // Windows that are left out are driven all the same, and in reverse the way leads back.
        let driven = v.as_ref().map_or(0.0, |v| v.mean) * gap.window;
        let along = self.way.drive(driven);
        // What was before a manoeuvre reaches into its beginning: sensors lag, controllers catch up.
        if std::mem::take(&mut self.first) {
            return Err("the beginning of a manoeuvre".to_owned());
        }
        if is_stub(ends, gap.window) {
            return Err("samples over less than half a window".to_owned());
        }
        if ends.len() < 3 {
            return Err(
                "window of fewer than three rows: a slow log wants a larger [gap] window_s"
                    .to_owned(),
            );
        }
        let v = v.ok_or("window with fewer than two samples of ground speed: a slow sensor wants a larger [gap] window_s")?;
        let wheels: Vec<Line> = log
            .wheel_speed
            .iter()
            .filter_map(|w| over(w, sd_of.wheel))
            .collect();
        if wheels.len() < 4 {
            return Err("window without all wheel speeds".to_owned());
        }
        let yaw = log.yaw_rate.as_ref().and_then(|r| over(r, sd_of.yaw));
        if yaw.is_none() && sides_differ(&wheels, v.mean.abs() / vehicle.wheel_radius) {
            return Err(
                "turning without yaw_rate_rad_s, which the travel of each side needs".to_owned(),
            );
        }
        // In a turn an inner wheel may stand while the vehicle moves.
        let turning = yaw.as_ref().map_or(0.0, |r| r.mean * 0.5 * vehicle.track);
        let travels = [v.mean - turning, v.mean + turning];
        let least = sd_of.least_speed();
        let slow = |w: &Line| (w.mean * vehicle.wheel_radius).abs() < least;
        let stands = travels.iter().any(|v| v.abs() < least);
        if stands || v.mean.abs() < least || wheels.iter().any(slow) {
            return Err(format!("standstill: below {least:.2} m/s"));
        }
        let against = |(q, w): (usize, &Line)| w.mean * travels[q % 2] < 0.0;
        if wheels.iter().enumerate().any(against) {
            return Err(AGAINST_THE_MOTION.to_owned());
        }
        let mut raw = [0.0; RAW];
        let mut sd = [0.0; RAW];
        let mut measured = vec![];
        let mut scatter = [f64::NAN; SERIES];
        let mut lag = [(f64::NAN, 0); SERIES];
        for (q, series) in log.wheel_torque.iter().flatten().enumerate() {
            if let Some(l) = over(series, sd_of.torque) {
                (raw[TORQUE + q], sd[TORQUE + q]) = (l.mean, l.mean_sd);
                scatter[q] = l.scatter;
                lag[q] = (l.lag, l.samples);
                measured.push(TORQUE + q);
            }
        }
        let accel = log.accel_x.as_ref().zip(sd_of.accel);
        if let Some(l) = accel.and_then(|(a, sd)| over(a, sd)) {
            (raw[ACCEL], sd[ACCEL]) = (l.mean, l.mean_sd);
            scatter[SCATTER_ACCEL] = l.scatter;
            lag[SCATTER_ACCEL] = (l.lag, l.samples);
            measured.push(ACCEL);
        }
        (raw[SPEED_RATE], sd[SPEED_RATE]) = (v.slope, v.slope_sd);
        measured.push(SPEED_RATE);
        (raw[SPEED], sd[SPEED]) = (v.mean, v.mean_sd);
        scatter[SCATTER_SPEED] = v.scatter;
        lag[SCATTER_SPEED] = (v.lag, v.samples);
        // Without a yaw rate the vehicle drives straight, as its wheels do; its yaw equation is then not used.
        if let Some(r) = yaw {
            (raw[YAW_ACCELERATION], sd[YAW_ACCELERATION]) = (r.slope, r.slope_sd);
            (raw[YAW_RATE], sd[YAW_RATE]) = (r.mean, r.mean_sd);
            scatter[SCATTER_YAW] = r.scatter;
            lag[SCATTER_YAW] = (r.lag, r.samples);
            measured.push(YAW_ACCELERATION);
        }
        if !measured.contains(&YAW_ACCELERATION) {
            sd[YAW_RATE] = STRAIGHT * 2.0 * v.mean.abs() / vehicle.track;
        }
        for (q, w) in wheels.iter().enumerate() {
            (raw[WHEEL + q], sd[WHEEL + q]) = (w.mean, w.mean_sd);
            scatter[SCATTER_WHEEL + q] = w.scatter;
            lag[SCATTER_WHEEL + q] = (w.lag, w.samples);
            (raw[WHEEL_RATE + q], sd[WHEEL_RATE + q]) = (w.slope, w.slope_sd);
        }
        self.see(log, rows.clone());
        let time = log.time.get(rows.start + rows.len() / 2);
        let time = time.copied().unwrap_or_default();
        let cells = |s: &Option<Series>, missing| cells(s.as_ref(), rows.clone(), missing);
        let declared = |s: &Option<Series>, missing| declared(s.as_ref(), rows.clone(), missing);
        let slips = (0..4).map(|q| library_slip(raw[WHEEL + q] * vehicle.wheel_radius, raw[SPEED]));
        let slip = slips.sum::<f64>() / 4.0;
        let (low, high) = gap.slip_range;
        if !(low..=high).contains(&slip) {
            return Err("slip outside [gap] slip_range".to_owned());
        }
        let pass = declared(&log.pass, "window without pass")?.unwrap_or(1.0);
        let payload = declared(&log.payload, "window without payload_kg")?.unwrap_or(0.0);
        let ends = [-0.5, 0.5].map(|end| {
            let dt = end * gap.window;
            let v = raw[SPEED] + raw[SPEED_RATE] * dt;
            [0, 1, 2, 3].map(|q| {
                let rim = (raw[WHEEL + q] + raw[WHEEL_RATE + q] * dt) * vehicle.wheel_radius;
                library_slip(rim, v)
            })
        });
        let change = (0..4).map(|q| (ends[1][q] - ends[0][q]).abs());
        let nodes = if change.fold(0.0, f64::max) > SLIP_CHANGE {
            // Gauss-Legendre, two points.
            let dt = gap.window / 12f64.sqrt();
            vec![-dt, dt]
        } else {
            vec![0.0]
        };
        let told = declared(&log.distance, "window without distance_m")?;
        let along = told.map_or(along, Along::told);
        let window = Window {
            raw,
            nodes,
            measured: measured.clone(),
            pitch: cells(&log.pitch, "window without pitch_rad")?.unwrap_or(0.0),
            roll: cells(&log.roll, "window without roll_rad")?.unwrap_or(0.0),
            payload,
            earlier_passes: (pass - 1.0).max(0.0),
            path: along.run,
            other_paths: along.others,
            leaning: 1.0,
            swing: 0.0,
            time,
            around: [gap.window, 2.0 * gap.window, -gap.window],
            known: 0,
            log: 0,
        };
        let observation = Observation {
            index: 0,
            group: self.segment.clone(),
            condition: String::new(),
            place: format!("t = {time:.2} s"),
            values: measured.iter().map(|&k| raw[k]).collect(),
            channels: measured,
            raw_sd: sd.to_vec(),
            shift: Default::default(),
            carried: vec![],
            factors: Factors::from([
                ("slip", slip),
                ("speed", v.mean),
                ("path", window.path),
                ("time", window.time),
                ("pass", pass),
                ("load", vehicle.mass * GRAVITY + payload * GRAVITY),
                ("yaw_rate", raw[YAW_RATE]),
            ]),
        };
        Ok(Taken {
            window,
            observation,
            scatter,
            lag,
        })
    }

    /// Looks at the values of a window.
    fn see(&mut self, log: &DriveLog, rows: Range<usize>) {
        let torques = log.wheel_torque.iter().flatten();
        let body = [&log.accel_x, &log.ground_speed, &log.yaw_rate];
        let all = torques.enumerate();
        let all = all.chain(
            (SCATTER_ACCEL..)
                .zip(body)
                .filter_map(|(k, s)| Some((k, s.as_ref()?))),
        );
        for (k, series) in all.chain((SCATTER_WHEEL..).zip(&log.wheel_speed)) {
            let values = rows.clone().filter_map(|row| series.get(row));
            values.for_each(|value| self.seen[k].see(value));
        }
    }

    /// The segment that windows belong to.
    pub(crate) fn segment(&self) -> &str {
        &self.segment
    }

    /// 1-sigma of the sensors met so far.
    pub(crate) fn sensors(&self) -> Sensors {
        self.sd
    }
}

/// Variance of a window's value at most, by what scatters inside windows beyond the sensors' noise: of the body's acceleration alone.
/// Under a motor that holds its torque a rough ground shows in a wheel's speed. `follows_itself`: the variance of its mean where
/// its samples follow each other.
pub(crate) fn short_scatter(
    usual: &[f64; SERIES],
    sensors: &Sensors,
    follows_itself: f64,
) -> Vec<Option<f64>> {
    // White noise alone scatters by 1.
    let beyond = |sd: f64| (usual[SCATTER_ACCEL] - 1.0).max(0.0) * sd * sd * LASTS;
    let mut out = vec![None; VALUES];
    out[ACCEL] = sensors.accel.map(|sd| beyond(sd).max(follows_itself));
    out
}
