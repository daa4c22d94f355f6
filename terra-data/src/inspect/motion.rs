//! Channels of a drive log against each other: units and signs.

use super::{Suspicion, quantile};
use crate::drive::{DriveLog, WHEELS};
use crate::rover::Rover;

/// Fewest samples that say anything.
const FEW: usize = 20;
/// Wheels slower than this share of the fastest sample are left out: ratios of small numbers say nothing.
const SLOW: f64 = 0.1;
/// A correlation beyond this is a relation.
const RELATED: f64 = 0.5;
/// Ratios of rim to ground speed: turns a minute give 9.5 and more, km/h .28 and less, unless nearly all is slip.
const RPM: f64 = 6.0;
const KM_H: f64 = 0.4;
/// Radii of wheels that robots have \[m\], for a log without a rover file.
const RADII: (f64, f64) = (0.02, 1.2);
/// Yaw rate over difference of wheel speeds is radius over track: below 1 on any vehicle, far above it in degrees.
const DEGREES: f64 = 4.0;
/// Share of rows in which torque works against the rotation, above which its sign is doubted.
const AGAINST: f64 = 0.8;

pub(super) fn suspicions(log: &DriveLog, rover: Option<&Rover>) -> Vec<Suspicion> {
    let mut out = Vec::new();
    out.extend(speed_units(log, rover));
    out.extend(turning(log, rover));
    out.extend(torque_signs(log));
    out
}

/// Mean of the wheels of one side, where both are there.
fn side(log: &DriveLog, front: usize, rear: usize, row: usize) -> Option<f64> {
    let one = |k: usize| log.wheel_speed.get(k).and_then(|s| s.get(row));
    Some(0.5 * (one(front)? + one(rear)?))
}

fn speed_units(log: &DriveLog, rover: Option<&Rover>) -> Option<Suspicion> {
    let ground = log.ground_speed.as_ref()?;
    let pairs: Vec<(f64, f64)> = (0..log.len())
        .filter_map(|k| {
            let mean = 0.5 * (side(log, 0, 2, k)? + side(log, 1, 3, k)?);
            Some((mean.abs(), ground.get(k)?.abs()))
        })
        .collect();
    let fastest = pairs
        .iter()
        .fold((0.0_f64, 0.0_f64), |m, p| (m.0.max(p.0), m.1.max(p.1)));
    // v/omega of rows in which both move.
    let mut radius: Vec<f64> = pairs
        .iter()
        .filter(|p| p.0 > SLOW * fastest.0 && p.1 > SLOW * fastest.1)
        .map(|p| p.1 / p.0)
        .collect();
    if radius.len() < FEW {
        return None;
    }
    let low = quantile(&mut radius, 0.1)?;
    let high = quantile(&mut radius, 0.9)?;
    let known = rover.map(|r| r.wheel.radius);
    let (short, long) = match known {
        Some(r) => (r / RPM, r / KM_H),
        None => RADII,
    };
    let beside = match known {
        Some(r) => format!("the wheel's radius is {r} m"),
        None => format!("wheels of robots have {short} to {long} m"),
    };
    if high < short {
        return Some(Suspicion {
            code: "rpm",
            message: format!(
                "ground speed over wheel speed is at most {high:.4} m and {beside}: wheel speeds in rpm (x 9.5) or deg/s \
                 (x 57)? In [columns]: unit = \"rpm\"; otherwise a gear ratio was left out, or the wheels nearly spin on the spot"
            ),
        });
    }
    (low > long).then(|| Suspicion {
        code: "km-h",
        message: format!(
            "ground speed over wheel speed is at least {low:.3} m and {beside}: ground speed in km/h (x 3.6)? In [columns]: \
             unit = \"km/h\""
        ),
    })
}

/// Yaw rate against the difference of wheel speeds, right less left: on any ground a vehicle turns away from its faster side.
fn turning(log: &DriveLog, rover: Option<&Rover>) -> Option<Suspicion> {
    let yaw = log.yaw_rate.as_ref()?;
    let pairs: Vec<(f64, f64)> = (0..log.len())
        .filter_map(|k| Some((side(log, 1, 3, k)? - side(log, 0, 2, k)?, yaw.get(k)?)))
        .collect();
    if pairs.len() < FEW {
        return None;
    }
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in &pairs {
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    if xx <= 0.0 || yy <= 0.0 {
        return None;
    }
    let correlation = xy / (xx * yy).sqrt();
    if correlation < -RELATED {
        return Some(Suspicion {
            code: "sides-swapped",
            message: format!(
                "the vehicle turns towards its faster side (correlation of yaw rate with right less left wheel speed \
                 {correlation:.2}): left and right swapped, or yaw_rate_rad_s not positive to the left"
            ),
        });
    }
    let slope = xy / xx;
    let expected = rover.and_then(|r| r.vehicle.map(|v| r.wheel.radius / v.track));
    let limit = DEGREES * expected.unwrap_or(1.0);
    (correlation > RELATED && slope > limit).then(|| Suspicion {
        code: "degrees",
        message: format!(
            "yaw_rate_rad_s changes by {slope:.2} for 1 rad/s between the sides, radius over track {}: deg/s logged as \
             rad/s? In [columns]: unit = \"deg/s\"",
            expected.map_or("is below 1 on any vehicle".to_owned(), |e| format!("allows {e:.2}")),
        ),
    })
}

/// Wheels whose torque works against their rotation nearly always.
fn torque_signs(log: &DriveLog) -> Option<Suspicion> {
    let torque = log.wheel_torque.as_ref()?;
    let against: Vec<&str> = WHEELS
        .iter()
        .zip(torque.iter().zip(&log.wheel_speed))
        .filter(|(_, (torque, speed))| {
            let power: Vec<f64> = torque
                .iter()
                .zip(speed.iter())
                .filter_map(|(t, w)| Some(t? * w?))
                .filter(|p| *p != 0.0)
                .collect();
            let negative = power.iter().filter(|p| **p < 0.0).count();
            power.len() >= FEW && negative as f64 > AGAINST * power.len() as f64
        })
        .map(|(wheel, _)| *wheel)
        .collect();
    (!against.is_empty()).then(|| Suspicion {
        code: "torque-sign",
        message: format!(
            "the torque of {} works against the rotation in more than {:.0} % of the rows: sign flipped? A torque that \
             drives forward is positive{}",
            against.join(", "),
            100.0 * AGAINST,
            if against.len() == WHEELS.len() {
                ". A log of pure braking looks the same"
            } else {
                ""
            }
        ),
    })
}
