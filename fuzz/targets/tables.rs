//! Small tables of the command, the first byte says which: a transition matrix, an identification to export, the lines of a
//! sweep to merge.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_cli::tasks::{ExportOptions, Soil, choice, merge, scm_json};
use terra_data::parse_scm_json;
use terra_fuzz::{Folder, run};

static PLACE: LazyLock<Folder> = LazyLock::new(|| Folder::new("tables"));

fuzz_target!(|data: &[u8]| run(|| {
    let [which, text @ ..] = data else { return };
    match which % 3 {
        0 => {
            let file = PLACE.put("matrix.txt", text);
            let _ = choice(&format!("transition:{}", file.display()));
        }
        1 => {
            let file = PLACE.put("identify.json", text);
            let soil = Soil::Named(file.display().to_string());
            if let Ok(json) = scm_json(&soil, &ExportOptions::default()) {
                let read = parse_scm_json(&json.to_string(), "x", "id");
                read.unwrap_or_else(|e| panic!("what was exported is refused: {e}\n{json}"));
            }
        }
        _ => {
            let file = PLACE.put("shard.jsonl", text);
            if let Ok(joined) = merge(&[file]) {
                assert_eq!(joined.len(), text.len(), "merging loses or makes bytes");
            }
        }
    }
}));
