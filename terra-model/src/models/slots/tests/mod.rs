//! Slots against the plain wheels, published figures, limits and second methods.

#![allow(clippy::unwrap_used, clippy::panic)]

mod conforming;
mod folds;
mod named;
mod pressures;
mod pushing;
mod quick;
mod scans;
mod shears;
mod two_zones;
mod tyre;
mod wheels;

use super::*;
use crate::catalogue;
use crate::law::Law;
use crate::{ForceLaw, Registry};

const LOADS: [f64; 2] = [245.25, 2452.5];

fn at(slip: f64, load: f64) -> Contact<f64> {
    Contact::new(slip, load, 0.254, 0.15)
}

fn composed(name: &str) -> Composed {
    let mut parts = name.split(':');
    let wheel = slot("", &WheelKind::ALL, WheelKind::name, parts.next().unwrap()).unwrap();
    let pressure = slot(
        "",
        &PressureKind::ALL,
        PressureKind::name,
        parts.next().unwrap(),
    )
    .unwrap();
    let shear = slot("", &ShearKind::ALL, ShearKind::name, parts.next().unwrap()).unwrap();
    find(wheel, pressure, shear).unwrap()
}

fn law(name: &str) -> Law {
    Law::new(composed(name).shared(), vec![]).unwrap()
}

/// max of the differences of entry angle, pull and torque in the metric of the reference wheel.
fn difference(f: &WheelForces<f64>, g: &WheelForces<f64>) -> f64 {
    let scale = g.drawbar_pull.abs() + g.resistive_torque.abs() / 0.254;
    ((f.drawbar_pull - g.drawbar_pull) / scale)
        .abs()
        .max(((f.resistive_torque - g.resistive_torque) / (0.254 * scale)).abs())
        .max((f.sinkage.unwrap() / g.sinkage.unwrap() - 1.0).abs())
}

/// A soil of the catalogue in the order of Bekker's parameters.
fn soil(id: &str) -> Vec<f64> {
    let plain = Registry::builtin().model("wong-reece").unwrap();
    catalogue::find(id).unwrap().parameters(&*plain).unwrap()
}

/// The same forces, or no equilibrium in both, over the whole catalogue; returns how many had forces.
fn same_over_the_catalogue(
    a: &Law,
    b: &Law,
    bound: f64,
    parameters: impl Fn(&[f64]) -> (Vec<f64>, Vec<f64>),
) -> usize {
    let plain = Registry::builtin().model("wong-reece").unwrap();
    let mut compared = 0;
    for terrain in catalogue::terrains() {
        let Ok(p) = terrain.parameters(&*plain) else {
            continue;
        };
        let (p, q) = parameters(&p);
        for slip in [-1.0, -0.6, -0.2, -0.02, 0.0, 0.05, 0.3, 0.8, 1.0] {
            for load in LOADS {
                match (a.forces(&p, &at(slip, load)), b.forces(&q, &at(slip, load))) {
                    (Ok(f), Ok(g)) => {
                        let off = difference(&f, &g);
                        assert!(
                            off < bound,
                            "{} slip {slip} load {load}: {off:e}",
                            terrain.id
                        );
                        compared += 1;
                    }
                    (f, g) => assert!(
                        matches!(f, Err(ModelError::NoEquilibrium { .. }))
                            && matches!(g, Err(ModelError::NoEquilibrium { .. })),
                        "{} slip {slip} load {load}: {f:?} {g:?}",
                        terrain.id
                    ),
                }
            }
        }
    }
    compared
}

/// Parameters of a Bekker soil, k_c, k_φ and n before the others, in those of another law.
type InOtherLaw = fn(&[f64]) -> Vec<f64>;

/// The other pressure laws at the values at which they are Bekker's, .15 m wide.
const AS_BEKKER: [(&str, InOtherLaw); 4] = [
    ("reece", |p| {
        // γ b k_φ' (z/b)^n of a weight of 15 kN/m³.
        let k_phi_prime = (p[0] / 0.15 + p[1]) * 0.15_f64.powf(p[2] - 1.0) / 15_000.0;
        [&[0.0, k_phi_prime, p[2], 15_000.0], &p[3..]].concat()
    }),
    ("slip-exponent", |p| [&p[..3], &[0.0], &p[3..]].concat()),
    ("layered", |p| [&p[..3], &[0.0, 0.02], &p[3..]].concat()),
    ("unload-reload", |p| {
        [&p[..3], &[1e8, 0.0, 0.0], &p[3..]].concat()
    }),
];

fn plain(name: &str) -> Law {
    Registry::builtin().law(name).unwrap()
}
