//! Sets that are made: what a grid, a Latin hypercube and perturbed copies promise.

use std::collections::BTreeSet;

use proptest::prelude::*;
use terra_mme::{Axis, EstimatorError, HypothesisSet, MultipleModel, ParameterEstimator, Weighed};
use terra_model::{Contact, ForceLaw};

use crate::common::{LOAD, RADIUS, WIDTH, constants, contact, law, pair, soil, wong21};

fn axes() -> [Axis; 3] {
    [
        Axis::new("cohesion", 500.0, 20_000.0),
        Axis::new("friction_angle", 0.2, 0.7),
        Axis::new("shear_modulus", 0.005, 0.05),
    ]
}

fn column(set: &HypothesisSet, name: &str) -> Vec<f64> {
    let at = law().params().iter().position(|p| p.name == name).unwrap();
    set.hypotheses().iter().map(|h| h.parameters[at]).collect()
}

/// Every value of each axis with every value of the others, once; ends as given; even in the logarithm; the rest stays.
#[test]
fn a_grid_is_the_product_of_its_axes() {
    let [c, phi, k] = axes();
    let set =
        HypothesisSet::grid(&law(), "g", &soil("dry_sand"), &[(c, 4), (phi, 3), (k, 1)]).unwrap();
    assert_eq!(set.len(), 12);
    let (c, phi, k) = (
        column(&set, "cohesion"),
        column(&set, "friction_angle"),
        column(&set, "shear_modulus"),
    );
    let points: BTreeSet<[u64; 2]> = c
        .iter()
        .zip(&phi)
        .map(|(c, p)| [c.to_bits(), p.to_bits()])
        .collect();
    assert_eq!(points.len(), 12);
    let values: BTreeSet<u64> = c.iter().map(|c| c.to_bits()).collect();
    assert_eq!(values.len(), 4);
    assert_eq!((c[0], c[11]), (500.0, 20_000.0));
    let ratio = (20_000.0_f64 / 500.0).cbrt();
    assert!((c[3] / c[0] - ratio).abs() < 1e-12 * ratio);
    assert!(
        k.iter()
            .all(|k| (k - (0.005_f64 * 0.05).sqrt()).abs() < 1e-15)
    );
    let n = column(&set, "sinkage_exponent");
    let own = column(
        &HypothesisSet::from_vectors(&law(), "o", [soil("dry_sand")]).unwrap(),
        "sinkage_exponent",
    );
    assert!(n.iter().all(|n| *n == own[0]));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// McKay, Beckman and Conover's definition: each of n equal slices of each axis holds exactly one member.
    #[test]
    fn a_hypercube_has_one_member_in_every_slice(n in 1usize..60, seed in any::<u64>()) {
        let set = HypothesisSet::latin_hypercube(&law(), "l", &soil("dry_sand"), &axes(), n, seed).unwrap();
        for axis in axes() {
            let mut slices: Vec<usize> = column(&set, &axis.parameter)
                .iter()
                .map(|v| {
                    let share = if linear(&axis.parameter) {
                        (v - axis.low) / (axis.high - axis.low)
                    } else {
                        (v / axis.low).ln() / (axis.high / axis.low).ln()
                    };
                    ((share * n as f64 + 1e-9) as usize).min(n - 1)
                })
                .collect();
            slices.sort_unstable();
            prop_assert_eq!(slices, (0..n).collect::<Vec<_>>());
        }
        let again = HypothesisSet::latin_hypercube(&law(), "l", &soil("dry_sand"), &axes(), n, seed).unwrap();
        prop_assert_eq!(column(&set, "cohesion"), column(&again, "cohesion"));
    }

    /// A copy does not change when more copies or more soils are asked for.
    #[test]
    fn a_perturbed_copy_is_its_own(copies in 1usize..6, seed in any::<u64>()) {
        let few = wong21().perturbed(copies, 0.1, seed).unwrap();
        let more = wong21().perturbed(copies + 2, 0.1, seed).unwrap();
        prop_assert_eq!(few.len(), 21 * copies);
        for h in few.hypotheses() {
            let twin = more.hypotheses().iter().find(|m| m.id == h.id).unwrap();
            prop_assert_eq!(&twin.parameters, &h.parameters);
        }
    }
}

/// ln(p'/p) is N(0, .1²): mean and variance of 4 000 draws within 4 sigma of theory (sd of the mean .1/√n, of the
/// variance .01 √(2/n)); other parameters are independent (|r| < 4/√n); zeros stay.
#[test]
fn perturbations_have_the_spread_they_say() {
    let n = 4000;
    let one = HypothesisSet::from_vectors(&law(), "s", [soil("lean_clay_22")]).unwrap();
    let set = one.perturbed(n, 0.1, 7).unwrap();
    let logs = |name: &str| -> Vec<f64> {
        let start = column(&one, name)[0];
        column(&set, name)
            .iter()
            .map(|v| (v / start).ln())
            .collect()
    };
    let (a, b) = (logs("cohesion"), logs("friction_angle"));
    let root = (n as f64).sqrt();
    for x in [&a, &b] {
        let mean = x.iter().sum::<f64>() / n as f64;
        let variance = x.iter().map(|v| v * v).sum::<f64>() / n as f64;
        assert!(mean.abs() < 4.0 * 0.1 / root, "{mean}");
        assert!(
            (variance - 0.01).abs() < 4.0 * 0.01 * 2.0_f64.sqrt() / root,
            "{variance}"
        );
    }
    let r = a.iter().zip(&b).map(|(a, b)| a * b / 0.01).sum::<f64>() / n as f64;
    assert!(r.abs() < 4.0 / root, "{r}");
    let zero = HypothesisSet::from_vectors(
        &law(),
        "z",
        [vec![0.0; one.hypotheses()[0].parameters.len()]],
    )
    .unwrap();
    let still = zero.perturbed(1, 0.1, 1).unwrap();
    assert!(still.hypotheses()[0].parameters.iter().all(|p| *p == 0.0));
}

/// What cannot be made is refused by name.
#[test]
fn slips_of_the_pen_are_refused() {
    let p = soil("dry_sand");
    let grid = |axis: Axis, n: usize| HypothesisSet::grid(&law(), "g", &p, &[(axis, n)]);
    let said = |r: Result<HypothesisSet, EstimatorError>| r.unwrap_err().to_string();
    assert!(said(grid(Axis::new("cohesoin", 1.0, 2.0), 2)).contains("did you mean 'cohesion'"));
    assert!(said(grid(Axis::new("cohesion", 3.0, 2.0), 2)).contains("above the low end"));
    assert!(said(grid(Axis::new("cohesion", f64::NAN, 2.0), 2)).contains("law allows"));
    assert!(matches!(
        grid(Axis::new("cohesion", 1.0, 2.0), 0),
        Err(EstimatorError::EmptySet)
    ));
    assert!(matches!(
        grid(Axis::new("cohesion", 1.0, 2.0), usize::MAX),
        Err(EstimatorError::Size { .. })
    ));
    let twice = [
        (Axis::new("cohesion", 1.0, 2.0), 2),
        (Axis::new("cohesion", 1.0, 3.0), 2),
    ];
    assert!(HypothesisSet::grid(&law(), "g", &p, &twice).is_err());
    assert!(HypothesisSet::grid(&law(), "g", &p[1..], &twice[..1]).is_err());
    assert!(wong21().perturbed(1, -0.1, 1).is_err());
    assert!(wong21().perturbed(0, 0.1, 1).is_err());
}

/// Soils of different laws in one set: each is compared by its own law, and a pair with the same forces is named.
#[test]
fn structures_mix_and_twins_are_named() {
    let registry = terra_model::Registry::builtin();
    let other = std::sync::Arc::new(registry.law("wong-reece+slip-sinkage").unwrap());
    let plain =
        HypothesisSet::from_vectors(&law(), "plain", [soil("dry_sand"), soil("lean_clay_22")])
            .unwrap();
    let mut with = soil("dry_sand");
    with.push(0.0);
    let mut strong = soil("dry_sand");
    strong.push(0.5);
    let sinking = HypothesisSet::from_vectors(&other, "sinking", [with, strong]).unwrap();
    let set = plain.joined(sinking).unwrap();
    assert_eq!(set.structures().len(), 2);
    let probes = [
        contact(0.2, LOAD),
        contact(0.6, LOAD),
        Contact::new(0.4, 300.0, RADIUS, WIDTH),
    ];
    let twins = set.near_duplicates(&probes, 1e-9);
    assert_eq!(twins.len(), 1, "{twins:?}");
    assert_eq!(
        twins[0].pair,
        ["plain-1".to_owned(), "sinking-1".to_owned()]
    );
}

/// A set on a line finds the point nearest to the truth: with one datum and flat prior, the winner of a grid minimises
/// the distance.
#[test]
fn the_winner_of_a_grid_is_its_nearest_point() {
    let set = constants(&[[0.0, 0.0]]);
    let law = set.hypotheses()[0].law.clone();
    let axes = [
        (Axis::new("pull", -10.0, 10.0), 21),
        (Axis::new("torque", -10.0, 10.0), 21),
    ];
    let set = HypothesisSet::grid(&law, "g", &[0.0, 0.0], &axes).unwrap();
    let mut models = MultipleModel::new(set).unwrap();
    let s = nalgebra::DMatrix::identity(2, 2);
    models.update(&pair(0.0, 0, [3.3, -6.7], &s)).unwrap();
    assert_eq!(models.map().parameters, vec![3.0, -7.0]);
}

fn linear(name: &str) -> bool {
    let law = law();
    let param = law.params().iter().find(|p| p.name == name).unwrap();
    param.scale == terra_model::Scale::Linear
}
