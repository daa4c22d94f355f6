//! B1-B7: what holds for a posterior over hypotheses, when, and the stored cases in which it does not.

use nalgebra::DMatrix;
use proptest::prelude::*;
use terra_mme::{
    Choice, MultipleModel, ParameterBelief, ParameterEstimator, Posterior, Prewhitening, Weighed,
    compare,
};
use terra_mme::{Comparison, HypothesisSet};

use crate::common::*;

fn run(choice: &Choice, prior: &[f64], steps: &[Vec<f64>]) -> Posterior {
    let mut posterior = Posterior::with_prior(prior).unwrap();
    for ll in steps {
        posterior.step(choice, ll).unwrap();
    }
    posterior
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// N hypotheses, up to 30 steps of log-likelihoods, and a permutation of the hypotheses.
fn case() -> impl Strategy<Value = (Vec<f64>, Vec<Vec<f64>>, Vec<usize>)> {
    (2_usize..40, 1_usize..30).prop_flat_map(|(n, k)| {
        (
            prop::collection::vec(0.01..1.0_f64, n),
            prop::collection::vec(prop::collection::vec(-50.0..5.0_f64, n), k),
            Just((0..n).collect::<Vec<_>>()).prop_shuffle(),
        )
    })
}

fn choices(n: usize) -> Vec<Choice> {
    let spread = DMatrix::from_fn(n, n, |i, j| {
        0.1 / n as f64 + if (i + 1) % n == j { 0.9 } else { 0.0 }
    });
    vec![
        Choice::None,
        Choice::Floor(1e-3),
        Choice::Forgetting(0.9),
        Choice::transition(spread).unwrap(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn b1_recursive_is_batch_and_order_does_not_matter((prior, steps, _) in case()) {
        let recursive = run(&Choice::None, &prior, &steps);
        let sum: Vec<f64> = (0..prior.len()).map(|j| steps.iter().map(|l| l[j]).sum()).collect();
        let batch = run(&Choice::None, &prior, &[sum]);
        prop_assert!(apart(recursive.probabilities(), batch.probabilities()) < 1e-12);
        let backwards: Vec<_> = steps.iter().rev().cloned().collect();
        let reversed = run(&Choice::None, &prior, &backwards);
        prop_assert!(apart(recursive.probabilities(), reversed.probabilities()) < 1e-12);
    }

    #[test]
    fn b2_permutation_and_common_constant((prior, steps, order) in case(), shift in -1e3..1e3_f64) {
        let permuted = |x: &[f64]| order.iter().map(|&j| x[j]).collect::<Vec<_>>();
        for choice in choices(prior.len()) {
            let plain = run(&choice, &prior, &steps);
            let other = match &choice {
                Choice::Transition(m) => {
                    Choice::transition(DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(order[i], order[j])])).unwrap()
                }
                c => c.clone(),
            };
            let moved: Vec<_> = steps.iter().map(|l| permuted(l)).collect();
            let swapped = run(&other, &permuted(&prior), &moved);
            prop_assert!(apart(&permuted(plain.probabilities()), swapped.probabilities()) < 1e-12);
            let lifted: Vec<Vec<f64>> = steps.iter().map(|l| l.iter().map(|x| x + shift).collect()).collect();
            let shifted = run(&choice, &prior, &lifted);
            prop_assert!(apart(plain.probabilities(), shifted.probabilities()) < 1e-10);
        }
    }

    #[test]
    fn b3_a_duplicate_shares_and_leaves_other_odds((_, steps, _) in case()) {
        let n = steps[0].len();
        let doubled: Vec<Vec<f64>> = steps.iter().map(|l| l.iter().copied().chain([l[0]]).collect()).collect();
        for choice in [Choice::None, Choice::Forgetting(0.8)] {
            let alone = run(&choice, &vec![1.0; n], &steps);
            let with = run(&choice, &vec![1.0; n + 1], &doubled);
            prop_assert_eq!(with.probabilities()[0], with.probabilities()[n]);
            let odds = |p: &Posterior, j: usize| p.log_probabilities()[j] - p.log_probabilities()[0];
            for j in 1..n {
                prop_assert!((odds(&alone, j) - odds(&with, j)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn b4_tempering_keeps_the_winner_and_only_adds_entropy((_, steps, _) in case(), betas in (0.01..1.0_f64, 0.01..1.0_f64)) {
        let n = steps[0].len();
        let tempered = |beta: f64| {
            let scaled: Vec<Vec<f64>> = steps.iter().map(|l| l.iter().map(|x| beta * x).collect()).collect();
            run(&Choice::None, &vec![1.0; n], &scaled)
        };
        let entropy = |p: &Posterior| {
            -p.probabilities().iter().zip(p.log_probabilities()).map(|(p, l)| if *p > 0.0 { p * l } else { 0.0 }).sum::<f64>()
        };
        let (low, high) = (tempered(betas.0.min(betas.1)), tempered(betas.0.max(betas.1)));
        prop_assert_eq!(low.map(), high.map());
        prop_assert!(entropy(&high) <= entropy(&low) + 1e-12);
    }

    #[test]
    fn b7_the_parameter_mean_lies_in_the_hull(weights in prop::collection::vec(0.0..1.0_f64, 21)) {
        prop_assume!(weights.iter().sum::<f64>() > 0.1);
        let posterior = Posterior::with_prior(&weights).unwrap();
        let set = wong21();
        let ParameterBelief::Shared(belief) = ParameterBelief::of(&set, posterior.probabilities()) else {
            panic!("one law, one belief")
        };
        for k in 0..belief.mean.len() {
            let values = set.hypotheses().iter().map(|h| h.parameters[k]);
            let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(0.0_f64, f64::max));
            prop_assert!(belief.mean[k] >= low * (1.0 - 1e-12) && belief.mean[k] <= high * (1.0 + 1e-12));
        }
    }
}

// Stored counterexamples: each must keep failing.

#[test]
fn b1_fails_for_floor_forgetting_and_transition() {
    let steps = [vec![0.0, -20.0], vec![-20.0, 0.0]];
    let swapped = [steps[1].clone(), steps[0].clone()];
    let spread = DMatrix::from_row_slice(2, 2, &[0.9, 0.1, 0.1, 0.9]);
    for choice in [
        Choice::Floor(1e-3),
        Choice::Forgetting(0.5),
        Choice::transition(spread).unwrap(),
    ] {
        let (a, b) = (
            run(&choice, &[1.0, 1.0], &steps),
            run(&choice, &[1.0, 1.0], &swapped),
        );
        assert!(
            apart(a.probabilities(), b.probabilities()) > 0.99,
            "{choice}: order no longer matters"
        );
    }
}

#[test]
fn b1_fails_for_prewhitened_order() {
    let s = DMatrix::identity(2, 2);
    let ys = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]];
    let posterior = |order: [usize; 3]| {
        let whitening = Some(Prewhitening::new(0.8, 0.01).unwrap());
        let mut m = MultipleModel::new(constants(&[[0.0, 0.0], [1.0, 0.0]]))
            .unwrap()
            .with_prewhitening(whitening);
        for (k, &i) in order.iter().enumerate() {
            m.update(&pair(0.01 * k as f64, 0, ys[i], &s)).unwrap();
        }
        m.probabilities()
    };
    assert!(apart(&posterior([0, 1, 2]), &posterior([0, 2, 1])) > 0.1);
}

#[test]
fn b2_fails_in_f32_with_a_large_offset() {
    // The odds e^0.5 of two hypotheses: gone when single precision carries a common constant of 1e8.
    let odds = |shift: f32| ((0.5_f32 + shift) - (0.0 + shift)).exp();
    assert!((odds(0.0) - 0.5_f32.exp()).abs() < 1e-6);
    assert!((odds(1e8) - 0.5_f32.exp()).abs() > 0.5);
}

#[test]
fn b3_fails_under_a_floor() {
    let steps = vec![vec![0.0, -20.0]; 3];
    let doubled = vec![vec![0.0, -20.0, 0.0]; 3];
    let odds = |p: &Posterior| p.probabilities()[1] / p.probabilities()[0];
    let alone = odds(&run(&Choice::Floor(0.1), &[1.0; 2], &steps));
    let with = odds(&run(&Choice::Floor(0.1), &[1.0; 3], &doubled));
    assert!((with / alone - 1.0).abs() > 0.2, "{alone} {with}");
}

#[test]
fn b4_fails_for_an_unequal_prior() {
    let prior = [0.99, 0.01];
    let full = run(&Choice::None, &prior, &[vec![-10.0, 0.0]]);
    let tempered = run(&Choice::None, &prior, &[vec![-1.0, 0.0]]);
    assert_eq!((full.map(), tempered.map()), (1, 0));
}

/// Runs of log-odds of the truth against a rival at constant distance, and the theorem's KL per sample.
fn log_odds(rho: f64, whitening: Option<Prewhitening>, runs: u64, n: usize) -> (f64, Vec<f64>) {
    let s = DMatrix::from_row_slice(2, 2, &[4.0, 0.6, 0.6, 0.25]);
    let l = s.clone().cholesky().unwrap().l();
    let rival = [7.0, 2.5];
    let d = nalgebra::DVector::from_column_slice(&rival);
    let kl = 0.5 * d.dot(&s.clone().cholesky().unwrap().solve(&d));
    let totals = (0..runs).map(|run| {
        let mut rng = rng(5, run);
        let mut m = MultipleModel::new(constants(&[[0.0, 0.0], rival]))
            .unwrap()
            .with_prewhitening(whitening);
        let mut e = nalgebra::DVector::from_fn(2, |_, _| normal(&mut rng));
        for k in 0..n {
            if k > 0 {
                e = e * rho
                    + nalgebra::DVector::from_fn(2, |_, _| {
                        (1.0 - rho * rho).sqrt() * normal(&mut rng)
                    });
            }
            let y = &l * &e;
            m.update(&pair(0.01 * k as f64, 0, [y[0], y[1]], &s))
                .unwrap();
        }
        let ll = m.log_likelihoods();
        ll[0] - ll[1]
    });
    (kl, totals.collect())
}

fn moments(x: &[f64]) -> (f64, f64) {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (
        mean,
        x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (x.len() - 1) as f64,
    )
}

#[test]
fn b5_log_odds_grow_by_kl_and_correlation_inflates_their_variance() {
    let (runs, n) = (800, 100);
    // 4 sigma of a variance estimated from 800 runs.
    let within = |x: f64, expected: f64| {
        assert!(
            (x / expected - 1.0).abs() < 4.0 * (2.0_f64 / 799.0).sqrt(),
            "{x} {expected}"
        )
    };

    let (kl, iid) = log_odds(0.0, None, runs, n);
    let (mean, variance) = moments(&iid);
    assert!((mean / (n as f64 * kl) - 1.0).abs() < 0.01, "{mean} {kl}");
    within(variance / n as f64, 2.0 * kl);

    // Correlated samples weighed as independent: the sum over n samples, exactly.
    let rho: f64 = 0.81;
    let inflation = (1.0 + rho) / (1.0 - rho)
        - 2.0 * rho * (1.0 - rho.powi(n as i32)) / (n as f64 * (1.0 - rho).powi(2));
    let (_, naive) = log_odds(rho, None, runs, n);
    let (naive_mean, naive_variance) = moments(&naive);
    assert!((naive_mean / (n as f64 * kl) - 1.0).abs() < 0.02);
    within(naive_variance / n as f64, 2.0 * kl * inflation);

    // Prewhitened: information per sample is KL (1-ρ)/(1+ρ) (the first sample counts in full), and the log-odds are
    // calibrated again, variance = 2 mean.
    let whitening = Some(Prewhitening::new(rho, 0.01).unwrap());
    let (_, white) = log_odds(rho, whitening, runs, n);
    let (white_mean, white_variance) = moments(&white);
    let information = kl * (1.0 + (n - 1) as f64 * (1.0 - rho) / (1.0 + rho));
    assert!(
        (white_mean / information - 1.0).abs() < 0.02,
        "{white_mean} {information}"
    );
    within(white_variance, 2.0 * information);
}

#[test]
fn b5_fails_for_a_misspecified_covariance() {
    // S taken four times too small: the mean grows fourfold, but the variance sixteenfold.
    let s = DMatrix::identity(2, 2);
    let totals: Vec<f64> = (0..400)
        .map(|run| {
            let mut rng = rng(6, run);
            let mut m = MultipleModel::new(constants(&[[0.0, 0.0], [1.0, 0.0]])).unwrap();
            for k in 0..50 {
                let y = [normal(&mut rng), normal(&mut rng)];
                m.update(&pair(k as f64, 0, y, &(&s * 0.25))).unwrap();
            }
            let ll = m.log_likelihoods();
            ll[0] - ll[1]
        })
        .collect();
    let (mean, variance) = moments(&totals);
    assert!(variance / mean > 5.0, "{}", variance / mean);
}

#[test]
fn b6_the_winner_is_the_closest_by_kl_also_when_none_is_true() {
    let set: HypothesisSet = wong21();
    let slips = sweep(60, 0.9, 0.1);
    let mut decided = 0;
    for (case, id) in [
        "dry_sand",
        "upland_sandy_loam",
        "lean_clay_22",
        "sandy_loam_15",
        "clayey_38",
        "grenville",
        "lete_sand",
        "north_gower",
    ]
    .iter()
    .enumerate()
    {
        let mut rng = rng(60, case as u64);
        let truth: Vec<f64> = soil(id)
            .iter()
            .map(|p| p * (0.1 * normal(&mut rng)).exp())
            .collect();
        // Expected log-score: -(dᵀS⁻¹d + tr(S⁻¹ S_true) + ln det S)/2 over the noise-free design.
        let mut scores = vec![0.0; set.len()];
        let exact = noiseless(&truth, &slips);
        for obs in &exact {
            let Comparison::Feasible(own) = compare("truth", &law(), &truth, obs, 0.0).unwrap()
            else {
                panic!()
            };
            for (score, h) in scores.iter_mut().zip(set.hypotheses()) {
                *score += match compare(&h.id, &h.law, &h.parameters, obs, 0.0).unwrap() {
                    Comparison::Feasible(r) => {
                        let c = r.covariance.cholesky().unwrap();
                        -0.5 * (r.value.dot(&c.solve(&r.value))
                            + c.solve(&own.covariance).trace()
                            + c.ln_determinant())
                    }
                    Comparison::Infeasible(_) => -1e4,
                };
            }
        }
        let mut order: Vec<usize> = (0..set.len()).collect();
        order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]));
        // The log-odds have standard deviation of about sqrt(2 gap): near ties may fall either way.
        if scores[order[0]] - scores[order[1]] < 20.0 {
            continue;
        }
        decided += 1;
        let mut m = MultipleModel::new(set.clone()).unwrap();
        for obs in side(&truth, &slips, [LOAD, LOAD], 0.0, &mut rng) {
            m.update(&obs).unwrap();
        }
        assert_eq!(m.map_index(), order[0], "{id}");
    }
    assert!(decided >= 6, "only {decided} cases were decided");
}

fn noiseless(p: &[f64], slips: &[f64]) -> Vec<terra_mme::ForceObservation> {
    use terra_model::ForceLaw;
    let mut out = side(p, slips, [LOAD, LOAD], 0.0, &mut rng(0, 0));
    for (obs, &slip) in out.iter_mut().zip(slips) {
        let f = law().forces(p, &contact(slip, LOAD)).unwrap();
        obs.contacts = vec![contact(slip, LOAD); 2];
        obs.forces = nalgebra::DVector::from_vec(vec![
            2.0 * f.drawbar_pull,
            f.resistive_torque,
            f.resistive_torque,
        ]);
    }
    out
}
