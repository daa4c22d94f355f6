//! Each wheel's speed against the motion of the vehicle: signs, and wheels that took each other's place.

use super::Suspicion;
use super::motion::turns;
use super::relation::{FEW, RELATED, Relation};
use crate::drive::{DriveLog, WHEELS};
use crate::rover::Rover;

/// Speeds below this share of the fastest say nothing of a direction.
const SLOW: f64 = 0.1;
/// Share of the rows of driving back in which a ground speed that has no sign points forward.
const UNSIGNED: f64 = 0.8;

/// What is needed of the rows, one after the other.
#[derive(Default)]
pub(super) struct Wheels {
    /// Ground speed against each wheel's.
    along: [Relation; 4],
    /// Yaw rate against right less left, front and rear.
    axles: [Relation; 2],
    back: Back,
}

/// The fastest so far of what each row's slowest wheel turns by \[rad/s\], the rows in which all wheels turn backwards, and those of
/// them in which the ground speed says forward.
#[derive(Default)]
struct Back {
    fastest: f64,
    rows: usize,
    forward: usize,
}

impl Wheels {
    pub(super) fn see(&mut self, log: &DriveLog, row: usize) {
        let speed = log.wheel_speed.each_ref().map(|w| w.get(row));
        let at = |k: usize| speed.get(k).copied().flatten();
        let ground = log.ground_speed.as_ref().and_then(|s| s.get(row));
        let yaw = log.yaw_rate.as_ref().and_then(|s| s.get(row));
        if let Some(v) = ground {
            for (k, along) in self.along.iter_mut().enumerate() {
                if let Some(w) = at(k) {
                    along.see(w, v);
                }
            }
            if let [Some(fl), Some(fr), Some(rl), Some(rr)] = speed {
                self.back.see([fl, fr, rl, rr], v);
            }
        }
        if let Some(r) = yaw {
            for (axle, seen) in self.axles.iter_mut().enumerate() {
                if let (Some(left), Some(right)) = (at(2 * axle), at(2 * axle + 1)) {
                    seen.see(right - left, r);
                }
            }
        }
    }

    /// Wheels that turn against the motion; where all four do it may be the ground speed's sign.
    pub(super) fn signs(&self) -> Option<Suspicion> {
        let against: Vec<&str> = WHEELS
            .iter()
            .zip(&self.along)
            .filter(|(_, seen)| seen.through_zero().is_some_and(|(c, _)| c < -RELATED))
            .map(|(wheel, _)| *wheel)
            .collect();
        (!against.is_empty()).then(|| Suspicion {
            code: "speed-sign",
            message: match against.len() == WHEELS.len() {
                true => "all wheels turn against ground_speed_m_s: both are positive forward; sign flipped, in one of the two, or does it slide back?"
                    .to_owned(),
                false => format!(
                    "wheel speed of {} falls as the vehicle speeds up: all are positive where they drive forward; sign flipped?",
                    against.join(", ")
                ),
            },
        })
    }

    /// An axle whose wheels took each other's place, while the other's did not; a ground speed without a sign.
    pub(super) fn suspicions(&self, rover: Option<&Rover>) -> Vec<Suspicion> {
        let expected = rover.and_then(|r| r.vehicle.map(|v| r.wheel.radius / v.track));
        let turns = self.axles.map(|axle| {
            let seen = axle.through_zero();
            let real = seen.filter(|(_, slope)| turns(*slope, expected, axle.size()));
            real.map_or(0.0, |(correlation, _)| correlation)
        });
        let swapped = match turns {
            [front, rear] if front < -RELATED && rear > RELATED => Some("fl and fr"),
            [front, rear] if rear < -RELATED && front > RELATED => Some("rl and rr"),
            _ => None,
        };
        let swapped = swapped.map(|pair| Suspicion {
            code: "axle-swapped",
            message: format!(
                "by {pair} the vehicle turns towards its faster side, by the other two away from it: {pair} swapped?"
            ),
        });
        swapped.into_iter().chain(self.back.suspicion()).collect()
    }
}

impl Back {
    fn see(&mut self, wheels: [f64; 4], ground: f64) {
        let slowest = wheels.iter().fold(f64::INFINITY, |a, w| a.min(w.abs()));
        self.fastest = self.fastest.max(slowest);
        let back = wheels.iter().all(|w| *w < 0.0) && slowest > SLOW * self.fastest;
        self.rows += usize::from(back);
        self.forward += usize::from(back && ground > 0.0);
    }

    fn suspicion(&self) -> Option<Suspicion> {
        let &Back { rows, forward, .. } = self;
        (rows >= FEW && forward as f64 > UNSIGNED * rows as f64).then(|| Suspicion {
            code: "unsigned-speed",
            message: format!(
                "ground_speed_m_s is above 0 in {forward} of {rows} rows in which all wheels turn backwards: a speed without a \
                 sign? It is negative where the vehicle drives back"
            ),
        })
    }
}
