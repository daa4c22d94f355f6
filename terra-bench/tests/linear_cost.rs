//! What a sample costs, counted in evaluations of the terrain model: time would show the machine, not the algorithm.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::cell::Cell;
use std::sync::Arc;

use terra_mme::{
    ForceObservation, Hypothesis, HypothesisSet, MultipleModel, ParameterEstimator,
    SufficientStatistics, TableBox, Weighed,
};
use terra_model::{Contact, ModelError, Param, Real, Registry, Scale, TerrainModel, WheelForces};

thread_local! {
    static EVALUATIONS: Cell<usize> = const { Cell::new(0) };
}

/// Evaluations made by `work` on this thread.
fn evaluations(work: impl FnOnce()) -> usize {
    let before = EVALUATIONS.get();
    work();
    EVALUATIONS.get() - before
}

/// Pull and torque in proportion to the load, and a count of how often anyone asked.
#[derive(Default)]
struct Counting;

const GRIP: Param = Param {
    name: "grip",
    symbol: "g",
    unit: "1",
    min: 0.0,
    max: 2.0,
    scale: Scale::Linear,
    prior_sd: 0.1,
    doc: "pull over load at full slip",
};

impl TerrainModel for Counting {
    const NAME: &'static str = "counting";
    const SUMMARY: &'static str = "counts its evaluations";
    const PARAMS: &'static [Param] = &[GRIP];
    const REFERENCE: &'static str = "none";
    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        EVALUATIONS.set(EVALUATIONS.get() + 1);
        let thrust = p[0] * at.slip * at.normal_load;
        let torque = thrust * at.radius;
        Ok(WheelForces::from_thrust(thrust, T::zero(), torque))
    }
}

fn set(n: usize) -> HypothesisSet {
    let registry = Registry::builtin().with_model::<Counting>();
    let law = Arc::new(registry.law("counting").unwrap());
    let hypotheses = (0..n)
        .map(|j| Hypothesis {
            id: format!("h{j}"),
            law: Arc::clone(&law),
            parameters: vec![0.1 + j as f64 / n as f64],
        })
        .collect();
    HypothesisSet::new(hypotheses).unwrap()
}

fn contact() -> Contact<f64> {
    Contact::new(0.3, 245.25, 0.254, 0.15)
}

fn observation(time: f64) -> ForceObservation {
    let forces = [Some(40.0), Some(10.0), None];
    ForceObservation::wheel(time, 0, forces, contact(), &[2.0, 0.5, 0.004, 1.0]).unwrap()
}

#[test]
fn a_sample_evaluates_the_model_equally_often_for_every_hypothesis() {
    let count = |n| {
        let mut estimator = MultipleModel::new(set(n)).unwrap();
        let first = evaluations(|| estimator.update(&observation(0.0)).unwrap());
        let second = evaluations(|| estimator.update(&observation(0.01)).unwrap());
        assert_eq!(
            first, second,
            "{n} hypotheses: the cost grows with the samples"
        );
        second
    };
    let each = count(1);
    assert!(each > 0, "the estimator must ask the model");
    for n in [2, 21, 100, 1000] {
        assert_eq!(count(n), each * n, "{n} hypotheses");
    }
}

#[test]
fn a_sample_of_sufficient_statistics_evaluates_no_model_at_all() {
    let range = TableBox {
        slip: (0.05, 0.9),
        load: (150.0, 350.0),
        nodes: (6, 4),
    };
    for n in [1, 21, 100] {
        let mut estimator = None;
        let built = evaluations(|| {
            estimator = Some(SufficientStatistics::new(set(n), range, &contact()).unwrap());
        });
        assert_eq!(
            built,
            n * 6 * 4,
            "the table asks once a node and hypothesis"
        );
        let mut estimator = estimator.unwrap();
        let asked = evaluations(|| {
            estimator.update(&observation(0.0)).unwrap();
            assert_eq!(estimator.probabilities().len(), n);
        });
        assert_eq!(asked, 0, "{n} hypotheses");
    }
}
