//! Names, units and missing cells of drive logs, and the kind of a log.

use approx::assert_relative_eq;
use terra_data::{LogKind, log_kind_from, read_drive_log_from};

use crate::support::{DRIVE, kind, rig, rover};

#[test]
fn missing_cells_are_missing_and_counted() {
    let log = format!("{DRIVE},note\n0,,nan,NA,1e999,NaN,a\n1,1, 2.5 ,-inf,+4,5e-1,b\n");
    let log = read_drive_log_from(log.as_bytes(), "log.csv", &rover("")).unwrap();
    let [fl, fr, rl, rr] = &log.wheel_speed;
    for series in [fl, fr, rl, rr, log.ground_speed.as_ref().unwrap()] {
        assert_eq!(series.get(0), None);
    }
    assert_eq!(
        (fl.get(1), fr.get(1), rl.get(1), rr.get(1)),
        (Some(1.0), Some(2.5), None, Some(4.0))
    );
    assert_eq!(log.ground_speed.as_ref().unwrap().get(1), Some(0.5));
    assert_eq!(log.notes.ignored_columns, ["note"]);
    assert_eq!(log.notes.not_finite(), 2);
    let missing = |name: &str| {
        let m = log.notes.missing[name];
        (m.blank, m.not_finite)
    };
    assert_eq!(missing("wheel_speed_fl_rad_s"), (1, 0));
    assert_eq!(missing("wheel_speed_rl_rad_s"), (1, 1));
    assert_eq!(missing("wheel_speed_rr_rad_s"), (0, 1));
    assert!(log.warnings.is_empty());
}

#[test]
fn byte_order_mark_crlf_quotes_and_column_order_change_nothing() {
    let plain = format!("segment,{DRIVE}\na,0,1,2,3,4,5\nb,0,6,7,8,9,10\n");
    let dressed = "\u{feff}\"ground_speed_m_s\", wheel_speed_rr_rad_s ,wheel_speed_rl_rad_s,wheel_speed_fr_rad_s,wheel_speed_fl_rad_s,time_s,segment\r\n\
                   \"5\",4,3,2,1,0,a\r\n\r\n10,9,\"8\",7,6,0,\"b\"";
    let read = |text: &str| read_drive_log_from(text.as_bytes(), "log.csv", &rover("")).unwrap();
    let (plain, dressed) = (read(&plain), read(dressed));
    assert_eq!(plain.time, dressed.time);
    assert_eq!(plain.segments, dressed.segments);
    assert_eq!(plain.wheel_speed, dressed.wheel_speed);
    assert_eq!(plain.ground_speed, dressed.ground_speed);
    assert_eq!(plain.segments.len(), 2);
    assert_eq!(
        plain.wheel_speed.each_ref().map(|s| s.get(1)),
        [6.0, 7.0, 8.0, 9.0].map(Some)
    );
    assert!(dressed.warnings[0].contains("no line end"));
}

#[test]
fn mapped_names_and_units() {
    let rover = rover(
        r#"
[columns]
time_s = { from = "stamp", unit = "ms" }
wheel_speed_fl_rad_s = { from = "wfl", unit = "rpm" }
wheel_speed_fr_rad_s = { from = "wfr", unit = "rpm" }
wheel_speed_rl_rad_s = { from = "wrl", unit = "rpm" }
wheel_speed_rr_rad_s = { from = "wrr", unit = "rpm" }
ground_speed_m_s = { from = "v", unit = "km/h" }
accel_x_m_s2 = { from = "ax", unit = "g" }
pitch_rad = { from = "pitch", unit = "deg" }
"#,
    );
    let log = "stamp,wfl,wfr,wrl,wrr,v,ax,pitch\n0,30,30,30,30,3.6,1,180\n10,60,0,0,0,36,0,0\n";
    let log = read_drive_log_from(log.as_bytes(), "log.csv", &rover).unwrap();
    assert_eq!(log.time, [0.0, 0.01]);
    // 30 turns a minute are half a turn a second: pi rad/s, up to the two roundings of x pi / 30.
    assert_relative_eq!(
        log.wheel_speed[0].get(0).unwrap(),
        std::f64::consts::PI,
        max_relative = 2.0 * f64::EPSILON
    );
    assert_eq!(log.ground_speed.as_ref().unwrap().get(1), Some(10.0));
    assert_eq!(log.accel_x.as_ref().unwrap().get(0), Some(9.80665));
    assert_relative_eq!(
        log.pitch.as_ref().unwrap().get(0).unwrap(),
        std::f64::consts::PI,
        max_relative = 2.0 * f64::EPSILON
    );

    // A value that only its conversion makes infinite is missing and counted too.
    let log = "stamp,wfl,wfr,wrl,wrr,v,ax,pitch\n0,30,30,30,30,3.6,1e308,180\n";
    let log = read_drive_log_from(log.as_bytes(), "log.csv", &rover).unwrap();
    assert_eq!(log.accel_x.as_ref().unwrap().get(0), None);
    assert_eq!(log.notes.missing["accel_x_m_s2"].not_finite, 1);

    // The same rover file reads a log in our own names: a simulated one.
    let own = format!("{DRIVE}\n0,1,1,1,1,1\n");
    let own = read_drive_log_from(own.as_bytes(), "sim.csv", &rover).unwrap();
    assert_eq!(own.wheel_speed[0].get(0), Some(1.0));

    // In a log in the user's names every mapped column must be there.
    let log = "stamp,wfl,wfr,wrl,wrr,v,ax,pich\n0,30,30,30,30,3.6,1,180\n";
    let e = read_drive_log_from(log.as_bytes(), "log.csv", &rover).unwrap_err();
    assert_eq!(
        (kind(&e).as_str(), e.line(), e.column()),
        ("MissingColumn", Some(1), Some(8))
    );
    assert!(
        e.to_string().contains("no column 'pitch'") && e.to_string().contains("'pich'"),
        "{e}"
    );
}

#[test]
fn motor_currents_give_torque_with_a_drivetrain_only() {
    let log = format!(
        "{DRIVE},motor_current_fl_A,motor_current_fr_A,motor_current_rl_A,motor_current_rr_A\n0,1,1,1,1,1,2,-2,0,\n"
    );
    let read = |r| read_drive_log_from(log.as_bytes(), "log.csv", &r).unwrap();
    let with = read(rover(
        "[drivetrain]\ntorque_constant_N_m_A = 0.0625\ngear_ratio = 40\nefficiency = 0.5\n",
    ));
    // 2 A x 0.0625 N m/A x 40 x 0.5 = 2.5 N m.
    let torque = with.wheel_torque.unwrap().map(|s| s.get(0));
    assert_eq!(torque, [Some(2.5), Some(-2.5), Some(0.0), None]);
    let without = read(rover(""));
    assert!(without.wheel_torque.is_none());
    assert!(without.warnings[0].contains("[drivetrain]"));
}

#[test]
fn ground_speed_may_be_declared_absent() {
    let log = DRIVE.replace(",ground_speed_m_s", "") + "\n0,1,1,1,1\n";
    let none = rover("[filter]\nground_speed = \"none\"\n");
    let log = read_drive_log_from(log.as_bytes(), "log.csv", &none).unwrap();
    assert!(log.ground_speed.is_none() && log.wheel_torque.is_none());
    assert_eq!(log.segments[0].name, "all");
}

#[test]
fn the_kind_is_told_by_the_columns() {
    let of = |text: &str| log_kind_from(text.as_bytes(), "log.csv", &rig(""));
    assert_eq!(of(DRIVE).unwrap(), LogKind::Drive);
    assert_eq!(of("slip,normal_load_N\n").unwrap(), LogKind::Rig);
    assert_eq!(
        of("travel_speed_m_s,wheel_speed_rad_s,normal_load_N\n").unwrap(),
        LogKind::Rig
    );
    let e = of("time_s,slip,force\n").unwrap_err();
    assert_eq!((kind(&e).as_str(), e.line()), ("UnknownLogKind", Some(1)));
    let text = e.to_string();
    assert!(
        text.contains("wheel_speed_{fl,fr,rl,rr}_rad_s") && text.contains("normal_load_N"),
        "{text}"
    );
}
