//! A user's own catalogue of soils.
#![no_main]

use libfuzzer_sys::fuzz_target;
use terra_data::{read_terrains_from, write_terrains_to};
use terra_fuzz::run;
use terra_model::catalogue::Terrain;

fn text(terrains: &[Terrain]) -> Vec<u8> {
    let mut out = vec![];
    write_terrains_to(&mut out, terrains).expect("memory takes what is written");
    out
}

fuzz_target!(|data: &[u8]| run(|| {
    let Ok(terrains) = read_terrains_from(data, "x") else {
        return;
    };
    assert!(!terrains.is_empty());
    for t in &terrains {
        let all = [
            t.sinkage_exponent,
            t.k_c,
            t.k_phi,
            t.cohesion,
            t.friction_angle,
        ];
        assert!(all.iter().all(|v| v.is_finite()), "{t:?}");
        assert!(
            [t.shear_modulus, t.c1, t.c2]
                .iter()
                .flatten()
                .all(|v| v.is_finite()),
            "{t:?}"
        );
    }
    let again = read_terrains_from(text(&terrains).as_slice(), "again");
    let again = again.unwrap_or_else(|e| panic!("what was written is refused: {e}"));
    let ids = |all: &[Terrain]| all.iter().map(|t| t.id.to_string()).collect::<Vec<_>>();
    assert_eq!(ids(&again), ids(&terrains));
}));
