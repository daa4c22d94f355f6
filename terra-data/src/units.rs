//! Units a log may use, and what they are in SI.
//!
//! Every contract column ends in the SI unit it is in; a log in another unit of the same quantity is converted by
//! `value x multiply / divide`. Dividing by 1000 is rounded once, where the factor 0.001 would be rounded before it is used:
//! a whole number of millimetres comes to the double nearest its metres.
//!
//! # Reference
//! A. Thompson, B. N. Taylor, *Guide for the Use of the SI*, NIST SP 811, 2008, appendix B.

use std::f64::consts::PI;

/// The quantity a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// s.
    Time,
    /// m.
    Length,
    /// rad.
    Angle,
    /// m/s.
    Speed,
    /// rad/s.
    AngularSpeed,
    /// m/s².
    Acceleration,
    /// kg.
    Mass,
    /// N.
    Force,
    /// N m.
    Torque,
    /// A.
    Current,
    /// V.
    Voltage,
    /// 1.
    Ratio,
}

/// A unit: `SI value = value x multiply / divide`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its usual spelling.
    pub name: &'static str,
    other_names: &'static [&'static str],
    multiply: f64,
    divide: f64,
}

impl Unit {
    /// The SI unit of a quantity.
    pub fn si(of: Dimension) -> Unit {
        let name = match of {
            Dimension::Time => "s",
            Dimension::Length => "m",
            Dimension::Angle => "rad",
            Dimension::Speed => "m/s",
            Dimension::AngularSpeed => "rad/s",
            Dimension::Acceleration => "m/s^2",
            Dimension::Mass => "kg",
            Dimension::Force => "N",
            Dimension::Torque => "N m",
            Dimension::Current => "A",
            Dimension::Voltage => "V",
            Dimension::Ratio => "1",
        };
        unit(name, &[], 1.0, 1.0)
    }

    /// The unit of that name among those of a quantity.
    pub fn find(of: Dimension, name: &str) -> Option<Unit> {
        let name = plain(name);
        of.units()
            .iter()
            .find(|u| plain(u.name) == name || u.other_names.contains(&name.as_str()))
            .copied()
    }

    /// A value in this unit, in SI.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.multiply / self.divide
    }
}

impl Dimension {
    /// The quantity a column's suffix stands for (`wheel_speed_fl_rad_s` is an angular speed); a ratio without one.
    pub fn of_column(name: &str) -> Dimension {
        // Longest first: `_m_s` also ends in `_s`.
        const SUFFIXES: [(&str, Dimension); 11] = [
            ("_rad_s", Dimension::AngularSpeed),
            ("_m_s2", Dimension::Acceleration),
            ("_N_m", Dimension::Torque),
            ("_m_s", Dimension::Speed),
            ("_rad", Dimension::Angle),
            ("_kg", Dimension::Mass),
            ("_m", Dimension::Length),
            ("_s", Dimension::Time),
            ("_N", Dimension::Force),
            ("_A", Dimension::Current),
            ("_V", Dimension::Voltage),
        ];
        SUFFIXES
            .iter()
            .find(|(suffix, _)| name.ends_with(suffix))
            .map_or(Dimension::Ratio, |(_, d)| *d)
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Dimension::Time => "time",
            Dimension::Length => "length",
            Dimension::Angle => "angle",
            Dimension::Speed => "speed",
            Dimension::AngularSpeed => "angular speed",
            Dimension::Acceleration => "acceleration",
            Dimension::Mass => "mass",
            Dimension::Force => "force",
            Dimension::Torque => "torque",
            Dimension::Current => "current",
            Dimension::Voltage => "voltage",
            Dimension::Ratio => "ratio",
        }
    }

    /// All quantities.
    pub fn all() -> [Dimension; 12] {
        use Dimension::*;
        [
            Time,
            Length,
            Angle,
            Speed,
            AngularSpeed,
            Acceleration,
            Mass,
            Force,
            Torque,
            Current,
            Voltage,
            Ratio,
        ]
    }

    /// The units a column of this quantity may have in a log.
    pub fn units(self) -> &'static [Unit] {
        match self {
            Dimension::Time => TIME,
            Dimension::Length => LENGTH,
            Dimension::Angle => ANGLE,
            Dimension::Speed => SPEED,
            Dimension::AngularSpeed => ANGULAR_SPEED,
            Dimension::Acceleration => ACCELERATION,
            Dimension::Mass => MASS,
            Dimension::Force => FORCE,
            Dimension::Torque => TORQUE,
            Dimension::Current => CURRENT,
            Dimension::Voltage => VOLTAGE,
            Dimension::Ratio => RATIO,
        }
    }
}

/// `N m`, `N*m`, `N·m` are one unit, and so are `m/s^2`, `m/s²`, `m/s2`.
fn plain(name: &str) -> String {
    name.chars()
        .filter(|c| !matches!(c, ' ' | '*' | '·' | '^'))
        .map(|c| if c == '²' { '2' } else { c })
        .collect()
}

const fn unit(
    name: &'static str,
    other_names: &'static [&'static str],
    multiply: f64,
    divide: f64,
) -> Unit {
    Unit {
        name,
        other_names,
        multiply,
        divide,
    }
}

/// Standard gravity \[m/s²\], exact.
const G: f64 = 9.80665;
/// Pound \[kg\], exact.
const POUND: f64 = 0.45359237;

#[rustfmt::skip]
const TIME: &[Unit] = &[
    unit("s", &[], 1.0, 1.0), unit("ms", &[], 1.0, 1e3), unit("us", &["µs", "μs"], 1.0, 1e6), unit("ns", &[], 1.0, 1e9),
    unit("min", &[], 60.0, 1.0), unit("h", &[], 3600.0, 1.0),
];
#[rustfmt::skip]
const LENGTH: &[Unit] = &[
    unit("m", &[], 1.0, 1.0), unit("mm", &[], 1.0, 1e3), unit("cm", &[], 1.0, 1e2), unit("um", &["µm", "μm"], 1.0, 1e6),
    unit("km", &[], 1e3, 1.0), unit("in", &[], 254.0, 1e4), unit("ft", &[], 3048.0, 1e4),
];
#[rustfmt::skip]
const ANGLE: &[Unit] = &[
    unit("rad", &[], 1.0, 1.0), unit("deg", &["°"], PI, 180.0), unit("mrad", &[], 1.0, 1e3), unit("rev", &[], 2.0 * PI, 1.0),
];
#[rustfmt::skip]
const SPEED: &[Unit] = &[
    unit("m/s", &["m_s"], 1.0, 1.0), unit("mm/s", &["mm_s"], 1.0, 1e3), unit("cm/s", &["cm_s"], 1.0, 1e2),
    unit("km/h", &["kph"], 10.0, 36.0), unit("mph", &[], 44704.0, 1e5), unit("ft/s", &[], 3048.0, 1e4),
];
#[rustfmt::skip]
const ANGULAR_SPEED: &[Unit] = &[
    unit("rad/s", &["rad_s"], 1.0, 1.0), unit("rpm", &["rev/min"], PI, 30.0), unit("deg/s", &["deg_s", "°/s"], PI, 180.0),
    unit("rev/s", &["rps"], 2.0 * PI, 1.0), unit("mrad/s", &[], 1.0, 1e3),
];
#[rustfmt::skip]
const ACCELERATION: &[Unit] = &[
    unit("m/s^2", &["m_s2"], 1.0, 1.0), unit("mm/s^2", &[], 1.0, 1e3), unit("cm/s^2", &[], 1.0, 1e2), unit("g", &[], G, 1.0),
];
#[rustfmt::skip]
const MASS: &[Unit] = &[
    unit("kg", &[], 1.0, 1.0), unit("g", &[], 1.0, 1e3), unit("t", &[], 1e3, 1.0), unit("lb", &[], POUND, 1.0),
];
#[rustfmt::skip]
const FORCE: &[Unit] = &[
    unit("N", &[], 1.0, 1.0), unit("kN", &[], 1e3, 1.0), unit("mN", &[], 1.0, 1e3), unit("kgf", &[], G, 1.0),
    unit("lbf", &[], POUND * G, 1.0),
];
#[rustfmt::skip]
const TORQUE: &[Unit] = &[
    unit("N m", &["N_m"], 1.0, 1.0), unit("kN m", &[], 1e3, 1.0), unit("mN m", &[], 1.0, 1e3), unit("N mm", &[], 1.0, 1e3),
    unit("N cm", &[], 1.0, 1e2), unit("kgf m", &[], G, 1.0), unit("lbf ft", &["ftlbf"], POUND * G * 0.3048, 1.0),
    unit("lbf in", &["inlbf"], POUND * G * 0.0254, 1.0),
];
#[rustfmt::skip]
const CURRENT: &[Unit] = &[unit("A", &[], 1.0, 1.0), unit("mA", &[], 1.0, 1e3), unit("kA", &[], 1e3, 1.0)];
#[rustfmt::skip]
const VOLTAGE: &[Unit] = &[unit("V", &[], 1.0, 1.0), unit("mV", &[], 1.0, 1e3), unit("kV", &[], 1e3, 1.0)];
#[rustfmt::skip]
const RATIO: &[Unit] = &[unit("1", &[], 1.0, 1.0), unit("percent", &["%"], 1.0, 1e2)];

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    /// NIST SP 811 appendix B.8, its printed digits (seven, so 1e-6); a revolution is 2 pi by definition.
    #[test]
    fn factors_are_the_published_ones() {
        use Dimension::*;
        for (of, name, factor) in [
            (Force, "lbf", 4.448_222),
            (Force, "kgf", 9.806_65),
            (Force, "kN", 1e3),
            (Torque, "lbf ft", 1.355_818),
            (Torque, "lbf in", 0.112_984_8),
            (Torque, "kgf m", 9.806_65),
            (Torque, "mN m", 1e-3),
            (Speed, "mph", 0.447_04),
            (Speed, "km/h", 0.277_777_8),
            (Speed, "ft/s", 0.304_8),
            (Speed, "mm/s", 1e-3),
            (AngularSpeed, "rpm", 0.104_719_8),
            (AngularSpeed, "rev/s", TAU),
            (AngularSpeed, "deg/s", 0.017_453_29),
            (Angle, "deg", 0.017_453_29),
            (Angle, "rev", TAU),
            (Length, "in", 0.025_4),
            (Length, "ft", 0.304_8),
            (Length, "mm", 1e-3),
            (Length, "cm", 1e-2),
            (Acceleration, "g", 9.806_65),
            (Mass, "lb", 0.453_592_4),
            (Mass, "g", 1e-3),
            (Time, "h", 3600.0),
            (Time, "ns", 1e-9),
            (Current, "mA", 1e-3),
            (Voltage, "mV", 1e-3),
            (Ratio, "percent", 1e-2),
        ] {
            let unit = Unit::find(of, name).unwrap();
            assert_relative_eq!(unit.to_si(1.0), factor, max_relative = 1e-6);
        }
    }

    #[test]
    fn the_si_unit_changes_no_bit() {
        for of in Dimension::all() {
            let si = Unit::find(of, Unit::si(of).name).unwrap();
            for v in [0.1, -0.0, 1e-310, 1.797e308] {
                assert_eq!(si.to_si(v).to_bits(), f64::to_bits(v));
            }
        }
    }

    #[test]
    fn spellings_of_one_unit_agree() {
        for name in ["N m", "N*m", "N·m", "Nm", "N_m"] {
            assert_eq!(Unit::find(Dimension::Torque, name).unwrap().name, "N m");
        }
        for name in ["m/s^2", "m/s²", "m/s2", "m_s2"] {
            assert_eq!(
                Unit::find(Dimension::Acceleration, name).unwrap().name,
                "m/s^2"
            );
        }
        assert_eq!(Unit::find(Dimension::Force, "MN"), None);
    }

    /// The quotient of two exact integers is rounded once, so it is the double that the decimal text means.
    #[test]
    fn whole_millimetres_come_to_the_nearest_double() {
        let mm = Unit::find(Dimension::Length, "mm").unwrap();
        for i in 0..10_000 {
            let metres: f64 = format!("{}.{:03}", i / 1000, i % 1000).parse().unwrap();
            assert_eq!(mm.to_si(f64::from(i)), metres);
        }
    }

    #[test]
    fn the_suffix_gives_the_quantity() {
        for (name, of) in [
            ("wheel_speed_fl_rad_s", Dimension::AngularSpeed),
            ("wheel_torque_rr_N_m", Dimension::Torque),
            ("accel_x_m_s2", Dimension::Acceleration),
            ("ground_speed_m_s", Dimension::Speed),
            ("time_s", Dimension::Time),
            ("sinkage_sd_m", Dimension::Length),
            ("normal_load_N", Dimension::Force),
            ("motor_current_fl_A", Dimension::Current),
            ("payload_kg", Dimension::Mass),
            ("slip_angle_rad", Dimension::Angle),
            ("slip", Dimension::Ratio),
            ("slip_sd", Dimension::Ratio),
        ] {
            assert_eq!(Dimension::of_column(name), of, "{name}");
        }
    }
}
