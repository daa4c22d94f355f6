//! Two data sets of a Clearpath Husky A200 (one motor a side, wheels of one side turn together).

use std::ops::Range;

use super::frame::Frame;
use super::{Cell, ImportedLog};
use crate::error::DataError;

/// Wheel radius \[m\].
const RADIUS: f64 = 0.165;
/// Rate of the windows \[Hz\].
const RATE: f64 = 20.0;
/// Samples to either side that a speed is the slope of.
const REACH: usize = 5;

/// Windows of 2 s of D. Baril et al., arXiv 2309.10718 (github.com/norlab-ulaval/DRIVE): wheel speeds a side and lidar
/// poses.
///
/// # Equation
/// v, r (and v_y): slopes of straight lines through the pose of the surrounding half second, turned into the body's axes;
/// never across two windows, whose poses have different origins.
pub(crate) fn norlab(frame: &Frame) -> Result<ImportedLog, DataError> {
    let window = frame.numbers("window", 1.0)?;
    let step = frame.numbers("calib_step", 1.0)?;
    let sample = frame.numbers("k", 1.0)?;
    let (left, right) = (
        frame.numbers("wl_rad_s", 1.0)?,
        frame.numbers("wr_rad_s", 1.0)?,
    );
    let (x, y, yaw) = (
        frame.numbers("x_m", 1.0)?,
        frame.numbers("y_m", 1.0)?,
        frame.numbers("yaw_rad", 1.0)?,
    );
    let (ax, ay) = (
        frame.numbers("ax_m_s2", 1.0)?,
        frame.numbers("ay_m_s2", 1.0)?,
    );
    let mut rows = vec![];
    let mut start = 0;
    while start < frame.rows {
        let same = |row: &usize| window.get(*row) == window.get(start);
        let end = (start..frame.rows).take_while(same).last().unwrap_or(start) + 1;
        let pose = Pose {
            x: piece(&x, start..end),
            y: piece(&y, start..end),
            yaw: unwrapped(&piece(&yaw, start..end)),
        };
        for row in start..end {
            let at = |column: &[Option<f64>]| column.get(row).copied().flatten();
            let (Some(w), Some(s), Some(k)) = (at(&window), at(&step), at(&sample)) else {
                continue;
            };
            let (speed, _, turn) = pose.motion(row - start);
            let mut cells = vec![
                // Windows follow one another: the encoder's held values run on from one into the next.
                Cell::Number(Some((w * (end - start) as f64 + k) / RATE)),
                Cell::Text(format!("step_{s:03}")),
            ];
            for v in [
                at(&left),
                at(&right),
                at(&left),
                at(&right),
                speed,
                turn,
                at(&ax),
                at(&ay),
            ] {
                cells.push(Cell::Number(v));
            }
            rows.push(cells);
        }
        start = end;
    }
    Ok(ImportedLog {
        header: [
            "time_s",
            "segment",
            "wheel_speed_fl_rad_s",
            "wheel_speed_fr_rad_s",
            "wheel_speed_rl_rad_s",
            "wheel_speed_rr_rad_s",
            "ground_speed_m_s",
            "yaw_rate_rad_s",
            "accel_x_m_s2",
            "accel_y_m_s2",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
        notes: vec![
            "speeds are slopes of the lidar pose over half a second; lateral speed is left out, because it depends on where along the vehicle the pose is taken, which the data set does not say; a segment is one calibration step of about three windows of 2 s; encoders report at 4 Hz and are held between"
                .to_owned(),
        ],
    })
}

/// Wheel speeds and motor currents a side of BorealTC, D. LaRocque et al., arXiv 2403.16877.
///
/// # Equation
/// ω = v_side / R with R = .165 m; a side's one motor drives two wheels, so each is given half of its current.
pub(crate) fn borealtc(frame: &Frame) -> Result<ImportedLog, DataError> {
    let (terrain, run) = (frame.texts("terrain")?, frame.texts("run")?);
    let time = frame.numbers("time", 1.0)?;
    let speed = [
        frame.numbers("velL", 1.0 / RADIUS)?,
        frame.numbers("velR", 1.0 / RADIUS)?,
    ];
    let current = [frame.numbers("curL", 0.5)?, frame.numbers("curR", 0.5)?];
    let mut rows = vec![];
    let mut last: Option<(String, f64)> = None;
    let mut left_out = 0usize;
    for row in 0..frame.rows {
        let at = |column: &[Option<f64>]| column.get(row).copied().flatten();
        let name = |column: &[String]| column.get(row).cloned().unwrap_or_default();
        let segment = format!("{}_{}", name(&terrain), name(&run));
        let Some(t) = at(&time) else {
            left_out += 1;
            continue;
        };
        if last
            .as_ref()
            .is_some_and(|(s, before)| *s == segment && t <= *before)
        {
            left_out += 1;
            continue;
        }
        let mut cells = vec![Cell::Number(Some(t)), Cell::Text(segment.clone())];
        for four in [&speed, &current] {
            let [l, r] = four;
            cells.extend([at(l), at(r), at(l), at(r)].map(Cell::Number));
        }
        rows.push(cells);
        last = Some((segment, t));
    }
    Ok(ImportedLog {
        header: [
            "time_s",
            "segment",
            "wheel_speed_fl_rad_s",
            "wheel_speed_fr_rad_s",
            "wheel_speed_rl_rad_s",
            "wheel_speed_rr_rad_s",
            "motor_current_fl_A",
            "motor_current_fr_A",
            "motor_current_rl_A",
            "motor_current_rr_A",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
        notes: vec![format!(
            "each wheel has half of its side's current, a magnitude; no ground speed, so no slip; {left_out} rows without increasing time left out"
        )],
    })
}

/// One window's pose in the frame of its start.
struct Pose {
    x: Vec<Option<f64>>,
    y: Vec<Option<f64>>,
    yaw: Vec<Option<f64>>,
}

impl Pose {
    /// v, v_y, r at a sample.
    fn motion(&self, k: usize) -> (Option<f64>, Option<f64>, Option<f64>) {
        let near = k.saturating_sub(REACH)..(k + REACH + 1).min(self.x.len());
        let (dx, dy) = (slope(&self.x, near.clone()), slope(&self.y, near.clone()));
        let turn = slope(&self.yaw, near.clone()).map(|l| l.0);
        let heading = slope(&self.yaw, near).map(|l| l.1);
        match (dx, dy, heading) {
            (Some((dx, _)), Some((dy, _)), Some(heading)) => {
                let (sin, cos) = heading.sin_cos();
                (Some(cos * dx + sin * dy), Some(cos * dy - sin * dx), turn)
            }
            _ => (None, None, turn),
        }
    }
}

/// Slope per second and mean of the present samples; none from fewer than three.
fn slope(series: &[Option<f64>], near: Range<usize>) -> Option<(f64, f64)> {
    let points: Vec<(f64, f64)> = near
        .filter_map(|i| Some((i as f64 / RATE, series.get(i).copied().flatten()?)))
        .collect();
    if points.len() < 3 {
        return None;
    }
    let n = points.len() as f64;
    let (t, v) = points
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (tt, tv) = points.iter().fold((0.0, 0.0), |s, p| {
        (s.0 + (p.0 - t).powi(2), s.1 + (p.0 - t) * (p.1 - v))
    });
    Some((tv / tt, v))
}

fn piece(column: &[Option<f64>], rows: Range<usize>) -> Vec<Option<f64>> {
    rows.map(|row| column.get(row).copied().flatten()).collect()
}

/// An angle without its jumps of a full turn.
fn unwrapped(angle: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut before: Option<f64> = None;
    angle
        .iter()
        .map(|a| {
            let a = (*a)?;
            let turn = std::f64::consts::TAU;
            let a = before.map_or(a, |b| a - turn * ((a - b) / turn).round());
            before = Some(a);
            Some(a)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle driven at .6 m/s and -.4 rad/s, facing inward by .1 rad: v = .6 cos .1, v_y = .6 sin .1 everywhere.
    #[test]
    fn motion_of_a_circle() {
        let (speed, turn, drift) = (0.6, -0.4, 0.1f64);
        let at = |f: &dyn Fn(f64) -> f64| (0..40).map(|k| Some(f(k as f64 / RATE))).collect();
        let pose = Pose {
            x: at(&|t| speed / turn * ((turn * t + drift).sin() - drift.sin())),
            y: at(&|t| -speed / turn * ((turn * t + drift).cos() - drift.cos())),
            yaw: unwrapped(
                &at(&|t| {
                    let a: f64 = turn * t - 3.0;
                    a.sin().atan2(a.cos())
                })
                .into_iter()
                .collect::<Vec<Option<f64>>>(),
            ),
        };
        // The pose's own heading starts at -3 rad here, so turn the path with it.
        let turned = Pose {
            x: pose
                .x
                .iter()
                .zip(&pose.y)
                .map(|(x, y)| Some(x.unwrap() * 3f64.cos() + y.unwrap() * 3f64.sin()))
                .collect(),
            y: pose
                .x
                .iter()
                .zip(&pose.y)
                .map(|(x, y)| Some(-x.unwrap() * 3f64.sin() + y.unwrap() * 3f64.cos()))
                .collect(),
            yaw: pose.yaw,
        };
        for k in [0, 3, 20, 39] {
            let (v, vy, r) = turned.motion(k);
            // A chord of half a second is short of its arc by (r T)²/24 at most.
            assert!((v.unwrap() - speed * drift.cos()).abs() < 1e-3, "{k} {v:?}");
            assert!(
                (vy.unwrap() - speed * drift.sin()).abs() < 1e-3,
                "{k} {vy:?}"
            );
            assert!((r.unwrap() - turn).abs() < 1e-9, "{k} {r:?}");
        }
    }
}
