//! A gyroscope that is off where it should read zero, as every one is a little.

use terra::data::{DriveLog, Rover};
use terra::gap::{Named, Settings, diagnose_drive, diagnose_drives};
use terra::model::Registry;

use crate::far::slowly;
use crate::magnitude;

/// Slow manoeuvres by a gyroscope with this offset \[rad/s\].
fn off_by(bias: f64) -> (DriveLog, Rover) {
    let noise = [
        ("wheel_speed_rad_s", 0.01),
        ("wheel_torque_N_m", 0.1),
        ("ground_speed_m_s", 0.006),
        ("yaw_rate_rad_s", 0.002),
        ("accel_x_m_s2", 0.02),
    ];
    slowly(Some(("yaw-rate-bias", bias)), noise)
}

/// It is named alone, and found as large as it is.
fn is_named(log: &DriveLog, rover: &Rover, bias: f64) {
    let d = diagnose_drive(log, rover, &Registry::builtin(), &Settings::of(rover)).unwrap();
    assert_eq!(d.set, ["yaw-rate-bias"], "{}", d.verdict);
    let (found, sd) = magnitude(&d);
    assert!((found - bias).abs() < 4.0 * sd, "{found} ± {sd}");
}

/// To the wheels it looks like other soil on one side than on the other.
#[test]
fn an_offset_of_the_gyroscope_is_told_from_soil_that_differs_between_sides() {
    for bias in [0.02, -0.01] {
        let (log, rover) = off_by(bias);
        is_named(&log, &rover, bias);
    }
}

/// Beside a log of the same vehicle without a gyroscope, in which it drives as its wheels do: that one knows of no offset.
#[test]
fn a_log_without_a_gyroscope_has_no_offset_of_one() {
    let (log, rover) = off_by(0.02);
    let mut unread = log.clone();
    unread.yaw_rate = None;
    let [one, two] =
        [("one.csv", &log), ("two.csv", &unread)].map(|(name, log)| Named { name, log });
    let (registry, settings) = (Registry::builtin(), Settings::of(&rover));
    let d = diagnose_drives(&[one, two], &rover, &registry, &settings).unwrap();
    assert_eq!(
        d.causes[0].name, "yaw-rate-bias",
        "{} {:?}",
        d.verdict, d.set
    );
    let (found, sd) = magnitude(&d);
    assert!((found - 0.02).abs() < 4.0 * sd, "{found} ± {sd}");
}
