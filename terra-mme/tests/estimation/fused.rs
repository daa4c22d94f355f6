//! The fused pass against the estimator that takes one hypothesis after the other in double precision.

use std::sync::Arc;

use nalgebra::DMatrix;
use proptest::prelude::*;
use terra_mme::{
    Choice, EstimatorError, EstimatorOptions, ForceObservation, FusedModel, Hypothesis,
    HypothesisSet, MultipleModel, ParameterEstimator, Prewhitening, TableBox, Weighed, estimator,
};
use terra_model::Registry;

use crate::common::{LOAD, contact, law, rng, side, soil, sweep, wong21};

fn fine() -> TableBox {
    TableBox {
        slip: (0.02, 0.98),
        load: (150.0, 350.0),
        nodes: (64, 12),
    }
}

/// Side sums whose slips and loads are known exactly: S is then the same for all hypotheses in both estimators.
fn exact_inputs(p: &[f64], n: usize, seed: u64) -> Vec<ForceObservation> {
    let mut rows = side(
        p,
        &sweep(n, 0.9, 0.05),
        [200.0, 290.0],
        0.0,
        &mut rng(seed, 0),
    );
    for o in &mut rows {
        let keep = DMatrix::from_fn(7, 7, |i, j| {
            if i < 3 && j < 3 {
                o.covariance[(i, j)]
            } else {
                0.0
            }
        });
        o.covariance = keep;
        for (at, load) in o.contacts.iter_mut().zip([200.0, 290.0]) {
            at.normal_load = load;
        }
    }
    for (o, slip) in rows.iter_mut().zip(sweep(n, 0.9, 0.05)) {
        o.contacts.iter_mut().for_each(|c| c.slip = slip);
    }
    rows
}

fn many(n: usize, seed: u64) -> HypothesisSet {
    let one = HypothesisSet::from_vectors(&law(), "h", [soil("lean_clay_22")]).unwrap();
    one.perturbed(n, 0.03, seed).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    /// Near ties, so that every digit shows: posterior and evidence of both, whatever the number of hypotheses (padding,
    /// tiles) and of samples a pass.
    #[test]
    fn single_precision_in_one_pass_is_bayes(n in 1usize..70, seed in any::<u64>(), block in 1usize..9, rho in 0.0f64..0.9) {
        let set = many(n, seed);
        let rows = exact_inputs(&soil("lean_clay_22"), 24, seed);
        let whitening = Some(Prewhitening::new(rho, 0.01).unwrap());
        let mut oracle = MultipleModel::new(set.clone()).unwrap().with_prewhitening(whitening);
        let mut fused = FusedModel::new(set, fine(), &contact(0.2, LOAD)).unwrap().with_prewhitening(whitening);
        for o in &rows {
            oracle.update(o).unwrap();
        }
        for some in rows.chunks(block) {
            fused.update_block(some).unwrap();
        }
        prop_assert_eq!(fused.samples(), 24);
        for (a, b) in fused.probabilities().iter().zip(oracle.probabilities()) {
            prop_assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        prop_assert!((fused.log_evidence() - oracle.log_evidence()).abs() < 2e-2);
        let (l, m) = (fused.log_likelihoods(), oracle.log_likelihoods());
        for (a, b) in l.iter().zip(&m) {
            prop_assert!((a - b).abs() < 2e-2 + 1e-3 * (m[oracle.map_index()] - b).abs(), "{a} {b}");
        }
    }
}

/// Blocks of any length are the same pass: with S fixed, to the rounding of single precision.
#[test]
fn time_blocking_is_exact() {
    let rows = exact_inputs(&soil("lean_clay_22"), 60, 5);
    let coarse = TableBox {
        nodes: (8, 4),
        ..fine()
    };
    let end = |block: usize| {
        let mut fused = FusedModel::new(many(1100, 2), coarse, &contact(0.2, LOAD)).unwrap();
        for some in rows.chunks(block) {
            fused.update_block(some).unwrap();
        }
        fused.probabilities()
    };
    let one = end(1);
    for block in [4, 16, 60] {
        for (a, b) in one.iter().zip(end(block)) {
            assert!((a - b).abs() < 1e-5, "{block}: {a} {b}");
        }
    }
}

/// A look-up at a load that stays is another sum of the same nodes: loads that differ in their last digit, for which nothing
/// can be kept, give the same posterior, whatever the number of loads that take turns.
#[test]
fn a_load_that_stays_changes_nothing() {
    for loads in 1..=6 {
        let mut rows = exact_inputs(&soil("lean_clay_22"), 60, 7);
        for (k, o) in rows.iter_mut().enumerate() {
            let load = 180.0 + 20.0 * (k / 2 % loads) as f64;
            o.contacts[0].normal_load = load;
        }
        let end = |rows: &[ForceObservation], block: usize| {
            let mut fused = FusedModel::new(many(150, 2), fine(), &contact(0.2, LOAD)).unwrap();
            for some in rows.chunks(block) {
                fused.update_block(some).unwrap();
            }
            fused.log_likelihoods()
        };
        let mut never = rows.clone();
        for (k, o) in never.iter_mut().enumerate() {
            for c in &mut o.contacts {
                c.normal_load *= 1.0 + 1e-13 * (k + 1) as f64;
            }
        }
        let expected = end(&never, 1);
        for block in [1, 2, 7] {
            for (a, b) in expected.iter().zip(end(&rows, block)) {
                assert!(
                    (a - b).abs() < 1e-3 + 1e-6 * a.abs(),
                    "{loads} {block}: {a} {b}"
                );
            }
        }
    }
}

/// Soils change under way: rivals fall thousands of nats behind and the winner changes. Nothing overflows, and the
/// winner is that of double precision at every turn.
#[test]
fn a_winner_from_behind_is_found() {
    let wide = TableBox {
        load: (100.0, 500.0),
        ..fine()
    };
    let mut fused = FusedModel::new(wong21(), wide, &contact(0.2, LOAD)).unwrap();
    let mut oracle = MultipleModel::new(wong21()).unwrap();
    let mut winners = std::collections::BTreeSet::new();
    for (part, (id, n)) in [
        ("dry_sand", 40),
        ("lean_clay_22", 160),
        ("lean_clay_22", 160),
    ]
    .into_iter()
    .enumerate()
    {
        for mut o in exact_inputs(&soil(id), n, 1) {
            o.time += 10.0 * part as f64;
            fused.update(&o).unwrap();
            oracle.update(&o).unwrap();
        }
        let p = fused.probabilities();
        assert!(p.iter().all(|p| p.is_finite()));
        assert!((p.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(fused.map().id, oracle.map().id, "after {id}");
        assert!((fused.log_evidence() / oracle.log_evidence() - 1.0).abs() < 1e-3);
        winners.insert(fused.map().id.clone());
    }
    assert!(winners.len() > 1, "{winners:?}");
}

/// A whole log with noise in slip and load: the same winner as side sums, with an alarm that knows its residuals.
#[test]
fn it_names_the_soil_of_a_side() {
    for id in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
        let rows = side(
            &soil(id),
            &sweep(80, 0.9, 0.1),
            [200.0, 290.0],
            0.0,
            &mut rng(2, 0),
        );
        let mut fused = FusedModel::new(
            wong21(),
            TableBox {
                load: (100.0, 500.0),
                ..fine()
            },
            &contact(0.2, LOAD),
        )
        .unwrap();
        for o in &rows {
            fused.update(o).unwrap();
        }
        assert_eq!(fused.map().id, id);
        let told = fused.consistency();
        assert!(
            !told.alarm && (0.6..1.4).contains(&told.nis_per_dof.unwrap()),
            "{told:?}"
        );
    }
}

/// What it cannot do exactly it refuses, and a sample outside the table changes nothing.
#[test]
fn limits_are_typed() {
    let at = contact(0.2, LOAD);
    let small = TableBox {
        nodes: (3, 12),
        ..fine()
    };
    assert!(FusedModel::new(wong21(), small, &at).is_err());
    let with = Arc::new(Registry::builtin().law("wong-reece+slip-sinkage").unwrap());
    let mut p = soil("dry_sand");
    p.push(0.2);
    let effect = HypothesisSet::new(vec![Hypothesis {
        id: "e".to_owned(),
        law: with,
        parameters: p,
    }])
    .unwrap();
    assert!(matches!(
        FusedModel::new(effect, fine(), &at),
        Err(EstimatorError::NotSupported { .. })
    ));
    let options = EstimatorOptions {
        choice: Choice::online(),
        ..EstimatorOptions::new(at)
    };
    assert!(estimator("fused", wong21(), &options).is_err());
    let mut fused = FusedModel::new(many(5, 1), fine(), &at).unwrap();
    let mut rows = exact_inputs(&soil("lean_clay_22"), 3, 1);
    fused.update(&rows[0]).unwrap();
    let before = fused.probabilities();
    rows[1].contacts[1].normal_load = 400.0;
    assert!(matches!(
        fused.update_block(&rows[1..]),
        Err(EstimatorError::OutsideTable { .. })
    ));
    assert_eq!((fused.probabilities(), fused.samples()), (before, 1));
}

/// Drawbar pull and torque of the first wheel, their errors going together.
fn front(o: &ForceObservation) -> ForceObservation {
    let sd = [20.0, 8.0, 0.0, 0.0];
    let forces = [Some(o.forces[0] / 2.0), Some(o.forces[1]), None];
    let mut one = ForceObservation::wheel(o.time, o.group, forces, o.contacts[0], &sd).unwrap();
    (one.covariance[(0, 1)], one.covariance[(1, 0)]) = (60.0, 60.0);
    one
}

/// With slips and loads known S is the same at every sample, so holding it changes nothing: posterior and evidence of `update`,
/// whether the load stays (a short look-up) or not, on one wheel and on a side, whatever the size of the set.
#[test]
fn a_held_covariance_is_the_same_update() {
    for (n, moving, wheels) in [
        (1, 0.0, 1),
        (21, 0.0, 1),
        (21, 0.3, 1),
        (12, 0.0, 1),
        (30, 0.0, 1),
        (60, 0.0, 1),
        (150, 0.0, 1),
        (1100, 0.0, 1),
        (21, 0.0, 2),
        (150, 0.3, 2),
    ] {
        let mut rows = exact_inputs(&soil("lean_clay_22"), 40, 3);
        for (k, o) in rows.iter_mut().enumerate() {
            if wheels == 1 {
                *o = front(o);
            }
            for c in &mut o.contacts {
                c.normal_load += moving * k as f64;
            }
        }
        let new = || FusedModel::new(many(n, 4), fine(), &contact(0.2, LOAD)).unwrap();
        let (mut whole, mut held) = (new(), new());
        let covariance = held.hold(&rows[0]).unwrap();
        for o in &rows {
            whole.update(o).unwrap();
            let at: Vec<_> = o.contacts.iter().map(|c| (c.slip, c.normal_load)).collect();
            held.update_held(&covariance, &at, o.forces.as_slice())
                .unwrap();
        }
        assert_eq!(held.samples(), 40);
        for (a, b) in whole.probabilities().iter().zip(held.probabilities()) {
            assert!((a - b).abs() < 1e-5, "{n} {moving} {wheels}: {a} {b}");
        }
        let (a, b) = (whole.log_evidence(), held.log_evidence());
        assert!(
            (a - b).abs() < 1e-4 * a.abs().max(1.0),
            "{n} {moving} {wheels}: {a} {b}"
        );
        assert_eq!(whole.map_index(), held.map_index());
    }
}

/// The order of the rows is the map's, and a row may be one that looks at nothing or at both forces.
#[test]
fn a_held_map_may_be_any() {
    let rows: Vec<_> = exact_inputs(&soil("lean_clay_22"), 20, 5)
        .iter()
        .map(front)
        .collect();
    for mix in [
        [0.0, 1.0, 1.0, 0.0],
        [1.0, 0.5, 0.0, 1.0],
        [1.0, 0.0, 0.0, 0.0],
    ] {
        let mix = DMatrix::from_row_slice(2, 2, &mix);
        let new = || FusedModel::new(many(21, 4), fine(), &contact(0.2, LOAD)).unwrap();
        let (mut whole, mut held) = (new(), new());
        let mixed = |o: &ForceObservation| ForceObservation {
            forces: &mix * &o.forces,
            map: &mix * &o.map,
            ..o.clone()
        };
        let covariance = held.hold(&mixed(&rows[0])).unwrap();
        for o in rows.iter().map(mixed) {
            whole.update(&o).unwrap();
            let at = [(o.contacts[0].slip, o.contacts[0].normal_load)];
            held.update_held(&covariance, &at, o.forces.as_slice())
                .unwrap();
        }
        for (a, b) in whole.probabilities().iter().zip(held.probabilities()) {
            assert!((a - b).abs() < 1e-5, "{mix}: {a} {b}");
        }
    }
}

/// As above for the sample that has a way of its own: one wheel under a load that stays.
#[test]
fn limits_of_a_held_wheel_are_typed() {
    let rows = exact_inputs(&soil("lean_clay_22"), 3, 1);
    let o = front(&rows[0]);
    let mut fused = FusedModel::new(many(21, 1), fine(), &contact(0.2, LOAD)).unwrap();
    let held = fused.hold(&o).unwrap();
    let (at, y) = ([(0.3, 200.0)], o.forces.as_slice());
    for _ in 0..4 {
        fused.update_held(&held, &at, y).unwrap();
    }
    let before = (fused.probabilities(), fused.log_evidence(), fused.samples());
    let size = |e| matches!(e, Err(EstimatorError::Size { .. }));
    assert!(size(fused.update_held(&held, &[], y)));
    assert!(size(fused.update_held(&held, &at, &y[..1])));
    // What single precision cannot weigh is an error of a whole update too.
    let mut absurd = o.clone();
    absurd.forces[0] = 1e20;
    assert!(matches!(
        fused.update(&absurd),
        Err(EstimatorError::Value { .. })
    ));
    for bad in [f64::NAN, f64::NEG_INFINITY, 1e20] {
        for forces in [[y[0], bad], [bad, y[1]]] {
            let found = fused.update_held(&held, &at, &forces);
            assert!(matches!(found, Err(EstimatorError::Value { .. })));
        }
    }
    for outside in [
        (0.99, 200.0),
        (f64::NAN, 200.0),
        (-1e300, 200.0),
        (0.3, 400.0),
        (0.3, f64::NAN),
    ] {
        let found = fused.update_held(&held, &[outside], y);
        assert!(matches!(found, Err(EstimatorError::OutsideTable { .. })));
    }
    assert_eq!(
        (fused.probabilities(), fused.log_evidence(), fused.samples()),
        before
    );
    let whitening = Some(Prewhitening::new(0.5, 0.01).unwrap());
    assert!(
        fused
            .clone()
            .with_prewhitening(whitening)
            .update_held(&held, &at, y)
            .is_err()
    );
    assert!(fused.with_history().update_held(&held, &at, y).is_err());
}

/// Against the belief, before and after samples, for sets that fill vectors and for those that do not.
#[test]
fn means_are_those_of_the_belief() {
    for n in [1, 21, 300, 4200] {
        let rows = exact_inputs(&soil("lean_clay_22"), 10, 2);
        let coarse = TableBox {
            nodes: (8, 4),
            ..fine()
        };
        let mut fused = FusedModel::new(many(n, 3), coarse, &contact(0.2, LOAD)).unwrap();
        let p = soil("lean_clay_22").len();
        for o in &rows {
            let mut mean = vec![f64::NAN; p];
            fused.mean_into(&mut mean).unwrap();
            let belief = fused.belief();
            let belief = belief.most_probable().unwrap();
            for (k, mean) in mean.iter().enumerate() {
                let exact = belief.mean[k];
                let spread = belief.sd(k).unwrap().max(1e-9 * exact.abs());
                assert!(
                    (mean - exact).abs() <= 1e-5 * spread,
                    "{n} {k}: {mean} {exact}"
                );
            }
            fused.update(o).unwrap();
        }
        let found = fused.mean_into(&mut vec![0.0; p + 1]);
        assert!(matches!(found, Err(EstimatorError::Size { .. })));
    }
}

/// Parameters of two laws have no common mean.
#[test]
fn several_laws_have_no_mean() {
    let other = Arc::new(Registry::builtin().law("linear-stress").unwrap());
    let own = soil("lean_clay_22");
    let set = many(2, 1)
        .joined(HypothesisSet::from_vectors(&other, "linear", [own]).unwrap())
        .unwrap();
    let fused = FusedModel::new(set, fine(), &contact(0.2, LOAD)).unwrap();
    let found = fused.mean_into(&mut [0.0; 8]);
    assert!(matches!(found, Err(EstimatorError::NotSupported { .. })));
}

/// What a held sample cannot be is said, and changes nothing.
#[test]
fn limits_of_a_held_covariance_are_typed() {
    let rows = exact_inputs(&soil("lean_clay_22"), 3, 1);
    let mut fused = FusedModel::new(many(5, 1), fine(), &contact(0.2, LOAD)).unwrap();
    let held = fused.hold(&rows[0]).unwrap();
    let (at, y) = ([(0.3, 200.0), (0.3, 290.0)], rows[0].forces.as_slice());
    fused.update_held(&held, &at, y).unwrap();
    let before = (fused.probabilities(), fused.log_evidence(), fused.samples());
    let size = |e| matches!(e, Err(EstimatorError::Size { .. }));
    assert!(size(fused.update_held(&held, &at[..1], y)));
    assert!(size(fused.update_held(&held, &at, &y[..2])));
    for bad in [f64::NAN, f64::INFINITY, -1e20] {
        let forces = [y[0], bad, y[2]];
        let found = fused.update_held(&held, &at, &forces);
        assert!(matches!(found, Err(EstimatorError::Value { .. })));
    }
    for outside in [
        (0.99, 290.0),
        (f64::NAN, 290.0),
        (0.3, 400.0),
        (0.3, f64::NAN),
    ] {
        // Twice: a load that stays is looked up by another way.
        for _ in 0..2 {
            let found = fused.update_held(&held, &[at[0], outside], y);
            assert!(matches!(found, Err(EstimatorError::OutsideTable { .. })));
        }
    }
    assert_eq!(
        (fused.probabilities(), fused.log_evidence(), fused.samples()),
        before
    );
    let whitening = Some(Prewhitening::new(0.5, 0.01).unwrap());
    let mut other = fused.clone().with_prewhitening(whitening);
    assert!(matches!(
        other.hold(&rows[0]),
        Err(EstimatorError::NotSupported { .. })
    ));
    assert!(other.update_held(&held, &at, y).is_err());
    assert!(fused.with_history().hold(&rows[0]).is_err());
}
