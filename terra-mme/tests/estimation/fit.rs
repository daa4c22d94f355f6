//! The fit space: an exact map there and back.

use std::collections::BTreeMap;

use proptest::prelude::*;
use terra_mme::{Centre, EstimatorError, FitSpace, Priors};
use terra_model::{ForceLaw, Registry, catalogue};

use crate::common::*;

fn space(id: &str) -> FitSpace {
    FitSpace::new(
        &law(),
        Centre::Terrain(catalogue::find(id).unwrap()),
        &[WIDTH],
        &Priors::default(),
    )
    .unwrap()
}

fn values(rows: &[(&str, f64)]) -> BTreeMap<String, f64> {
    rows.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect()
}

#[test]
fn one_width_fits_k_eq_with_the_published_spreads() {
    let s = space("upland_sandy_loam");
    assert_eq!(
        s.names(),
        [
            "k_eq",
            "sinkage_exponent",
            "cohesion",
            "friction_angle",
            "shear_modulus",
            "c1",
            "c2"
        ]
    );
    assert_eq!(s.prior_sd(), [0.5, 0.12, 0.5, 0.15, 0.4, 0.2, 0.3]);
    assert_eq!(s.units()[0], "N/m^(n+2)");
    assert!(s.merges_stiffness() && s.logarithmic().iter().all(|l| *l));
    let k_eq = s.physical(&[0.0; 7])[0];
    assert!((k_eq - (74.6e3 / WIDTH + 2080e3)).abs() < 1e-6);
    // Exact for this width: the same forces from (k_c, k_phi) and (0, k_eq).
    for slip in [0.05, 0.4, 0.9] {
        let at = contact(slip, LOAD);
        let whole = law().forces(&soil("upland_sandy_loam"), &at).unwrap();
        let merged = law().forces(&s.parameters(&[0.0; 7]), &at).unwrap();
        assert!((whole.drawbar_pull - merged.drawbar_pull).abs() < 1e-9 * LOAD);
        assert!((whole.resistive_torque - merged.resistive_torque).abs() < 1e-9 * LOAD);
    }
}

#[test]
fn two_widths_keep_both_moduli() {
    let terrain = catalogue::find("dry_sand").unwrap();
    let s = FitSpace::new(
        &law(),
        Centre::Terrain(terrain),
        &[0.15, 0.3],
        &Priors::default(),
    )
    .unwrap();
    assert_eq!(&s.names()[..2], ["k_c", "k_phi"]);
    assert_eq!((s.dim(), s.merges_stiffness()), (8, false));
    assert_eq!(s.parameters(&[0.0; 8]), soil("dry_sand"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn there_and_back_with_its_exact_slope(q in prop::collection::vec(-3.0..3.0_f64, 7)) {
        let s = space("lean_clay_22");
        let p = s.parameters(&q);
        let back = s.coordinates(&p).unwrap();
        for (a, b) in q.iter().zip(back.iter()) {
            prop_assert!((a - b).abs() < 1e-11);
        }
        let jac = s.jacobian(&q);
        let (_, exact) = terra_model::jacobian(&q, |x| Ok::<_, ()>(s.parameters_t(x))).unwrap();
        prop_assert!((jac - exact).amax() <= 1e-9 * p[1]);
        let sd = s.physical_sd(&q, &nalgebra::DMatrix::identity(7, 7));
        for ((v, sd), prior) in s.physical(&q).iter().zip(&sd).zip(s.prior_sd()) {
            prop_assert!((sd / (v * prior) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_start_of_zero_is_linear_and_one_sided() {
    let terrain = catalogue::find("chrono_mid").unwrap();
    let s = FitSpace::new(
        &law(),
        Centre::Terrain(terrain),
        &[WIDTH],
        &Priors::default(),
    )
    .unwrap();
    let k = s.names().iter().position(|n| *n == "cohesion").unwrap();
    assert_eq!(
        (s.logarithmic()[k], s.prior_sd()[k], s.lower_bounds()[k]),
        (false, 500.0, 0.0)
    );
    let mut q = vec![0.0; s.dim()];
    q[k] = 2.0;
    assert_eq!(s.physical(&q)[k], 1000.0);
    let mut none = Priors::default();
    none.abs_sd.clear();
    let refused = FitSpace::new(&law(), Centre::Terrain(terrain), &[WIDTH], &none);
    assert!(matches!(refused, Err(EstimatorError::NoPrior { .. })));
}

#[test]
fn effects_start_at_zero_and_values_are_named() {
    let law = Registry::builtin().law("wong-reece+slip-sinkage").unwrap();
    let all = [
        ("k_eq", 1.5e6),
        ("sinkage_exponent", 1.1),
        ("cohesion", 1040.0),
        ("friction_angle", 0.49),
        ("shear_modulus", 0.025),
        ("c1", 0.38),
        ("c2", 0.41),
    ];
    let new = |v: &BTreeMap<String, f64>| {
        FitSpace::new(&law, Centre::Values(v), &[WIDTH], &Priors::default())
    };
    let s = new(&values(&all)).unwrap();
    assert_eq!(s.dim(), 8);
    assert_eq!(s.parameters(&[0.0; 8])[..2], [0.0, 1.5e6]);
    assert_eq!(s.parameters(&[0.0; 8])[8], 0.0);
    // A misspelt name, a missing one, and a stiffness given twice with different values.
    let mut wrong = values(&all);
    wrong.insert("cohesoin".to_owned(), 1.0);
    assert!(new(&wrong).unwrap_err().to_string().contains("cohesion"));
    assert!(matches!(
        new(&values(&all[1..])),
        Err(EstimatorError::Name(_))
    ));
    let mut twice = values(&all);
    twice.insert("k_phi".to_owned(), 1.0e6);
    assert!(matches!(new(&twice), Err(EstimatorError::Value { .. })));
    twice.insert("k_c".to_owned(), 0.5e6 * WIDTH);
    assert!(new(&twice).is_ok());
}

#[test]
fn spreads_can_be_overridden_and_zero_holds_a_parameter() {
    let priors = Priors::default().with(
        &values(&[("cohesion", 0.9), ("c1", 0.0)]),
        &values(&[("k_c", 3.0)]),
    );
    let terrain = catalogue::find("dry_sand").unwrap();
    let s = FitSpace::new(&law(), Centre::Terrain(terrain), &[WIDTH], &priors).unwrap();
    assert!(!s.names().contains(&"c1"));
    let k = s.names().iter().position(|n| *n == "cohesion").unwrap();
    assert_eq!(s.prior_sd()[k], 0.9);
    assert_eq!(s.parameters(&[1.0; 6])[6], 0.38);
    assert!(FitSpace::new(&law(), Centre::Terrain(terrain), &[], &priors).is_err());
    assert!(FitSpace::new(&law(), Centre::Terrain(terrain), &[0.0], &priors).is_err());
}
