//! Sufficient statistics give the posterior of recursive Bayes, and their table the forces of the law.

use nalgebra::{DMatrix, DVector};
use terra_mme::{
    Choice, EstimatorError, ForceObservation, HypothesisSet, ParameterEstimator, Posterior,
    Prewhitening, SufficientStatistics, TableBox, Weighed, score,
};
use terra_model::{ForceLaw, Registry};

use crate::common::*;

const TABLE: TableBox = TableBox {
    slip: (0.02, 0.98),
    load: (150.0, 350.0),
    nodes: (12, 5),
};
const TRANSFER: [f64; 2] = [185.0, 305.5];

fn sums(set: HypothesisSet) -> SufficientStatistics {
    SufficientStatistics::new(set, TABLE, &contact(0.2, LOAD)).unwrap()
}

#[test]
fn sums_are_recursive_bayes() {
    let observations = side(
        &soil("north_gower"),
        &sweep(150, 0.9, 0.1),
        TRANSFER,
        0.8,
        &mut rng(30, 0),
    );
    for (choice, rho) in [
        (Choice::None, None),
        (Choice::None, Some(0.8)),
        (Choice::Forgetting(0.9), Some(0.8)),
        (Choice::Forgetting(0.5), None),
    ] {
        let whitening = rho.map(|r| Prewhitening::new(r, 0.01).unwrap());
        let mut fast = sums(wong21())
            .with_choice(choice.clone())
            .unwrap()
            .with_prewhitening(whitening);
        let mut slow = Posterior::uniform(21).unwrap();
        let mut last: Option<(DMatrix<f64>, DVector<f64>)> = None;
        let mut worst: f64 = 0.0;
        for obs in &observations {
            fast.update(obs).unwrap();
            // The recursion by hand: residual, prewhitening, density, Bayes' rule, hypothesis by hypothesis.
            let (phi, _) = fast.table().observe(obs).unwrap();
            let s = fast.shared_covariance(obs).unwrap();
            let rho = if last.is_some() {
                rho.unwrap_or(0.0)
            } else {
                0.0
            };
            let ll: Vec<f64> = (0..21)
                .map(|j| {
                    let Some(theta) = fast.table().coefficients(j) else {
                        return -1e4;
                    };
                    let mut r = &phi * theta - &obs.forces;
                    if let Some((phi0, y0)) = &last {
                        r -= (phi0 * theta - y0) * rho;
                    }
                    score(&r, &(&s * (1.0 - rho * rho))).unwrap().log_density
                })
                .collect();
            slow.step(&choice, &ll).unwrap();
            last = Some((phi, obs.forces.clone()));
            for (a, b) in fast.probabilities().iter().zip(slow.probabilities()) {
                worst = worst.max((a - b).abs());
            }
        }
        assert!(worst < 1e-10, "{choice} {rho:?}: {worst:e}");
        assert_eq!(fast.map().id, "north_gower");
    }
}

#[test]
fn the_table_gives_the_forces_of_the_law() {
    let set = wong21();
    let table = sums(set.clone());
    let mut worst: f64 = 0.0;
    let mut tabulated = 0;
    for (j, h) in set.hypotheses().iter().enumerate() {
        let Some(theta) = table.table().coefficients(j) else {
            continue;
        };
        tabulated += 1;
        for slip in [0.03, 0.1, 0.33, 0.61, 0.97] {
            for load in [151.0, 200.0, 349.0] {
                let at = contact(slip, load);
                let f = h.law.forces(&h.parameters, &at).unwrap();
                let y = [Some(f.drawbar_pull), Some(f.resistive_torque), f.sinkage];
                let obs = ForceObservation::wheel(0.0, 0, y, at, &[1.0; 5]).unwrap();
                let (phi, _) = table.table().observe(&obs).unwrap();
                let error = phi * theta - &obs.forces;
                let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / RADIUS;
                worst = worst
                    .max(error[0].abs() / scale)
                    .max(error[1].abs() / f.resistive_torque);
                assert!(error[2].abs() < 1e-3 * RADIUS);
            }
        }
    }
    // Published: 12 x 5 nodes, 1.9e-3 at most.
    assert!(tabulated >= 18 && worst < 1.9e-3, "{tabulated} {worst:e}");
}

#[test]
fn what_is_not_exact_is_refused() {
    for choice in [
        Choice::Floor(1e-3),
        Choice::transition(DMatrix::identity(21, 21)).unwrap(),
    ] {
        assert!(matches!(
            sums(wong21()).with_choice(choice),
            Err(EstimatorError::NotSupported { .. })
        ));
    }
    let law = std::sync::Arc::new(Registry::builtin().law("wong-reece+slip-sinkage").unwrap());
    let set = HypothesisSet::from_catalogue(&law, "wong21").unwrap();
    let refused = SufficientStatistics::new(set, TABLE, &contact(0.2, LOAD));
    assert!(matches!(refused, Err(EstimatorError::NotSupported { .. })));
}

#[test]
fn outside_the_table_is_an_error_that_changes_nothing() {
    let observations = side(
        &soil("dry_sand"),
        &sweep(3, 0.5, 0.4),
        TRANSFER,
        0.0,
        &mut rng(31, 0),
    );
    let mut fast = sums(wong21());
    fast.update(&observations[0]).unwrap();
    let before = fast.posterior();
    for change in [
        |o: &mut ForceObservation| o.contacts[0].slip = -0.1,
        |o: &mut ForceObservation| o.contacts[0].normal_load = 900.0,
        |o: &mut ForceObservation| o.contacts[1].width = 0.3,
    ] {
        let mut obs = observations[1].clone();
        change(&mut obs);
        assert!(matches!(
            fast.update(&obs),
            Err(EstimatorError::OutsideTable { .. })
        ));
    }
    assert_eq!(fast.posterior(), before);
    let snow = before
        .iter()
        .find(|r| r.id == "snow_us_harrison_1")
        .unwrap();
    assert_eq!((snow.infeasible_samples, snow.log_likelihood), (1, -1e4));
}

#[test]
fn consistency_speaks_about_the_winner() {
    let whitening = Some(Prewhitening::new(0.8, 0.01).unwrap());
    let mut fast = sums(wong21()).with_prewhitening(whitening);
    for obs in side(
        &soil("dry_sand"),
        &sweep(60, 0.8, 0.2),
        TRANSFER,
        0.8,
        &mut rng(32, 0),
    ) {
        fast.update(&obs).unwrap();
    }
    let seen = fast.consistency();
    assert_eq!(seen.samples, 50);
    assert!(
        !seen.alarm && (seen.nis_per_dof.unwrap() - 1.0).abs() < 0.45,
        "{seen:?}"
    );
}
