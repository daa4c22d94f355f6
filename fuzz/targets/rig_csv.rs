//! Rig logs, under the contract's column names and under others.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{Rover, log_kind_from, read_rig_log_from};
use terra_fuzz::{check_rig, rigs, run};

static RIGS: LazyLock<[Rover; 2]> = LazyLock::new(rigs);

fuzz_target!(|data: &[u8]| run(|| {
    for rig in &*RIGS {
        let _ = log_kind_from(data, "x", rig);
        if let Ok(log) = read_rig_log_from(data, "x", rig) {
            check_rig(&log, &RIGS[0]);
        }
    }
}));
