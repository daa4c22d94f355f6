//! Bags whose clock or types are wrong: an error that says so, in bounded time and memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use mcap::Writer;
use mcap::records::MessageHeader;
use terra_data::{DataError, ImportedLog, import_mcap};

const MAP: &str = "ground_speed_m_s = { topic = \"/speed\", field = \"v\" }\n";

/// A bag of one topic `/speed` whose messages have that definition, log times and bodies.
fn bag(folder: &Path, definition: &str, messages: &[(u64, Vec<u8>)]) -> PathBuf {
    let path = folder.join("made.mcap");
    let mut writer = Writer::new(File::create(&path).unwrap()).unwrap();
    let schema = writer
        .add_schema("my/msg/M", "ros2msg", definition.as_bytes())
        .unwrap();
    let channel_id = writer
        .add_channel(schema, "/speed", "cdr", &BTreeMap::new())
        .unwrap();
    for (log_time, body) in messages {
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: *log_time,
            publish_time: *log_time,
        };
        let cdr = [&[0, 1, 0, 0], body.as_slice()].concat();
        writer.write_to_known_channel(&header, &cdr).unwrap();
    }
    writer.finish().unwrap();
    path
}

fn read(
    definition: &str,
    messages: &[(u64, Vec<u8>)],
    rows: &str,
) -> Result<ImportedLog, DataError> {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("topics.toml");
    std::fs::write(&map, format!("[rows]\n{rows}\n[columns]\n{MAP}")).unwrap();
    import_mcap(bag(folder.path(), definition, messages), map)
}

fn speed(v: f64) -> Vec<u8> {
    v.to_le_bytes().to_vec()
}

/// A body with a stamp of 64-bit seconds, then the speed.
fn stamped(sec: i64, v: f64) -> Vec<u8> {
    [sec.to_le_bytes(), 0i64.to_le_bytes(), v.to_le_bytes()].concat()
}

const STAMPED: &str =
    "Head header\nfloat64 v\nMSG: my/Head\nStamp stamp\nMSG: my/Stamp\nint64 sec\nint64 nanosec\n";

#[test]
fn a_bag_made_here_reads() {
    let log = read(
        "float64 v\n",
        &[(5, speed(0.5)), (1_000_000_005, speed(1.5))],
        "rate_hz = 2.0\nmax_gap_s = 1.0",
    )
    .unwrap();
    let mut csv = vec![];
    log.write_to(&mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    assert_eq!(csv, "time_s,ground_speed_m_s\n0,0.5\n0.5,1\n1,1.5\n");
}

/// A day at a kilohertz of two messages: 86.4 million rows, all but a few of them empty.
#[test]
fn a_clock_that_jumps_does_not_fill_the_memory() {
    let day = 86_400_000_000_000;
    let messages = [(0, speed(0.5)), (day, speed(1.5))];
    let error = read("float64 v\n", &messages, "rate_hz = 1000.0").unwrap_err();
    let said = error.to_string();
    assert!(
        said.contains("86400 s") && said.contains("86400000 rows"),
        "{said}"
    );
    assert!(said.contains("jump of the clock"), "{said}");
    // At its own messages it is read, and the gap is said.
    let log = read("float64 v\n", &messages, "at = \"/speed\"").unwrap();
    assert_eq!(log.len(), 2);
}

/// Seconds that are no time in nanoseconds, and log times beyond what has a difference.
#[test]
fn a_time_out_of_range_is_said() {
    for sec in [i64::MAX, i64::MIN, 5_000_000_000, -5_000_000_000] {
        let error = read(STAMPED, &[(0, stamped(sec, 1.0))], "at = \"/speed\"").unwrap_err();
        assert!(error.to_string().contains("a time of"), "{error}");
    }
    let error = read("float64 v\n", &[(u64::MAX, speed(1.0))], "at = \"/speed\"").unwrap_err();
    assert!(
        error.to_string().contains("a time of 18446744073709551615"),
        "{error}"
    );
}

/// From year 1824 to 2116 is the whole range; the difference of its ends is a number.
#[test]
fn the_furthest_times_have_a_difference() {
    let messages = [
        (0, stamped(-4_600_000_000, 1.0)),
        (0, stamped(4_600_000_000, 2.0)),
    ];
    let log = read(STAMPED, &messages, "at = \"/speed\"").unwrap();
    assert_eq!(log.len(), 2);
    assert!(
        log.notes.iter().any(|n| n.contains("in 9200000000 s")),
        "{:?}",
        log.notes
    );
}

/// A text of four gigabytes in a record of some bytes: said, and no room is made for it. Other records are nobody's business.
#[test]
fn a_text_longer_than_its_record_is_said() {
    let record = |opcode: u8, body: &[u8]| {
        [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
    };
    let endless = u32::MAX.to_le_bytes();
    let text = |t: &str| [&(t.len() as u32).to_le_bytes()[..], t.as_bytes()].concat();
    let header = record(1, &[text(""), text("")].concat());
    let schema = [&[1, 0], text("my/msg/M").as_slice(), &endless].concat();
    let metadata = [&[8, 0, 0, 0], endless.as_slice(), &[0; 4]].concat();
    let channel = [
        &[1, 0, 1, 0],
        text("/speed").as_slice(),
        &text("cdr"),
        &metadata,
    ]
    .concat();
    let folder = tempfile::tempdir().unwrap();
    let (bag, map) = (
        folder.path().join("a.mcap"),
        folder.path().join("topics.toml"),
    );
    std::fs::write(&map, format!("[rows]\nat = \"/speed\"\n[columns]\n{MAP}")).unwrap();
    for records in [
        [header.clone(), record(3, &schema)].concat(),
        [header, record(4, &channel)].concat(),
    ] {
        std::fs::write(&bag, [b"\x89MCAP0\r\n", records.as_slice()].concat()).unwrap();
        let e = import_mcap(&bag, &map).unwrap_err();
        assert!(e.to_string().contains("longer than its record"), "{e}");
    }
    // A bag's header, which nothing is read of.
    let header = record(1, &endless);
    std::fs::write(&bag, [b"\x89MCAP0\r\n", header.as_slice()].concat()).unwrap();
    let e = import_mcap(&bag, &map).unwrap_err();
    assert!(!e.to_string().contains("longer than its record"), "{e}");
}
