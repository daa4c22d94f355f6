//! Measured data that stay outside the repository: read through the example's rig file.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use approx::assert_relative_eq;
use terra_data::{LogKind, log_kind, read_rig_log, read_rover, read_terrains};
use terra_model::catalogue;

/// `TERRA_DATA`, by default beside the workspace; `None`, said aloud, when the file is not there.
fn data(file: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let folder = std::env::var_os("TERRA_DATA").map_or_else(beside, PathBuf::from);
    let path = folder.join(file);
    if path.is_file() {
        return Some(path);
    }
    // Not by a print macro: the test harness would keep the line to itself.
    let line = format!(
        "SKIPPED: no {} (set TERRA_DATA to the measured data)\n",
        path.display()
    );
    std::io::stderr().write_all(line.as_bytes()).unwrap();
    None
}

#[test]
fn the_example_s_rig_file_is_right() {
    let rig =
        read_rover(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/cmu/rig.toml")).unwrap();
    assert!(rig.is_rig());
    assert_eq!((rig.wheel.radius, rig.wheel.width), (0.058, 0.05));
    assert_eq!(rig.noise.get("sinkage_m"), Some(0.00062));
}

/// Values of rows 2, 8 and 28 of the file, in its own units beside ours; 9 rim speeds x 3 repeats (its README).
#[test]
fn cmu_trials() {
    let Some(path) = data("cmu_single_wheel/smooth_straight.csv") else {
        return;
    };
    let rig =
        read_rover(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/cmu/rig.toml")).unwrap();
    assert_eq!(log_kind(&path, &rig).unwrap(), LogKind::Rig);
    let log = read_rig_log(&path, &rig).unwrap();
    assert_eq!((log.rows.len(), log.dropped.len()), (27, 0));
    assert_eq!(log.warnings, Vec::<String>::new());
    let mut repeats: BTreeMap<&str, usize> = BTreeMap::new();
    for row in &log.rows {
        *repeats.entry(row.trial.as_str()).or_default() += 1;
        assert_eq!(
            (row.condition.as_str(), row.pass, row.slip_angle),
            ("smooth", 1, Some(0.0))
        );
        // The slip of the file and that of its speeds agree to the digits it prints.
        let rim = row.wheel_speed.unwrap() * 0.058;
        let travel = row.travel_speed.unwrap();
        assert!(
            ((rim - travel) / rim.max(travel) - row.slip.value).abs() < 1.1e-3,
            "{row:?}"
        );
    }
    assert_eq!(repeats.len(), 9);
    assert!(repeats.values().all(|n| *n == 3), "{repeats:?}");
    let first = &log.rows[0];
    assert_eq!((first.slip.value, first.normal_load.value), (-1.0, 20.122));
    assert_eq!(first.drawbar_pull.unwrap().value, -38.1885);
    assert_eq!(
        (first.travel_speed, first.wheel_speed),
        (Some(10.001 / 1e3), Some(0.0))
    );
    assert_relative_eq!(
        first.sinkage.unwrap().value,
        0.0501221,
        max_relative = 1e-15
    );
    let last = &log.rows[26];
    assert_eq!(
        (last.line, last.slip.value, last.trial.as_str()),
        (28, 0.8998, "100")
    );
    assert_relative_eq!(
        last.wheel_speed.unwrap(),
        0.0997597 / 0.058,
        max_relative = 1e-15
    );
    assert_eq!(last.drawbar_pull.unwrap().sd, None);
    for unused in ["trial", "slip", "Fx_sd_N", "Fy_sd_N", "Fz_sd_N"] {
        assert!(
            log.notes.ignored_columns.iter().any(|c| c == unused),
            "{unused}"
        );
    }
}

#[test]
fn the_literature_table_reads_as_the_built_in_catalogue() {
    let Some(path) = data("terrains.csv") else {
        return;
    };
    let own = read_terrains(path).unwrap();
    let built_in = catalogue::terrains();
    assert_eq!(own.len(), built_in.len());
    for (own, known) in own.iter().zip(built_in) {
        assert_eq!(
            (&own.id, &own.set, &own.name),
            (&known.id, &known.set, &known.name)
        );
        assert_eq!(
            (own.confidence, &own.source),
            (known.confidence, &known.source)
        );
        assert_eq!(
            (own.shear_modulus, own.c1, own.c2),
            (known.shear_modulus, known.c1, known.c2)
        );
        for (a, b) in [
            (own.sinkage_exponent, known.sinkage_exponent),
            (own.k_c, known.k_c),
            (own.k_phi, known.k_phi),
            (own.cohesion, known.cohesion),
            (own.friction_angle, known.friction_angle),
        ] {
            assert_eq!(a, b, "{}", own.id);
        }
    }
}
