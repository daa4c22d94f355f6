//! A set that adapts counts no evidence twice.

use proptest::prelude::*;
use terra_mme::{
    Adaptation, AdaptiveModel, Choice, MultipleModel, ParameterEstimator, Prewhitening, Weighed,
};
use terra_model::ForceLaw;

use crate::common::{LOAD, constants, contact, law, pair, rng, side, soil, sweep, wong21};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The posterior is that of the final set had it been there all along under its prior: same probabilities, same
    /// evidence; the priors, with those of the dropped, sum to 1.
    #[test]
    fn adapting_equals_having_known_the_set(seed in any::<u64>(), copies in 1usize..6, first in 1usize..8, rho in 0.0f64..0.9) {
        let start: Vec<[f64; 2]> = (0..5).map(|k| [1.0 + k as f64, 2.0 - 0.3 * k as f64]).collect();
        let how = Adaptation { first, copies, sd: 0.2, drop: 12.0, generations: 3, seed };
        let whitening = Some(Prewhitening::new(rho, 1.0).unwrap());
        let models = |set| MultipleModel::new(set).unwrap().with_prewhitening(whitening);
        let mut adaptive = AdaptiveModel::new(models(constants(&start)), how).unwrap().with_history();
        let s = nalgebra::DMatrix::identity(2, 2) * 0.3;
        let mut noise = rng(seed, 1);
        let rows: Vec<_> = (0..40)
            .map(|k| {
                let e = [crate::common::normal(&mut noise), crate::common::normal(&mut noise)];
                pair(k as f64, 0, [2.2 + 0.5 * e[0], 1.6 + 0.5 * e[1]], &s)
            })
            .collect();
        for o in &rows {
            adaptive.update(o).unwrap();
        }
        prop_assert_eq!(adaptive.generation(), 3);
        let held: f64 = adaptive.prior().iter().sum();
        prop_assert!((held + adaptive.dropped_prior() - 1.0).abs() < 1e-12);
        prop_assert!(adaptive.dropped_probability() < 20.0 * (-12.0f64).exp());
        let mut batch = models(adaptive.hypotheses().clone()).with_prior(adaptive.prior()).unwrap();
        for o in &rows {
            batch.update(o).unwrap();
        }
        for (a, b) in adaptive.probabilities().iter().zip(batch.probabilities()) {
            prop_assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        // The batch normalises its prior; the adaptive set knows that part of it is gone.
        prop_assert!((adaptive.log_evidence() - batch.log_evidence() - held.ln()).abs() < 1e-8);
        let history = adaptive.history().unwrap();
        prop_assert_eq!(history.probability.len(), 40);
        for row in &history.probability {
            prop_assert_eq!(row.len(), history.ids.len());
            prop_assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }
}

/// On a soil that no hypothesis is, the set comes nearer to its forces; on one that is in the set, that one still wins
/// against all its copies together only as far as the data tell them apart.
#[test]
fn the_set_moves_towards_a_soil_that_is_not_in_it() {
    let mut off = soil("dry_sand");
    off.iter_mut().for_each(|p| *p *= 1.08);
    let rows = side(
        &off,
        &sweep(120, 0.9, 0.05),
        [200.0, 290.0],
        0.0,
        &mut rng(9, 0),
    );
    let mut fixed = MultipleModel::new(wong21()).unwrap();
    let how = Adaptation {
        copies: 24,
        ..Adaptation::default()
    };
    let mut adaptive = AdaptiveModel::new(MultipleModel::new(wong21()).unwrap(), how).unwrap();
    for o in &rows {
        fixed.update(o).unwrap();
        adaptive.update(o).unwrap();
    }
    let at = contact(0.4, LOAD);
    let truth = law().forces(&off, &at).unwrap().resistive_torque;
    let error = |w: &dyn Weighed| {
        let f = w.force_prediction(&[0.4], &[LOAD], &at).unwrap().remove(0);
        (f.torque.unwrap().mean / truth - 1.0).abs()
    };
    assert!(
        error(&adaptive) < 0.5 * error(&fixed),
        "{} {}",
        error(&adaptive),
        error(&fixed)
    );
    assert!(adaptive.log_evidence() > fixed.log_evidence() + 10.0);
    assert!(adaptive.hypotheses().len() < 21 + 3 * 24);
}

/// What would bend the evidence is refused.
#[test]
fn an_adaptive_set_refuses_to_forget() {
    let online = MultipleModel::new(wong21())
        .unwrap()
        .with_choice(Choice::online())
        .unwrap();
    assert!(AdaptiveModel::new(online, Adaptation::default()).is_err());
    for how in [
        Adaptation {
            first: 0,
            ..Adaptation::default()
        },
        Adaptation {
            copies: 0,
            ..Adaptation::default()
        },
        Adaptation {
            sd: f64::NAN,
            ..Adaptation::default()
        },
        Adaptation {
            drop: 0.0,
            ..Adaptation::default()
        },
    ] {
        assert!(AdaptiveModel::new(MultipleModel::new(wong21()).unwrap(), how).is_err());
    }
}
