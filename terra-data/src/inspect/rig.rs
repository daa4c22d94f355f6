//! What is in a rig log.

use super::clock::Pace;
use super::rig_forces::forces;
use super::rig_speeds::slip_against_speeds;
use super::wheel_size::wheel_size;
use super::{Count, Group, Inspection, Suspicion, angle, largest};
use crate::kind::LogKind;
use crate::rig::{Measured, RigLog, RigRow};
use crate::rover::Rover;

/// Fewest rows that say anything about a sign.
const FEW: usize = 5;
type Reading = fn(&RigRow) -> Option<f64>;

/// Counts the channels of a rig log and says what looks wrong in it.
pub fn inspect_rig(log: &RigLog, rover: Option<&Rover>) -> Inspection {
    fn value(m: Option<Measured>) -> Option<f64> {
        m.map(|m| m.value)
    }
    let readings: [(&str, Reading); 10] = [
        ("time_s", |r| r.time),
        ("slip", |r| Some(r.slip.value)),
        ("normal_load_N", |r| Some(r.normal_load.value)),
        ("drawbar_pull_N", |r| value(r.drawbar_pull)),
        ("torque_N_m", |r| value(r.torque)),
        ("sinkage_m", |r| value(r.sinkage)),
        ("side_force_N", |r| value(r.side_force)),
        ("slip_angle_rad", |r| r.slip_angle),
        ("travel_speed_m_s", |r| r.travel_speed),
        ("wheel_speed_rad_s", |r| r.wheel_speed),
    ];
    let channels: Vec<_> = readings
        .iter()
        .map(|(name, read)| {
            let mut count = Count::default();
            log.rows.iter().for_each(|row| count.see(read(row)));
            count.summary(name, &log.notes)
        })
        .filter(|c| c.present > 0)
        .collect();
    let mut groups: Vec<Group> = Vec::new();
    let mut times: Vec<Vec<f64>> = Vec::new();
    for row in &log.rows {
        let at = groups.iter().position(|g| g.name == row.trial);
        let at = at.unwrap_or_else(|| {
            groups.push(Group {
                name: row.trial.clone(),
                rows: 0,
                pace: None,
            });
            times.push(Vec::new());
            groups.len() - 1
        });
        if let (Some(group), Some(time)) = (groups.get_mut(at), times.get_mut(at)) {
            group.rows += 1;
            time.extend(row.time);
        }
    }
    for (group, time) in groups.iter_mut().zip(&times) {
        group.pace = Pace::of(time);
    }
    let mut suspicions: Vec<Suspicion> = groups
        .iter()
        .filter_map(|g| g.pace.as_ref().map(|p| p.suspicions(&g.name)))
        .flatten()
        .collect();
    for channel in &channels {
        match channel.name.as_str() {
            "slip_angle_rad" => suspicions.extend(angle(channel)),
            "slip" if largest(channel) > 1.0 => suspicions.push(Suspicion {
                code: "slip-range",
                message: format!(
                    "slip reaches {:.3}; it lies in [-1, 1]: percent, or another definition? In [columns]: convention = \"percent\"",
                    largest(channel)
                ),
            }),
            "sinkage_m" => suspicions.extend(deep(largest(channel), rover)),
            "torque_N_m" | "drawbar_pull_N" => {
                suspicions.extend(still(&channel.name, channel.range, channel.present));
            }
            _ => {}
        }
    }
    match load_sign(log) {
        Some(sign) => suspicions.push(sign),
        None => suspicions.extend(forces(log, rover)),
    }
    if let Some(rover) = rover {
        suspicions.extend(slip_against_speeds(log, rover));
        suspicions.extend(wheel_size(rover));
    }
    Inspection {
        kind: LogKind::Rig,
        rows: log.rows.len(),
        channels,
        groups,
        suspicions,
        dropped: log.dropped.clone(),
        notes: log.notes.clone(),
        warnings: log.warnings.clone(),
    }
}

fn deep(found: f64, rover: Option<&Rover>) -> Option<Suspicion> {
    let limit = rover.map_or(0.5, |r| 2.0 * r.wheel.radius);
    (found > limit).then(|| Suspicion {
        code: "millimetres",
        message: format!(
            "sinkage_m reaches {found:.2} m, deeper than {limit} m: millimetres logged as metres? In [columns]: unit = \"mm\""
        ),
    })
}

fn still(name: &str, range: Option<[f64; 3]>, rows: usize) -> Option<Suspicion> {
    let [low, _, high] = range?;
    (low == high && rows >= FEW).then(|| Suspicion {
        code: "stuck",
        message: format!(
            "{name} is exactly {low} in all {rows} rows: a stuck or unplugged sensor?"
        ),
    })
}

fn load_sign(log: &RigLog) -> Option<Suspicion> {
    let row = log.rows.iter().find(|r| r.normal_load.value <= 0.0)?;
    Some(Suspicion {
        code: "load-sign",
        message: format!(
            "normal_load_N is {} in line {}: a load presses down and is positive",
            row.normal_load.value, row.line
        ),
    })
}
