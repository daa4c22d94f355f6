//! The key of a challenge, a NUL, what was committed to.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_cli::challenge::{KeyFile, digest, reveal};
use terra_fuzz::{Folder, run};

static PLACE: LazyLock<Folder> = LazyLock::new(|| Folder::new("key"));

fuzz_target!(|data: &[u8]| run(|| {
    let at = data.iter().position(|b| *b == 0).unwrap_or(data.len());
    let (key, commitments) = data.split_at(at);
    let Ok(key) = KeyFile::open(&PLACE.put("key.json", key)) else {
        return;
    };
    // What is written of a key is the same key, with the same commitments.
    let text = serde_json::to_vec(&key).expect("a key is JSON");
    let again = KeyFile::open(&PLACE.put("again.json", &text));
    let again = again.unwrap_or_else(|e| panic!("what was written is refused: {e}"));
    assert_eq!(again, key);
    PLACE.put("COMMIT.txt", commitments.get(1..).unwrap_or_default());
    let _ = reveal(&key, PLACE.path());
    // Its own commitments hold, unless a name has no line of its own.
    let named = |c: &str| !c.contains(char::is_whitespace);
    if key.cases.iter().all(|c| named(&c.case)) {
        let lines: String = key
            .cases
            .iter()
            .map(|c| format!("{} {}\n", c.case, digest(c)))
            .collect();
        PLACE.put("COMMIT.txt", lines.as_bytes());
        let answers = reveal(&key, PLACE.path()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(answers.len(), key.cases.len());
    }
}));
