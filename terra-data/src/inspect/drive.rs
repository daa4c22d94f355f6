//! What is in a drive log.

use super::clock::Pace;
use super::{ChannelSummary, Group, Inspection, Suspicion, angle, largest, motion, summary};
use crate::drive::{DriveLog, WHEELS};
use crate::kind::LogKind;
use crate::rover::Rover;
use crate::series::Series;

/// Fewest equal samples in a row that can be called stuck.
const STUCK_ROWS: usize = 25;
/// An accelerometer along x that reads more than this on average carries gravity \[m/s²\].
const GRAVITY_ON_X: f64 = 5.0;

/// Counts the channels of a drive log and says what looks wrong in it. With a rover the checks of units know the wheel's
/// radius and the track.
pub fn inspect_drive(log: &DriveLog, rover: Option<&Rover>) -> Inspection {
    let series = log.channels();
    let channels: Vec<ChannelSummary> = series
        .iter()
        .map(|(name, s)| summary(name, s.iter(), &log.notes))
        .collect();
    let groups: Vec<Group> = log
        .segments
        .iter()
        .map(|s| Group {
            name: s.name.clone(),
            rows: s.rows.len(),
            pace: log.time.get(s.rows.clone()).and_then(Pace::of),
        })
        .collect();
    let mut suspicions: Vec<Suspicion> = groups
        .iter()
        .filter_map(|g| g.pace.as_ref().map(|p| p.suspicions(&g.name)))
        .flatten()
        .collect();
    for channel in &channels {
        suspicions.extend(plausible(channel));
    }
    suspicions.extend(motion::suspicions(log, rover));
    for (name, one) in &series {
        let told = ["payload_kg", "pass", "pitch_rad", "roll_rad", "distance_m"];
        if !told.contains(&name.as_str()) {
            suspicions.extend(stuck(name, one, log));
        }
    }
    if log.normal_load.is_none() && rover.is_none_or(|r| r.vehicle.is_none()) {
        suspicions.push(Suspicion {
            code: "load-missing",
            message: "no normal_load_{fl,fr,rl,rr}_N and no [vehicle]: give --rover, whose mass and geometry set the wheel loads"
                .to_owned(),
        });
    }
    Inspection {
        kind: LogKind::Drive,
        rows: log.len(),
        channels,
        groups,
        suspicions,
        dropped: Vec::new(),
        notes: log.notes.clone(),
        warnings: log.warnings.clone(),
    }
}

/// What one channel's range says on its own.
fn plausible(channel: &ChannelSummary) -> Option<Suspicion> {
    let name = channel.name.as_str();
    if channel.present == 0 {
        return Some(Suspicion {
            code: "empty-channel",
            message: format!("{name} has no value in any row: remove the column or record it"),
        });
    }
    if name == "pitch_rad" || name == "roll_rad" {
        return angle(channel);
    }
    let mean = channel.range.map_or(0.0, |[_, mean, _]| mean);
    if name == "accel_x_m_s2" && mean.abs() > GRAVITY_ON_X {
        return Some(Suspicion {
            code: "gravity-on-x",
            message: format!(
                "{name} averages {mean:.2} m/s2: gravity lies on it, so this is not the axis that points forward"
            ),
        });
    }
    if name.starts_with("sinkage") && largest(channel) > 0.5 {
        return Some(Suspicion {
            code: "millimetres",
            message: format!(
                "{name} reaches {:.1} m: millimetres logged as metres? In [columns]: unit = \"mm\"",
                largest(channel)
            ),
        });
    }
    let low = channel.range.map_or(1.0, |[low, ..]| low);
    (name.starts_with("normal_load") && low <= 0.0).then(|| Suspicion {
        code: "load-sign",
        message: format!("{name} falls to {low:.1} N: a load presses down and is positive"),
    })
}

/// A value that stands still while the wheels change their speed.
fn stuck(name: &str, one: &Series, log: &DriveLog) -> Option<Suspicion> {
    let mut longest = 0..0;
    for segment in &log.segments {
        let mut begin = segment.rows.start;
        for k in segment.rows.clone() {
            if one.get(k).is_none() || one.get(k) != one.get(begin) {
                begin = k;
            }
            if k + 1 - begin > longest.len() {
                longest = begin..k + 1;
            }
        }
    }
    if longest.len() < STUCK_ROWS.max(log.len() / 20) {
        return None;
    }
    // Speeds of the other wheels in these rows: if they move, this value should.
    let moves = WHEELS
        .iter()
        .zip(&log.wheel_speed)
        .filter(|(wheel, _)| !name.contains(&format!("_{wheel}_")))
        .any(|(_, speed)| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for v in longest.clone().filter_map(|k| speed.get(k)) {
                low = low.min(v);
                high = high.max(v);
            }
            high - low > 0.05 * high.abs().max(low.abs())
        });
    let value = one.get(longest.start)?;
    let from = log.time.get(longest.start)?;
    moves.then(|| Suspicion {
        code: "stuck",
        message: format!(
            "{name} is exactly {value} for {} rows from {from} s while wheels change speed: a stuck or unplugged sensor?",
            longest.len()
        ),
    })
}
