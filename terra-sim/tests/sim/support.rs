//! A wheel with constant forces, whose vehicle has closed-form motion, and shorthands.

use std::collections::BTreeMap;

use terra_data::{Rover, Start};
use terra_model::{Contact, ModelError, Param, Real, Registry, Scale, TerrainModel, WheelForces};
use terra_sim::integrate::DormandPrince;
use terra_sim::{
    Command, DriveRun, DriveSegment, Integrator, Profile, Scenario, StartMotion, paper,
    simulate_drive_with,
};

/// D and T whatever the slip and the load.
#[derive(Default)]
pub(crate) struct ConstantForce;

const fn param(name: &'static str, unit: &'static str) -> Param {
    Param {
        name,
        symbol: name,
        unit,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        scale: Scale::Linear,
        prior_sd: 1.0,
        doc: "",
    }
}

impl TerrainModel for ConstantForce {
    const NAME: &'static str = "constant-force";
    const SUMMARY: &'static str = "constant";
    const PARAMS: &'static [Param] = &[param("pull", "N"), param("torque", "N m")];
    const REFERENCE: &'static str = "none";

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        _at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        Ok(WheelForces::from_thrust(p[0], T::zero(), p[1]))
    }
}

pub(crate) fn registry() -> Registry {
    Registry::builtin().with_model::<ConstantForce>()
}

pub(crate) fn constant(pull: f64, torque: f64) -> Start {
    Start::Values(BTreeMap::from([
        ("pull".to_owned(), pull),
        ("torque".to_owned(), torque),
    ]))
}

/// A drive on constant forces, started with turning wheels so that no standstill rule takes part.
pub(crate) fn constant_drive(left: f64, right: f64, duration: f64) -> Scenario {
    let mut segment = DriveSegment::new(
        "run",
        duration,
        Command::Torque([Profile::constant(5.0); 4]),
    );
    segment.start = Some(StartMotion {
        ground_speed: 0.0,
        wheel_speed: [1.0; 4],
    });
    Scenario {
        model: "constant-force".to_owned(),
        left: constant(left, 3.0),
        right: constant(right, 3.0),
        segments: vec![segment],
        noise_scale: 0.0,
        ..paper::torque_ramp("dry_sand", 1).unwrap()
    }
}

pub(crate) fn quiet_ramp(terrain: &str) -> Scenario {
    Scenario {
        noise_scale: 0.0,
        ..paper::torque_ramp(terrain, 1).unwrap()
    }
}

pub(crate) fn adaptive() -> Integrator {
    Integrator::DormandPrince(DormandPrince::default())
}

pub(crate) fn drive(scenario: &Scenario, rover: &Rover, integrator: Integrator) -> DriveRun {
    simulate_drive_with(scenario, rover, &registry(), integrator).unwrap()
}

/// Integral of a column's samples over a segment's rows, Simpson's rule (an odd number of rows).
pub(crate) fn simpson(time: &[f64], f: impl Fn(usize) -> f64) -> f64 {
    let h = time[1] - time[0];
    let last = time.len() - 1;
    assert_eq!(last % 2, 0);
    (0..=last)
        .map(|i| {
            f(i) * if i == 0 || i == last {
                1.0
            } else {
                2.0 + 2.0 * (i % 2) as f64
            }
        })
        .sum::<f64>()
        * h
        / 3.0
}
