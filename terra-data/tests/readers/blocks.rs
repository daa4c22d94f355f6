//! A drive log read in blocks of any size is the log read in one go: its rows to the bit, its notes, its first error.

use std::collections::BTreeMap;

use proptest::prelude::*;
use terra_data::{
    DataError, DriveBlock, DriveInspector, DriveLog, DriveReader, MissingCells, Rover, Segment,
    Series, inspect_drive, read_drive_log_from,
};

use crate::robust::damaged;
use crate::support::{DRIVE, rover};

/// All that a log holds, in types that compare to the bit.
#[derive(Debug, Default, PartialEq)]
struct Content {
    time: Vec<u64>,
    segments: Vec<(String, usize)>,
    series: Vec<Option<Vec<Option<u64>>>>,
    ignored: Vec<String>,
    missing: BTreeMap<String, MissingCells>,
    warnings: Vec<String>,
}

fn series(log: &DriveLog) -> Vec<Option<&Series>> {
    let mut all: Vec<Option<&Series>> = log.wheel_speed.iter().map(Some).collect();
    for f in [&log.wheel_torque, &log.sinkage, &log.normal_load] {
        all.extend((0..4).map(|k| f.as_ref().map(|f| &f[k])));
    }
    all.extend(
        [
            &log.ground_speed,
            &log.yaw_rate,
            &log.accel_x,
            &log.accel_y,
            &log.lateral_speed,
            &log.pitch,
            &log.roll,
            &log.distance,
            &log.payload,
            &log.pass,
        ]
        .map(Option::as_ref),
    );
    all
}

impl Content {
    /// Puts a block behind what there is; its first segment may go on from it.
    fn append(&mut self, log: &DriveLog, continues: bool) {
        for (k, segment) in log.segments.iter().enumerate() {
            match self.segments.last_mut() {
                Some(last) if k == 0 && continues => {
                    assert_eq!(last.0, segment.name);
                    last.1 += segment.rows.len();
                }
                _ => self
                    .segments
                    .push((segment.name.clone(), segment.rows.len())),
            }
        }
        let found = series(log);
        if self.time.is_empty() {
            self.series = found.iter().map(|s| s.map(|_| Vec::new())).collect();
        }
        for (all, new) in self.series.iter_mut().zip(found) {
            assert_eq!(all.is_some(), new.is_some());
            if let (Some(all), Some(new)) = (all, new) {
                assert_eq!(new.len(), log.len());
                all.extend(new.iter().map(|v| v.map(f64::to_bits)));
            }
        }
        self.time.extend(log.time.iter().map(|t| t.to_bits()));
        self.ignored.clone_from(&log.notes.ignored_columns);
        for (name, cells) in &log.notes.missing {
            let all = self.missing.entry(name.clone()).or_default();
            all.blank += cells.blank;
            all.not_finite += cells.not_finite;
        }
        self.warnings.extend_from_slice(&log.warnings);
    }
}

fn whole(bytes: &[u8], rover: &Rover) -> Result<Content, DataError> {
    let mut all = Content::default();
    all.append(&read_drive_log_from(bytes, "log.csv", rover)?, false);
    Ok(all)
}

fn joined(bytes: &[u8], rover: &Rover, rows: usize) -> Result<Content, DataError> {
    let mut reader = DriveReader::from_reader(bytes, "log.csv", rover)?;
    let mut all = Content::default();
    loop {
        match reader.next_block(rows) {
            Ok(None) => return Ok(all),
            Ok(Some(block)) => {
                assert_eq!(block.first_row, all.time.len());
                assert!((1..=rows).contains(&block.log.len()));
                let covered: usize = block.log.segments.iter().map(|s| s.rows.len()).sum();
                assert_eq!(covered, block.log.len());
                all.append(&block.log, block.continues);
            }
            Err(e) => {
                assert!(matches!(reader.next_block(rows), Ok(None)));
                return Err(e);
            }
        }
    }
}

/// Cells that are good, blank or no number of this world.
fn cell() -> impl Strategy<Value = String> {
    prop_oneof![
        6 => (-1e3..1e3).prop_map(|v: f64| v.to_string()),
        1 => Just(String::new()),
        1 => Just("nan".to_owned()),
        1 => Just("1e999".to_owned()),
    ]
}

/// A log of good rows in segments of a few rows, two of one name in a row among them.
fn text() -> impl Strategy<Value = String> {
    let row = (
        proptest::sample::select(vec!["a", "a", "a", "b", "\"b, c\""]),
        1..5u32,
        proptest::collection::vec(cell(), 7),
    );
    (proptest::collection::vec(row, 1..40), any::<bool>()).prop_map(|(rows, ends)| {
        let mut text = format!("segment,{DRIVE},pitch_rad,operator\n");
        let mut time = 0;
        let lines: Vec<String> = rows
            .into_iter()
            .map(|(segment, step, cells)| {
                time += step;
                let (numbers, pitch) = cells.split_at(5);
                let (pitch, operator) = pitch.split_at(1);
                format!(
                    "{segment},{}.25,{},{},{}",
                    time,
                    numbers.join(","),
                    pitch[0],
                    operator[0]
                )
            })
            .collect();
        text.push_str(&lines.join("\n"));
        if ends {
            text.push('\n');
        }
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn joined_they_are_the_log(text in text(), rows in 1..50usize) {
        let rover = rover("");
        let expected = whole(text.as_bytes(), &rover).unwrap();
        prop_assert_eq!(joined(text.as_bytes(), &rover, rows).unwrap(), expected);
    }

    #[test]
    fn damaged_they_give_the_same_log_or_first_error(
        bytes in text().prop_flat_map(damaged),
        rows in 1..50usize,
    ) {
        let rover = rover("");
        let said = |read: Result<Content, DataError>| read.map_err(|e| e.to_string());
        prop_assert_eq!(said(joined(&bytes, &rover, rows)), said(whole(&bytes, &rover)));
    }
}

/// Warnings stand where they arise: of the header in the first block, of the file's end in the last, however it is cut.
#[test]
fn each_warning_comes_once() {
    let current = ["fl", "fr", "rl", "rr"].map(|w| format!("motor_current_{w}_A"));
    let row = |k: usize| format!("{k},1,1,1,1,0.2,3,3,3,3");
    let rows: Vec<String> = (0..6).map(row).collect();
    let text = format!("{DRIVE},{}\n{}", current.join(","), rows.join("\n"));
    for size in 1..8 {
        let mut reader = DriveReader::from_reader(text.as_bytes(), "log.csv", &rover("")).unwrap();
        let mut said = Vec::new();
        while let Some(block) = reader.next_block(size).unwrap() {
            said.push(block.log.warnings);
        }
        let first = said.first().unwrap().first().unwrap();
        let last = said.last().unwrap().last().unwrap();
        assert!(first.contains("motor currents"), "{first}");
        assert!(last.contains("no line end"), "{last}");
        assert_eq!(said.iter().flatten().count(), 2, "{size}");
    }
}

/// What is in a log, and what looks wrong in it, does not depend on how the log comes: with stretches that stand still,
/// gaps and holes over the ends of blocks. The speed is once in cm/s; the accelerometer points backwards.
#[test]
fn inspected_in_blocks_it_is_the_same_log() {
    for (radius, found) in [(25.0, "speed-unit"), (0.25, "accel-sign")] {
        let mut text = format!("segment,{DRIVE},yaw_rate_rad_s,pitch_rad,accel_x_m_s2\n");
        for k in 0..900 {
            let segment = ["a", "b", "a"][k / 300];
            let time = 0.1 * k as f64 + if k % 300 > 200 { 1.5 } else { 0.0 };
            let phase = 0.05 * k as f64;
            let w = 2.0 + phase.sin();
            // One wheel stands still over 60 rows, the ground speed is missing in some, left and right are swapped.
            let stuck = if (130..190).contains(&k) { 2.5 } else { w };
            let ground = match k % 7 {
                0 => String::new(),
                1 => "1e999".to_owned(),
                _ => (radius * w).to_string(),
            };
            let turn = 0.3 * (0.02 * k as f64).sin();
            let (left, right) = (w - turn, w + turn);
            text.push_str(&format!(
                "{segment},{time},{stuck},{right},{left},{right},{ground},{},2.0,{}\n",
                -0.3 * turn,
                -0.125 * phase.cos(),
            ));
        }
        let rover = rover("");
        let expected = inspect_drive(
            &read_drive_log_from(text.as_bytes(), "log.csv", &rover).unwrap(),
            Some(&rover),
        );
        let codes: Vec<&str> = expected.suspicions.iter().map(|s| s.code).collect();
        let wanted = [
            "gap",
            "gap",
            "gap",
            "degrees",
            found,
            "sides-swapped",
            "stuck",
        ];
        assert_eq!(codes, wanted);
        for rows in [1, 7, 64, 299, 300, 301, 1000] {
            let mut reader = DriveReader::from_reader(text.as_bytes(), "log.csv", &rover).unwrap();
            let mut inspector = DriveInspector::new(Some(&rover));
            while let Some(block) = reader.next_block(rows).unwrap() {
                inspector.block(&block);
            }
            assert_eq!(inspector.finish(), expected, "{rows}");
        }
    }
}

/// Beyond 262 144 rows a usual value is found among fewer; what is counted is still counted in every row.
#[test]
fn a_long_log_is_still_counted_in_full() {
    let rows = 600_000;
    let mut inspector = DriveInspector::new(None);
    let mut first_row = 0;
    while first_row < rows {
        let n = 50_000.min(rows - first_row);
        let series = |f: &dyn Fn(usize) -> f64| -> Series {
            (first_row..first_row + n).map(|k| Some(f(k))).collect()
        };
        let speed = |k: usize| 2.0 + (0.001 * k as f64).sin();
        // Every hundredth step is three times as long, 6000 in all; wheels in turns a minute.
        let time = |k: usize| 0.5 * (k + 2 * (k / 100)) as f64;
        inspector.block(&DriveBlock {
            log: DriveLog {
                time: (first_row..first_row + n).map(time).collect(),
                segments: vec![Segment {
                    name: "all".to_owned(),
                    rows: 0..n,
                }],
                wheel_speed: [0; 4].map(|_| series(&speed)),
                ground_speed: Some(series(&|k| 0.01 * speed(k))),
                ..DriveLog::default()
            },
            first_row,
            continues: first_row > 0,
        });
        first_row += n;
    }
    let found = inspector.finish();
    assert_eq!(found.rows, rows);
    let ground = found
        .channels
        .iter()
        .find(|c| c.name == "ground_speed_m_s")
        .unwrap();
    assert_eq!(ground.present, rows);
    let [group] = found.groups.as_slice() else {
        panic!("one segment");
    };
    let pace = group.pace.as_ref().unwrap();
    assert_eq!((pace.step, pace.uneven), (0.5, 0.0));
    assert_eq!(pace.gaps.len(), rows / 100 - 1);
    assert_eq!(
        (pace.start, pace.end),
        (0.0, 0.5 * (rows - 1 + 2 * 5999) as f64)
    );
    assert!(found.suspicions.iter().any(|s| s.code == "rpm"));
}
