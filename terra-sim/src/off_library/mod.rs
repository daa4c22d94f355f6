//! Effects that exist in the truth alone: no diagnosis library has them, so the honest verdict on them is "unknown".
//!
//! Unlike the effects of [`terra_model`], they may remember (a temperature, a gap, a force), know the angle of the wheel,
//! and act on one wheel only.

mod drivetrain;
mod ground;
mod sensing;
mod weather;
mod wheels;

use terra_model::{Contact, Scope, nearest};

/// An effect, or a formula of a library effect, that only the truth has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthOnly {
    /// Kebab-case name; of a form variant the library effect's.
    pub name: &'static str,
    /// `default` for an off-library effect.
    pub form: &'static str,
    /// Magnitudes worth drawing: from barely to plainly visible on a robot of 100 kg.
    pub magnitude: (f64, f64),
    /// Unit of the magnitude.
    pub unit: &'static str,
    /// Kinds of log it shows on.
    pub scope: Scope,
    /// What happens, with the formula.
    pub summary: &'static str,
    /// Where the formula comes from, or that it is chosen.
    pub reference: &'static str,
}

/// Legal magnitudes reach this many times beyond the range worth drawing.
const LEGAL_MARGIN: f64 = 3.0;

impl TruthOnly {
    /// The largest legal magnitude; the smallest is 0, which changes nothing.
    pub fn largest(&self) -> f64 {
        LEGAL_MARGIN * self.magnitude.1
    }
}

/// One wheel at one instant, as an off-library effect sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelView {
    /// 0 to 3 for fl, fr, rl, rr.
    pub(crate) wheel: usize,
    /// ∫ ω dt since the run or the last reset began \[rad\].
    pub(crate) angle: f64,
    /// ω \[rad/s\].
    pub(crate) wheel_speed: f64,
    /// ω of the other wheel on the axle \[rad/s\].
    pub(crate) mate_speed: f64,
    /// v_x of the vehicle \[m/s\].
    pub(crate) speed: f64,
    /// Torque of the motor \[N m\].
    pub(crate) torque: f64,
    /// R of the rover file \[m\].
    pub(crate) radius: f64,
    /// t \[s\].
    pub(crate) time: f64,
    /// What the effect remembers at this wheel.
    pub(crate) memory: f64,
}

/// Where an off-library effect may act; everything is neutral by default, and at e = 0 bit for bit.
pub(crate) trait Unlisted: Send + Sync {
    /// Its row in the list.
    fn entry(&self) -> &TruthOnly;
    /// Factor on the wheel's radius.
    fn radius(&self, _e: f64, _at: &WheelView) -> f64 {
        1.0
    }
    /// The contact before the library's effects.
    fn contact(&self, _e: f64, _at: &WheelView, contact: Contact<f64>) -> Contact<f64> {
        contact
    }
    /// The drawbar pull after the model \[N\].
    fn pull(&self, _e: f64, _at: &WheelView, pull: f64) -> f64 {
        pull
    }
    /// Torque that goes missing between motor and wheel \[N m\].
    fn loss(&self, _e: f64, _at: &WheelView) -> f64 {
        0.0
    }
    /// Force along x \[N\] and moment about z \[N m\] on the body, at v \[m/s\] and t \[s\].
    fn body(&self, _e: f64, _speed: f64, _time: f64) -> (f64, f64) {
        (0.0, 0.0)
    }
    /// What the torque sensor says.
    fn torque_reading(&self, _e: f64, _at: &WheelView, torque: f64) -> f64 {
        torque
    }
    /// What the wheel's speed sensor says.
    fn speed_reading(&self, _e: f64, _at: &WheelView, speed: f64) -> f64 {
        speed
    }
    /// True when it remembers.
    fn remembers(&self) -> bool {
        false
    }
    /// d(memory)/dt, `pull` being the model's \[N\].
    fn memory_rate(&self, _e: f64, _at: &WheelView, _pull: f64) -> f64 {
        0.0
    }
}

static EFFECTS: &[&dyn Unlisted] = &[
    &drivetrain::StickSlip,
    &drivetrain::GearboxBacklash,
    &drivetrain::ThermalTorqueFade,
    &drivetrain::DifferentialCrossCoupling,
    &wheels::WheelOutOfRound,
    &wheels::WheelHop,
    &wheels::PuncturedWheel,
    &ground::MoistureCrust,
    &ground::ForceRelaxation,
    &ground::BuriedStones,
    &weather::WindGusts,
    &sensing::EncoderEccentricity,
];

static LIST: &[TruthOnly] = &[
    drivetrain::STICK_SLIP,
    drivetrain::GEARBOX_BACKLASH,
    drivetrain::THERMAL_TORQUE_FADE,
    drivetrain::DIFFERENTIAL_CROSS_COUPLING,
    wheels::WHEEL_OUT_OF_ROUND,
    wheels::WHEEL_HOP,
    wheels::PUNCTURED_WHEEL,
    ground::MOISTURE_CRUST,
    ground::FORCE_RELAXATION,
    ground::BURIED_STONES,
    weather::WIND_GUSTS,
    sensing::ENCODER_ECCENTRICITY,
];

/// The effects that only the truth has.
pub fn off_library() -> &'static [TruthOnly] {
    LIST
}

/// The off-library effect of that name.
pub(crate) fn find(name: &str) -> Option<&'static dyn Unlisted> {
    EFFECTS.iter().find(|e| e.entry().name == name).copied()
}

/// The off-library name that a misspelt one most likely meant.
pub(crate) fn nearest_name(name: &str) -> Option<&'static str> {
    nearest(name, LIST.iter().map(|e| e.name))
}

/// 0 below 0, 1 above 1, smooth between.
pub(crate) fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_that_of_the_effects_and_names_are_unique() {
        assert_eq!(EFFECTS.len(), LIST.len());
        for (effect, row) in EFFECTS.iter().zip(LIST) {
            assert_eq!(effect.entry(), row);
            assert_eq!(LIST.iter().filter(|e| e.name == row.name).count(), 1);
            assert!(!row.summary.is_empty() && !row.reference.is_empty());
            assert!(row.magnitude.0 > 0.0 && row.magnitude.1 > row.magnitude.0);
        }
    }

    /// e = 0 changes no number, whatever the wheel does.
    #[test]
    fn neutral_at_zero() {
        let at = WheelView {
            wheel: 0,
            angle: 2.3,
            wheel_speed: 4.1,
            mate_speed: -3.0,
            speed: 0.9,
            torque: 17.0,
            radius: 0.254,
            time: 1.7,
            memory: 0.4,
        };
        for effect in EFFECTS {
            for wheel in 0..4 {
                let at = WheelView { wheel, ..at };
                let before = Contact::new(0.21, 245.0, 0.254, 0.15);
                let after = effect.contact(0.0, &at, before);
                assert_eq!(format!("{before:?}"), format!("{after:?}"));
                assert_eq!(effect.radius(0.0, &at), 1.0);
                if !effect.remembers() {
                    assert_eq!(effect.pull(0.0, &at, 31.7), 31.7);
                    assert_eq!(effect.loss(0.0, &at), 0.0);
                }
                assert_eq!(effect.body(0.0, 0.9, 1.7), (0.0, 0.0));
                assert_eq!(effect.torque_reading(0.0, &at, 12.3), 12.3);
                assert_eq!(effect.speed_reading(0.0, &at, 4.1), 4.1);
            }
        }
    }
}
