//! Underflow and return: what becomes of a rival whose probability has collapsed.

use nalgebra::DMatrix;
use terra_mme::{Choice, MultipleModel, ParameterEstimator, Weighed};

use crate::common::*;

/// Rivals ten standard deviations apart; `before` samples of the first, then up to 200 of the second. Returns the
/// number of samples after the switch until the second leads (1: at once).
fn samples_to_return(choice: Choice, before: usize) -> Option<usize> {
    let s = DMatrix::identity(2, 2);
    let mut m = MultipleModel::new(constants(&[[0.0, 0.0], [10.0, 0.0]]))
        .unwrap()
        .with_choice(choice)
        .unwrap();
    for k in 0..before {
        m.update(&pair(k as f64, 0, [0.0, 0.0], &s)).unwrap();
    }
    assert_eq!(m.map_index(), 0);
    (1..=200).find(|k| {
        m.update(&pair((before + k) as f64, 0, [10.0, 0.0], &s))
            .unwrap();
        m.map_index() == 1
    })
}

#[test]
fn the_literal_product_loses_a_rival_for_ever() {
    // Ray 2008 eq. 22 as printed, in double precision: 50 nats a sample.
    let mut p = [0.5_f64, 0.5];
    let step = |p: &mut [f64; 2], first: f64, second: f64| {
        let joint = [p[0] * first, p[1] * second];
        let sum = joint[0] + joint[1];
        *p = [joint[0] / sum, joint[1] / sum];
    };
    for _ in 0..15 {
        step(&mut p, 1.0, (-50.0_f64).exp());
    }
    assert_eq!(p[1], 0.0);
    for _ in 0..200 {
        step(&mut p, (-50.0_f64).exp(), 1.0);
    }
    assert_eq!(p[1], 0.0);
}

#[test]
fn log_domain_alone_returns_only_after_new_evidence_outweighs_all_the_old() {
    // After fifteen the two are level.
    let k = samples_to_return(Choice::None, 15).unwrap();
    assert!((15..=16).contains(&k), "{k}");
    assert_eq!(samples_to_return(Choice::None, 250), None);
}

#[test]
fn a_floor_returns_at_once() {
    for before in [15, 250] {
        let k = samples_to_return(Choice::Floor(1e-6), before).unwrap();
        assert!(k <= 2, "{k}");
        assert!(samples_to_return(Choice::online(), before).unwrap() <= 2);
    }
    let stay = DMatrix::from_row_slice(2, 2, &[0.999, 0.001, 0.001, 0.999]);
    assert!(samples_to_return(Choice::transition(stay).unwrap(), 250).unwrap() <= 2);
}

#[test]
fn forgetting_bounds_the_memory() {
    // Old evidence saturates at 50/(1 - .9) = 500 nats; the odds turn when 500 .9^k < 500 (1 - .9^k), k > ln 2/-ln .9 = 6.6.
    let k = samples_to_return(Choice::Forgetting(0.9), 250).unwrap();
    assert_eq!(k, 7);
}

#[test]
fn a_probability_that_rounds_to_zero_keeps_its_logarithm() {
    let s = DMatrix::identity(2, 2);
    let mut m = MultipleModel::new(constants(&[[0.0, 0.0], [10.0, 0.0]])).unwrap();
    for k in 0..100 {
        m.update(&pair(k as f64, 0, [0.0, 0.0], &s)).unwrap();
    }
    assert_eq!(m.probabilities()[1], 0.0);
    assert!((m.log_probabilities()[1] + 5000.0).abs() < 1e-8);
}

#[test]
fn a_switch_of_soil_is_followed_on_line() {
    let slips = sweep(60, 0.6, 0.5);
    let mut rng = rng(7, 0);
    let mut first = side(
        &soil("upland_sandy_loam"),
        &slips,
        [LOAD, LOAD],
        0.0,
        &mut rng,
    );
    let second = side(&soil("dry_sand"), &slips, [LOAD, LOAD], 0.0, &mut rng);
    first.extend(second.into_iter().map(|mut o| {
        o.time += 1.0;
        o
    }));
    let mut m = MultipleModel::new(wong21())
        .unwrap()
        .with_choice(Choice::online())
        .unwrap()
        .with_history();
    for obs in &first {
        m.update(obs).unwrap();
    }
    let history = m.history().unwrap();
    let id = |step: usize| {
        let row = &history.probability[step];
        let best = (0..row.len())
            .max_by(|&a, &b| row[a].total_cmp(&row[b]))
            .unwrap();
        history.ids[best].as_str()
    };
    assert_eq!(history.step, (1..=120).collect::<Vec<_>>());
    assert_eq!(id(59), "upland_sandy_loam");
    assert_eq!(id(64), "dry_sand");
    assert_eq!(id(119), "dry_sand");
}
