//! The wheels' torques: signs by the work they do, units by what the vehicle's weight lets them be.

use super::relation::FEW;
use super::thinned::Thinned;
use super::{Suspicion, quantile};
use crate::drive::{DriveLog, WHEELS};
use crate::rover::Rover;

/// Share of rows in which torque works against the rotation, above which its sign is doubted.
const AGAINST: f64 = 0.8;
/// Torque over load times radius that nine rows in ten stay below: friction carries about one, and the firmest ground takes this much.
const CARRIED: (f64, f64) = (0.01, 3.0);
const STRONG: f64 = 0.9;
/// g \[m/s²\].
const GRAVITY: f64 = 9.81;

/// What is needed of the rows, one after the other.
#[derive(Default)]
pub(super) struct Torques {
    power: [Power; 4],
    back: Back,
    /// Mean of the wheels' torques \[N m\] without sign, in rows in which all turn.
    size: Thinned<f64>,
}

/// Rows in which a wheel's torque does work, and those in which it works against the rotation.
#[derive(Clone, Copy, Default)]
struct Power {
    rows: usize,
    against: usize,
}

/// Rows in which all wheels turn backwards, and whether any torque of the log points backwards.
#[derive(Clone, Copy, Default)]
struct Back {
    rows: usize,
    torque: bool,
}

impl Torques {
    pub(super) fn see(&mut self, log: &DriveLog, row: usize) {
        let torque = log.wheel_torque.iter().flatten();
        let (mut sum, mut turning, mut back) = (0.0, 0, 0);
        for (power, (torque, speed)) in self.power.iter_mut().zip(torque.zip(&log.wheel_speed)) {
            if let (Some(t), Some(w)) = (torque.get(row), speed.get(row)) {
                power.rows += usize::from(t * w != 0.0);
                power.against += usize::from(t * w < 0.0);
                sum += t.abs();
                turning += usize::from(w != 0.0);
                back += usize::from(w < 0.0);
                self.back.torque |= t < 0.0;
            }
        }
        if turning == WHEELS.len() {
            self.size.see(sum / WHEELS.len() as f64);
            self.back.rows += usize::from(back == WHEELS.len());
        }
    }

    /// Torques of which none points backwards, in a log that does.
    pub(super) fn unsigned(&self) -> Option<Suspicion> {
        let Back { rows, torque } = self.back;
        (rows >= FEW && !torque).then(|| Suspicion {
            code: "unsigned-torque",
            message: format!(
                "no torque is negative, though all wheels turn backwards in {rows} rows: absolute values? Forward is positive"
            ),
        })
    }

    /// Wheels whose torque works against their rotation nearly always.
    pub(super) fn signs(&self) -> Option<Suspicion> {
        let against: Vec<&str> = WHEELS
            .iter()
            .zip(&self.power)
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

    /// Torques that no ground gives to wheels under this vehicle's weight.
    pub(super) fn unit(&self, rover: Option<&Rover>) -> Option<Suspicion> {
        let rover = rover?;
        let load = 0.25 * rover.vehicle?.mass * GRAVITY;
        let mut sizes = self.size.values.clone();
        let strong = quantile(&mut sizes, STRONG).filter(|_| sizes.len() >= FEW)?;
        let share = strong / (load * rover.wheel.radius);
        let (least, most) = CARRIED;
        let why = match share {
            s if s > most => "a smaller unit than N m, or mass_kg or radius_m too small",
            s if s < least => "measured before the gear, or mass_kg or radius_m too large",
            _ => return None,
        };
        Some(Suspicion {
            code: "torque-unit",
            message: format!(
                "nine torques in ten are below {strong:.3} N m, {share:.4} of a wheel's share of the weight times its radius, where \
                 ground gives {least} to {most}: {why}?"
            ),
        })
    }
}
