//! What the targets share: which panics count, a file to read from, and what is true of every log that a reader gives.

use std::cell::RefCell;
use std::fs;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::OnceLock;

use terra_data::{
    DataError, DriveLog, ImportedLog, RigLog, Rover, Series, inspect_drive, inspect_rig,
    parse_rover, read_drive_log_from, read_rig_log_from, write_drive_log_to, write_rig_log_to,
};

thread_local! {
    /// The last panic of another crate, in words.
    static FOREIGN: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs one input. A panic in terra's own code is a finding wherever it is caught; one in a dependency only when nobody
/// catches it, because readers of other projects are run behind a guard.
pub fn run(body: impl FnOnce()) {
    static HOOK: OnceLock<()> = OnceLock::new();
    // The first input comes after libFuzzer has set its own hook, which would end the process at any panic.
    HOOK.get_or_init(|| panic::set_hook(Box::new(hook)));
    if panic::catch_unwind(AssertUnwindSafe(body)).is_err() {
        let said = FOREIGN.with_borrow(String::clone);
        finding(&format!("not caught: {said}"));
    }
}

fn hook(info: &PanicHookInfo<'_>) {
    let dependency = |file: &str| file.contains("/registry/src/") || file.contains("/library/");
    if info.location().is_none_or(|l| dependency(l.file())) {
        FOREIGN.with_borrow_mut(|said| *said = info.to_string());
    } else {
        finding(&info.to_string());
    }
}

fn finding(said: &str) -> ! {
    let trace = std::backtrace::Backtrace::force_capture();
    eprintln!("{said}\n{trace}");
    process::abort()
}

/// Bytes as a file of this process: readers of binary formats take a path.
pub struct Scratch(PathBuf);

impl Scratch {
    /// A file that ends on those letters.
    pub fn new(ending: &str) -> Self {
        // In memory where there is such a place; two processes never share one.
        let memory = Path::new("/dev/shm");
        let folder = match memory.is_dir() {
            true => memory.to_owned(),
            false => std::env::temp_dir(),
        };
        Scratch(folder.join(format!("terra-fuzz-{}-{ending}", process::id())))
    }

    /// The file, holding these bytes.
    pub fn with(&self, bytes: &[u8]) -> &Path {
        fs::write(&self.0, bytes).expect("a place for one small file");
        &self.0
    }

    /// The file as it is.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// Several files of this process in a folder: one that names another finds it there.
pub struct Folder(PathBuf);

impl Folder {
    /// An empty folder that ends on those letters.
    pub fn new(ending: &str) -> Self {
        let Scratch(path) = Scratch::new(ending);
        fs::create_dir_all(&path).expect("a place for a few small files");
        Folder(path)
    }

    /// A file of it, holding these bytes.
    pub fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).expect("a place for one small file");
        path
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// A rover whose log has the contract's columns, and one whose log has others, in other units, with motor currents.
pub fn rovers() -> [Rover; 2] {
    const VEHICLE: &str = include_str!("../fixed/rover.toml");
    const COLUMNS: &str = include_str!("../fixed/rover_columns.toml");
    [
        parse_rover(VEHICLE, "rover.toml").expect("a good rover"),
        parse_rover(&format!("{VEHICLE}{COLUMNS}"), "rover.toml").expect("a good rover"),
    ]
}

/// A rig whose log has the contract's columns, and one whose log has others.
pub fn rigs() -> [Rover; 2] {
    const WHEEL: &str = include_str!("../fixed/rig.toml");
    const COLUMNS: &str = include_str!("../fixed/rig_columns.toml");
    [
        parse_rover(WHEEL, "rig.toml").expect("a good rig"),
        parse_rover(&format!("{WHEEL}{COLUMNS}"), "rig.toml").expect("a good rig"),
    ]
}

/// What is true of every drive log: a sample a row, finite, time growing inside a segment, segments covering all rows,
/// and the same log again from what is written of it.
pub fn check_drive(log: &DriveLog, plain: &Rover) {
    let rows = log.len();
    assert!(rows > 0, "a log without rows");
    for (name, series) in channels(log) {
        assert_eq!(series.len(), rows, "{name}");
        assert!(series.iter().flatten().all(f64::is_finite), "{name}");
    }
    assert!(log.time.iter().all(|t| t.is_finite()));
    let mut next = 0;
    for segment in &log.segments {
        assert_eq!(segment.rows.start, next, "{}", segment.name);
        assert!(segment.rows.end > next, "{}", segment.name);
        next = segment.rows.end;
        let time = &log.time[segment.rows.clone()];
        assert!(time.windows(2).all(|w| w[0] < w[1]), "{}", segment.name);
    }
    assert_eq!(next, rows);
    let _ = inspect_drive(log, Some(plain));
    let written = drive_text(log);
    // A log without ground speed needs a rover that says so.
    if log.ground_speed.is_some() {
        let again = read_drive_log_from(written.as_bytes(), "again", plain);
        let again = again.unwrap_or_else(|e| panic!("what was written is refused: {e}\n{written}"));
        assert_eq!(drive_text(&again), written);
    }
}

/// What is true of every rig log: numbers are finite, library slips lie in [-1, 1], and the same log again from what is
/// written of it.
pub fn check_rig(log: &RigLog, plain: &Rover) {
    assert!(!log.rows.is_empty(), "a log without rows");
    for row in &log.rows {
        assert!((-1.0..=1.0).contains(&row.slip.value), "line {}", row.line);
        let measured = [row.drawbar_pull, row.torque, row.sinkage, row.side_force];
        let mut all = measured
            .into_iter()
            .flatten()
            .chain([row.slip, row.normal_load]);
        assert!(
            all.all(|m| m.value.is_finite() && m.sd.is_none_or(|s| s.is_finite() && s >= 0.0)),
            "line {}",
            row.line
        );
        let mut numbers = [row.time, row.slip_angle, row.travel_speed, row.wheel_speed]
            .into_iter()
            .flatten();
        assert!(numbers.all(f64::is_finite), "line {}", row.line);
    }
    let _ = inspect_rig(log, Some(plain));
    let written = rig_text(log);
    let again = read_rig_log_from(written.as_bytes(), "again", plain);
    let again = again.unwrap_or_else(|e| panic!("what was written is refused: {e}\n{written}"));
    assert_eq!(rig_text(&again), written);
}

/// What is true of every import: as many cells a row as columns, written as a CSV that the readers of logs take or
/// refuse, but never for its shape.
pub fn check_import(imported: &Result<ImportedLog, DataError>, rover: &Rover) {
    let Ok(log) = imported else { return };
    assert!(!log.is_empty(), "an import without rows");
    let mut csv = vec![];
    log.write_to(&mut csv)
        .expect("every row has the header's length");
    if let Ok(log) = read_drive_log_from(csv.as_slice(), "imported", rover) {
        check_drive(&log, rover);
    }
}

fn drive_text(log: &DriveLog) -> String {
    let mut out = vec![];
    write_drive_log_to(&mut out, log).expect("memory takes what is written");
    String::from_utf8(out).expect("text")
}

fn rig_text(log: &RigLog) -> String {
    let mut out = vec![];
    write_rig_log_to(&mut out, log).expect("memory takes what is written");
    String::from_utf8(out).expect("text")
}

fn channels(log: &DriveLog) -> Vec<(&'static str, &Series)> {
    let fours = [
        ("wheel_speed", Some(&log.wheel_speed)),
        ("wheel_torque", log.wheel_torque.as_ref()),
        ("sinkage", log.sinkage.as_ref()),
        ("normal_load", log.normal_load.as_ref()),
    ];
    let mut all = Vec::new();
    for (name, four) in fours {
        all.extend(four.into_iter().flatten().map(|s| (name, s)));
    }
    let single = [
        ("ground_speed", &log.ground_speed),
        ("yaw_rate", &log.yaw_rate),
        ("accel_x", &log.accel_x),
        ("accel_y", &log.accel_y),
        ("lateral_speed", &log.lateral_speed),
        ("pitch", &log.pitch),
        ("roll", &log.roll),
        ("distance", &log.distance),
        ("payload", &log.payload),
        ("pass", &log.pass),
    ];
    all.extend(
        single
            .into_iter()
            .filter_map(|(name, s)| Some((name, s.as_ref()?))),
    );
    all
}
