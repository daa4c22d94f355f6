//! Verdicts as the marking of a challenge reads them, one for each kind of case.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_cli::challenge::{KeyFile, ScoreOptions, score};
use terra_fuzz::{Folder, run};

const CASES: [&str; 3] = ["a", "b", "c"];

static KEY: LazyLock<KeyFile> = LazyLock::new(|| {
    let place = Folder::new("marking");
    let key = place.put("key.json", include_bytes!("../fixed/key.json"));
    KeyFile::open(&key).expect("a good key")
});
static PLACE: LazyLock<Folder> = LazyLock::new(|| Folder::new("verdicts"));

fuzz_target!(|data: &[u8]| run(|| {
    for case in CASES {
        PLACE.put(&format!("{case}.json"), data);
    }
    let options = ScoreOptions { closing: false };
    let Ok(score) = score(&KEY, PLACE.path(), &options, &|| ()) else {
        return;
    };
    assert!(!score.summary().is_empty());
    let all = score.to_json().to_string();
    assert!(!all.contains("NaN"), "{all}");
}));
