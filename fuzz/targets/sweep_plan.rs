//! Plans of a sweep beside a scenario that stays as it is.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_cli::tasks::sweep_runs;
use terra_fuzz::{Folder, run};

static PLACE: LazyLock<Folder> = LazyLock::new(|| {
    let place = Folder::new("sweep");
    place.put("rig.toml", include_bytes!("../../examples/rig/rig.toml"));
    place.put(
        "trials.toml",
        include_bytes!("../../examples/rig/slip_sinkage.toml"),
    );
    place
});

fuzz_target!(|data: &[u8]| run(|| {
    if let Ok(runs) = sweep_runs(&PLACE.put("plan.toml", data)) {
        assert!(runs > 0, "a plan without runs");
    }
}));
