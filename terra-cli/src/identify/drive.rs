//! Drive logs: force filter, then side sums.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_data::{DriveLog, Rover};
use terra_ekf::{Flag, Side, SideForces, SlipState, Tally, side_forces};
use terra_mme::{AlarmRule, EstimatorInput, ForceObservation, HypothesisSet, Prewhitening};
use terra_model::catalogue::Terrain;
use terra_model::{Contact, Registry, Vehicle};

use super::alarm;
use super::motion::Motion;
use super::{Identification, IdentifyOptions, Job, Samples};
use crate::error::CliError;
use crate::robot::forces;

/// Correlation of the filter's force errors from one sample to the next at 100 Hz, measured on the reproduction of
/// Ray 2008 (.75 to .82).
const RHO: f64 = 0.8;
const RHO_INTERVAL: f64 = 0.01;
/// NIS/d of prewhitened side sums above which no soil explains them: whitening leaves some correlation, and above 1.5
/// one true soil in 25 would ring.
const SIDE_SUM_ALARM: f64 = 2.0;

/// Identifies the soil under each side of a vehicle (or under both, joined).
///
/// # Errors
/// A configuration that makes no sense, or a log without a sample that can be weighed.
pub fn identify_drive(
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    terrains: &[Terrain],
    options: &IdentifyOptions,
) -> Result<Identification, CliError> {
    let law = Arc::new(registry.law(&rover.terrain.model)?);
    let set = HypothesisSet::from_terrains(&law, terrains)?;
    identify_drive_among(log, rover, registry, &set, options)
}

/// As [`identify_drive`], among hypotheses of any laws.
///
/// # Errors
/// As there.
pub fn identify_drive_among(
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    set: &HypothesisSet,
    options: &IdentifyOptions,
) -> Result<Identification, CliError> {
    let forces = forces(log, rover, &options.filter, false)?;
    let whitening = Prewhitening::new(RHO, RHO_INTERVAL)?;
    let whitening = options.prewhiten.then_some(whitening);
    let name = options
        .estimator
        .clone()
        .unwrap_or_else(|| "side-sum".to_owned());
    let job = Job {
        set,
        rover,
        options,
        estimator: &name,
        whitening,
        alarm: AlarmRule {
            threshold: SIDE_SUM_ALARM,
            ..AlarmRule::default()
        },
    };
    let motion = Motion::new(log, rover, set, &forces)?;
    let of_motion = terra_mme::estimators()
        .iter()
        .any(|e| e.name == name && e.input == EstimatorInput::Motion);

    let mut samples = Samples {
        rows: log.len(),
        ..Samples::default()
    };
    samples.missing = Tally::of(&forces.steps).iter().map(|t| t.missing).sum();
    let mut sides: [Vec<ForceObservation>; 2] = [vec![], vec![]];
    let mut joined = vec![];
    // Errors of the filter are correlated from sample to sample until it starts anew: at a segment, and where it reset.
    let (mut run, mut segment) = (0, None);
    for step in &forces.steps {
        if segment.replace(step.segment) != Some(step.segment)
            || matches!(step.flag, Flag::Reset(_))
        {
            run += 1;
        }
        if step.flag == Flag::Starting {
            samples.waiting += 1;
            continue;
        }
        let both = [Side::Left, Side::Right].map(|side| {
            side_forces(&step.belief, &step.vehicle, side)
                .ok()
                .filter(|s| s.slip_state.iter().all(|state| *state == SlipState::Moving))
        });
        let (Some(left), Some(right)) = (&both[0], &both[1]) else {
            samples.rejected += 1;
            continue;
        };
        samples.used += 1;
        if options.join {
            joined.push(observation(&[left, right], &forces.vehicle, step.time, run));
        } else {
            for (k, side) in [left, right].into_iter().enumerate() {
                sides[k].push(observation(&[side], &forces.vehicle, step.time, run));
            }
        }
    }
    samples.rejected += log.len() - forces.steps.len();

    let mut groups = vec![];
    let mut refused = 0;
    if of_motion {
        let observations = if options.join {
            vec![&joined]
        } else {
            sides.iter().collect()
        };
        (groups, refused) = motion.groups(&job, &observations)?;
        samples.used = motion.samples.len();
        samples.waiting = 0;
        samples.rejected = log.len() - samples.used;
    } else if options.join {
        let (group, n) = job.group("all", &joined)?;
        groups.push(group);
        refused = n;
    } else {
        for (name, observations) in ["left", "right"].into_iter().zip(&sides) {
            let (group, n) = job.group(name, observations)?;
            groups.push(group);
            refused = refused.max(n);
        }
    }
    if options.check {
        alarm::raise(&mut groups, &motion, registry, options.explain)?;
    }
    samples.used -= refused;
    samples.rejected += refused;
    Ok(Identification {
        log_kind: "drive",
        filter: (!of_motion).then(|| options.filter.clone()),
        estimator: name.clone(),
        choice: options.choice.clone(),
        prewhiten_rho: (!of_motion && options.prewhiten).then_some(RHO),
        samples,
        flags: if motion.without_ground_speed() {
            vec!["no-ground-speed"]
        } else {
            vec![]
        },
        near_duplicates: Vec::new(),
        groups,
    })
}

/// Stacks one or two sides. Each side gives \[F_side, T_f, T_r\] against the sum of its pulls and each torque.
///
/// The errors of two sides are taken as independent: they share only the accelerometer and the speed. In reverse a wheel
/// meets the same soil mirrored: forces change their sign, slips and loads do not.
pub(crate) fn observation(
    sides: &[&SideForces],
    vehicle: &Vehicle<f64>,
    time: f64,
    run: usize,
) -> ForceObservation {
    let m = 3 * sides.len();
    let wheels = 2 * sides.len();
    let mut map = DMatrix::zeros(m, 3 * wheels);
    let mut covariance = DMatrix::zeros(m + 2 * wheels, m + 2 * wheels);
    let mut values = DVector::zeros(m);
    let mut contacts = vec![];
    for (s, side) in sides.iter().enumerate() {
        let (row, column) = (3 * s, 6 * s);
        map[(row, column)] = 1.0;
        map[(row, column + 3)] = 1.0;
        map[(row + 1, column + 1)] = 1.0;
        map[(row + 2, column + 4)] = 1.0;
        // Places of the side's seven numbers in the stacked vector: forces first, then slip and load of each wheel.
        let places: Vec<usize> = (0..3)
            .map(|k| row + k)
            .chain((0..4).map(|k| m + 4 * s + k))
            .collect();
        let forward = if side.travel_speed < 0.0 { -1.0 } else { 1.0 };
        let sign = |k: usize| if k < 3 { forward } else { 1.0 };
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                covariance[(a, b)] = sign(i) * sign(j) * side.covariance[(i, j)];
            }
        }
        for k in 0..3 {
            values[row + k] = forward * side.vector[k];
        }
        for wheel in 0..2 {
            let mut at = Contact::new(
                side.vector[3 + 2 * wheel],
                side.vector[4 + 2 * wheel],
                vehicle.wheel_radius,
                vehicle.wheel_width,
            );
            at.speed = side.travel_speed;
            at.wheel_speed = side.wheel_speed[wheel];
            at.yaw_rate = side.yaw_rate;
            at.side = side.side.sign();
            let leads = (wheel == 0) == (side.travel_speed >= 0.0);
            at.earlier_passes = if leads { 0.0 } else { 1.0 };
            at.time = time;
            contacts.push(at);
        }
    }
    ForceObservation {
        time,
        group: run,
        forces: values,
        map,
        contacts,
        covariance,
    }
}
