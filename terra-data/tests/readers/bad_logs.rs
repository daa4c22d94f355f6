//! Bad logs, each with the kind, line and column of the error it must give.

use std::io::Write;

use terra_data::{DataError, DriveLog, read_drive_log, read_drive_log_from, read_rig_log_from};

use crate::support::{Case, DRIVE, check, kind, rig, rover};

fn drive(bytes: &[u8]) -> Result<DriveLog, DataError> {
    // Through a file: the whole way a user's log takes.
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    read_drive_log(file.path(), &rover(""))
}

fn csv(rows: &str) -> Vec<u8> {
    format!("{DRIVE}\n{rows}").into_bytes()
}

fn utf16(text: &str, mark: bool, big: bool) -> Vec<u8> {
    let units = mark
        .then_some(0xfeff)
        .into_iter()
        .chain(text.encode_utf16());
    units
        .flat_map(|u| {
            if big {
                u.to_be_bytes()
            } else {
                u.to_le_bytes()
            }
        })
        .collect()
}

#[test]
fn files_that_are_no_csv() {
    let good = String::from_utf8(csv("0,1,1,1,1,0.2\n")).unwrap();
    let noise: Vec<u8> = (0..600u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("no bytes", vec![], "Empty", None, None),
        ("blank lines", b"\n\r\n  \n".to_vec(), "Empty", None, None),
        ("a mark and nothing", b"\xef\xbb\xbf".to_vec(), "Empty", None, None),
        ("gzip", b"\x1f\x8b\x08\x00\x00\x00\x00\x00".to_vec(), "Compressed", None, None),
        ("cut gzip", b"\x1f\x8b".to_vec(), "Compressed", None, None),
        ("zip", b"PK\x03\x04\x14\x00".to_vec(), "Compressed", None, None),
        ("zstd", b"\x28\xb5\x2f\xfd\x24".to_vec(), "Compressed", None, None),
        ("parquet", b"PAR1\x15\x04\x15".to_vec(), "Binary", None, None),
        ("mcap", b"\x89MCAP0\r\n".to_vec(), "Binary", None, None),
        ("hdf5", b"\x89HDF\r\n\x1a\n".to_vec(), "Binary", None, None),
        ("random bytes", noise, "Binary", None, None),
        ("utf-16 little endian", utf16(&good, true, false), "Utf16", None, None),
        ("utf-16 big endian", utf16(&good, true, true), "Utf16", None, None),
        ("utf-16 without a mark", utf16(&good, false, false), "Utf16", None, None),
        ("utf-16 big endian without a mark", utf16(&good, false, true), "Utf16", None, None),
        ("semicolons", good.replace(',', ";").into_bytes(), "WrongDelimiter", Some(1), None),
        ("tabs", good.replace(',', "\t").into_bytes(), "WrongDelimiter", Some(1), None),
        ("latin-1 in the header", b"time_s,temp\xe9rature\n0,1\n".to_vec(), "NotUtf8", Some(1), Some(2)),
    ];
    check(&cases, drive);
}

#[test]
fn headers() {
    let header =
        |from: &str, to: &str| format!("{}\n0,1,1,1,1,1\n", DRIVE.replace(from, to)).into_bytes();
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("header only", csv(""), "NoRows", Some(1), None),
        ("header without line end", DRIVE.as_bytes().to_vec(), "NoRows", Some(1), None),
        ("header after blank lines", format!("\n\r\n{DRIVE}\n").into_bytes(), "NoRows", Some(3), None),
        ("no time", header("time_s", "x"), "MissingColumn", Some(1), None),
        ("time without unit", header("time_s", "time"), "MissingColumn", Some(1), Some(1)),
        ("a wheel renamed", header("wheel_speed_rl", "wheel_speed_lr"), "MissingColumn", Some(1), Some(4)),
        ("a wheel in rpm", header("fr_rad_s", "fr_rpm"), "MissingColumn", Some(1), Some(3)),
        ("no ground speed", header("ground_speed_m_s", "v"), "MissingColumn", Some(1), None),
        ("ground speed in km/h", header("ground_speed_m_s", "ground_speed_km_h"), "MissingColumn", Some(1), Some(6)),
        ("capitals", header("time_s", "Time_s"), "MissingColumn", Some(1), Some(1)),
        ("a wheel twice", header("wheel_speed_fr", "wheel_speed_fl"), "DuplicateColumn", Some(1), Some(3)),
        ("time twice", header("ground_speed_m_s", "time_s"), "DuplicateColumn", Some(1), Some(6)),
        ("one torque of four", format!("{DRIVE},wheel_torque_rl_N_m\n0,1,1,1,1,1,1\n").into_bytes(), "MissingColumn", Some(1), None),
        ("no header", b"0,1,1,1,1,1\n0.1,1,1,1,1,1\n".to_vec(), "MissingColumn", Some(1), None),
        ("a comment before the header", format!("# robot 3\n{DRIVE}\n").into_bytes(), "MissingColumn", Some(1), None),
    ];
    check(&cases, drive);
}

#[test]
fn rows() {
    const GOOD: &str = "0,1,1,1,1,0.2\n";
    let after = |rows: &str| csv(&format!("{GOOD}{rows}"));
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("quoted decimal comma", after("0.1,1,\"1,5\",1,1,0.2\n"), "BadNumber", Some(3), Some(3)),
        ("plain decimal comma", after("0.1,1,1,5,1,1,0.2\n"), "RaggedRow", Some(3), Some(7)),
        ("letters after digits", after("0.1,1,1,12abc,1,0.2\n"), "BadNumber", Some(3), Some(4)),
        ("hexadecimal", after("0.1,0x1F,1,1,1,0.2\n"), "BadNumber", Some(3), Some(2)),
        ("thousands", after("0.1,1_000,1,1,1,0.2\n"), "BadNumber", Some(3), Some(2)),
        ("a unit in the cell", after("0.1,1,1,1,1,0.2 m/s\n"), "BadNumber", Some(3), Some(6)),
        ("a date", after("2024-05-01T10:00:00Z,1,1,1,1,0.2\n"), "BadNumber", Some(3), Some(1)),
        ("a question mark", after("0.1,1,1,1,?,0.2\n"), "BadNumber", Some(3), Some(5)),
        ("two numbers in a cell", after("0.1,1 2,1,1,1,0.2\n"), "BadNumber", Some(3), Some(2)),
        ("a cell too few", after("0.1,1,1,1,1\n0.2,1,1,1,1,1\n"), "RaggedRow", Some(3), Some(6)),
        ("a cell too many", after("0.1,1,1,1,1,0.2,7\n"), "RaggedRow", Some(3), Some(7)),
        ("the header again", after(&format!("{DRIVE}\n")), "BadNumber", Some(3), Some(1)),
        ("cut between cells", after("0.1,1,1"), "CutLastLine", Some(3), Some(3)),
        ("too long, without a line end", after("0.1,1,1,1,1,0.2,7"), "RaggedRow", Some(3), Some(7)),
        ("cut after a comma", after("0.1,1,1,"), "CutLastLine", Some(3), Some(4)),
        ("an open quote in the middle", after("0.1,\"1,1,1,1,0.2\n0.2,1,1,1,1,0.2\n"), "UnclosedQuote", Some(3), Some(2)),
        ("an open quote at the end", after("0.1,1,1,1,1,\"0.2\n0.2,1,1,1,1,0.2\n"), "UnclosedQuote", Some(3), Some(6)),
        ("a NUL", after("0.1,1,1,\0,1,0.2\n"), "Nul", Some(3), Some(4)),
        ("a NUL after a number", after("0.1,1,1,1,1,0.2\0\n"), "Nul", Some(3), Some(6)),
        ("no UTF-8", [after("0.1,1,1,"), b"\xff1,1,0.2\n".to_vec()].concat(), "NotUtf8", Some(3), Some(4)),
        ("time stands still", after("0,1,1,1,1,0.2\n"), "TimeNotIncreasing", Some(3), Some(1)),
        ("time goes back", after("0.2,1,1,1,1,1\n0.1,1,1,1,1,1\n"), "TimeNotIncreasing", Some(4), Some(1)),
        ("no time in a row", after(",1,1,1,1,0.2\n"), "MissingTime", Some(3), Some(1)),
        ("endless time", after("1e999,1,1,1,1,0.2\n"), "MissingTime", Some(3), Some(1)),
        ("after blank lines", after("\n\n\n0.1,x,1,1,1,0.2\n"), "BadNumber", Some(6), Some(2)),
        (
            "after CRLF",
            csv("0,1,1,1,1,1\n0.1,1,1,1,1,1\n0.2,1,1,1,1,x\n")
                .iter()
                .flat_map(|b| match b {
                    b'\n' => b"\r\n".to_vec(),
                    b => vec![*b],
                })
                .collect(),
            "BadNumber",
            Some(4),
            Some(6),
        ),
        ("after a cell of three lines", format!("note,{DRIVE}\n\"a\nb\nc\",0,1,1,1,1,1\n,0.1,1,1,1,1,x\n").into_bytes(), "BadNumber", Some(5), Some(7)),
        ("after a mark", [b"\xef\xbb\xbf".to_vec(), after("0.1,1,1,1,1,x\n")].concat(), "BadNumber", Some(3), Some(6)),
        ("old Macintosh line ends", String::from_utf8(after("0.1,1,1,1,x,1\n")).unwrap().replace('\n', "\r").into_bytes(), "BadNumber", Some(3), Some(5)),
        ("pass of one and a half", format!("{DRIVE},pass\n0,1,1,1,1,1,1.5\n").into_bytes(), "BadValue", Some(2), Some(7)),
        ("pass 0", format!("{DRIVE},pass\n0,1,1,1,1,1,0\n").into_bytes(), "BadValue", Some(2), Some(7)),
        (
            "deep in a long file",
            csv(&(0..20_000).map(|i| format!("{i},1,1,1,{},0.2\n", if i == 19_998 { "x" } else { "1" })).collect::<String>()),
            "BadNumber",
            Some(20_000),
            Some(5),
        ),
    ];
    check(&cases, drive);
}

#[test]
fn time_may_start_anew_in_a_segment_only() {
    let log =
        format!("segment,{DRIVE}\na,0,1,1,1,1,1\na,1,1,1,1,1,1\nb,0,1,1,1,1,1\nb,0,1,1,1,1,1\n");
    let e = drive(log.as_bytes()).unwrap_err();
    assert_eq!(
        (kind(&e).as_str(), e.line(), e.column()),
        ("TimeNotIncreasing", Some(5), Some(2))
    );
    assert!(e.to_string().contains("inside 'b'"), "{e}");
}

#[test]
fn rig_logs() {
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("no load", b"slip,drawbar_pull_N\n.1,2\n".to_vec(), "MissingColumn", Some(1), None),
        ("load in kN", b"slip,normal_load_kN,drawbar_pull_N\n.1,2,3\n".to_vec(), "MissingColumn", Some(1), Some(2)),
        ("no slip", b"normal_load_N,drawbar_pull_N\n80,2\n".to_vec(), "MissingColumn", Some(1), None),
        ("half of the speeds", b"normal_load_N,drawbar_pull_N,rim_speed_m_s\n80,2,1\n".to_vec(), "MissingColumn", Some(1), None),
        ("nothing measured", b"slip,normal_load_N\n.1,80\n".to_vec(), "MissingColumn", Some(1), None),
        ("bad slip", b"slip,normal_load_N,torque_N_m\n.1,80,2\n20 %,80,2\n".to_vec(), "BadNumber", Some(3), Some(1)),
        ("a bad cell in a row without load", b"slip,normal_load_N,torque_N_m\n.1,,x\n".to_vec(), "BadNumber", Some(2), Some(3)),
        ("negative sd", b"slip,slip_sd,normal_load_N,torque_N_m\n.1,-.01,80,2\n".to_vec(), "BadValue", Some(2), Some(2)),
        ("pass in words", b"pass,slip,normal_load_N,torque_N_m\nfirst,.1,80,2\n".to_vec(), "BadNumber", Some(2), Some(1)),
        ("all slips impossible", b"slip,normal_load_N,torque_N_m\n20,80,2\n40,80,2\n".to_vec(), "NoUsableRows", Some(2), None),
        ("time back in a trial", b"trial,time_s,slip,normal_load_N,torque_N_m\na,1,.1,80,2\na,.5,.1,80,2\n".to_vec(), "TimeNotIncreasing", Some(3), Some(2)),
    ];
    check(&cases, |bytes| {
        read_rig_log_from(bytes, "log.csv", &rig(""))
    });
}

#[test]
fn paths_that_are_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let read =
        |name: &str| kind(&read_drive_log(folder.path().join(name), &rover("")).unwrap_err());
    assert_eq!(read("nothing.csv"), "NotFound");
    assert_eq!(read("."), "IsDirectory");
    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        symlink(folder.path().join("b"), folder.path().join("a")).unwrap();
        symlink(folder.path().join("a"), folder.path().join("b")).unwrap();
        assert_eq!(read("a"), "SymlinkLoop");
        symlink(folder.path().join("gone"), folder.path().join("dangling")).unwrap();
        assert_eq!(read("dangling"), "NotFound");
        let locked = folder.path().join("locked.csv");
        std::fs::write(&locked, csv("0,1,1,1,1,1\n")).unwrap();
        std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o000)).unwrap();
        // A superuser may read anything: there is nothing to test then.
        if std::fs::File::open(&locked).is_err() {
            assert_eq!(read("locked.csv"), "Unreadable");
        }
    }
}

#[test]
fn an_error_says_what_was_found_and_expected() {
    let log = csv("0,1,1,1,1,0.2\n0.1,1,1,\"1,5\",1,0.2\n");
    let e = read_drive_log_from(log.as_slice(), "drive.csv", &rover("")).unwrap_err();
    assert_eq!(
        e.to_string(),
        "drive.csv:3:4: column 'wheel_speed_rl_rad_s': found '1,5', expected a number (empty, nan or NA when missing)"
    );
    assert_eq!(e.file(), "drive.csv");
    assert!(!e.is_configuration() && !e.is_write());
    let log = DRIVE.replace("wheel_speed_fr", "wheel_sped_fr");
    let e = read_drive_log_from(log.as_bytes(), "drive.csv", &rover("")).unwrap_err();
    assert!(
        e.to_string().contains("no column 'wheel_speed_fr_rad_s'"),
        "{e}"
    );
    assert!(
        e.to_string()
            .contains("did you mean 'wheel_sped_fr_rad_s'?"),
        "{e}"
    );
}
