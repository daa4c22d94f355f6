//! Bevameter tests: a file of columns, a NUL, the curves. Without a NUL all are curves under the contract's names.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_cli::tasks::{ReportFiles, Source, bevameter};
use terra_fuzz::{Scratch, run};

static COLUMNS: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("columns.toml"));

fuzz_target!(|data: &[u8]| run(|| {
    let (columns, log) = match data.iter().position(|b| *b == 0) {
        Some(at) => (Some(COLUMNS.with(&data[..at])), &data[at + 1..]),
        None => (None, data),
    };
    let log = Source::Memory {
        name: "x".to_owned(),
        bytes: log.to_vec(),
    };
    for kind in ["plate", "shear"] {
        let Ok(found) = bevameter(&log, kind, columns, &ReportFiles::default()) else {
            continue;
        };
        let soils = found["soils"].as_array().expect("a list of soils");
        assert!(!soils.is_empty());
        for soil in soils {
            let laws = soil["laws"].as_array().expect("a list of laws");
            let best = &soil["best"];
            assert!(laws.iter().any(|l| l["law"] == *best), "{soil}");
        }
    }
}));
