//! A drive log of any length is read, inspected, run through the force filter, watched, and cut into a diagnosis' windows in
//! memory that does not grow with it.
//!
//! The log is made while it is read, so that nothing of it lies anywhere; every byte that the library asks for is counted.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::io::{self, Read};
use std::path::Path;

use peak_alloc::PeakAlloc;
use terra::data::{DriveInspector, DriveLog, DriveReader, Rover, parse_rover, read_rover};
use terra::ekf::spaces::longitudinal_robot::LongitudinalRobot;
use terra::ekf::{FirstPass, ForceConfig, RobotRow};
use terra::gap::{BaselineSpan, DriveWindows, Settings, Watch, WatchSettings};
use terra::model::Registry;
use terra::sim::{Scenario, simulate_drive};

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Rows of a segment.
const SEGMENT: usize = 3000;

/// A log of so many rows as a stream: a robot that weaves, with holes in its channels and pauses of its clock.
struct Drive {
    rows: usize,
    row: usize,
    line: Vec<u8>,
}

impl Drive {
    fn new(rows: usize) -> Self {
        let mut header = "time_s,segment,ground_speed_m_s,yaw_rate_rad_s,accel_x_m_s2".to_owned();
        for wheel in ["fl", "fr", "rl", "rr"] {
            header.push_str(&format!(
                ",wheel_speed_{wheel}_rad_s,wheel_torque_{wheel}_N_m"
            ));
        }
        header.push('\n');
        Drive {
            rows,
            row: 0,
            line: header.into_bytes(),
        }
    }
}

impl Read for Drive {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.line.is_empty() && self.row < self.rows {
            let k = self.row;
            self.row += 1;
            let time = 0.05 * (k + 40 * (k / 700)) as f64;
            // Many digits: a row of a real log is as long.
            let noise = |j: usize| 0.01 * ((k * 13 + j) as f64 * 0.618_033_988_749_894_9).fract();
            let speed = match k % 1100 {
                0..400 => String::new(),
                _ => (0.5 + noise(0)).to_string(),
            };
            let turn = (0.01 * k as f64).sin();
            let mut line = format!(
                "{time},{},{speed},{},{}",
                k / SEGMENT,
                0.2 * turn + noise(1),
                noise(2)
            );
            for j in 0..4 {
                let side = if j % 2 == 0 { -0.24 } else { 0.24 };
                let w = 2.0 + side * turn + noise(3 + j);
                line.push_str(&format!(",{w},{}", 2.0 + noise(7 + j)));
            }
            line.push('\n');
            self.line = line.into_bytes();
        }
        let n = self.line.len().min(buffer.len());
        buffer[..n].copy_from_slice(&self.line[..n]);
        self.line.drain(..n);
        Ok(n)
    }
}

fn rover() -> Rover {
    let text = "[vehicle]\nmass_kg = 100.0\nyaw_inertia_kg_m2 = 10.0\ntrack_m = 0.6\nwheelbase_m = 0.6\n\
        cg_to_front_axle_m = 0.3\ncg_height_m = 0.22\nyaw_damping_N_m_s = 8.0\n\
        [wheel]\nradius_m = 0.254\nwidth_m = 0.15\ninertia_kg_m2 = 0.25\ndamping_N_m_s = 0.1\n\
        [terrain]\nmodel = \"wong-reece\"\n\
        [noise]\nwheel_speed_rad_s = 0.02\nwheel_torque_N_m = 0.5\nground_speed_m_s = 0.03\nyaw_rate_rad_s = 0.01\n\
        accel_x_m_s2 = 0.15\n";
    parse_rover(text, "rover.toml").unwrap()
}

/// Calls `see` with each row, and with true where a segment begins.
fn each_row(rows: usize, rover: &Rover, mut see: impl FnMut(bool, &RobotRow)) {
    let mut reader = DriveReader::from_reader(Drive::new(rows), "drive.csv", rover).unwrap();
    while let Some(block) = reader.next_block(500).unwrap() {
        let log = &block.log;
        for (i, segment) in log.segments.iter().enumerate() {
            for k in segment.rows.clone() {
                let [fl, fr, rl, rr] = log.wheel_speed.each_ref().map(|s| s.get(k));
                let one = |s: &Option<terra::data::Series>| s.as_ref().and_then(|s| s.get(k));
                let torque = log.wheel_torque.as_ref().unwrap();
                let row = RobotRow {
                    row: block.first_row + k,
                    time: log.time[k],
                    torque: torque.each_ref().map(|s| s.get(k)),
                    channels: [
                        one(&log.accel_x),
                        fl,
                        fr,
                        rl,
                        rr,
                        one(&log.ground_speed),
                        one(&log.yaw_rate),
                    ],
                    ..RobotRow::default()
                };
                see(
                    k == segment.rows.start && !(i == 0 && block.continues),
                    &row,
                );
            }
        }
    }
}

fn estimate(rows: usize) {
    let rover = rover();
    let config = ForceConfig::new(LongitudinalRobot::light().unwrap());
    let mut first = FirstPass::new(&config).unwrap();
    each_row(rows, &rover, |begins, row| {
        if begins {
            first.segment();
        }
        first.row(row);
    });
    let mut run = first.run().unwrap();
    let (mut steps, mut made) = (Vec::new(), 0);
    each_row(rows, &rover, |begins, row| {
        if begins {
            run.segment(&mut steps).unwrap();
        }
        run.row(row, &mut steps).unwrap();
        made += steps.drain(..).count();
    });
    run.finish(&mut steps).unwrap();
    assert_eq!(made + steps.len(), rows);
}

fn inspect(rows: usize) {
    let rover = rover();
    let mut reader = DriveReader::from_reader(Drive::new(rows), "drive.csv", &rover).unwrap();
    let mut inspector = DriveInspector::new(Some(&rover));
    while let Some(block) = reader.next_block(500).unwrap() {
        inspector.block(&block);
    }
    let found = inspector.finish();
    assert_eq!(
        (found.rows, found.groups.len()),
        (rows, rows.div_ceil(SEGMENT))
    );
}

fn windows(rows: usize) {
    let rover = rover();
    let mut reader = DriveReader::from_reader(Drive::new(rows), "drive.csv", &rover).unwrap();
    let mut windows = DriveWindows::new(&rover, Settings::WINDOWS).unwrap();
    while let Some(block) = reader.next_block(500).unwrap() {
        windows.push(&block.log).unwrap();
    }
    windows.finish().unwrap();
    let most = Settings::WINDOWS;
    assert!((most / 2..=most).contains(&windows.kept()));
}

/// A patrol that drives the same rounds over and over.
fn watch(round: &DriveLog, rover: &Rover, rounds: usize) {
    let settings = WatchSettings {
        baseline: BaselineSpan::Seconds(30.0),
        effects: Some(vec!["torque-scale".to_owned()]),
        ..WatchSettings::default()
    };
    let mut watch = Watch::new(rover, &Registry::builtin(), &settings).unwrap();
    let lasts = round.time.last().unwrap() + 0.01;
    let mut looked_at = 0;
    for k in 0..rounds {
        let mut piece = round.clone();
        for time in &mut piece.time {
            *time += k as f64 * lasts;
        }
        looked_at += watch.push(&piece).unwrap().len();
    }
    looked_at += watch.finish().unwrap().len();
    assert!(watch.refused().is_none(), "{:?}", watch.refused());
    assert!(looked_at > 50 * rounds, "{looked_at}");
}

/// The most bytes held at once while something is done, above what is held before.
fn peak(what: impl FnOnce()) -> usize {
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    what();
    HEAP.peak_usage() - before
}

/// Bytes of a log, at least: its first rows have the shortest times.
fn length(rows: usize) -> usize {
    let mut log = Drive::new(1000);
    let bytes = io::copy(&mut log, &mut io::sink()).unwrap();
    bytes as usize * (rows / 1000)
}

/// One test, since threads of others would be counted with it.
#[test]
fn memory_does_not_grow_with_the_log() {
    const MIB: usize = 1 << 20;
    // A step has 18 x 18 covariances: 2.6 kB a row if they were kept.
    let (short, long) = (30_000, 120_000);
    let bytes = length(long);
    assert!(bytes > 20 * MIB, "{bytes}");
    let (a, b) = (peak(|| estimate(short)), peak(|| estimate(long)));
    println!("estimate: {a} B for {short} rows, {b} B for {long}");
    assert!(b < 4 * MIB, "{b} B for a log of {bytes} B");
    assert!(b < a + a / 10, "{a} B for {short} rows, {b} B for {long}");
    // Samples that a usual value is found among are held up to 262 144 rows.
    let (short, long) = (300_000, 1_200_000);
    let bytes = length(long);
    assert!(bytes > 200 * MIB, "{bytes}");
    let (a, b) = (peak(|| inspect(short)), peak(|| inspect(long)));
    println!("inspect: {a} B for {short} rows, {b} B for {long}");
    assert!(b < 16 * MIB, "{b} B for a log of {bytes} B");
    assert!(b < a + a / 10, "{a} B for {short} rows, {b} B for {long}");
    // Twice the windows that are kept, at least.
    let (short, long) = (30_000, 300_000);
    let bytes = length(long);
    assert!(bytes > 50 * MIB, "{bytes}");
    let (a, b) = (peak(|| windows(short)), peak(|| windows(long)));
    println!("windows: {a} B for {short} rows, {b} B for {long}");
    assert!(b < 4 * MIB, "{b} B for a log of {bytes} B");
    assert!(b < a + a / 10, "{a} B for {short} rows, {b} B for {long}");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drive");
    let rover = read_rover(folder.join("rover.toml")).unwrap();
    let mut scenario = Scenario::read(&folder.join("rich.toml")).unwrap();
    scenario.effects.clear();
    let round = simulate_drive(&scenario, &rover, &Registry::builtin()).unwrap();
    let (short, long) = (4, 16);
    let (a, b) = (
        peak(|| watch(&round.log, &rover, short)),
        peak(|| watch(&round.log, &rover, long)),
    );
    println!("watch: {a} B for {short} rounds, {b} B for {long}");
    assert!(b < a + a / 10, "{a} B for {short} rounds, {b} B for {long}");
}
