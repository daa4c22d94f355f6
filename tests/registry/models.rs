//! Any terrain model with any estimator, any effect, and the simulator.

use std::sync::Arc;

use terra::mme::{EstimatorInput, EstimatorOptions, PredictionStatus, estimator, estimators};
use terra::model::{ForceLaw, Law, ModelError, Registry};
use terra::sim::{EffectSetting, Scenario, Trial, simulate_rig};

use crate::support::{LOADS, contact, observations, soils};

/// The soil that made the forces wins under every model in every estimator; the posterior is one.
///
/// The estimators are told apart by what they may be given: `proportional-split` is the known-biased one, and its bias
/// vanishes where both wheels are alike, so it sees a side of one wheel like `wheel` does.
#[test]
fn any_model_with_any_estimator() {
    let registry = Registry::builtin();
    let mut pairs = 0;
    for model in registry.models() {
        let law = Arc::new(registry.law(model.name()).unwrap());
        let options = EstimatorOptions {
            history: true,
            ..EstimatorOptions::new(contact(0.2, LOADS[0]))
        };
        for info in estimators()
            .iter()
            .filter(|e| e.input == EstimatorInput::Forces)
        {
            let wheels = if matches!(info.name, "wheel" | "proportional-split") {
                1
            } else {
                2
            };
            for truth in soils(&law).hypotheses() {
                let label = format!("{} x {} on {}", model.name(), info.name, truth.id);
                let mut weigher = estimator(info.name, soils(&law), &options).unwrap();
                for o in observations(truth, wheels) {
                    weigher
                        .update(&o)
                        .unwrap_or_else(|e| panic!("{label}: {e}"));
                }
                let posterior = weigher.posterior();
                assert_eq!(posterior[0].id, truth.id, "{label}: {posterior:?}");
                assert_eq!(posterior[0].model, model.name(), "{label}");
                let sum: f64 = posterior.iter().map(|p| p.probability).sum();
                assert!(
                    (sum - 1.0).abs() < 1e-12,
                    "{label}: posterior sums to {sum}"
                );
                assert!(posterior[0].probability > 0.99, "{label}: {posterior:?}");
                assert_eq!(weigher.samples(), 12, "{label}");
                assert_eq!(weigher.history().unwrap().probability.len(), 12, "{label}");
                // The mixture is the truth's own force once the truth has all the weight.
                let at = contact(0.3, 245.25);
                let expected = law.forces(&truth.parameters, &at).unwrap();
                let found = weigher
                    .force_prediction(&[0.3], &[245.25], &at)
                    .unwrap()
                    .remove(0);
                assert_eq!(found.status, PredictionStatus::Ok, "{label}");
                let scale =
                    expected.drawbar_pull.abs() + expected.resistive_torque.abs() / at.radius;
                let off = (found.drawbar_pull.unwrap().mean - expected.drawbar_pull).abs();
                assert!(off < 0.02 * scale, "{label}: pull off by {off} of {scale}");
            }
            pairs += 1;
        }
    }
    let of_forces = estimators()
        .iter()
        .filter(|e| e.input == EstimatorInput::Forces)
        .count();
    assert_eq!(pairs, registry.models().len() * of_forces);
    assert!(
        pairs >= 6,
        "a walk over nothing proves nothing: {pairs} pairs"
    );
}

/// A pair composes, and then has forces and a finite exact Jacobian, or is refused by an error that names both and what is
/// missing. Magnitude 0 is the nominal model, bit for bit.
#[test]
fn any_effect_with_any_model_composes_or_says_why_not() {
    let registry = Registry::builtin();
    let (mut composed, mut refused) = (0, 0);
    for model in registry.models() {
        for effect in registry.effects() {
            let label = format!("{}+{} ({})", model.name(), effect.name(), effect.form());
            let law = match Law::new(Arc::clone(model), vec![Arc::clone(effect)]) {
                Ok(law) => Arc::new(law),
                Err(ModelError::EffectNotApplicable {
                    model: m,
                    effect: e,
                    hook,
                }) => {
                    assert_eq!((m, e), (model.name(), effect.name()));
                    assert!(
                        effect.needs().iter().any(|h| h.name() == hook),
                        "{label}: {hook} is not needed"
                    );
                    assert!(
                        model.hooks().iter().all(|h| h.name() != hook),
                        "{label}: {hook} is there"
                    );
                    refused += 1;
                    continue;
                }
                Err(ModelError::SoilUnknown {
                    model: m,
                    effect: e,
                    quantity,
                }) => {
                    assert_eq!((m, e), (model.name(), effect.name()));
                    assert!(
                        effect.needs_soil().contains(&quantity),
                        "{label}: {quantity} is not needed"
                    );
                    refused += 1;
                    continue;
                }
                Err(e) => panic!("{label}: {e}"),
            };
            let nominal = registry.law(model.name()).unwrap();
            let set = soils(&law);
            let p = &set.hypotheses()[0].parameters;
            let mut at = contact(0.2, 245.25);
            (
                at.speed,
                at.wheel_speed,
                at.path,
                at.time,
                at.earlier_passes,
            ) = (0.2, 1.0, 1.0, 5.0, 1.0);
            let (f, jacobian) = law
                .jacobian(p, &at)
                .unwrap_or_else(|e| panic!("{label}: {e}"));
            let plain = nominal.forces(&p[..nominal.params().len()], &at).unwrap();
            assert_eq!(
                f.drawbar_pull.to_bits(),
                plain.drawbar_pull.to_bits(),
                "{label}"
            );
            assert_eq!(
                f.resistive_torque.to_bits(),
                plain.resistive_torque.to_bits(),
                "{label}"
            );
            assert_eq!(jacobian.shape(), (4, law.params().len() + 2), "{label}");
            assert!(
                jacobian.iter().all(|x| x.is_finite()),
                "{label}: {jacobian}"
            );
            composed += 1;
        }
    }
    assert_eq!(
        composed + refused,
        registry.models().len() * registry.effects().len()
    );
    assert!(composed > refused, "{composed} compose, {refused} do not");
}

/// The truth simulator takes every model by name, with an effect that every one of them carries.
#[test]
fn any_model_in_the_simulator() {
    let registry = Registry::builtin();
    let mut rig = terra::sim::paper::light_rover();
    rig.vehicle = None;
    rig.noise.0 = [
        ("drawbar_pull_N", 0.5),
        ("torque_N_m", 0.1),
        ("slip", 0.005),
        ("normal_load_N", 0.5),
    ]
    .map(|(k, v)| (k.to_owned(), v))
    .into();
    for model in registry.models() {
        let trial = Trial {
            slip: vec![0.1, 0.4],
            normal_load: vec![245.25],
            repeats: 2,
            travel_speed: 0.05,
            condition: String::new(),
            pass: 1,
            ramp: None,
        };
        let soil = terra::model::catalogue::find("dry_sand").unwrap();
        let start = match soil.parameters(&**model) {
            Ok(_) => terra::data::Start::Id("dry_sand".to_owned()),
            Err(_) => {
                let names = model.params().iter().map(|p| p.name.to_owned());
                terra::data::Start::Values(
                    names.zip(model.typical_parameters().remove(0)).collect(),
                )
            }
        };
        let scenario = Scenario {
            seed: 1,
            run: 0,
            rover: String::new(),
            rate: 0.0,
            left: start.clone(),
            right: start,
            model: model.name().to_owned(),
            noise_scale: 1.0,
            segments: vec![],
            trials: vec![trial],
            effects: vec![EffectSetting::new("torque-scale", 0.1)],
            world: Default::default(),
        };
        let run = simulate_rig(&scenario, &rig, &registry)
            .unwrap_or_else(|e| panic!("{}: {e}", model.name()));
        assert_eq!(run.log.rows.len(), 4, "{}", model.name());
        assert!(
            run.log
                .rows
                .iter()
                .all(|r| r.drawbar_pull.is_some() && r.torque.is_some()),
            "{}",
            model.name()
        );
    }
}
