//! Imports of data sets that stay outside the repository, and of a few of their rows.

use std::io::Write;
use std::path::{Path, PathBuf};

use approx::assert_relative_eq;
#[cfg(feature = "parquet")]
use terra_data::read_drive_log_from;
use terra_data::{ImportKind, import, parse_rover, read_rig_log_from};

#[cfg(feature = "parquet")]
const VEHICLE: &str = r#"
[vehicle]
mass_kg = 50.0
yaw_inertia_kg_m2 = 5.0
track_m = 0.55
wheelbase_m = 0.512
cg_to_front_axle_m = 0.256
cg_height_m = 0.2
yaw_damping_N_m_s = 0.0
[wheel]
radius_m = 0.165
width_m = 0.125
inertia_kg_m2 = 0.1
damping_N_m_s = 0.0
[drivetrain]
torque_constant_N_m_A = 0.1
gear_ratio = 10.0
efficiency = 0.5
[terrain]
model = "wong-reece"
"#;

const RIG: &str = "[wheel]\nradius_m = 0.1\nwidth_m = 0.1\n[terrain]\nmodel = \"wong-reece\"\n";

fn said(line: &str) {
    // Not by a print macro: the test harness would keep the line to itself.
    std::io::stderr().write_all(line.as_bytes()).unwrap();
}

fn data(file: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let folder = std::env::var_os("TERRA_DATA").map_or_else(beside, PathBuf::from);
    let path = folder.join(file);
    if path.is_file() {
        return Some(path);
    }
    said(&format!(
        "SKIPPED: no {} (set TERRA_DATA to the measured data)\n",
        path.display()
    ));
    None
}

fn written(kind: ImportKind, source: &Path) -> Vec<u8> {
    let mut csv = vec![];
    import(kind, source).unwrap().write_to(&mut csv).unwrap();
    csv
}

/// First two rows and the row of the first file line with 10 % slip, as their files give them.
#[test]
fn published_points() {
    let Some(path) = data("published_single_wheel/points.csv") else {
        return;
    };
    let rig = parse_rover(RIG, "rig.toml").unwrap();
    let csv = written(ImportKind::PublishedSingleWheel, &path);
    let log = read_rig_log_from(csv.as_slice(), "points.csv", &rig).unwrap();
    let first = &log.rows[0];
    assert_eq!((first.slip.value, first.normal_load.value), (0.0, 80.0));
    assert_eq!(first.drawbar_pull.unwrap().value, -6.5);
    let second = &log.rows[1];
    assert_eq!(second.trial, "ding2011_smooth_w80_s10");
    assert_eq!(second.condition, "smooth");
    assert_eq!(
        (
            second.slip.value,
            second.torque.unwrap().value,
            second.sinkage.unwrap().value
        ),
        (0.1, 3.0, 0.0055)
    );
}

/// The same 27 rows as through the example's rig file, by another way: the import, and a bare rig file.
#[test]
fn cmu_import_equals_the_mapped_columns() {
    let Some(path) = data("cmu_single_wheel/smooth_straight.csv") else {
        return;
    };
    let bare = parse_rover(RIG, "rig.toml").unwrap();
    let example = terra_data::read_rover(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/cmu/rig.toml"),
    )
    .unwrap();
    let csv = written(ImportKind::CmuSingleWheel, path.parent().unwrap());
    let imported = read_rig_log_from(csv.as_slice(), "import.csv", &bare).unwrap();
    let mapped = terra_data::read_rig_log(&path, &example).unwrap();
    assert_eq!(imported.rows.len(), mapped.rows.len());
    for (a, b) in imported.rows.iter().zip(&mapped.rows) {
        assert_eq!(
            (&a.trial, &a.condition, a.slip.value),
            (&b.trial, &b.condition, b.slip.value)
        );
        assert_eq!(a.drawbar_pull.unwrap().value, b.drawbar_pull.unwrap().value);
        assert_relative_eq!(
            a.sinkage.unwrap().value,
            b.sinkage.unwrap().value,
            max_relative = 1e-14
        );
        assert_relative_eq!(
            a.travel_speed.unwrap(),
            b.travel_speed.unwrap(),
            max_relative = 1e-14
        );
    }
}

#[test]
fn a_missing_column_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.csv");
    std::fs::write(
        &path,
        "case_id,grouser_height_m,slip,vertical_load\na,0,0.1,80\n",
    )
    .unwrap();
    let e = import(ImportKind::PublishedSingleWheel, &path)
        .unwrap_err()
        .to_string();
    assert!(
        e.contains("vertical_load_n") && e.contains("vertical_load"),
        "{e}"
    );
}

#[cfg(not(feature = "parquet"))]
#[test]
fn without_the_feature_the_error_says_how_to_build() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("husky_windows.parquet");
    std::fs::write(&path, b"PAR1").unwrap();
    let e = import(ImportKind::NorlabDrive, &path)
        .unwrap_err()
        .to_string();
    assert!(e.contains("--features parquet"), "{e}");
    said("SKIPPED: norlab_drive and borealtc imports (built without the feature parquet)\n");
}

#[cfg(feature = "parquet")]
mod parquet {
    use super::*;

    /// Rows, windows and rates as the data set's own description gives them: 603 windows of 40 samples at 20 Hz. The
    /// figures of window 3 were computed apart from this code, from the file read by another library.
    #[test]
    fn norlab_windows() {
        let Some(path) = data("norlab_drive/husky_windows.parquet") else {
            return;
        };
        let rover = parse_rover(VEHICLE, "rover.toml").unwrap();
        let csv = written(ImportKind::NorlabDrive, &path);
        let log = read_drive_log_from(csv.as_slice(), "norlab.csv", &rover).unwrap();
        assert_eq!((log.len(), log.segments.len()), (603 * 40, 201));
        assert!(log.wheel_torque.is_none());
        let mean = |s: &terra_data::Series| (120..160).filter_map(|i| s.get(i)).sum::<f64>() / 40.0;
        assert!((mean(&log.wheel_speed[0]) - 3.155).abs() < 1e-3);
        assert!((mean(&log.wheel_speed[3]) + 0.250).abs() < 1e-3);
        // A mean of overlapping slopes weighs the ends of the window less than one slope through all of it does.
        assert!((mean(log.yaw_rate.as_ref().unwrap()) + 0.410).abs() < 0.05);
        assert!((mean(log.ground_speed.as_ref().unwrap()) - 0.155).abs() < 0.03);
        assert!((log.time[41] - log.time[40] - 0.05).abs() < 1e-9);
    }

    /// Median current a side of straight driving, and with the sides turning against each other: the order of the surfaces
    /// that the data set's own description states.
    #[test]
    fn borealtc_resistance_orders_the_surfaces() {
        let Some(path) = data("borealtc/wheel_service.parquet") else {
            return;
        };
        let example = include_str!("../../../examples/borealtc/rover.toml");
        let rover = parse_rover(example, "rover.toml").unwrap();
        let csv = written(ImportKind::BorealTc, &path);
        let log = read_drive_log_from(csv.as_slice(), "borealtc.csv", &rover).unwrap();
        let torque = log.wheel_torque.as_ref().unwrap();
        // Torque of the example's [drivetrain]: .1 x 10 x .5 = .5 N m an ampere, on half of the side's current.
        let amperes = |q: usize, i: usize| Some(torque[q].get(i)? / 0.5 * 2.0);
        let median = |terrain: &str, turning: bool| {
            let mut values: Vec<f64> = log
                .segments
                .iter()
                .filter(|s| s.name.starts_with(terrain))
                .flat_map(|s| s.rows.clone())
                .filter_map(|i| {
                    let (l, r) = (
                        log.wheel_speed[0].get(i)? * 0.165,
                        log.wheel_speed[1].get(i)? * 0.165,
                    );
                    let wanted = if turning {
                        l * r < 0.0
                    } else {
                        l > 0.3 && r > 0.3 && (l - r).abs() < 0.1
                    };
                    wanted.then_some(())?;
                    Some(0.5 * (amperes(0, i)? + amperes(1, i)?))
                })
                .collect();
            values.sort_by(f64::total_cmp);
            (values[values.len() / 2], values.len())
        };
        let straight = ["ASPHALT", "ICE", "SNOW"].map(|t| median(t, false));
        let turning = ["ASPHALT", "ICE", "SNOW"].map(|t| median(t, true));
        said(&format!("straight {straight:?}, turning {turning:?}\n"));
        assert!(straight.iter().chain(&turning).all(|m| m.1 > 200));
        // The table of the example, in amperes.
        let table = [[2.04, 2.37, 4.92], [8.81, 3.75, 8.34]];
        for (found, told) in straight.iter().chain(&turning).zip(table.as_flattened()) {
            assert!((found.0 - told).abs() < 0.01, "{straight:?} {turning:?}");
        }
        let [asphalt, ice, snow] = straight.map(|m| m.0);
        // Rolling: snow clearly above the two hard surfaces, which are alike.
        assert!(snow > 1.5 * asphalt && snow > 1.5 * ice, "{straight:?}");
        assert!((asphalt - ice).abs() < 0.25 * asphalt, "{straight:?}");
        let [asphalt, ice, snow] = turning.map(|m| m.0);
        // Sides against each other is friction: asphalt grips most, ice least.
        assert!(asphalt > snow && snow > ice, "{turning:?}");
    }
}
