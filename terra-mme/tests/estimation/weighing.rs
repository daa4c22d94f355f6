//! Weighing soils by side sums: right answers, infeasible soils, bad input, alarms.

use nalgebra::DMatrix;
use terra_mme::{
    Choice, EstimatorError, EstimatorInput, EstimatorOptions, ForceObservation, HypothesisSet,
    MultipleModel, ParameterEstimator, Prewhitening, Weighed, estimator, estimators,
};

use crate::common::*;

const TRANSFER: [f64; 2] = [185.0, 305.5];

#[test]
fn side_sums_find_every_soil_and_the_proportional_split_does_not() {
    // Full traction of the light vehicle (h/L = .37) takes its front wheel down to 155 N.
    let transfer = [155.0, 335.5];
    let (mut by_sum, mut by_split, mut overconfident, mut runs) = (0, 0, 0, 0);
    for draw in 0..3 {
        for (case, id) in firm().iter().enumerate() {
            let stream = draw * 100 + case as u64;
            let observations = side(&soil(id), &[0.95, 0.94], transfer, 0.8, &mut rng(1, stream));
            let whitening = Some(Prewhitening::new(0.8, 0.01).unwrap());
            let mut sum = MultipleModel::new(wong21())
                .unwrap()
                .with_prewhitening(whitening);
            let mut split = MultipleModel::proportional_split(wong21())
                .unwrap()
                .with_prewhitening(whitening);
            for obs in &observations {
                sum.update(obs).unwrap();
                split.update(obs).unwrap();
            }
            by_sum += usize::from(sum.map().id == *id);
            by_split += usize::from(split.map().id == *id);
            overconfident += usize::from(
                split.map().id != *id && split.probabilities()[split.map_index()] > 0.99,
            );
            runs += 1;
        }
    }
    // Published campaign after two samples: .977 and .303.
    assert_eq!(runs, 54);
    assert!(by_sum >= 50, "{by_sum} of 54");
    assert!(
        by_split <= 27 && overconfident >= 10,
        "{by_split} of 54, {overconfident} confident mistakes"
    );
}

#[test]
fn input_noise_belongs_into_the_covariance() {
    // NIS per degree of freedom of the true soil over independent samples: 1 by construction of S = H C Hᵀ.
    for (case, id) in ["dry_sand", "upland_sandy_loam", "lean_clay_22"]
        .iter()
        .enumerate()
    {
        let mut m =
            MultipleModel::new(HypothesisSet::from_vectors(&law(), "truth", [soil(id)]).unwrap())
                .unwrap()
                .with_alarm(terra_mme::AlarmRule {
                    window: 400,
                    threshold: 1.5,
                    ..terra_mme::AlarmRule::default()
                })
                .unwrap();
        for obs in side(
            &soil(id),
            &sweep(400, 0.9, 0.1),
            TRANSFER,
            0.0,
            &mut rng(2, case as u64),
        ) {
            m.update(&obs).unwrap();
        }
        let seen = m.consistency();
        // 1200 degrees of freedom: sd of NIS/d is .041.
        assert!(
            (seen.nis_per_dof.unwrap() - 1.0).abs() < 0.15,
            "{id} {seen:?}"
        );
        assert!(seen.lag1.unwrap().abs() < 0.12 && !seen.alarm);
    }
}

#[test]
fn prewhitening_restarts_at_a_group_and_fades_over_a_gap() {
    let s = DMatrix::identity(2, 2);
    let hypotheses = || constants(&[[0.0, 0.0], [3.0, 0.0]]);
    let whitening = Some(Prewhitening::new(0.8, 0.01).unwrap());
    let log_odds = |second: (f64, usize)| {
        let mut m = MultipleModel::new(hypotheses())
            .unwrap()
            .with_prewhitening(whitening);
        m.update(&pair(0.0, 0, [0.0, 0.0], &s)).unwrap();
        m.update(&pair(second.0, second.1, [0.0, 0.0], &s)).unwrap();
        let l = m.log_likelihoods();
        l[0] - l[1]
    };
    // d²/2 = 4.5 nats for a sample as it is, times (1-ρ)/(1+ρ) for one after another.
    assert!((log_odds((0.0, 1)) - 9.0).abs() < 1e-12);
    for (gap, rho) in [(0.01, 0.8_f64), (0.03, 0.512)] {
        assert!((log_odds((gap, 0)) - 4.5 * (1.0 + (1.0 - rho) / (1.0 + rho))).abs() < 1e-12);
    }
}

#[test]
fn an_infeasible_soil_is_penalised_counted_and_can_return() {
    let mut m = MultipleModel::new(wong21())
        .unwrap()
        .with_choice(Choice::online())
        .unwrap();
    for obs in side(
        &soil("lean_clay_22"),
        &sweep(5, 0.9, 0.8),
        [LOAD, LOAD],
        0.0,
        &mut rng(3, 0),
    ) {
        m.update(&obs).unwrap();
    }
    let row = |m: &MultipleModel, id: &str| m.posterior().into_iter().find(|r| r.id == id).unwrap();
    let snow = row(&m, "snow_us_harrison_1");
    assert_eq!((snow.infeasible_samples, snow.log_likelihood), (5, -5e4));
    assert!(m.probabilities().iter().all(|p| p.is_finite()));
    // The same soil can carry the wheel at low slip, and then wins.
    for mut obs in side(
        &soil("snow_us_harrison_1"),
        &sweep(20, 0.3, 0.1),
        [LOAD, LOAD],
        0.0,
        &mut rng(3, 1),
    ) {
        obs.time += 1.0;
        m.update(&obs).unwrap();
    }
    assert_eq!(m.map().id, "snow_us_harrison_1");
}

#[test]
fn all_infeasible_is_an_error_that_changes_nothing() {
    let set = HypothesisSet::from_vectors(
        &law(),
        "snow",
        [soil("snow_us_harrison_1"), soil("snow_us_harrison_2")],
    );
    let mut m = MultipleModel::new(set.unwrap()).unwrap();
    let good = side(
        &soil("snow_us_harrison_1"),
        &[0.2, 0.2],
        [LOAD, LOAD],
        0.0,
        &mut rng(4, 0),
    );
    m.update(&good[0]).unwrap();
    let before = (m.posterior(), m.samples(), m.consistency());
    let bad = &side(&soil("dry_sand"), &[0.9], [LOAD, LOAD], 0.0, &mut rng(4, 1))[0];
    let bad = ForceObservation {
        time: 0.005,
        ..bad.clone()
    };
    assert!(matches!(
        m.update(&bad),
        Err(EstimatorError::AllInfeasible { hypotheses: 2, .. })
    ));
    assert_eq!((m.posterior(), m.samples(), m.consistency()), before);
    m.update(&good[1]).unwrap();
}

#[test]
fn bad_observations_are_typed_errors() {
    let good = side(&soil("dry_sand"), &[0.5], [LOAD, LOAD], 0.0, &mut rng(8, 0)).remove(0);
    let mut m = MultipleModel::new(wong21()).unwrap();
    m.update(&good).unwrap();
    let later = |change: &dyn Fn(&mut ForceObservation)| {
        let mut obs = ForceObservation {
            time: 1.0,
            ..good.clone()
        };
        change(&mut obs);
        obs
    };
    let mut refused =
        |change: &dyn Fn(&mut ForceObservation)| m.update(&later(change)).unwrap_err();
    assert!(matches!(
        refused(&|o| o.forces[0] = f64::NAN),
        EstimatorError::Observation { .. }
    ));
    assert!(matches!(
        refused(&|o| o.contacts[1].slip = f64::INFINITY),
        EstimatorError::Observation { .. }
    ));
    assert!(matches!(
        refused(&|o| o.contacts[0].slip = 1.5),
        EstimatorError::Model { .. }
    ));
    assert!(matches!(
        refused(&|o| o.contacts[0].normal_load = -5.0),
        EstimatorError::Model { .. }
    ));
    assert!(matches!(
        refused(&|o| o.covariance = DMatrix::zeros(3, 3)),
        EstimatorError::Size { .. }
    ));
    assert!(matches!(
        refused(&|o| o.covariance.fill(0.0)),
        EstimatorError::NotPositiveDefinite { .. }
    ));
    assert!(matches!(
        refused(&|o| o.time = 0.0),
        EstimatorError::TimeOrder { .. }
    ));
    assert_eq!(m.samples(), 1);
    let mut wheel = MultipleModel::wheel(wong21()).unwrap();
    assert!(matches!(
        wheel.update(&good),
        Err(EstimatorError::Observation { .. })
    ));
}

#[test]
fn a_rig_row_with_sinkage_counts_sinkage() {
    use terra_model::ForceLaw;
    let at = contact(0.4, LOAD);
    let truth = law().forces(&soil("dry_sand"), &at).unwrap();
    let rows = |sinkage| {
        let forces = [Some(truth.drawbar_pull), None, sinkage];
        let sd: &[f64] = if sinkage.is_some() {
            &[0.5, 0.003, 0.005, 0.5]
        } else {
            &[0.5, 0.005, 0.5]
        };
        let mut m = MultipleModel::wheel(wong21()).unwrap();
        for row in 0..10 {
            m.update(&ForceObservation::wheel(f64::from(row), 0, forces, at, sd).unwrap())
                .unwrap();
        }
        m
    };
    // At slip .4 lean clay pulls 1.4 N more than dry sand, but the wheel hardly sinks into it.
    let clay = |m: &MultipleModel| {
        let l = m.log_likelihoods();
        let ids = m.hypotheses().ids();
        let at = |id: &str| l[ids.iter().position(|i| i == id).unwrap()];
        at("dry_sand") - at("lean_clay_22")
    };
    let (blind, seeing) = (rows(None), rows(Some(truth.sinkage.unwrap())));
    assert!(clay(&seeing) > clay(&blind) + 100.0);
    assert_eq!(seeing.map().id, "dry_sand");
}

#[test]
fn the_alarm_is_silent_on_a_true_soil_and_loud_on_a_systematic_error() {
    let whitening = Some(Prewhitening::new(0.8, 0.01).unwrap());
    let slips = sweep(60, 0.9, 0.2);
    let run = |observations: &[ForceObservation], id: &str| {
        let mut m = MultipleModel::new(wong21())
            .unwrap()
            .with_prewhitening(whitening);
        for obs in observations {
            m.update(obs).unwrap();
        }
        let wrong = m.map().id != id && m.probabilities()[m.map_index()] > 0.99;
        (m.consistency().alarm, wrong)
    };
    let [mut false_alarms, mut alarms, mut wrong, mut caught] = [0; 4];
    for (case, id) in firm().iter().enumerate() {
        let good = side(&soil(id), &slips, TRANSFER, 0.8, &mut rng(9, case as u64));
        false_alarms += usize::from(run(&good, id).0);
        // Two degrees of unknown pitch: m g sin 2 deg / 2 on each side.
        let pitched: Vec<_> = good
            .iter()
            .map(|o| {
                let mut o = o.clone();
                o.forces[0] -= 0.5 * 100.0 * 9.81 * 2.0_f64.to_radians().sin();
                o
            })
            .collect();
        let (alarm, mistaken) = run(&pitched, id);
        alarms += usize::from(alarm);
        wrong += usize::from(mistaken);
        caught += usize::from(alarm && mistaken);
    }
    assert_eq!(false_alarms, 0);
    assert!(alarms >= 13, "{alarms} of 18 pitched runs raise the alarm");
    // Published: 61 % of the runs end wrong and sure, of which the alarm at 1.5 catches 83 %; asked for: 70 %.
    assert!(
        wrong >= 3 && caught as f64 >= 0.7 * wrong as f64,
        "{caught} of {wrong}"
    );
}

#[test]
fn every_estimator_names_the_soil_through_the_registry() {
    let observations = side(
        &soil("upland_sandy_loam"),
        &sweep(30, 0.8, 0.2),
        [LOAD, LOAD],
        0.0,
        &mut rng(10, 0),
    );
    for info in estimators()
        .iter()
        .filter(|e| e.input == EstimatorInput::Forces)
    {
        let mut options = EstimatorOptions::new(contact(0.2, LOAD));
        options.history = true;
        let mut e = estimator(info.name, wong21(), &options).unwrap();
        for obs in &observations {
            let rows = if info.name == "wheel" {
                terra_mme::proportional_split(obs, 0).unwrap()
            } else {
                obs.clone()
            };
            e.update(&rows).unwrap();
        }
        assert_eq!(e.map().id, "upland_sandy_loam", "{}", info.name);
        let posterior = e.posterior();
        assert!((posterior.iter().map(|r| r.probability).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(
            posterior
                .windows(2)
                .all(|w| w[0].probability >= w[1].probability)
        );
        assert_eq!(e.history().unwrap().probability.len(), 30);
    }
}

#[test]
fn known_to_lists_rivals_within_half_a_nat_per_sample() {
    let s = DMatrix::identity(2, 2);
    // d²/2: .405, .605 and 50 nats a sample at zero noise.
    let mut m = MultipleModel::new(constants(&[
        [0.0, 0.0],
        [0.9, 0.0],
        [1.1, 0.0],
        [10.0, 0.0],
    ]))
    .unwrap();
    for k in 0..40 {
        m.update(&pair(f64::from(k), 0, [0.0, 0.0], &s)).unwrap();
    }
    assert_eq!(m.known_to(), ["c-2"]);
}
