//! Every row of the terrain table against the catalogue, after conversion of units.

use std::collections::HashSet;

use terra::model::{Registry, catalogue};

use crate::common::data;

#[test]
fn the_catalogue_is_the_table() {
    let Some(path) = data("terrains.csv") else {
        return;
    };
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.is_empty());
    let header = "id,set,name,moisture_pct,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2,soil_class,conf,source_note";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.splitn(15, ',').collect()).collect();
    assert_eq!(rows.len(), catalogue::terrains().len());
    for (row, terrain) in rows.iter().zip(catalogue::terrains()) {
        let id = row[0];
        assert_eq!(
            (id, row[1], row[2]),
            (&*terrain.id, &*terrain.set, &*terrain.name)
        );
        assert_eq!(
            (row[12], row[13], row[14]),
            (&*terrain.class, terrain.confidence.mark(), &*terrain.source),
            "{id}"
        );
        let cell = |k: usize| (row[k] != "NA").then(|| row[k].parse::<f64>().unwrap());
        let same = |what: &str, found: Option<f64>, expected: Option<f64>| match (found, expected) {
            (Some(a), Some(b)) => assert!(
                (a - b).abs() <= 1e-14 * b.abs(),
                "{id}, {what}: {a}, table {b}"
            ),
            (a, b) => assert_eq!(a, b, "{id}, {what}"),
        };
        same("moisture", terrain.moisture, cell(3));
        same("n", Some(terrain.sinkage_exponent), cell(4));
        same("k_c", Some(terrain.k_c), cell(5).map(|x| x * 1000.0));
        same("k_phi", Some(terrain.k_phi), cell(6).map(|x| x * 1000.0));
        same("c", Some(terrain.cohesion), cell(7).map(|x| x * 1000.0));
        same(
            "phi",
            Some(terrain.friction_angle),
            cell(8).map(f64::to_radians),
        );
        same("K", terrain.shear_modulus, cell(9));
        same("c1", terrain.c1, cell(10));
        same("c2", terrain.c2, cell(11));
    }
}

#[test]
fn ids_are_unique() {
    let mut seen = HashSet::new();
    for terrain in catalogue::terrains() {
        assert!(seen.insert(&terrain.id), "{} twice", terrain.id);
    }
    assert_eq!(catalogue::set("wong21").unwrap().len(), 21);
}

/// Every row says where it comes from and how far that can be trusted, also without the table beside.
#[test]
fn every_terrain_has_a_source_and_a_confidence() {
    for terrain in catalogue::terrains() {
        assert!(!terrain.source.trim().is_empty(), "{}", terrain.id);
        let mark = terrain.confidence.mark();
        assert!(["A", "B", "C"].contains(&mark), "{} {mark}", terrain.id);
    }
    assert!(catalogue::terrains().len() >= 38);
}

/// A value that a source does not give is refused by name, and never guessed.
#[test]
fn a_missing_value_is_named_with_its_row() {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let mut missing = 0;
    for terrain in catalogue::terrains() {
        match terrain.parameters(law.model()) {
            Ok(p) => assert!(p.iter().all(|x| x.is_finite()) && terrain.shear_modulus.is_some()),
            Err(e) => {
                let said = e.to_string();
                assert!(terrain.shear_modulus.is_none(), "{said}");
                assert!(
                    said.contains(&*terrain.id) && said.contains("shear_modulus"),
                    "{said}"
                );
                missing += 1;
            }
        }
    }
    assert!(missing > 0);
}
