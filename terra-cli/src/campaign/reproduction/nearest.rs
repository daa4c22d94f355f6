//! Which soil of the set is nearest to the true one, by what a force filter can know.

use terra_ekf::{Flag, Side, side_forces};
use terra_mme::{Comparison, compare, score};
use terra_model::{ForceLaw, catalogue::Terrain};
use terra_sim::DriveRun;

use super::Bench;
use crate::identify::side_observation;
use crate::robot;

/// The soil of the set under which the noise-free forces of the left side are the most likely, at the true slips and loads, each
/// with the covariance that the force filter states for forces, slips and loads there.
///
/// The covariance decides: with slips and loads taken as known the steep beginning of a ramp weighs most, where in truth a
/// filter knows slips least. None where the run cannot be filtered or the true soil has no answer.
pub(super) fn nearest(bench: &Bench, truth: &[f64], run: &DriveRun) -> Option<String> {
    let filtered = robot::forces(&run.log, &bench.rover, &bench.options().filter, false).ok()?;
    let mut observations = vec![];
    for step in filtered.steps.iter().filter(|s| s.flag != Flag::Starting) {
        let Ok(side) = side_forces(&step.belief, &step.vehicle, Side::Left) else {
            continue;
        };
        let mut o = side_observation(&[&side], &filtered.vehicle, step.time, 0);
        let row = run.truth.time.partition_point(|t| *t < step.time - 1e-9);
        let mut wheels = vec![];
        // Front left and rear left.
        for (at, q) in o.contacts.iter_mut().zip([0, 2]) {
            at.slip = *run.truth.slip[q].get(row)?;
            at.normal_load = *run.truth.normal_load[q].get(row)?;
            wheels.push(bench.law.forces(truth, at).ok()?);
        }
        let [front, rear] = wheels.try_into().ok()?;
        let pull = front.drawbar_pull + rear.drawbar_pull;
        o.forces = nalgebra::dvector![pull, front.resistive_torque, rear.resistive_torque];
        observations.push(o);
    }
    let log_likelihood = |soil: &Terrain| -> Option<f64> {
        let p = soil.parameters(bench.law.model()).ok()?;
        let mut sum = 0.0;
        for o in &observations {
            match compare(&soil.id, &bench.law, &p, o, 0.0).ok()? {
                Comparison::Feasible(r) => sum += score(&r.value, &r.covariance)?.log_density,
                Comparison::Infeasible(_) => return Some(f64::NEG_INFINITY),
            }
        }
        Some(sum)
    };
    let mut best: Option<(f64, &Terrain)> = None;
    for soil in &bench.hypotheses {
        let found = log_likelihood(soil)?;
        if best.is_none_or(|(least, _)| found > least) {
            best = Some((found, soil));
        }
    }
    best.map(|(_, soil)| soil.id.to_string())
}
