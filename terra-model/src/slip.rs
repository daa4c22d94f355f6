//! Slip: one convention inside, the others by conversion.

use crate::error::ModelError;
use crate::real::Real;

/// Below this speed \[m/s\] slip from speeds is not meaningful and is computed against this value.
pub const STANDSTILL_SPEED: f64 = 0.05;

/// Slip conventions found in logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipConvention {
    /// Driving 1 - v/(R ω), braking R ω/v - 1: in \[-1, 1\]. The library's own.
    Library,
    /// 100 x the library slip.
    Percent,
    /// (R ω - v)/|v|.
    Unbounded,
    /// 1 - v/(R ω) throughout.
    Driving,
    /// R ω/v - 1 throughout.
    Braking,
}

impl SlipConvention {
    /// The convention of that name in a rover file.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the nearest known one.
    pub fn from_name(name: &str) -> Result<Self, ModelError> {
        match name {
            "library" => Ok(Self::Library),
            "percent" => Ok(Self::Percent),
            "unbounded" => Ok(Self::Unbounded),
            "driving" => Ok(Self::Driving),
            "braking" => Ok(Self::Braking),
            _ => Err(ModelError::UnknownName {
                kind: "slip convention",
                name: name.to_owned(),
                nearest: crate::nearest(
                    name,
                    ["library", "percent", "unbounded", "driving", "braking"],
                )
                .map(str::to_owned),
            }),
        }
    }

    /// Converts a value of this convention to the library slip.
    ///
    /// # Errors
    /// [`ModelError::Contact`] when the value means a wheel turning against its motion, or is out of range.
    pub fn to_library(self, value: f64) -> Result<f64, ModelError> {
        // Each convention gives the ratio of rim to travel speed or its inverse; both must be >= 0.
        let s = match self {
            Self::Library => value,
            Self::Percent => value / 100.0,
            Self::Unbounded | Self::Braking => {
                if value > 0.0 {
                    value / (1.0 + value)
                } else {
                    value
                }
            }
            Self::Driving => {
                if value < 0.0 {
                    value / (1.0 - value)
                } else {
                    value
                }
            }
        };
        if s.is_nan() || !(-1.0..=1.0).contains(&s) {
            return Err(ModelError::Contact {
                quantity: "slip",
                value,
                expected: "a wheel that turns with its motion: library slip in [-1, 1]",
            });
        }
        Ok(s)
    }
}

/// Library slip from rim speed R ω and travel speed v, any scalar, no guard near standstill.
///
/// In reverse both are negative and the magnitudes count.
pub fn library_slip<T: Real>(rim_speed: T, travel_speed: T) -> T {
    let (rim, travel) = (rim_speed.abs(), travel_speed.abs());
    rim.select_lt(travel, rim / travel - 1.0, T::one() - travel / rim)
}

/// Slip from speeds with the standstill rule: near standstill it is (R ω - v)/max(|R ω|, |v|, 0.05 m/s), and flagged.
///
/// Returns the slip and whether it is meaningful (false near standstill, where it may even leave \[-1, 1\]).
///
/// # Errors
/// [`ModelError::Contact`] when the wheel turns against its motion, or when a speed is not finite.
pub fn slip_from_speeds(rim_speed: f64, travel_speed: f64) -> Result<(f64, bool), ModelError> {
    for (quantity, value) in [("rim_speed", rim_speed), ("travel_speed", travel_speed)] {
        if !value.is_finite() {
            return Err(ModelError::Contact {
                quantity,
                value,
                expected: "a finite speed",
            });
        }
    }
    let moving = rim_speed.abs().max(travel_speed.abs()) >= STANDSTILL_SPEED;
    if moving && rim_speed * travel_speed < 0.0 {
        return Err(ModelError::Contact {
            quantity: "slip",
            value: rim_speed,
            expected: "a rim speed in the direction of travel",
        });
    }
    if !moving {
        let sign = if rim_speed + travel_speed < 0.0 {
            -1.0
        } else {
            1.0
        };
        return Ok((sign * (rim_speed - travel_speed) / STANDSTILL_SPEED, false));
    }
    Ok((library_slip(rim_speed, travel_speed), true))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// R ω = 0.3, v = 0.2 (driving) and R ω = 0.2, v = 0.25 (braking), each in every convention by hand.
    #[test]
    fn conventions_agree_on_the_same_motion() {
        for (convention, driving, braking) in [
            (SlipConvention::Library, 1.0 / 3.0, -0.2),
            (SlipConvention::Percent, 100.0 / 3.0, -20.0),
            (SlipConvention::Unbounded, 0.5, -0.2),
            (SlipConvention::Driving, 1.0 / 3.0, -0.25),
            (SlipConvention::Braking, 0.5, -0.2),
        ] {
            assert_relative_eq!(
                convention.to_library(driving).unwrap(),
                1.0 / 3.0,
                epsilon = 1e-15
            );
            assert_relative_eq!(
                convention.to_library(braking).unwrap(),
                -0.2,
                epsilon = 1e-15
            );
        }
        assert_relative_eq!(
            slip_from_speeds(-0.3, -0.2).unwrap().0,
            1.0 / 3.0,
            epsilon = 1e-15
        );
    }

    #[test]
    fn a_wheel_against_its_motion_is_an_error() {
        assert!(slip_from_speeds(0.3, -0.2).is_err());
        assert!(SlipConvention::Unbounded.to_library(-1.2).is_err());
        assert!(SlipConvention::Library.to_library(f64::NAN).is_err());
        assert!(slip_from_speeds(f64::NAN, 1.0).is_err());
        assert!(slip_from_speeds(1.0, f64::INFINITY).is_err());
    }
}
