//! Topic maps of a bag.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{Rover, import_mcap};
use terra_fuzz::{Scratch, check_import, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static MAP: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("topics.toml"));
static BAG: LazyLock<Scratch> = LazyLock::new(|| {
    let bag = Scratch::new("bag.mcap");
    bag.with(include_bytes!("../fixed/drive.mcap"));
    bag
});

fuzz_target!(|data: &[u8]| run(|| {
    check_import(&import_mcap(BAG.path(), MAP.with(data)), &ROVERS[0]);
}));
