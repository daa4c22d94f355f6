//! The tables of public data sets: the first byte says which.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{ImportKind, Rover, import};
use terra_fuzz::{Scratch, check_import, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static FILE: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("table.csv"));

const KINDS: [ImportKind; 4] = [
    ImportKind::CmuSingleWheel,
    ImportKind::PublishedSingleWheel,
    ImportKind::NorlabDrive,
    ImportKind::BorealTc,
];

fuzz_target!(|data: &[u8]| run(|| {
    let [which, table @ ..] = data else { return };
    let kind = KINDS[*which as usize % KINDS.len()];
    check_import(&import(kind, FILE.with(table)), &ROVERS[0]);
}));
