//! Estimators that need the whole log, against closed forms, first-order conditions and a grid.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use terra_mme::{
    Axis, Batch, BatchMethod, Centre, Choice, EnsembleOptions, FitSpace, ForceObservation,
    HypothesisSet, LeastSquaresOptions, MultipleModel, ParameterEstimator, Priors, Weighed,
    ensemble, least_squares,
};
use terra_model::ForceLaw;

use crate::common::{LOAD, constants, law, normal, pair, rng, side, soil, sweep, wong21};

/// The constant law around (0, 0) with prior sd (a, b).
fn space(sd: [f64; 2]) -> (std::sync::Arc<terra_model::Law>, FitSpace) {
    let law = constants(&[[0.0, 0.0]]).hypotheses()[0].law.clone();
    let abs: BTreeMap<String, f64> =
        [("pull".to_owned(), sd[0]), ("torque".to_owned(), sd[1])].into();
    let priors = Priors::default().with(&BTreeMap::new(), &abs);
    let space = FitSpace::new(&law, Centre::Parameters(&[0.0, 0.0]), &[0.15], &priors).unwrap();
    (law, space)
}

fn correlated() -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 2, &[4.0, 1.5, 1.5, 1.0])
}

fn data(n: usize, mean: [f64; 2], seed: u64) -> Vec<ForceObservation> {
    let s = correlated();
    let root = s.clone().cholesky().unwrap().l();
    let mut rng = rng(seed, 0);
    (0..n)
        .map(|k| {
            let e = &root * DVector::from_fn(2, |_, _| normal(&mut rng));
            pair(k as f64, k, [mean[0] + e[0], mean[1] + e[1]], &s)
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Bounded linear least squares in closed form: the minimum of a quadratic over a box is where the first-order
    /// conditions hold, and an unbounded one is the mean.
    #[test]
    fn a_linear_fit_obeys_the_conditions_of_its_bounds(
        n in 1usize..20, seed in any::<u64>(), a in -8.0f64..8.0, b in -8.0f64..8.0,
        low in -6.0f64..-0.1, high in 0.1f64..6.0,
    ) {
        let (law, space) = space([10.0, 10.0]);
        let rows = data(n, [a, b], seed);
        let mean: DVector<f64> =
            rows.iter().fold(DVector::zeros(2), |m, o| m + &o.forces / n as f64);
        let free = LeastSquaresOptions {
            bounds: vec![Axis::new("pull", -1e3, 1e3), Axis::new("torque", -1e3, 1e3)],
            tolerance: 1e-12,
            ..LeastSquaresOptions::default()
        };
        let fit = least_squares(&law, &space, &rows, &free).unwrap();
        prop_assert!(fit.converged && fit.held.is_empty());
        for k in 0..2 {
            prop_assert!((fit.parameters[k] - mean[k]).abs() < 1e-5 * (1.0 + mean[k].abs()), "{:?} {mean}", fit);
        }
        let bounded = LeastSquaresOptions {
            bounds: vec![Axis::new("pull", low, high), Axis::new("torque", low, high)],
            ..free
        };
        let fit = least_squares(&law, &space, &rows, &bounded).unwrap();
        prop_assert!(fit.converged, "{fit:?}");
        let p = DVector::from_column_slice(&fit.parameters);
        let gradient = correlated().try_inverse().unwrap() * (&p - &mean) * n as f64;
        for k in 0..2 {
            prop_assert!(p[k] >= low - 1e-9 && p[k] <= high + 1e-9);
            let scale = 1e-4 * n as f64 * (1.0 + mean.amax());
            if p[k] <= low + 1e-9 {
                prop_assert!(gradient[k] > -scale);
            } else if p[k] >= high - 1e-9 {
                prop_assert!(gradient[k] < scale);
            } else {
                prop_assert!(gradient[k].abs() < scale, "{gradient} at {p}");
            }
        }
    }
}

/// Forces of a soil without noise, fitted from each of its neighbours: the cost falls from that of the start to
/// nothing, and the forces are the soil's.
#[test]
fn a_fit_without_noise_finds_the_forces_of_the_soil() {
    let truth = soil("sandy_loam_15");
    let mut quiet = side(
        &truth,
        &sweep(24, 0.9, 0.05),
        [LOAD * 0.8, LOAD * 1.2],
        0.0,
        &mut rng(1, 0),
    );
    for o in &mut quiet {
        let slips = o.contacts.clone();
        let mut forces = DVector::zeros(6);
        for (k, at) in slips.iter().enumerate() {
            let f = law().forces(&truth, at).unwrap();
            forces[3 * k] = f.drawbar_pull;
            forces[3 * k + 1] = f.resistive_torque;
        }
        o.forces = &o.map * forces;
    }
    // A box that holds the soil: without it the fit ends at the bound, five prior sd from its start.
    let wide = LeastSquaresOptions {
        bounds: vec![
            Axis::new("k_eq", 1e3, 1e8),
            Axis::new("sinkage_exponent", 0.05, 2.0),
            Axis::new("cohesion", 10.0, 1e5),
            Axis::new("friction_angle", 0.05, 0.9),
            Axis::new("shear_modulus", 1e-3, 0.2),
        ],
        max_steps: 300,
        ..LeastSquaresOptions::default()
    };
    for start in ["sandy_loam_22", "upland_sandy_loam"] {
        let p = soil(start);
        let space =
            FitSpace::new(&law(), Centre::Parameters(&p), &[0.15], &Priors::default()).unwrap();
        let nowhere = LeastSquaresOptions {
            max_steps: 0,
            ..LeastSquaresOptions::default()
        };
        let before = least_squares(&law(), &space, &quiet, &nowhere).unwrap();
        let fit = least_squares(&law(), &space, &quiet, &wide).unwrap();
        assert!(
            fit.chi2 < 1e-3 && fit.chi2 < 1e-3 * before.chi2,
            "{start}: {fit:?}"
        );
        for slip in [0.1, 0.5, 0.8] {
            let at = crate::common::contact(slip, LOAD);
            let (a, b) = (
                law().forces(&truth, &at).unwrap(),
                law().forces(&fit.parameters, &at).unwrap(),
            );
            assert!(
                (a.resistive_torque / b.resistive_torque - 1.0).abs() < 2e-3,
                "{start} {slip}"
            );
            assert!(
                (a.drawbar_pull - b.drawbar_pull).abs() < 0.5,
                "{start} {slip}"
            );
        }
    }
}

/// Gaussian prior and linear forces: the posterior is N((P⁻¹ + nS⁻¹)⁻¹ nS⁻¹ȳ, (P⁻¹ + nS⁻¹)⁻¹). Mean and covariance of the
/// draws within 5 standard errors by the draws' own autocorrelation time.
#[test]
fn an_ensemble_draws_from_the_closed_form() {
    let (law, space) = space([1.0, 3.0]);
    let rows = data(7, [2.0, -1.0], 5);
    let options = EnsembleOptions {
        walkers: 30,
        steps: 1500,
        burn_in: 200,
        ..EnsembleOptions::default()
    };
    let found = ensemble(&law, &space, &rows, &options).unwrap();
    let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0 / 9.0]));
    let weight = correlated().try_inverse().unwrap() * 7.0;
    let ybar = rows
        .iter()
        .fold(DVector::zeros(2), |m, o| m + &o.forces / 7.0);
    let covariance = (prior + &weight).try_inverse().unwrap();
    let mean = &covariance * weight * ybar;
    // q is in prior sd.
    let scale = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 3.0]));
    let (m, c) = (&scale * found.mean(), &scale * found.covariance() * &scale);
    let n = found.effective_draws();
    assert!(
        n > 500.0 && (0.3..0.9).contains(&found.acceptance),
        "{n} {}",
        found.acceptance
    );
    for i in 0..2 {
        let error = (covariance[(i, i)] / n).sqrt();
        assert!(
            (m[i] - mean[i]).abs() < 5.0 * error,
            "{i}: {} {} {error}",
            m[i],
            mean[i]
        );
        for j in 0..2 {
            let error =
                ((covariance[(i, i)] * covariance[(j, j)] + covariance[(i, j)].powi(2)) / n).sqrt();
            assert!(
                (c[(i, j)] - covariance[(i, j)]).abs() < 5.0 * error,
                "{i} {j} {c} {covariance}"
            );
        }
    }
    let again = ensemble(&law, &space, &rows, &options).unwrap();
    assert_eq!(again.draws, found.draws);
}

/// The ensemble's promise: after an affine map of the parameters the same moves are made. Priors ten times as wide on a
/// world ten times as large give ten times the draws.
#[test]
fn an_ensemble_does_not_see_units() {
    let options = EnsembleOptions {
        walkers: 8,
        steps: 40,
        burn_in: 0,
        ..EnsembleOptions::default()
    };
    let (law, near) = space([1.0, 1.0]);
    let rows = data(5, [0.5, -0.3], 2);
    let small = ensemble(&law, &near, &rows, &options).unwrap();
    let (law, far) = space([10.0, 10.0]);
    let large: Vec<_> = rows
        .iter()
        .map(|o| {
            pair(
                o.time,
                o.group,
                [o.forces[0] * 10.0, o.forces[1] * 10.0],
                &(correlated() * 100.0),
            )
        })
        .collect();
    let large = ensemble(&law, &far, &large, &options).unwrap();
    for (a, b) in small.draws.iter().zip(&large.draws) {
        assert!((a - b).amax() < 1e-6);
    }
}

/// Two free parameters of a real soil: mean and sd of the draws against a 41 x 41 grid weighed by Bayes' rule.
#[test]
fn an_ensemble_agrees_with_a_grid() {
    let p = soil("lean_clay_22");
    let still: BTreeMap<String, f64> = law()
        .params()
        .iter()
        .map(|q| (q.name.to_owned(), 0.0))
        .chain([
            ("k_eq".to_owned(), 0.0),
            ("cohesion".to_owned(), 0.2),
            ("shear_modulus".to_owned(), 0.3),
        ])
        .collect();
    let priors = Priors::default().with(&still, &BTreeMap::new());
    let space = FitSpace::new(&law(), Centre::Parameters(&p), &[0.15], &priors).unwrap();
    assert_eq!(space.names(), ["cohesion", "shear_modulus"]);
    // Few samples: the posterior stays wide enough for the grid.
    let rows = side(&p, &[0.6, 0.3, 0.1], [200.0, 290.0], 0.0, &mut rng(3, 0));
    let options = EnsembleOptions {
        walkers: 20,
        steps: 300,
        burn_in: 60,
        ..EnsembleOptions::default()
    };
    let found = ensemble(&law(), &space, &rows, &options).unwrap();
    let (mean, sd) = (found.mean(), found.covariance().diagonal().map(f64::sqrt));
    // The grid covers six sd each way of where the draws are; its prior is the ensemble's.
    let value = |k: usize, q: f64| {
        let mut at = [0.0, 0.0];
        at[k] = q;
        space.physical(&at)[k]
    };
    let axes: Vec<(Axis, usize)> = space
        .names()
        .iter()
        .enumerate()
        .map(|(k, name)| {
            (
                Axis::new(
                    name,
                    value(k, mean[k] - 6.0 * sd[k]),
                    value(k, mean[k] + 6.0 * sd[k]),
                ),
                41,
            )
        })
        .collect();
    let grid = HypothesisSet::grid(&law(), "g", &p, &axes).unwrap();
    let q: Vec<DVector<f64>> = grid
        .hypotheses()
        .iter()
        .map(|h| space.coordinates(&h.parameters).unwrap())
        .collect();
    let prior: Vec<f64> = q.iter().map(|q| (-0.5 * q.norm_squared()).exp()).collect();
    let mut models = MultipleModel::new(grid)
        .unwrap()
        .with_prior(&prior)
        .unwrap();
    for o in &rows {
        models.update(o).unwrap();
    }
    let w = models.probabilities();
    let centre: DVector<f64> = q
        .iter()
        .zip(&w)
        .fold(DVector::zeros(2), |m, (q, w)| m + q * *w);
    let n = found.effective_draws();
    for k in 0..2 {
        let spread = q
            .iter()
            .zip(&w)
            .map(|(q, w)| w * (q[k] - centre[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        // Standard error of the draws, and 5 % for S, which the grid takes anew at each soil.
        assert!(
            (mean[k] - centre[k]).abs() < spread * (5.0 / n.sqrt() + 0.05),
            "{k}: {} {}",
            mean[k],
            centre[k]
        );
        assert!(
            (sd[k] / spread - 1.0).abs() < 5.0 / (2.0 * n).sqrt() + 0.05,
            "{k}: {} {spread}",
            sd[k]
        );
    }
}

/// While the log comes in they answer as multiple models; at its end by what they found, and forces come nearer.
#[test]
fn batch_estimators_end_nearer_than_their_set() {
    let mut off = soil("lean_clay_22");
    for (k, p) in off.iter_mut().enumerate() {
        *p *= if k % 2 == 0 { 1.08 } else { 0.93 };
    }
    let rows = side(
        &off,
        &sweep(30, 0.9, 0.05),
        [200.0, 290.0],
        0.0,
        &mut rng(4, 0),
    );
    let at = crate::common::contact(0.4, 400.0);
    let truth = law().forces(&off, &at).unwrap();
    let error = |w: &dyn Weighed| {
        let f = w.force_prediction(&[0.4], &[400.0], &at).unwrap().remove(0);
        let size = truth.drawbar_pull.abs() + truth.resistive_torque / at.radius;
        (f.drawbar_pull.unwrap().mean - truth.drawbar_pull).abs() / size
    };
    let methods = [
        BatchMethod::LeastSquares(LeastSquaresOptions {
            starts: 3,
            ..LeastSquaresOptions::default()
        }),
        BatchMethod::Ensemble(EnsembleOptions {
            steps: 40,
            burn_in: 20,
            ..EnsembleOptions::default()
        }),
    ];
    for method in methods {
        let mut models = MultipleModel::new(wong21()).unwrap();
        let mut batch = Batch::new(
            MultipleModel::new(wong21()).unwrap(),
            Priors::default(),
            method,
        )
        .unwrap();
        for o in &rows {
            models.update(o).unwrap();
            batch.update(o).unwrap();
        }
        assert_eq!(batch.probabilities(), models.probabilities());
        let before = error(&batch);
        batch.finish().unwrap();
        let sum: f64 = batch.probabilities().iter().sum();
        assert!((sum - 1.0).abs() < 1e-12);
        assert!(
            error(&batch) < 0.03 && error(&batch) < before,
            "{}: {before} {}",
            batch.name(),
            error(&batch)
        );
        assert!(batch.consistency().nis_per_dof.unwrap() < 1.6);
        batch.update(&rows[29].clone()).unwrap_err();
        assert_eq!(batch.samples(), 30);
    }
    let online = MultipleModel::new(wong21())
        .unwrap()
        .with_choice(Choice::online())
        .unwrap();
    assert!(
        Batch::new(
            online,
            Priors::default(),
            BatchMethod::Ensemble(EnsembleOptions::default())
        )
        .is_err()
    );
}
