//! Flat Parquet files.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{ImportKind, Rover, import};
use terra_fuzz::{Scratch, check_import, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static FILE: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("log.parquet"));

fuzz_target!(|data: &[u8]| run(|| {
    check_import(&import(ImportKind::Parquet, FILE.with(data)), &ROVERS[0]);
}));
