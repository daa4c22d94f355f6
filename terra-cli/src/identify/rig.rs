//! Rig logs: each row is one contact, weighed as it is.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_data::{Measured, RigLog, RigRow, Rover, SoilSharing};
use terra_mme::{AlarmRule, ForceObservation, HypothesisSet};
use terra_model::catalogue::Terrain;
use terra_model::{Contact, Registry};

use super::{Identification, IdentifyOptions, Job, Samples};
use crate::error::CliError;

/// Identifies the soil under a rig's wheel; conditions with their own soil are groups of their own.
///
/// # Errors
/// A configuration that makes no sense, a channel without noise level, or no row that can be weighed.
pub fn identify_rig(
    log: &RigLog,
    rover: &Rover,
    registry: &Registry,
    terrains: &[Terrain],
    options: &IdentifyOptions,
) -> Result<Identification, CliError> {
    let law = Arc::new(registry.law(&rover.terrain.model)?);
    let set = HypothesisSet::from_terrains(&law, terrains)?;
    identify_rig_among(log, rover, &set, options)
}

/// As [`identify_rig`], among hypotheses of any laws.
///
/// # Errors
/// As there.
pub fn identify_rig_among(
    log: &RigLog,
    rover: &Rover,
    set: &HypothesisSet,
    options: &IdentifyOptions,
) -> Result<Identification, CliError> {
    let name = options
        .estimator
        .clone()
        .unwrap_or_else(|| "wheel".to_owned());
    let job = Job {
        set,
        rover,
        options,
        estimator: &name,
        whitening: None,
        alarm: AlarmRule::default(),
    };
    let mut samples = Samples {
        rows: log.rows.len() + log.dropped.len(),
        ..Samples::default()
    };
    samples.rejected = log.dropped.len();

    let mut groups: BTreeMap<String, Vec<ForceObservation>> = BTreeMap::new();
    for (k, row) in log.rows.iter().enumerate() {
        let (low, high) = rover.gap.slip_range;
        if !(low..=high).contains(&row.slip.value) || row.slip_angle.is_some_and(|a| a.abs() > 1e-6)
        {
            samples.rejected += 1;
            continue;
        }
        let own = rover
            .conditions
            .get(&row.condition)
            .is_some_and(|c| c.soil == SoilSharing::Own);
        let group = if own {
            row.condition.clone()
        } else {
            "all".to_owned()
        };
        match observation(row, k, rover)? {
            Some(o) => {
                samples.used += 1;
                groups.entry(group).or_default().push(o);
            }
            None => samples.missing += 1,
        }
    }
    let mut out = vec![];
    for (name, observations) in &groups {
        let (group, refused) = job.group(name, observations)?;
        samples.used -= refused;
        samples.rejected += refused;
        out.push(group);
    }
    if out.is_empty() {
        return Err(CliError::data(
            "no row of the log can be weighed",
            "each row needs slip, load and at least one of drawbar_pull_N, torque_N_m, sinkage_m",
        ));
    }
    Ok(Identification {
        log_kind: "rig",
        filter: None,
        estimator: name.clone(),
        choice: options.choice.clone(),
        prewhiten_rho: None,
        samples,
        flags: Vec::new(),
        near_duplicates: Vec::new(),
        groups: out,
    })
}

fn observation(
    row: &RigRow,
    k: usize,
    rover: &Rover,
) -> Result<Option<ForceObservation>, CliError> {
    let sd = |m: &Measured, key: &str| {
        m.sd.or_else(|| rover.noise.get(key)).ok_or_else(|| {
            CliError::rover(
                format!("no noise level for '{key}'"),
                format!("add {key} = ... (1-sigma) to [noise], or a sd column to the log"),
            )
        })
    };
    let outputs: Vec<(usize, &Measured, &str)> = [
        (0, &row.drawbar_pull, "drawbar_pull_N"),
        (1, &row.torque, "torque_N_m"),
        (2, &row.sinkage, "sinkage_m"),
    ]
    .into_iter()
    .filter_map(|(column, m, key)| m.as_ref().map(|m| (column, m, key)))
    .collect();
    if outputs.is_empty() {
        return Ok(None);
    }
    let wheel = rover.wheel_of(&row.condition);
    let m = outputs.len();
    let mut map = DMatrix::zeros(m, 3);
    let mut covariance = DMatrix::zeros(m + 2, m + 2);
    for (r, (column, measured, key)) in outputs.iter().enumerate() {
        map[(r, *column)] = 1.0;
        covariance[(r, r)] = sd(measured, key)?.powi(2);
    }
    covariance[(m, m)] = sd(&row.slip, "slip")?.powi(2);
    covariance[(m + 1, m + 1)] = sd(&row.normal_load, "normal_load_N")?.powi(2);
    let mut at = Contact::new(
        row.slip.value,
        row.normal_load.value,
        wheel.radius,
        wheel.width,
    );
    at.speed = row.travel_speed.unwrap_or(0.0);
    at.wheel_speed = row.wheel_speed.unwrap_or(0.0);
    at.earlier_passes = f64::from(row.pass.max(1)) - 1.0;
    // The rig's torque is measured at the axle, bearing damping included where the wheel speed is known.
    let damping = wheel.damping * at.wheel_speed;
    let forces = DVector::from_iterator(
        m,
        outputs
            .iter()
            .map(|(c, v, _)| if *c == 1 { v.value - damping } else { v.value }),
    );
    Ok(Some(ForceObservation {
        time: k as f64,
        group: k,
        forces,
        map,
        contacts: vec![at],
        covariance,
    }))
}
