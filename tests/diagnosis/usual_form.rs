//! Forms of one effect that a log hardly tells apart.

use terra::gap::{Settings, diagnose_drive};
use terra::model::Registry;

use crate::far::slowly;
use crate::magnitude;

/// Soil piled up ahead of the wheel by the usual formula, which by bearing-capacity factors is a fourth as much and as good: it is told
/// by the usual one, and its magnitude is what was put in.
#[test]
fn a_cause_is_told_in_its_usual_form() {
    let noise = [
        ("wheel_speed_rad_s", 0.01),
        ("wheel_torque_N_m", 0.1),
        ("ground_speed_m_s", 0.006),
        ("yaw_rate_rad_s", 0.004),
        ("accel_x_m_s2", 0.02),
    ];
    let (log, rover) = slowly(Some(("bulldozing", 2.0)), noise);
    let d = diagnose_drive(&log, &rover, &Registry::builtin(), &Settings::of(&rover)).unwrap();
    let first = &d.causes[0];
    assert_eq!(
        (first.name.as_str(), first.form.as_str()),
        ("bulldozing", "default"),
        "{} {:?}",
        d.verdict,
        d.set
    );
    let (found, sd) = magnitude(&d);
    assert!((found - 2.0).abs() < 4.0 * sd, "{found} ± {sd}");
}
