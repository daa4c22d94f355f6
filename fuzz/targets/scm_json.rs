//! A terrain of Chrono's soil contact model.
#![no_main]

use libfuzzer_sys::fuzz_target;
use terra_data::{parse_scm_json, scm_json};
use terra_fuzz::run;

fuzz_target!(|data: &[u8]| run(|| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let Ok(t) = parse_scm_json(text, "x", "id") else {
        return;
    };
    let again = parse_scm_json(&scm_json(&t).to_string(), "again", "id");
    let again = again.unwrap_or_else(|e| panic!("what was written is refused: {e}"));
    assert_eq!(
        (again.k_c, again.k_phi, again.cohesion),
        (t.k_c, t.k_phi, t.cohesion)
    );
    assert_eq!(again.shear_modulus, t.shear_modulus);
}));
