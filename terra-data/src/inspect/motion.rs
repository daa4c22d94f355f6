//! Channels of a drive log against each other: units and signs.

use super::accel::Accelerations;
use super::relation::{FEW, RELATED, Relation};
use super::thinned::Thinned;
use super::torque::Torques;
use super::wheels::Wheels;
use super::{Suspicion, quantile};
use crate::drive::DriveLog;
use crate::rover::Rover;

/// Wheels slower than this share of the fast ones are left out, ratios of small numbers say nothing; and which are fast.
const SLOW: f64 = 0.1;
const FAST: f64 = 0.95;
/// Ratios of rim to ground speed: turns a minute give 9.5 and more, km/h .28 and less, unless nearly all is slip.
const RPM: f64 = 6.0;
const KM_H: f64 = 0.4;
/// Radii of wheels that robots have \[m\], for a log without a rover file.
const RADII: (f64, f64) = (0.02, 1.2);
/// Yaw rate over difference of wheel speeds is radius over track: below 1 on any vehicle, far above it in degrees.
const DEGREES: f64 = 4.0;
/// Share of radius over track by which a vehicle turns at least with the speeds of its sides, skids and all, and the yaw rate
/// \[rad/s\] from which it turns at all.
const TURNS: (f64, f64) = (0.2, 0.05);
/// Where it is this far above that of the rover file, a track in millimetres is likelier than degrees (57).
const MILLIMETRES: f64 = 130.0;
/// Ground speed logged in these units is so many times that in m/s. What wheels slip hides the difference of km/h, mph and ft/s.
const SPEEDS: [(&str, f64); 3] = [("km/h", 3.6), ("cm/s", 100.0), ("mm/s", 1000.0)];

/// What is needed of the rows, one after the other.
#[derive(Default)]
pub(super) struct Motion {
    /// Mean speed of the wheels \[rad/s\] and ground speed \[m/s\], both without sign.
    speeds: Thinned<(f64, f64)>,
    /// Right less left wheel speed against yaw rate.
    turning: Relation,
    wheels: Wheels,
    torques: Torques,
    accelerations: Accelerations,
}

impl Motion {
    /// A segment begins.
    pub(super) fn begin(&mut self) {
        self.accelerations.begin();
    }

    /// Takes a row in.
    pub(super) fn see(&mut self, log: &DriveLog, row: usize) {
        let (left, right) = (side(log, 0, 2, row), side(log, 1, 3, row));
        if let (Some(left), Some(right)) = (left, right) {
            if let Some(ground) = log.ground_speed.as_ref().and_then(|s| s.get(row)) {
                let pair = ((0.5 * (left + right)).abs(), ground.abs());
                self.speeds.see(pair);
            }
            if let Some(yaw) = log.yaw_rate.as_ref().and_then(|s| s.get(row)) {
                self.turning.see(right - left, yaw);
            }
        }
        self.wheels.see(log, row);
        self.torques.see(log, row);
        self.accelerations.see(log, row);
    }

    pub(super) fn suspicions(&self, rover: Option<&Rover>) -> Vec<Suspicion> {
        let mut out = Vec::new();
        match self.wheels.signs() {
            // Means of a side say nothing then, nor does the work of a torque or the change of a speed.
            Some(signs) => out.push(signs),
            None => {
                let unit = self.speed_units(rover);
                // Nor does what a speed in another unit changes by.
                let accelerations = self.accelerations.suspicion();
                out.extend(accelerations.filter(|_| unit.is_none()));
                out.extend(unit);
                out.extend(self.turns(rover));
                out.extend(self.wheels.suspicions(rover));
                out.extend(self.torques.unsigned());
                out.extend(self.torques.signs());
            }
        }
        out.extend(self.torques.unit(rover));
        out
    }

    fn speed_units(&self, rover: Option<&Rover>) -> Option<Suspicion> {
        // Not the largest of each: a few outliers would be all that is left.
        let fast = |of: fn(&(f64, f64)) -> f64| {
            let mut each: Vec<f64> = self.speeds.values.iter().map(of).collect();
            quantile(&mut each, FAST)
        };
        let fastest = (fast(|p| p.0)?, fast(|p| p.1)?);
        // v/omega of rows in which both move.
        let mut radius: Vec<f64> = self
            .speeds
            .values
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
        if low <= long {
            return None;
        }
        // Without a radius the commonest is meant.
        let times = known.map_or(SPEEDS[0].1, |r| (low * high).sqrt() / r);
        let off = |factor: f64| (times / factor).ln().abs();
        let (unit, factor) = SPEEDS
            .into_iter()
            .min_by(|a, b| off(a.1).total_cmp(&off(b.1)))?;
        let code = if unit == "km/h" { "km-h" } else { "speed-unit" };
        Some(Suspicion {
            code,
            message: format!(
                "ground speed over wheel speed is at least {low:.3} m and {beside}: ground speed in {unit} (x {factor})? In \
                 [columns]: unit = \"{unit}\""
            ),
        })
    }

    /// Yaw rate against the difference of wheel speeds, right less left: on any ground a vehicle turns away from its faster side.
    fn turns(&self, rover: Option<&Rover>) -> Option<Suspicion> {
        let (correlation, slope) = self.turning.through_zero()?;
        let vehicle = rover.and_then(|r| r.vehicle.map(|v| (r.wheel.radius / v.track, v.track)));
        let expected = vehicle.map(|(expected, _)| expected);
        if correlation < -RELATED && turns(slope, expected, self.turning.size()) {
            return Some(Suspicion {
                code: "sides-swapped",
                message: format!(
                    "the vehicle turns towards its faster side (correlation of yaw rate with right less left wheel speed \
                     {correlation:.2}): left and right swapped, or yaw_rate_rad_s not positive to the left? One side on much softer ground does it too"
                ),
            });
        }
        let expected = expected.unwrap_or(1.0);
        if correlation < RELATED || slope < DEGREES * expected {
            return None;
        }
        let track = vehicle.filter(|(expected, _)| slope > MILLIMETRES * expected);
        Some(match track {
            Some((_, track)) => Suspicion {
                code: "track-unit",
                message: format!(
                    "yaw_rate_rad_s changes by {slope:.2} for 1 rad/s between the sides, which no track_m = {track} allows: \
                     millimetres given as metres in the rover file?"
                ),
            },
            None => Suspicion {
                code: "degrees",
                message: format!(
                    "yaw_rate_rad_s changes by {slope:.2} for 1 rad/s between the sides, radius over track {}: deg/s logged as \
                     rad/s? In [columns]: unit = \"deg/s\"",
                    match vehicle {
                        Some((e, _)) => format!("allows {e:.2}"),
                        None => "is below 1 on any vehicle".to_owned(),
                    },
                ),
            },
        })
    }
}

/// Whether the vehicle turns with the speeds of its sides, be it the wrong way: where one side stands on softer ground it slips
/// more and the vehicle goes its way a little, and a straight drive is noise.
pub(super) fn turns(slope: f64, expected: Option<f64>, yaw: f64) -> bool {
    let (share, least) = TURNS;
    slope.abs() > share * expected.unwrap_or(least) && yaw > least
}

/// Mean of the wheels of one side, where both are there.
fn side(log: &DriveLog, front: usize, rear: usize, row: usize) -> Option<f64> {
    let one = |k: usize| log.wheel_speed.get(k).and_then(|s| s.get(row));
    Some(0.5 * (one(front)? + one(rear)?))
}
