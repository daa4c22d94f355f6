//! Draws that move: a log of a vehicle that hardly moves holds nothing that any method could tell.
//!
//! A window is .2 s; it moves when the mean speed of the vehicle and of each rim is above .12 m/s, which is where a
//! diagnosis begins to use it at the designs' noise of the ground speed (.03 m/s). A draw is kept when at least
//! [`needed`] windows move, on the drawn soil without any effect and in the log itself. That is asked of every kind of
//! case alike, so that being kept tells nothing.

use terra_data::{DriveLog, Series};

use super::design::{AnyLog, Design};

/// Length of a window \[s\].
pub(crate) const WINDOW: f64 = 0.2;
/// Speed above which a window moves \[m/s\].
pub(crate) const SPEED: f64 = 0.12;
/// Windows that a long design needs.
const ENOUGH: usize = 10;

/// Windows that must move: ten, or half of a short design's; none of a rig's.
pub(crate) fn needed(design: &Design) -> usize {
    let seconds: f64 = design.scenario.segments.iter().map(|s| s.duration).sum();
    ENOUGH.min((seconds / WINDOW / 2.0) as usize)
}

/// True when enough windows of a log move.
pub(crate) fn moves(log: &AnyLog, radius: f64, needed: usize) -> bool {
    match log {
        AnyLog::Drive(log) => windows(log, radius) >= needed,
        AnyLog::Rig(_) => true,
    }
}

/// Number of windows that move.
fn windows(log: &DriveLog, radius: f64) -> usize {
    let Some(speed) = &log.ground_speed else {
        return 0;
    };
    let mut count = 0;
    let mut from = 0;
    while let Some(start) = log.time.get(from) {
        let rows = log
            .time
            .iter()
            .skip(from)
            .take_while(|t| **t < start + WINDOW - 1e-9)
            .count()
            .max(1);
        let range = from..from + rows;
        let fast = |series: &Series, factor: f64| mean(series, range.clone()) * factor > SPEED;
        if fast(speed, 1.0) && log.wheel_speed.iter().all(|w| fast(w, radius)) {
            count += 1;
        }
        from += rows;
    }
    count
}

/// Mean of the absolute readings; 0 without any.
fn mean(series: &Series, rows: std::ops::Range<usize>) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for x in series.iter().skip(rows.start).take(rows.len()).flatten() {
        sum += x;
        n += 1.0;
    }
    if n > 0.0 { f64::abs(sum / n) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::design::simulate;
    use super::*;
    use terra_model::Registry;
    use terra_sim::{Command, Profile};

    fn made(name: &str, change: impl Fn(&mut Design)) -> (Design, AnyLog) {
        let mut design = Design::named(name).unwrap();
        design.scenario.noise_scale = 0.0;
        change(&mut design);
        let log = simulate(&design.scenario, &design.rover, &Registry::builtin()).unwrap();
        (design, log)
    }

    /// Torques that never overcome the resistance of the soil move nothing; the design's own torques move most of the
    /// time.
    #[test]
    fn a_vehicle_that_stands_has_no_moving_window() {
        let (design, log) = made("ramp", |_| ());
        let need = needed(&design);
        assert_eq!(need, 10);
        assert!(moves(&log, design.rover.wheel.radius, need));
        let (design, log) = made("ramp", |design| {
            for segment in &mut design.scenario.segments {
                segment.command = Command::Torque([Profile::constant(0.5); 4]);
                segment.start = None;
            }
        });
        let AnyLog::Drive(drive) = &log else {
            panic!("a drive")
        };
        assert_eq!(windows(drive, design.rover.wheel.radius), 0);
        assert!(!moves(&log, design.rover.wheel.radius, need));
    }

    /// Reverse is motion, and a rig always moves.
    #[test]
    fn reverse_counts_and_a_rig_is_not_asked() {
        let (design, log) = made("rich", |design| {
            design.scenario.segments.retain(|s| s.name == "reverse");
        });
        let AnyLog::Drive(drive) = &log else {
            panic!("a drive")
        };
        // 5 s of it, from -.45 m/s on.
        assert_eq!(windows(drive, design.rover.wheel.radius), 25);
        let (design, log) = made("rig", |_| ());
        assert_eq!(needed(&design), 0);
        assert!(moves(&log, design.rover.wheel.radius, 0));
    }
}
