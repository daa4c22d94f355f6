//! MCAP bags as bytes; what is inside a whole bag is the matter of `bag_messages`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{Rover, import_mcap};
use terra_fuzz::{Scratch, check_import, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static BAG: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("bag.mcap"));
static MAP: LazyLock<Scratch> = LazyLock::new(|| {
    let map = Scratch::new("topics.toml");
    map.with(include_bytes!("../fixed/speed.toml"));
    map
});

fuzz_target!(|data: &[u8]| run(|| {
    check_import(&import_mcap(BAG.with(data), MAP.path()), &ROVERS[0]);
}));
