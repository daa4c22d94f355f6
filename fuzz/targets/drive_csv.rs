//! Drive logs, under the contract's column names and under others.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{Rover, log_kind_from, read_drive_log_from};
use terra_fuzz::{check_drive, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);

fuzz_target!(|data: &[u8]| run(|| {
    for rover in &*ROVERS {
        let _ = log_kind_from(data, "x", rover);
        if let Ok(log) = read_drive_log_from(data, "x", rover) {
            check_drive(&log, &ROVERS[0]);
        }
    }
}));
