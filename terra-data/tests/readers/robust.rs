//! Any bytes give a log or a typed error: no panic, nothing that is not finite, no row unaccounted for.

use proptest::prelude::*;
use terra_data::{
    DriveLog, log_kind_from, parse_rover, read_drive_log_from, read_rig_log_from,
    read_terrains_from,
};

use crate::support::{DRIVE, ROVER, rig, rover};

fn finite(log: &DriveLog) -> bool {
    let fours = [&log.wheel_torque, &log.sinkage, &log.normal_load];
    let all = log
        .wheel_speed
        .iter()
        .chain(fours.into_iter().flatten().flatten());
    all.chain(&log.ground_speed)
        .flat_map(|s| s.iter())
        .flatten()
        .all(f64::is_finite)
        && log.time.iter().all(|t| t.is_finite())
}

/// A good text with a few bytes replaced, inserted or the end cut off.
pub(crate) fn damaged(text: String) -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![
        any::<u8>(),
        proptest::sample::select(b",\"\n\r\0;.-e1N[]{}=#".to_vec())
    ];
    let edits = proptest::collection::vec((any::<prop::sample::Index>(), byte, 0..3u8), 0..6);
    edits.prop_map(move |edits| {
        let mut bytes = text.clone().into_bytes();
        for (index, byte, how) in edits {
            let at = index.index(bytes.len().max(1));
            match how {
                0 if at < bytes.len() => bytes[at] = byte,
                1 => bytes.insert(at.min(bytes.len()), byte),
                _ if byte < 16 => bytes.truncate(at),
                _ => {}
            }
        }
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let rover = rover("");
        let _ = read_drive_log_from(bytes.as_slice(), "x", &rover);
        let _ = read_rig_log_from(bytes.as_slice(), "x", &rover);
        let _ = read_terrains_from(bytes.as_slice(), "x");
        let _ = log_kind_from(bytes.as_slice(), "x", &rover);
        let _ = parse_rover(&String::from_utf8_lossy(&bytes), "x");
    }

    #[test]
    fn a_damaged_drive_log(bytes in damaged(format!("segment,{DRIVE}\na,0,1,2,,nan,0.5\na,0.1,\"1\",2,3,4,1e9\r\nb,0,1,1,1,1,1\n"))) {
        if let Ok(log) = read_drive_log_from(bytes.as_slice(), "x", &rover("")) {
            prop_assert!(finite(&log));
            prop_assert!(log.wheel_speed.iter().all(|s| s.len() == log.time.len()));
            prop_assert_eq!(log.segments.last().unwrap().rows.end, log.time.len());
        }
    }

    #[test]
    fn a_damaged_rig_log(bytes in damaged("trial,slip,slip_sd,normal_load_N,torque_N_m\na,.1,.01,80,2\nb,-.5,,80,3\nc,2,,,\n".to_owned())) {
        if let Ok(log) = read_rig_log_from(bytes.as_slice(), "x", &rig("")) {
            for row in &log.rows {
                prop_assert!((-1.0..=1.0).contains(&row.slip.value));
                prop_assert!(row.normal_load.value > 0.0 && row.normal_load.value.is_finite());
            }
        }
    }

    #[test]
    fn a_damaged_rover_file(bytes in damaged(ROVER.to_owned())) {
        let text = String::from_utf8_lossy(&bytes);
        if let Err(e) = parse_rover(&text, "rover.toml") {
            prop_assert!(e.is_configuration());
            let lines = text.split('\n').count() as u64;
            prop_assert!(e.line().is_none_or(|l| (1..=lines).contains(&l)), "{}", e);
        }
    }
}

/// An endless line: what a reader allocates is bounded by what it has read.
#[test]
fn a_long_line_is_an_error_with_a_short_text() {
    let mut text = format!("{DRIVE}\n0,1,1,1,1,");
    text.push_str(&"9x".repeat(1_000_000));
    let e = read_drive_log_from(text.as_bytes(), "x", &rover("")).unwrap_err();
    assert!(e.to_string().len() < 300, "{}", e.to_string().len());
}

/// Names that no edit distance should ever see, and nesting that no recursion should follow.
#[test]
fn monstrous_names_and_nesting_are_errors_with_short_texts() {
    let name = "x".repeat(3_000_000);
    let many = "column,".repeat(300_000);
    for header in [name.as_str(), many.as_str()] {
        let text = format!("{header}\n1\n");
        for e in [
            read_drive_log_from(text.as_bytes(), "x", &rover("")).unwrap_err(),
            read_rig_log_from(text.as_bytes(), "x", &rig("")).unwrap_err(),
            log_kind_from(text.as_bytes(), "x", &rover("")).unwrap_err(),
        ] {
            assert!(e.to_string().len() < 1000, "{}", e.to_string().len());
        }
    }
    for text in [
        format!("{name} = 1\n"),
        format!("x = {}", "[".repeat(1_000_000)),
        format!("x = {}", "{a=".repeat(300_000)),
        format!("[{}]\n", "a.".repeat(300_000)),
    ] {
        let e = parse_rover(&text, "rover.toml").unwrap_err();
        assert!(e.to_string().len() < 1000, "{}", e.to_string().len());
    }
}

#[cfg(unix)]
#[test]
fn a_device_that_never_ends_is_no_text() {
    for e in [
        terra_data::read_rover("/dev/zero").unwrap_err(),
        terra_data::read_drive_log("/dev/zero", &rover("")).unwrap_err(),
    ] {
        assert!(e.to_string().contains("is binary"), "{e}");
    }
}
