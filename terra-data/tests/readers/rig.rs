//! Rig logs: slip, rows left out, groups.

use approx::assert_relative_eq;
use terra_data::{RigLog, read_rig_log_from};

use crate::support::rig;

fn read(text: &str, extra: &str) -> RigLog {
    read_rig_log_from(text.as_bytes(), "log.csv", &rig(extra)).unwrap()
}

#[test]
fn rows_that_cannot_be_used_are_left_out_with_line_and_reason() {
    let log = read(
        "slip,normal_load_N,drawbar_pull_N,pass\n.1,80,2,1\n,80,2,1\n.1,,2,1\n.1,80,,1\n1.5,80,2,1\n.1,-3,2,1\n.1,80,2,\n.2,80,3,2\n",
        "",
    );
    assert_eq!(log.rows.iter().map(|r| r.line).collect::<Vec<_>>(), [2, 9]);
    let expected = [
        (3, "slip is missing"),
        (4, "normal load is missing"),
        (5, "drawbar pull, torque and sinkage are missing"),
        (6, "turns against its motion"),
        (7, "normal load -3 N"),
        (8, "pass is missing"),
    ];
    assert_eq!(log.dropped.len(), expected.len());
    for ((line, reason), (at, words)) in log.dropped.iter().zip(expected) {
        assert!(*line == at && reason.contains(words), "{line}: {reason}");
    }
    // Rows in = used + left out.
    assert_eq!(log.rows.len() + log.dropped.len(), 8);
    assert_eq!(log.rows[1].trial, "8");
    assert_eq!((log.rows[0].pass, log.rows[1].pass), (1, 2));
}

#[test]
fn slip_from_the_speeds_of_a_slow_testbed() {
    // R = .254 m. Driving 1 - v/(R w), braking R w/v - 1; 10 mm/s is ordinary speed on a rig.
    let log = read(
        "rim_speed_m_s,travel_speed_m_s,normal_load_N,sinkage_m\n.02,.01,80,.01\n.005,.01,80,.01\n0,.01,80,.01\n.01,0,80,.01\n-.02,-.01,80,.01\n.02,-.01,80,.01\n0,0,80,.01\n",
        "",
    );
    let slips: Vec<f64> = log.rows.iter().map(|r| r.slip.value).collect();
    assert_eq!(slips, [0.5, -0.5, -1.0, 1.0, 0.5]);
    assert_eq!(log.dropped.iter().map(|d| d.0).collect::<Vec<_>>(), [7, 8]);
    assert_relative_eq!(
        log.rows[0].wheel_speed.unwrap(),
        0.02 / 0.254,
        max_relative = 1e-15
    );
    let log = read(
        "wheel_speed_rad_s,travel_speed_m_s,normal_load_N,sinkage_m\n1,.127,80,.01\n",
        "",
    );
    assert_relative_eq!(log.rows[0].slip.value, 0.5, max_relative = 1e-15);
}

#[test]
fn the_radius_is_the_condition_s_own() {
    let log = read(
        "condition,wheel_speed_rad_s,travel_speed_m_s,normal_load_N,sinkage_m\nsmall,1,.05,80,.01\nlarge,1,.127,80,.01\nsmal,1,.127,80,.01\n",
        "[condition.small]\nwheel = { radius_m = 0.1 }\n[condition.large]\n",
    );
    assert_relative_eq!(log.rows[0].slip.value, 0.5, max_relative = 1e-15);
    assert_relative_eq!(log.rows[1].slip.value, 0.5, max_relative = 1e-15);
    assert!(
        log.warnings
            .iter()
            .any(|w| w.contains("'smal'") && w.contains("'small'")),
        "{:?}",
        log.warnings
    );
}

#[test]
fn slip_counts_and_a_disagreement_above_two_hundredths_is_a_warning() {
    let log = read(
        "slip,rim_speed_m_s,travel_speed_m_s,normal_load_N,torque_N_m\n.515,.02,.01,80,1\n.525,.02,.01,80,1\n.3,.02,-.01,80,1\n",
        "",
    );
    let slips: Vec<f64> = log.rows.iter().map(|r| r.slip.value).collect();
    assert_eq!(slips, [0.515, 0.525, 0.3]);
    assert_eq!(log.warnings.len(), 2);
    assert!(log.warnings[0].contains("line 3") && log.warnings[1].contains("line 4"));
}

/// R w = .3, v = .2 (driving) and R w = .2, v = .25 (braking), by hand in every convention; the 1-sigma by the slope of
/// the conversion, here against a central difference.
#[test]
fn conventions_and_their_sd() {
    for (convention, driving, braking) in [
        ("library", 1.0 / 3.0, -0.2),
        ("percent", 100.0 / 3.0, -20.0),
        ("unbounded", 0.5, -0.2),
        ("driving", 1.0 / 3.0, -0.25),
        ("braking", 0.5, -0.2),
    ] {
        let h = 1e-6;
        let extra = format!(
            "[columns]\nslip = {{ from = \"s\", convention = \"{convention}\" }}\nslip_sd = {{ from = \"e\", convention = \"{convention}\" }}\n"
        );
        let mut text = "s,e,normal_load_N,torque_N_m\n".to_owned();
        for s in [
            driving,
            driving - h,
            driving + h,
            braking,
            braking - h,
            braking + h,
        ] {
            text += &format!("{s},0.01,80,1\n");
        }
        let log = read(&text, &extra);
        for (i, library) in [(0, 1.0 / 3.0), (3, -0.2)] {
            let [at, below, above] = [i, i + 1, i + 2].map(|i| log.rows[i].slip);
            assert_relative_eq!(at.value, library, epsilon = 1e-15);
            let slope = (above.value - below.value) / (2.0 * h);
            assert_relative_eq!(at.sd.unwrap(), 0.01 * slope, max_relative = 1e-6);
        }
    }
}

#[test]
fn groups_and_side_channels_are_kept() {
    let log = read(
        "trial,condition,pass,time_s,slip,normal_load_N,normal_load_sd_N,drawbar_pull_N,drawbar_pull_sd_N,slip_angle_rad,side_force_N\n\
         a,dense,1,0,.1,80,.5,2,,.1,4\na,dense,1,.1,.1,80,.5,2,.3,.1,4\na,dense,2,0,.1,80,.5,2,.3,,\n,dense,2,0,.1,80,.5,2,.3,,\n",
        "",
    );
    let row = &log.rows[1];
    assert_eq!(
        (row.trial.as_str(), row.condition.as_str(), row.pass),
        ("a", "dense", 1)
    );
    assert_eq!((row.time, row.slip_angle), (Some(0.1), Some(0.1)));
    assert_eq!(row.normal_load.sd, Some(0.5));
    assert_eq!(log.rows[0].drawbar_pull.unwrap().sd, None);
    assert_eq!(row.drawbar_pull.unwrap().sd, Some(0.3));
    assert_eq!(row.side_force.unwrap().value, 4.0);
    assert_eq!(log.rows[3].trial, "row 4");
    assert!(
        log.rows
            .iter()
            .all(|r| r.torque.is_none() && r.sinkage.is_none())
    );
    // Samples without a trial column are one trial.
    let log = read(
        "time_s,slip,normal_load_N,torque_N_m\n0,.1,80,1\n.1,.1,80,1\n",
        "",
    );
    assert!(log.rows.iter().all(|r| r.trial == "all"));
}

/// A mapped name that is nearly one of the file's is a slip of the pen, which would leave a channel out; a rover file that maps other
/// names reads a log in our own all the same.
#[test]
fn a_misspelt_mapped_name_is_no_missing_channel() {
    let columns = "[columns]\ntorque_N_m = { from = \"Mx_Nm\" }";
    let text = |name: &str| format!("slip,normal_load_N,drawbar_pull_N,{name}\n.1,80,2,3\n");
    let found = |name: &str| read_rig_log_from(text(name).as_bytes(), "log.csv", &rig(columns));
    let e = format!("{:?}", found("Mx_N_m").unwrap_err());
    assert!(e.contains("Mx_Nm") && e.contains("Mx_N_m"), "{e}");
    assert!(found("Mx_Nm").unwrap().rows[0].torque.is_some());
    assert!(found("torque_N_m").unwrap().rows[0].torque.is_some());
    assert!(found("note").unwrap().rows[0].torque.is_none());
}
