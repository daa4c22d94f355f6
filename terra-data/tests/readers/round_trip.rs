//! What is written is read back to the same bits.

use proptest::prelude::*;
use terra_data::{
    DriveLog, Measured, RigLog, RigRow, Segment, Series, read_drive_log_from, read_rig_log,
    write_drive_log, write_drive_log_to, write_rig_log,
};

use crate::support::{kind, rig, rover};

/// Any finite double, subnormal and -0 included, or a missing sample.
fn sample() -> impl Strategy<Value = Option<f64>> {
    let finite = any::<u64>()
        .prop_map(f64::from_bits)
        .prop_filter("finite", |v| v.is_finite());
    prop_oneof![4 => finite.prop_map(Some), 1 => Just(None), 1 => Just(Some(-0.0)), 1 => (-1e3..1e3).prop_map(Some)]
}

fn series(n: usize) -> impl Strategy<Value = Series> {
    proptest::collection::vec(sample(), n).prop_map(Series::from_iter)
}

fn four(n: usize) -> impl Strategy<Value = [Series; 4]> {
    [series(n), series(n), series(n), series(n)]
}

/// Names as people write them, and the characters CSV has to quote.
fn name() -> impl Strategy<Value = String> {
    "[a-zA-Z0-9,\"'; é#]{0,8}".prop_map(|s| s.trim().to_owned())
}

fn drive_log() -> impl Strategy<Value = DriveLog> {
    (1usize..30).prop_flat_map(|n| {
        let steps = proptest::collection::vec(1e-6..1e3, n);
        let cuts = proptest::collection::vec((any::<bool>(), name()), n);
        let optional = (
            proptest::option::of(four(n)),
            proptest::option::of(series(n)),
            proptest::option::of(four(n)),
            proptest::option::of(series(n)),
        );
        (-1e6..1e9, steps, cuts, four(n), series(n), optional).prop_map(
            move |(start, steps, cuts, wheel_speed, ground, (torque, accel, sinkage, pitch))| {
                let mut now = start;
                let time: Vec<f64> = steps
                    .iter()
                    .map(|dt| {
                        now += dt;
                        now
                    })
                    .collect();
                let mut segments: Vec<Segment> = Vec::new();
                for (row, (cut, name)) in cuts.into_iter().enumerate() {
                    match segments.last_mut() {
                        Some(last) if !cut || last.name == name => last.rows.end = row + 1,
                        _ => segments.push(Segment {
                            name,
                            rows: row..row + 1,
                        }),
                    }
                }
                DriveLog {
                    time,
                    segments,
                    wheel_speed,
                    wheel_torque: torque,
                    ground_speed: Some(ground),
                    accel_x: accel,
                    sinkage,
                    pitch,
                    ..DriveLog::default()
                }
            },
        )
    })
}

fn bits(series: &Series) -> Vec<Option<u64>> {
    series.iter().map(|v| v.map(f64::to_bits)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn drive_logs(log in drive_log()) {
        let mut text = Vec::new();
        write_drive_log_to(&mut text, &log).unwrap();
        let back = read_drive_log_from(text.as_slice(), "log.csv", &rover("")).unwrap();
        prop_assert_eq!(&back.segments, &log.segments);
        let time = |l: &DriveLog| l.time.iter().map(|t| t.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(time(&back), time(&log));
        let all = |l: &DriveLog| {
            let four = |f: &Option<[Series; 4]>| f.as_ref().map(|f| f.each_ref().map(bits));
            let one = |s: &Option<Series>| s.as_ref().map(bits);
            (
                l.wheel_speed.each_ref().map(bits),
                four(&l.wheel_torque),
                four(&l.sinkage),
                one(&l.ground_speed),
                one(&l.accel_x),
                one(&l.pitch),
                one(&l.roll),
            )
        };
        prop_assert_eq!(all(&back), all(&log));
        let blank: usize = back.notes.missing.values().map(|m| m.total()).sum();
        let holes = |s: &Series| s.count().missing;
        let mut expected: usize = log.wheel_speed.iter().map(holes).sum();
        expected += log.wheel_torque.iter().chain(&log.sinkage).flatten().map(holes).sum::<usize>();
        expected += [&log.ground_speed, &log.accel_x, &log.pitch].into_iter().flatten().map(holes).sum::<usize>();
        prop_assert_eq!(blank, expected);
        prop_assert!(back.warnings.is_empty());
    }

    #[test]
    fn rig_logs(rows in proptest::collection::vec(rig_row(), 1..20)) {
        let rows: Vec<RigRow> = rows.into_iter().enumerate().map(|(i, row)| RigRow { line: i as u64 + 2, ..row }).collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        write_rig_log(&path, &RigLog { rows: rows.clone(), ..RigLog::default() }).unwrap();
        let back = read_rig_log(&path, &rig("")).unwrap();
        prop_assert_eq!(back.dropped, vec![]);
        prop_assert_eq!(back.rows, rows);
    }
}

fn measured() -> impl Strategy<Value = Measured> {
    let sd = proptest::option::of(0.0..1e3);
    ((-1e6..1e6), sd).prop_map(|(value, sd)| Measured { value, sd })
}

fn rig_row() -> impl Strategy<Value = RigRow> {
    let names = ("[a-z][a-z0-9,\" ]{0,6}[a-z]", name(), 1u32..9);
    let inputs = (-1.0..=1.0, 1e-3..1e4, proptest::option::of(0.0..1.0));
    let channels = (
        measured(),
        proptest::option::of(measured()),
        proptest::option::of(measured()),
        proptest::option::of(measured()),
    );
    let motion = (
        proptest::option::of(-1.0..1.0),
        proptest::option::of(0.0..1.0),
    );
    (names, inputs, channels, motion).prop_map(
        |(
            (trial, condition, pass),
            (slip, load, sd),
            (pull, torque, sinkage, side),
            (angle, speed),
        )| RigRow {
            line: 0,
            trial,
            condition,
            pass,
            time: None,
            slip: Measured { value: slip, sd },
            normal_load: Measured {
                value: load,
                sd: sd.map(|s| s * 3.0),
            },
            drawbar_pull: Some(pull),
            torque,
            sinkage,
            side_force: side,
            slip_angle: angle,
            travel_speed: speed,
            wheel_speed: None,
        },
    )
}

#[test]
fn numbers_are_written_with_the_fewest_digits() {
    let ramp = |values: [f64; 4]| Series::from_iter(values.map(Some));
    let log = DriveLog {
        time: vec![0.0, 0.1, 0.2, 0.30000000000000004],
        wheel_speed: [(); 4].map(|()| ramp([1.0, 1e300, 5e-324, 0.1])),
        ..DriveLog::default()
    };
    let mut text = Vec::new();
    write_drive_log_to(&mut text, &log).unwrap();
    assert_eq!(
        String::from_utf8(text).unwrap(),
        "time_s,wheel_speed_fl_rad_s,wheel_speed_fr_rad_s,wheel_speed_rl_rad_s,wheel_speed_rr_rad_s\n\
         0,1,1,1,1\n0.1,1e300,1e300,1e300,1e300\n0.2,5e-324,5e-324,5e-324,5e-324\n0.30000000000000004,0.1,0.1,0.1,0.1\n"
    );
}

#[test]
fn a_log_that_would_not_come_back_is_not_written() {
    let one = |value: f64| Series::from_iter([Some(value), Some(value)]);
    let good = DriveLog {
        time: vec![0.0, 1.0],
        wheel_speed: [(); 4].map(|()| one(1.0)),
        ..DriveLog::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let refused = |log: DriveLog| kind(&write_drive_log(&path, &log).unwrap_err());
    let segments = |names: [&str; 2]| {
        let segment = |i: usize| Segment {
            name: names[i].to_owned(),
            rows: i..i + 1,
        };
        vec![segment(0), segment(1)]
    };
    assert_eq!(
        refused(DriveLog {
            segments: segments(["a", "a"]),
            ..good.clone()
        }),
        "NotALog"
    );
    assert_eq!(
        refused(DriveLog {
            segments: segments(["a", " b"]),
            ..good.clone()
        }),
        "NotALog"
    );
    assert_eq!(
        refused(DriveLog {
            time: vec![1.0, 0.5],
            ..good.clone()
        }),
        "NotALog"
    );
    assert_eq!(
        refused(DriveLog {
            time: vec![0.0, f64::NAN],
            ..good.clone()
        }),
        "NotALog"
    );
    assert_eq!(
        refused(DriveLog {
            time: vec![0.0],
            ..good.clone()
        }),
        "NotALog"
    );
    assert!(!path.exists());
    write_drive_log(
        &path,
        &DriveLog {
            segments: segments(["a", "b"]),
            ..good
        },
    )
    .unwrap();
}
