//! Diagnoses of logs whose answer is known, made by the truth simulator, and of measured ones.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod calibrate;
mod conditions;
mod contrast;
mod edge;
mod far;
mod gyro;
mod light;
mod measured;
mod motion_against;
mod no_torques;
mod own_noise;
mod patch;
mod properties;
mod ramp;
mod rig;
mod rig_speeds;
mod rounded;
mod several;
mod size;
mod slip_noise;
mod turning;
mod uneven;
mod upright;
mod usual_form;
mod vehicle;
mod watch;
mod way;

use terra::data::{DriveLog, Rover, Segment, Series, parse_rover};
use terra::gap::Diagnosis;

/// A rig with the noise of a good testbed.
fn rig() -> Rover {
    rig_with("")
}

/// The same with more of `[noise]`, or more behind it.
fn rig_with(noise: &str) -> Rover {
    rig_reading_slip(0.005, noise)
}

/// The same, where slip is read with another noise.
fn rig_reading_slip(slip: f64, noise: &str) -> Rover {
    let text = format!(
        r#"
        [wheel]
        radius_m = 0.254
        width_m = 0.15
        [terrain]
        model = "wong-reece"
        start = "dry_sand"
        [noise]
        drawbar_pull_N = 0.5
        torque_N_m = 0.1
        sinkage_m = 0.001
        slip = {slip}
        normal_load_N = 0.5
        {noise}
        "#
    );
    parse_rover(&text, "rig.toml").unwrap()
}

/// The last magnitude of the first cause, as plainly fitted, and its sd.
fn magnitude(d: &Diagnosis) -> (f64, f64) {
    let first = &d.causes[0].weighed;
    let last = |x: &[f64]| first.hypothesis.parameters(x).last().copied().unwrap();
    let mut x = first.plain.x.as_slice().to_vec();
    let found = last(&x);
    let k = x.len() - 1;
    x[k] += first.posterior.covariance[(k, k)].sqrt();
    (found, (last(&x) - found).abs())
}

/// Probability of one answer, 0 when it is not among the causes.
fn probability(d: &Diagnosis, name: &str) -> f64 {
    d.causes
        .iter()
        .find(|c| c.name == name)
        .map_or(0.0, |c| c.probability)
}

fn total(d: &Diagnosis) -> f64 {
    d.causes.iter().map(|c| c.probability).sum::<f64>() + d.probability_none + d.probability_unknown
}

/// Rows of a log, the segments that they touch.
fn part(log: &DriveLog, from: usize, to: usize) -> DriveLog {
    let one = |s: &Series| -> Series { s.iter().skip(from).take(to - from).collect() };
    let some = |s: &Option<Series>| s.as_ref().map(one);
    let four = |s: &[Series; 4]| s.each_ref().map(one);
    DriveLog {
        time: log.time[from..to].to_vec(),
        segments: log
            .segments
            .iter()
            .filter(|s| s.rows.start < to && s.rows.end > from)
            .map(|s| Segment {
                name: s.name.clone(),
                rows: s.rows.start.max(from) - from..s.rows.end.min(to) - from,
            })
            .collect(),
        wheel_speed: four(&log.wheel_speed),
        wheel_torque: log.wheel_torque.as_ref().map(four),
        ground_speed: some(&log.ground_speed),
        yaw_rate: some(&log.yaw_rate),
        accel_x: some(&log.accel_x),
        pitch: some(&log.pitch),
        payload: some(&log.payload),
        pass: some(&log.pass),
        ..DriveLog::default()
    }
}
