//! One drive in every format its users have: each reader gives the log of the CSV, to rounding. The files are written by
//! other people's libraries (`files/make.py`).
#![cfg_attr(
    not(any(feature = "mat", feature = "mcap", feature = "parquet")),
    allow(
        dead_code,
        reason = "nothing optional is built, so nothing is compared"
    )
)]

use std::path::{Path, PathBuf};

use terra_data::{DriveLog, ImportKind, ImportedLog, import, read_drive_log, read_drive_log_from};

use crate::support::{kind, rover};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/readers/files")
        .join(name)
}

fn read(log: &ImportedLog) -> DriveLog {
    let mut csv = vec![];
    log.write_to(&mut csv).unwrap();
    read_drive_log_from(csv.as_slice(), "imported", &rover("")).unwrap()
}

/// Same samples bit for bit; times within the nanosecond that a bag can tell.
fn same(found: &DriveLog) {
    let expected = read_drive_log(file("drive.csv"), &rover("")).unwrap();
    assert_eq!(found.len(), 60);
    assert_eq!(found.segments, expected.segments);
    for (a, b) in found.time.iter().zip(&expected.time) {
        assert!((a - b).abs() <= 1e-9, "{a} {b}");
    }
    assert_eq!(found.wheel_speed, expected.wheel_speed);
    assert_eq!(found.wheel_torque, expected.wheel_torque);
    assert_eq!(found.ground_speed, expected.ground_speed);
    assert_eq!(found.yaw_rate, expected.yaw_rate);
    assert_eq!(found.accel_x, expected.accel_x);
}

/// The outcome of a damaged file: whatever it is, it is no panic. Every byte of the head is changed, then bytes all over,
/// and the file is cut at many places.
fn survives(name: &str, read: impl Fn(&Path)) {
    let good = std::fs::read(file(name)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let try_it = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read(&path);
    };
    for at in (0..300).chain((300..good.len()).step_by(good.len() / 150)) {
        for flip in [0xff, 0x80, 0x01] {
            let mut bad = good.clone();
            bad[at % good.len()] ^= flip;
            try_it(&bad);
        }
    }
    for length in (0..good.len()).step_by(good.len() / 100) {
        try_it(&good[..length]);
    }
}

#[test]
fn a_format_that_is_not_built_is_said() {
    for (kind_of, name, built) in [
        (
            ImportKind::Parquet,
            "drive.parquet",
            cfg!(feature = "parquet"),
        ),
        (ImportKind::Mat, "drive.mat", cfg!(feature = "mat")),
    ] {
        match import(kind_of, file(name)) {
            Ok(_) => assert!(built),
            Err(e) => {
                assert!(!built, "{e}");
                assert_eq!(kind(&e), "FormatNotBuilt");
                assert!(
                    e.to_string()
                        .contains(&format!("--features {}", kind_of.name()))
                );
            }
        }
    }
}

#[cfg(feature = "parquet")]
mod parquet {
    use super::*;

    #[test]
    fn gives_the_log_of_the_csv() {
        same(&read(
            &import(ImportKind::Parquet, file("drive.parquet")).unwrap(),
        ));
    }

    #[test]
    fn damaged_files_are_errors() {
        survives("drive.parquet", |path| {
            drop(import(ImportKind::Parquet, path))
        });
    }
}

#[cfg(feature = "mat")]
mod mat {
    use super::*;

    /// A structure, compressed, and variables on their own, as scipy writes both.
    #[test]
    fn gives_the_log_of_the_csv() {
        for name in ["drive.mat", "drive_plain.mat"] {
            let log = import(ImportKind::Mat, file(name)).unwrap();
            same(&read(&log));
            let left_out = log.notes.iter().any(|n| n.starts_with("rate: "));
            assert_eq!(left_out, name == "drive.mat", "{:?}", log.notes);
        }
    }

    #[test]
    fn damaged_files_are_errors() {
        for name in ["drive.mat", "drive_plain.mat"] {
            survives(name, |path| drop(import(ImportKind::Mat, path)));
        }
    }

    /// A text array of 2^31 - 1 rows of no characters: the file has 184 bytes, and its reading must not take 48 GB.
    #[test]
    fn rows_without_characters_take_no_room() {
        let mut file = vec![b' '; 124];
        file.extend([0, 1, b'I', b'M']);
        let word = |n: u32| n.to_le_bytes();
        let mut matrix = vec![];
        // Class character; dimensions; the name, in its tag; UTF-8, nothing.
        for n in [6, 8, 4, 0, 5, 8, i32::MAX as u32, 0] {
            matrix.extend(word(n));
        }
        matrix.extend(word((1 << 16) | 1));
        matrix.extend(*b"a\0\0\0");
        matrix.extend([word(16), word(0)].concat());
        file.extend([word(14), word(matrix.len() as u32)].concat());
        file.extend(matrix);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("empty.mat");
        std::fs::write(&path, file).unwrap();
        let e = import(ImportKind::Mat, &path).unwrap_err();
        assert!(e.to_string().contains("no vector of numbers"), "{e}");
    }

    fn compressed(zeros: usize) -> Vec<u8> {
        use std::io::Write;
        let mut file = vec![b' '; 124];
        file.extend([0, 1, b'I', b'M']);
        let word = |n: u32| n.to_le_bytes();
        let mut matrix = vec![];
        // Class unsigned 8-bit; dimensions; the name, in its tag; the values.
        for n in [6, 8, 9, 0, 5, 8, zeros as u32, 1] {
            matrix.extend(word(n));
        }
        matrix.extend(word((1 << 16) | 1));
        matrix.extend(*b"a\0\0\0");
        matrix.extend([word(2), word(zeros as u32)].concat());
        matrix.resize(matrix.len() + zeros, 0);
        let mut deflate = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::best());
        let tag = [word(14), word(matrix.len() as u32)].concat();
        deflate.write_all(&[tag, matrix].concat()).unwrap();
        let body = deflate.finish().unwrap();
        file.extend([word(15), word(body.len() as u32)].concat());
        file.extend(body);
        file
    }

    /// Zeros deflate a thousandfold: a million of them are a log, a hundred million in 100 kB are none.
    #[test]
    fn what_inflates_without_end_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zeros.mat");
        std::fs::write(&path, compressed(1_000_000)).unwrap();
        assert_eq!(import(ImportKind::Mat, &path).unwrap().len(), 1_000_000);
        let bomb = compressed(100_000_000);
        assert!(bomb.len() < 200_000, "{}", bomb.len());
        std::fs::write(&path, bomb).unwrap();
        let e = import(ImportKind::Mat, &path).unwrap_err();
        assert_eq!(kind(&e), "Unreadable");
        assert!(e.to_string().contains("64 MiB"), "{e}");
    }

    #[test]
    fn what_is_no_mat_file_is_said() {
        let e = import(ImportKind::Mat, file("drive.csv")).unwrap_err();
        assert!(e.to_string().contains("save it with -v6 or -v7"), "{e}");
        let e = import(ImportKind::Mat, file("none.mat")).unwrap_err();
        assert_eq!(kind(&e), "NotFound");
    }
}

#[cfg(feature = "mcap")]
mod mcap {
    use super::*;
    use terra_data::{DataError, import_mcap};

    fn with(map: &str) -> Result<ImportedLog, DataError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("topics.toml");
        std::fs::write(&path, map).unwrap();
        import_mcap(file("drive.mcap"), &path)
    }

    fn topics() -> String {
        std::fs::read_to_string(file("topics.toml")).unwrap()
    }

    #[test]
    fn gives_the_log_of_the_csv() {
        for name in ["drive.mcap", "drive_zstd.mcap"] {
            let log = import_mcap(file(name), file("topics.toml")).unwrap();
            same(&read(&log));
            assert!(log.notes[0].contains("linear"), "{:?}", log.notes);
            let odometry = log.notes.iter().find(|n| n.starts_with("/odom")).unwrap();
            assert!(
                odometry.contains("nav_msgs/msg/Odometry")
                    && odometry.contains("60 messages in 0.59 s"),
                "{odometry}"
            );
        }
    }

    /// The same speed in three kinds of message.
    #[test]
    fn speed_from_any_message_that_has_it() {
        for (topic, field) in [
            ("/twist", "twist.linear.x"),
            ("/twist_cov", "twist.twist.linear.x"),
        ] {
            let map = topics().replace(
                "\"/odom\", field = \"twist.twist.linear.x\"",
                &format!("\"{topic}\", field = \"{field}\""),
            );
            same(&read(&with(&map).unwrap()));
        }
    }

    /// /pitch holds k/2 rad at sample k, 10 ms apart, without header: at 250 Hz a line through them is 4 ms x 50 rad/s.
    #[test]
    fn another_rate_and_another_unit() {
        let map = format!(
            "{}pitch_rad = {{ topic = \"/pitch\", field = \"data\", unit = \"deg\" }}\n",
            topics().replace("at = \"/joint_states\"", "rate_hz = 250.0")
        );
        let log = read(&with(&map).unwrap());
        // 59 intervals of 10 ms at 4 ms a row: 0 to 588 ms.
        assert_eq!(log.len(), 148);
        let pitch = log.pitch.unwrap();
        for row in 0..148 {
            let expected = (row as f64 * 0.2).to_radians();
            let found = pitch.get(row).unwrap();
            assert!((found - expected).abs() < 1e-9, "{row}: {found} {expected}");
        }
        let previous = map.replace("\"linear\"", "\"previous\"");
        let held = read(&with(&previous).unwrap()).pitch.unwrap();
        for row in 0..148 {
            let expected = (0.5 * (4 * row / 10) as f64).to_radians();
            assert!((held.get(row).unwrap() - expected).abs() < 1e-9, "{row}");
        }
    }

    /// What lies further from a sample than `max_gap_s` stays missing.
    #[test]
    fn a_gap_is_not_bridged() {
        let map = topics()
            .replace("at = \"/joint_states\"", "rate_hz = 250.0")
            .replace("max_gap_s = 0.05", "max_gap_s = 0.001");
        let log = with(&map).unwrap();
        // Rows 4 ms apart meet samples 10 ms apart every 20 ms: 30 of 148.
        let note = log
            .notes
            .iter()
            .find(|n| n.starts_with("yaw_rate_rad_s"))
            .unwrap();
        assert!(note.contains("118 of 148"), "{note}");
    }

    #[test]
    fn mistakes_of_the_map_are_named_with_their_place() {
        let line =
            |key: &str| 1 + topics().lines().position(|l| l.starts_with(key)).unwrap() as u64;
        let speed = line("ground_speed");
        #[rustfmt::skip]
        let cases = [
            ("method = \"linear\"", "method = \"cubic\"", "UnknownName", Some(line("method")), Some(10)),
            ("max_gap_s = 0.05", "max_gap_s = -1", "OutOfRange", Some(line("max_gap")), Some(13)),
            ("at = \"/joint_states\"", "", "MissingKey", Some(line("[rows]")), Some(2)),
            ("at = \"/joint_states\"", "at = \"/joint_states\"\nrate_hz = 10", "Conflict", Some(line("at =")), Some(6)),
            ("ground_speed_m_s", "ground_sped_m_s", "UnknownName", Some(speed), Some(1)),
            ("twist.twist.linear.x", "twist..x", "UnknownName", Some(speed), Some(47)),
            ("twist.twist.linear.x\"", "twist.twist.linear.x\", unit = \"N\"", "UnknownName", Some(speed), Some(78)),
            ("ground_speed_m_s = { topic", "ground_speed_m_s = { topc", "UnknownKey", Some(speed), Some(22)),
            ("[columns]", "[column]", "UnknownKey", Some(line("[columns]")), Some(2)),
            // These only the bag can tell.
            ("\"/odom\"", "\"/odm\"", "UnknownName", None, None),
            ("twist.twist.linear.x", "twist.twist.linear.w", "UnknownName", None, None),
            ("velocity[wheel_fl]", "velocity[wheel_lf]", "Unreadable", None, None),
            ("\"/odom\", field = \"twist.twist.linear.x\"", "\"/odom\", field = \"child_frame_id\"", "Unreadable", None, None),
        ];
        for (from, to, expected, line, column) in cases {
            assert!(topics().contains(from), "{from}");
            let e = with(&topics().replacen(from, to, 1)).unwrap_err();
            assert_eq!(
                (kind(&e).as_str(), e.line(), e.column()),
                (expected, line, column),
                "{to}: {e}"
            );
        }
        let e = with(&topics().replace("\"/odom\"", "\"/odm\"")).unwrap_err();
        assert!(e.to_string().contains("did you mean '/odom'?"), "{e}");
    }

    #[test]
    fn damaged_bags_are_errors() {
        for name in ["drive.mcap", "drive_zstd.mcap"] {
            survives(name, |path| drop(import_mcap(path, file("topics.toml"))));
        }
    }
}
