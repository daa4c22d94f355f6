//! Plans of what `terra identify` weighs.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_cli::tasks::{Source, hypotheses};
use terra_fuzz::{Folder, run};
use terra_model::Registry;

static PLACE: LazyLock<Folder> = LazyLock::new(|| {
    let place = Folder::new("plans");
    place.put(
        "soils.csv",
        include_bytes!("../seeds/terrains_csv/soils.csv"),
    );
    place
});
static REGISTRY: LazyLock<Registry> = LazyLock::new(Registry::builtin);
static ROVER: LazyLock<Source> = LazyLock::new(|| Source::Memory {
    name: "rover.toml".to_owned(),
    bytes: include_bytes!("../fixed/rover.toml").to_vec(),
});

fuzz_target!(|data: &[u8]| run(|| {
    // A plan may ask for a million hypotheses and then has them: that is long, and no finding.
    if data.windows(5).any(|w| w.iter().all(u8::is_ascii_digit)) {
        return;
    }
    let plan = PLACE.put("plan.toml", data);
    let Ok(set) = hypotheses(&ROVER, &REGISTRY, plan.to_str()) else {
        return;
    };
    let set = set.as_array().expect("a list of hypotheses");
    assert!(!set.is_empty());
    for h in set {
        let values = h["parameters"].as_object().expect("parameters by name");
        assert!(values.values().all(|v| v.is_f64()), "{h}");
    }
}));
