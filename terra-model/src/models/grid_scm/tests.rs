//! The grid against its closed form, against itself, and what it remembers.

use super::*;
use crate::{ForceLaw, Registry, catalogue};

/// Dry sand with all its stiffness in k_φ.
const SAND: [f64; 6] = [0.0, 1.535e6, 1.1, 1040.0, 0.4887, 0.025];
const LOAD: f64 = 245.25;

/// Next to rigid before it yields, and undamped: what the closed form describes.
const RIGID: GridScm = GridScm {
    elastic_stiffness: 1e12,
    damping: 0.0,
};
const ELASTIC: GridScm = GridScm {
    elastic_stiffness: 4e7,
    damping: 0.0,
};

fn at(slip: f64, load: f64) -> Contact<f64> {
    Contact {
        speed: 0.1,
        ..Contact::new(slip, load, 0.254, 0.15)
    }
}

fn rolled(soil: &GridScm, cell: f64, slip: f64) -> (SoilGrid, WheelForces<f64>) {
    let mut grid = SoilGrid::virgin(cell).unwrap();
    let forces = soil
        .roll(&SAND, &mut grid, 0.0, 0.3, &at(slip, LOAD))
        .unwrap();
    (grid, forces[forces.len() - 1])
}

/// A wheel that has rolled for longer than its contact has the forces of `scm-column`, the more exactly the finer the cells.
#[test]
fn fine_cells_have_the_closed_form() {
    let law = Registry::builtin().law("scm-column").unwrap();
    for slip in [-0.2, 0.1, 0.3, 0.9] {
        let column = law.forces(&SAND, &at(slip, LOAD)).unwrap();
        let off = |cell: f64| {
            let (_, f) = rolled(&RIGID, cell, slip);
            let scale = column.drawbar_pull.abs() + column.resistive_torque.abs() / 0.254;
            let pull = (f.drawbar_pull - column.drawbar_pull).abs() / scale;
            let torque = (f.resistive_torque - column.resistive_torque).abs() / (0.254 * scale);
            let sinkage = (f.sinkage.unwrap() / column.sinkage.unwrap() - 1.0).abs();
            pull.max(torque).max(sinkage)
        };
        let (coarse, fine) = (off(4e-3), off(1e-3));
        assert!(
            fine < 0.012 && fine < 0.5 * coarse,
            "slip {slip}: {coarse} {fine}"
        );
    }
}

/// Pressed straight down on linear soil: W = b k ∫ (z - R (1 - cos θ)) R cos θ dθ over -θ1..θ1, and nothing pulls or turns.
#[test]
fn a_wheel_set_down_is_carried_by_its_footprint() {
    let p = [0.0, 2e6, 1.0, 0.0, 0.5, 0.02];
    let grid = SoilGrid::virgin(2e-4).unwrap();
    let f = RIGID.forces(&p, &grid, 0.0, &at(0.0, LOAD)).unwrap();
    let z = f.sinkage.unwrap();
    let angle = (1.0 - z / 0.254_f64).acos();
    let (sin, cos) = angle.sin_cos();
    let area = 2.0 * ((z - 0.254) * sin + 0.254 * 0.5 * (angle + sin * cos)) * 0.254;
    assert!((0.15 * 2e6 * area / LOAD - 1.0).abs() < 1e-4);
    assert!(f.drawbar_pull == 0.0 && f.resistive_torque.abs() < 1e-9 * LOAD);
}

/// Every number to its last digit.
fn said(f: &WheelForces<f64>) -> String {
    format!("{f:?}")
}

/// Asking changes nothing, and equal pasts give equal futures.
#[test]
fn the_memory_is_the_callers() {
    let (grid, last) = rolled(&ELASTIC, 5e-3, 0.3);
    let before = grid.clone();
    let ask = || ELASTIC.forces(&SAND, &grid, 0.31, &at(0.3, LOAD)).unwrap();
    assert_eq!(said(&ask()), said(&ask()));
    assert_eq!(grid, before);
    let (other, again) = rolled(&ELASTIC, 5e-3, 0.3);
    assert_eq!(other, before);
    assert_eq!(said(&again), said(&last));
}

/// What is left is the sinkage less what springs back, z - k z^n/k_e; nothing before the first place but what the wheel that
/// stood there reached.
#[test]
fn a_rut_is_the_sinkage_less_what_springs_back() {
    let (grid, f) = rolled(&ELASTIC, 2e-3, 0.3);
    let z = f.sinkage.unwrap();
    let expected = z - SAND[1] * z.powf(SAND[2]) / ELASTIC.elastic_stiffness;
    assert!(
        (grid.rut(0.2) / expected - 1.0).abs() < 0.01,
        "{} {expected}",
        grid.rut(0.2)
    );
    assert!(expected < 0.99 * z);
    assert_eq!(grid.rut(-0.3), 0.0);
    assert_eq!(grid.rut(0.6), 0.0);
    let exit = f.angles.unwrap().exit;
    assert!(
        exit < -0.02,
        "what springs back carries behind the bottom: {exit}"
    );
}

/// In its own rut a wheel of the same load sinks hardly further and is easier to drive; a third pass changes less than the
/// second; a heavier wheel deepens the rut.
#[test]
fn passes_over_a_rut() {
    let mut grid = SoilGrid::virgin(4e-3).unwrap();
    let mut pass = |load| {
        let f = ELASTIC
            .roll(&SAND, &mut grid, 0.0, 0.5, &at(0.05, load))
            .unwrap();
        (f[100], grid.rut(0.2))
    };
    let (first, rut) = pass(LOAD);
    let (second, deeper) = pass(LOAD);
    let (third, deepest) = pass(LOAD);
    let z = |f: &WheelForces<f64>| f.sinkage.unwrap();
    assert!(deeper >= rut && deeper - rut < 0.35 * rut, "{rut} {deeper}");
    assert!(deepest - deeper < deeper - rut + 1e-12);
    assert!(second.resistive_torque < 0.8 * first.resistive_torque);
    assert!(z(&third) - z(&second) < z(&second) - z(&first) + 1e-9);
    let (_, heavy) = pass(2.0 * LOAD);
    assert!(heavy > 1.2 * deepest, "{heavy} {deepest}");
}

/// A faster wheel is held up by damping.
#[test]
fn damping_holds_a_fast_wheel_up() {
    let damped = GridScm::default();
    let sinkage = |speed: f64| {
        let mut grid = SoilGrid::virgin(4e-3).unwrap();
        let contact = Contact {
            speed,
            ..at(0.1, LOAD)
        };
        let f = damped.roll(&SAND, &mut grid, 0.0, 0.3, &contact).unwrap();
        f[f.len() - 1].sinkage.unwrap()
    };
    let (slow, fast) = (sinkage(0.0), sinkage(2.0));
    assert!(fast < 0.9 * slow, "{fast} {slow}");
}

#[test]
fn mistakes_are_typed() {
    let grid = SoilGrid::virgin(0.01).unwrap();
    let ask = |p: &[f64], slip, load| ELASTIC.forces(p, &grid, 0.0, &at(slip, load));
    let quantity = |found: Result<WheelForces<f64>, ModelError>| match found {
        Err(ModelError::Contact { quantity, .. }) => quantity,
        other => panic!("{other:?}"),
    };
    assert_eq!(quantity(ask(&SAND, 1.0, LOAD)), "slip");
    assert_eq!(quantity(ask(&SAND, 0.1, -1.0)), "normal_load");
    assert!(matches!(
        ask(&SAND[..5], 0.1, LOAD),
        Err(ModelError::ParameterCount { .. })
    ));
    let snow = catalogue::find("snow_us_harrison_1").unwrap();
    let p = [
        snow.k_c,
        snow.k_phi,
        snow.sinkage_exponent,
        snow.cohesion,
        0.3,
        0.05,
    ];
    let Err(ModelError::NoEquilibrium { load, max_load }) = ask(&p, 0.1, 1e5) else {
        panic!("carried")
    };
    assert!(max_load < load);
    assert!(SoilGrid::virgin(0.0).is_err());
    assert!(
        ELASTIC
            .roll(&SAND, &mut grid.clone(), 1.0, 0.0, &at(0.1, LOAD))
            .is_err()
    );
}
