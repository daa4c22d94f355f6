//! Forces are averaged, parameters are not.

use terra_mme::{HypothesisSet, ParameterBelief, PredictionStatus, mixture};
use terra_model::ForceLaw;

use crate::common::*;

fn sand_and_clay() -> HypothesisSet {
    HypothesisSet::from_vectors(&law(), "half", [soil("dry_sand"), soil("lean_clay_22")]).unwrap()
}

#[test]
fn the_mean_soil_pulls_five_times_as_hard_as_the_mixture() {
    // B7's expected failure: forces of the mean parameters (Ray 2008, eq. 24) leave the hull of the members' forces.
    let set = sand_and_clay();
    let ParameterBelief::Shared(belief) = ParameterBelief::of(&set, &[0.5, 0.5]) else {
        panic!("one law")
    };
    let at = contact(0.5, LOAD);
    let member = |j: usize| {
        law()
            .forces(&set.hypotheses()[j].parameters, &at)
            .unwrap()
            .drawbar_pull
    };
    let of_mean = law()
        .forces(belief.mean.as_slice(), &at)
        .unwrap()
        .drawbar_pull;
    let mixed = mixture(&set, &[0.5, 0.5], &at)
        .unwrap()
        .drawbar_pull
        .unwrap();
    assert!((of_mean - 178.0).abs() < 1.0, "{of_mean}");
    assert!((mixed.mean - 35.0).abs() < 0.5, "{mixed:?}");
    assert!(of_mean > 4.0 * member(0).max(member(1)));
    assert!(mixed.mean > member(0).min(member(1)) && mixed.mean < member(0).max(member(1)));
}

#[test]
fn spread_is_the_law_of_total_variance() {
    let set = sand_and_clay();
    let at = contact(0.8, LOAD);
    let f: Vec<_> = set
        .hypotheses()
        .iter()
        .map(|h| law().forces(&h.parameters, &at).unwrap())
        .collect();
    let m = mixture(&set, &[0.3, 0.7], &at).unwrap();
    let expect = |a: f64, b: f64| (0.3 * a + 0.7 * b, (0.3 * 0.7_f64).sqrt() * (a - b).abs());
    for (seen, (mean, sd)) in [
        (m.drawbar_pull, expect(f[0].drawbar_pull, f[1].drawbar_pull)),
        (
            m.torque,
            expect(f[0].resistive_torque, f[1].resistive_torque),
        ),
        (
            m.sinkage,
            expect(f[0].sinkage.unwrap(), f[1].sinkage.unwrap()),
        ),
    ] {
        let seen = seen.unwrap();
        assert!((seen.mean - mean).abs() < 1e-10 && (seen.sd - sd).abs() < 1e-10);
    }
}

#[test]
fn soils_that_cannot_carry_the_load_are_told_apart() {
    let set =
        HypothesisSet::from_vectors(&law(), "x", [soil("dry_sand"), soil("snow_us_harrison_1")])
            .unwrap();
    let at = contact(0.8, LOAD);
    let sand = law().forces(&soil("dry_sand"), &at).unwrap().drawbar_pull;
    let m = mixture(&set, &[0.9, 0.1], &at).unwrap();
    assert_eq!((m.status, m.infeasible), (PredictionStatus::Ok, 0.1));
    assert!((m.drawbar_pull.unwrap().mean - sand).abs() < 1e-12);
    let m = mixture(&set, &[0.2, 0.8], &at).unwrap();
    assert_eq!((m.status.name(), m.drawbar_pull), ("no-equilibrium", None));
    assert!(mixture(&set, &[1.0], &at).is_err());
    assert!(mixture(&set, &[0.5, 0.5], &contact(2.0, LOAD)).is_err());
}
