//! Sets of hypotheses: twins, mixed structures, refusals.

use std::sync::Arc;

use terra_mme::{
    EstimatorError, Hypothesis, HypothesisSet, MultipleModel, ParameterBelief, ParameterEstimator,
    Weighed,
};
use terra_model::Registry;

use crate::common::*;

#[test]
fn twins_are_reported_also_when_only_their_forces_agree() {
    // k_c and k_phi traded at one width: other numbers, the same forces.
    let mut twin = soil("upland_sandy_loam");
    twin[1] += twin[0] / WIDTH;
    twin[0] = 0.0;
    let set = wong21()
        .joined(HypothesisSet::from_vectors(&law(), "twin", [twin]).unwrap())
        .unwrap();
    let probes = [contact(0.1, LOAD), contact(0.5, 200.0), contact(0.9, 300.0)];
    let found = set.near_duplicates(&probes, 1e-6);
    assert_eq!(found.len(), 1);
    assert_eq!(
        found[0].pair,
        ["upland_sandy_loam".to_owned(), "twin-1".to_owned()]
    );
    assert!(found[0].distance < 1e-9);
    assert!(wong21().near_duplicates(&probes, 1e-6).is_empty());
    // At 10 N width-1 probes nothing changes; at another width the twins part.
    let wide = terra_model::Contact::new(0.5, LOAD, RADIUS, 0.3);
    assert!(set.near_duplicates(&[wide], 1e-6).is_empty());
}

#[test]
fn structures_compete_and_parameters_are_averaged_inside_one() {
    let linear = Arc::new(Registry::builtin().law("linear-stress").unwrap());
    let other = |id: &str| Hypothesis {
        id: format!("{id}/linear"),
        law: Arc::clone(&linear),
        parameters: soil(id),
    };
    let set = wong21()
        .joined(HypothesisSet::new(vec![other("dry_sand"), other("lean_clay_22")]).unwrap())
        .unwrap();
    let mut m = MultipleModel::new(set).unwrap();
    for obs in side(
        &soil("dry_sand"),
        &sweep(2, 0.4, 0.39),
        [LOAD, LOAD],
        0.0,
        &mut rng(11, 0),
    ) {
        m.update(&obs).unwrap();
    }
    assert_eq!(m.map().id, "dry_sand");
    let ParameterBelief::PerModel(beliefs) = m.belief() else {
        panic!("two laws")
    };
    assert_eq!(beliefs[0].model, "wong-reece");
    assert!((beliefs.iter().map(|b| b.probability).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(m.belief().most_probable().unwrap().model, "wong-reece");
}

#[test]
fn empty_double_and_broken_sets_are_refused() {
    assert!(matches!(
        HypothesisSet::new(vec![]),
        Err(EstimatorError::EmptySet)
    ));
    assert!(matches!(
        wong21().joined(wong21()),
        Err(EstimatorError::DuplicateId { .. })
    ));
    let short = HypothesisSet::from_vectors(&law(), "x", [vec![1.0]]);
    assert!(matches!(short, Err(EstimatorError::Model { .. })));
    let mut nan = soil("dry_sand");
    nan[3] = f64::NAN;
    assert!(matches!(
        HypothesisSet::from_vectors(&law(), "x", [nan]),
        Err(EstimatorError::Value { .. })
    ));
    let unknown = HypothesisSet::from_catalogue(&law(), "wong22").unwrap_err();
    assert!(unknown.to_string().contains("wong21"), "{unknown}");
}

#[test]
fn a_single_hypothesis_is_certain() {
    let mut m = MultipleModel::new(
        HypothesisSet::from_vectors(&law(), "only", [soil("dry_sand")]).unwrap(),
    )
    .unwrap();
    for obs in side(
        &soil("dry_sand"),
        &[0.3],
        [LOAD, LOAD],
        0.0,
        &mut rng(12, 0),
    ) {
        m.update(&obs).unwrap();
    }
    assert_eq!(m.probabilities(), [1.0]);
    assert!(m.known_to().is_empty());
}
