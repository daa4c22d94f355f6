//! A user's own terrain model and effect: thirty lines each, one line to join, and everything else follows.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use terra::data::{Rover, Start};
use terra::gap::{HoldOut, Provenance, Settings, diagnose_rig, to_json};
use terra::mme::{
    EstimatorError, EstimatorInput, EstimatorOptions, Hypothesis, HypothesisSet, estimator,
    estimators,
};
use terra::model::{
    Contact, Effect, ForceLaw, ModelError, Param, Real, Registry, Scale, Soil, TerrainModel, Touch,
    WheelForces, catalogue, conformance,
};
use terra::sim::{EffectSetting, Scenario, Trial, paper, simulate_rig};

use crate::support::{contact, observations};

const fn param(name: &'static str, min: f64, max: f64, scale: Scale, prior_sd: f64) -> Param {
    Param {
        name,
        symbol: name,
        unit: "1",
        min,
        max,
        scale,
        prior_sd,
        doc: "a number of the example",
    }
}

/// Pull and torque in proportion to the load, saturating with slip: a road-vehicle style closed form.
/// T = W R μ (1 - exp(-s/κ)), D = T/R - ρ W, odd in s.
#[derive(Default)]
struct Saturating;

impl TerrainModel for Saturating {
    const NAME: &'static str = "saturating";
    const SUMMARY: &'static str = "pull in proportion to load, saturating with slip";
    const PARAMS: &'static [Param] = &[
        param("traction", 0.05, 1.5, Scale::Log, 0.3),
        param("slip_scale", 0.01, 1.0, Scale::Log, 0.3),
        param("rolling_resistance", 0.001, 0.5, Scale::Log, 0.3),
    ];
    const REFERENCE: &'static str = "this test";

    fn typical() -> Vec<Vec<f64>> {
        vec![
            vec![0.5, 0.1, 0.05],
            vec![0.8, 0.05, 0.02],
            vec![0.3, 0.3, 0.1],
        ]
    }

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        let grip = -(-(at.slip.abs() / p[1])).exp_m1();
        let thrust = at.normal_load * p[0] * at.slip.select_lt(T::zero(), -grip, grip);
        Ok(WheelForces::from_thrust(
            thrust,
            at.normal_load * p[2],
            thrust * at.radius,
        ))
    }
}

/// The treads clog as the wheel slips: thrust falls by the share e s².
#[derive(Default)]
struct Clogging;

impl Effect for Clogging {
    const NAME: &'static str = "clogging";
    const SUMMARY: &'static str = "treads clog as the wheel slips: thrust falls with slip squared";
    const PARAMS: &'static [Param] = &[param("magnitude", 0.0, 1.0, Scale::Linear, 0.2)];
    const REFERENCE: &'static str = "this test";
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const REGIME: &'static str = "pull down at high slip, torque unchanged";
    const ISOLATED_BY: &'static str = "clean treads between trials";

    fn after<T: Real>(&self, e: &[T], _: &Soil<T>, at: &Contact<T>, f: &mut WheelForces<T>) {
        let lost = f.parts.thrust * e[0] * at.slip * at.slip;
        f.parts.thrust -= lost;
        f.drawbar_pull -= lost;
    }
}

/// The one line.
fn registry() -> Registry {
    Registry::builtin()
        .with_model::<Saturating>()
        .with_effect::<Clogging>()
}

const SOIL: [f64; 3] = [0.6, 0.15, 0.08];

#[test]
fn own_model_and_effect_conform() {
    conformance::check_model::<Saturating>().unwrap_or_else(|e| panic!("{e}"));
    conformance::check_effect::<Clogging>().unwrap_or_else(|e| panic!("{e}"));
}

/// D = W (μ g (1 - e s²) - ρ), g = 1 - exp(-s/κ): values and derivatives by hand.
#[test]
fn own_law_has_forces_and_an_exact_jacobian() {
    let law = registry().law("saturating+clogging").unwrap();
    assert_eq!(law.name(), "saturating+clogging");
    let ([mu, kappa, rho], e, s, w) = (SOIL, 0.3, 0.4, 200.0);
    let at = contact(s, w);
    let (f, j) = law.jacobian(&[mu, kappa, rho, e], &at).unwrap();
    let decay = f64::exp(-s / kappa);
    let g = 1.0 - decay;
    let clean = 1.0 - e * s * s;
    let close = |found: f64, expected: f64, what: &str| {
        assert!(
            (found - expected).abs() <= 1e-12 * (1.0 + expected.abs()),
            "{what}: {found}, by hand {expected}"
        );
    };
    close(f.drawbar_pull, w * (mu * g * clean - rho), "D");
    close(f.resistive_torque, at.radius * w * mu * g, "T");
    let slope = decay / kappa;
    let by_hand = [
        w * g * clean,
        -w * mu * clean * s / kappa.powi(2) * decay,
        -w,
        -w * mu * g * s * s,
        w * mu * (slope * clean - 2.0 * e * s * g),
        mu * g * clean - rho,
    ];
    for (column, expected) in by_hand.into_iter().enumerate() {
        close(j[(0, column)], expected, &format!("dD, column {column}"));
    }
}

/// Every estimator weighs the user's own law, effect included; only those that tabulate slip and load must refuse an
/// effect, which may look at more than these, and take the model alone.
#[test]
fn own_law_runs_in_every_estimator() {
    let registry = registry();
    for name in ["saturating", "saturating+clogging"] {
        let law = Arc::new(registry.law(name).unwrap());
        let hypotheses = [0.4, 0.6, 0.8].map(|mu| {
            let mut parameters = vec![mu, 0.15, 0.08];
            parameters.resize(law.params().len(), 0.2);
            Hypothesis {
                id: format!("mu {mu}"),
                law: Arc::clone(&law),
                parameters,
            }
        });
        for info in estimators()
            .iter()
            .filter(|e| e.input == EstimatorInput::Forces)
        {
            let set = HypothesisSet::new(hypotheses.to_vec()).unwrap();
            let mut weigher =
                match estimator(info.name, set, &EstimatorOptions::new(contact(0.2, 245.0))) {
                    Ok(weigher) => weigher,
                    Err(EstimatorError::NotSupported {
                        estimator, choice, ..
                    }) => {
                        assert!(["sufficient-statistics", "fused"].contains(&estimator));
                        assert_eq!(choice, "saturating+clogging");
                        continue;
                    }
                    Err(e) => panic!("{name} x {}: {e}", info.name),
                };
            for o in observations(&hypotheses[1], 1) {
                weigher.update(&o).unwrap();
            }
            assert_eq!(weigher.map().id, "mu 0.6", "{name} x {}", info.name);
            assert_eq!(weigher.posterior()[0].model, name, "{}", info.name);
        }
    }
}

fn rig(model: &str, start: Start) -> Rover {
    let mut rover = paper::light_rover();
    rover.vehicle = None;
    rover.terrain.model = model.to_owned();
    rover.terrain.start = Some(start);
    rover.noise.0 = [
        ("drawbar_pull_N", 0.5),
        ("torque_N_m", 0.1),
        ("slip", 0.002),
        ("normal_load_N", 0.5),
        ("roughness_N", 0.3),
    ]
    .map(|(k, v)| (k.to_owned(), v))
    .into();
    rover
}

/// Two loads, six slips, three repeats, with the user's effect in the ground.
fn trials(model: &str, soil: &Start, magnitude: f64) -> Scenario {
    Scenario {
        seed: 1,
        run: 0,
        rover: String::new(),
        rate: 0.0,
        left: soil.clone(),
        right: soil.clone(),
        model: model.to_owned(),
        noise_scale: 1.0,
        segments: vec![],
        trials: vec![Trial {
            slip: vec![0.05, 0.1, 0.2, 0.4, 0.6, 0.8],
            normal_load: vec![150.0, 245.25],
            repeats: 3,
            travel_speed: 0.05,
            condition: String::new(),
            pass: 1,
            ramp: None,
        }],
        effects: vec![EffectSetting::new("clogging", magnitude)],
        world: Default::default(),
    }
}

/// The user's effect over the user's model: simulated by name, diagnosed by name, against every effect of the library.
#[test]
fn own_effect_takes_part_in_the_diagnosis() {
    let registry = registry();
    let names = Saturating::PARAMS.iter().map(|p| p.name.to_owned());
    let soil = Start::Values(names.zip(SOIL).collect::<BTreeMap<_, _>>());
    let rover = rig("saturating", soil.clone());
    let log = simulate_rig(&trials("saturating", &soil, 0.4), &rover, &registry)
        .unwrap()
        .log;
    let settings = Settings {
        hold_out: Some(HoldOut::Slip),
        ..Settings::of(&rover)
    };
    let (diagnosis, _) = diagnose_rig(&log, &rover, &registry, &settings).unwrap();
    let causes: Vec<_> = diagnosis
        .causes
        .iter()
        .map(|c| (c.name.as_str(), c.probability))
        .collect();
    assert!(
        causes.iter().any(|(name, _)| *name == "clogging"),
        "{causes:?}"
    );
    assert!(causes.len() > 3, "rivals from the library: {causes:?}");
    assert_eq!(
        diagnosis.verdict, "named",
        "{causes:?}, {:?}",
        diagnosis.reason
    );
    assert_eq!(diagnosis.set, ["clogging"], "{causes:?}");
    let provenance = Provenance {
        log_sha256: String::new(),
        rover_sha256: String::new(),
        seed: 1,
    };
    let json = to_json(&diagnosis, &provenance);
    let magnitude = json["causes"][0]["parameters"]["magnitude"]["mean"]
        .as_f64()
        .unwrap();
    assert!(
        (magnitude - 0.4).abs() < 0.1,
        "magnitude .4 was simulated, {magnitude} found"
    );
}

/// Ground that follows the user's model is told from soil of the nominal one, whose parameters it has none of: it starts where its
/// author says.
#[test]
fn own_model_takes_part_in_the_diagnosis() {
    let names = Saturating::PARAMS.iter().map(|p| p.name.to_owned());
    let soil = Start::Values(names.zip([0.4, 0.15, 0.04]).collect::<BTreeMap<_, _>>());
    let rover = rig("wong-reece", Start::Id("dry_sand".to_owned()));
    let mut scenario = trials("saturating", &soil, 0.0);
    scenario.effects.clear();
    let log = simulate_rig(&scenario, &rover, &registry()).unwrap().log;
    let settings = Settings::of(&rover);
    let (told, _) = diagnose_rig(&log, &rover, &registry(), &settings).unwrap();
    let causes: Vec<_> = told
        .causes
        .iter()
        .map(|c| (&c.name, c.probability))
        .collect();
    assert_eq!(
        told.set[0], "structure:saturating",
        "{causes:?} {:?}",
        told.reason
    );
}

/// A table of a catalogue soil's values asks the same models as its name.
#[test]
fn a_table_of_values_leaves_no_model_out() {
    let registry = Registry::builtin();
    let law = registry.law("wong-reece").unwrap();
    let values = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    let names = law.params().iter().map(|p| p.name.to_owned());
    let table = Start::Values(names.zip(values).collect());
    let id = Start::Id("dry_sand".to_owned());
    let log = {
        let mut scenario = trials("wong-reece", &id, 0.0);
        scenario.effects.clear();
        let rover = rig("wong-reece", id.clone());
        simulate_rig(&scenario, &rover, &registry).unwrap().log
    };
    let found = [id, table].map(|start| {
        let rover = rig("wong-reece", start);
        diagnose_rig(&log, &rover, &registry, &Settings::of(&rover))
            .unwrap()
            .0
    });
    let asked = found.each_ref().map(|d| {
        let names = d.causes.iter().map(|c| c.name.clone());
        names
            .filter(|n| n.starts_with("structure:"))
            .collect::<BTreeSet<_>>()
    });
    assert!(
        asked[0].iter().any(|n| n == "structure:scm-column"),
        "{asked:?}"
    );
    assert_eq!(asked[0], asked[1]);
    assert_eq!(found[0].set, found[1].set);
}
