//! Channels of a drive log against each other: units and signs.

use super::{KEPT, Suspicion, quantile};
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

/// What is needed of the rows, one after the other.
#[derive(Default)]
pub(super) struct Motion {
    /// Mean speed of the wheels \[rad/s\] and ground speed \[m/s\], both without sign.
    speeds: Thinned,
    /// The largest of each.
    fastest: (f64, f64),
    turning: Turning,
    power: [Power; 4],
}

/// Right less left wheel speed (x) against yaw rate (y).
#[derive(Default)]
struct Turning {
    rows: usize,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// Rows in which a wheel's torque does work, and those in which it works against the rotation.
#[derive(Clone, Copy, Default)]
struct Power {
    rows: usize,
    against: usize,
}

/// Up to [`KEPT`] values: all, then every second, every fourth and so on of those there were.
struct Thinned {
    values: Vec<(f64, f64)>,
    every: usize,
    seen: usize,
}

impl Default for Thinned {
    fn default() -> Self {
        Thinned {
            values: Vec::new(),
            every: 1,
            seen: 0,
        }
    }
}

impl Thinned {
    fn see(&mut self, value: (f64, f64)) {
        if self.values.len() == KEPT {
            let mut even = false;
            self.values.retain(|_| {
                even = !even;
                even
            });
            self.every *= 2;
        }
        if self.seen.is_multiple_of(self.every) {
            self.values.push(value);
        }
        self.seen += 1;
    }
}

impl Motion {
    pub(super) fn look(&mut self, log: &DriveLog) {
        for k in 0..log.len() {
            let (left, right) = (side(log, 0, 2, k), side(log, 1, 3, k));
            if let (Some(left), Some(right)) = (left, right) {
                if let Some(ground) = log.ground_speed.as_ref().and_then(|s| s.get(k)) {
                    let pair = ((0.5 * (left + right)).abs(), ground.abs());
                    self.fastest = (self.fastest.0.max(pair.0), self.fastest.1.max(pair.1));
                    self.speeds.see(pair);
                }
                if let Some(yaw) = log.yaw_rate.as_ref().and_then(|s| s.get(k)) {
                    self.turning.see(right - left, yaw);
                }
            }
            let torque = log.wheel_torque.iter().flatten();
            for (power, (torque, speed)) in self.power.iter_mut().zip(torque.zip(&log.wheel_speed))
            {
                if let (Some(t), Some(w)) = (torque.get(k), speed.get(k)) {
                    power.rows += usize::from(t * w != 0.0);
                    power.against += usize::from(t * w < 0.0);
                }
            }
        }
    }

    pub(super) fn suspicions(&self, rover: Option<&Rover>) -> Vec<Suspicion> {
        let mut out = Vec::new();
        out.extend(self.speed_units(rover));
        out.extend(self.turning.suspicion(rover));
        out.extend(torque_signs(&self.power));
        out
    }

    fn speed_units(&self, rover: Option<&Rover>) -> Option<Suspicion> {
        // v/omega of rows in which both move.
        let mut radius: Vec<f64> = self
            .speeds
            .values
            .iter()
            .filter(|p| p.0 > SLOW * self.fastest.0 && p.1 > SLOW * self.fastest.1)
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
}

/// Mean of the wheels of one side, where both are there.
fn side(log: &DriveLog, front: usize, rear: usize, row: usize) -> Option<f64> {
    let one = |k: usize| log.wheel_speed.get(k).and_then(|s| s.get(row));
    Some(0.5 * (one(front)? + one(rear)?))
}

impl Turning {
    fn see(&mut self, x: f64, y: f64) {
        self.rows += 1;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Yaw rate against the difference of wheel speeds, right less left: on any ground a vehicle turns away from its faster side.
    fn suspicion(&self, rover: Option<&Rover>) -> Option<Suspicion> {
        let &Turning { rows, xx, xy, yy } = self;
        if rows < FEW || xx <= 0.0 || yy <= 0.0 {
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
}

/// Wheels whose torque works against their rotation nearly always.
fn torque_signs(power: &[Power; 4]) -> Option<Suspicion> {
    let against: Vec<&str> = WHEELS
        .iter()
        .zip(power)
        .filter(|(_, p)| p.rows >= FEW && p.against as f64 > AGAINST * p.rows as f64)
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
