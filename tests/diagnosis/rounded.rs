//! Channels that are rounded more coarsely than they scatter, as by a driver that reports whole turns a minute.

use std::f64::consts::PI;

use terra::gap::{Diagnosis, Settings, diagnose_drive};
use terra::model::Registry;

use crate::far::slowly;

/// Wheels in whole turns a minute, a twentieth of their speed, beside a ground speed that is known to 6 mm/s.
fn by_whole_turns(missing: Option<(&str, f64)>) -> Diagnosis {
    let turns = PI / 30.0;
    let noise = [
        ("wheel_speed_rad_s", 0.01),
        ("wheel_torque_N_m", 0.1),
        ("ground_speed_m_s", 0.006),
        ("yaw_rate_rad_s", 0.004),
        ("accel_x_m_s2", 0.05),
    ];
    let (mut log, rover) = slowly(missing, noise);
    for wheel in &mut log.wheel_speed {
        *wheel = wheel
            .iter()
            .map(|w| Some((w? / turns).round() * turns))
            .collect();
    }
    diagnose_drive(&log, &rover, &Registry::builtin(), &Settings::of(&rover)).unwrap()
}

/// What a wheel's digit hides stays the same while it turns evenly. Taken for noise that comes and goes it was an effect, and a second
/// one beside any other.
#[test]
fn whole_turns_a_minute_are_no_effect() {
    let nothing = by_whole_turns(None);
    assert_eq!(nothing.verdict, "none", "{:?}", nothing.set);
    let told = |line: &String| line.contains("wheel_speed_rad_s is rounded to 0.105");
    assert_eq!(
        nothing.heed.iter().filter(|l| told(l)).count(),
        1,
        "{:?}",
        nothing.heed
    );
    for missing in [("torque-scale", 0.1), ("wheel-radius-error", 0.05)] {
        let d = by_whole_turns(Some(missing));
        assert_eq!(d.set, [missing.0], "{:?}", d.verdict);
    }
}
