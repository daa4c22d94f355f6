//! A drive log as a bank of vehicle filters is fed it, and what the bank says.

use terra_data::{DriveLog, GroundSpeedSource, Rover};
use terra_mme::{
    AT_SPEED, EstimatorError, ForceObservation, HypothesisSet, MotionNoise, MotionSample, Plant,
    SoilMaps, motion_estimator, side_bank,
};
use terra_model::Contact;

use super::{Group, Job};
use crate::error::CliError;
use crate::robot::Forces;

/// Everything a bank needs of a log.
pub(super) struct Motion {
    pub(super) plant: Plant,
    pub(super) maps: SoilMaps,
    pub(super) samples: Vec<MotionSample>,
}

impl Motion {
    /// The rows the force filter could use, with torques held over short gaps as it held them.
    pub(super) fn new(
        log: &DriveLog,
        rover: &Rover,
        set: &HypothesisSet,
        forces: &Forces,
    ) -> Result<Self, CliError> {
        let default = MotionNoise::default();
        let sd = |key: &str, otherwise: f64| rover.noise.get(key).unwrap_or(otherwise);
        let noise = MotionNoise {
            accel_x: sd("accel_x_m_s2", default.accel_x),
            wheel_speed: sd("wheel_speed_rad_s", default.wheel_speed),
            ground_speed: sd("ground_speed_m_s", default.ground_speed),
            yaw_rate: sd("yaw_rate_rad_s", default.yaw_rate),
            wheel_torque: sd("wheel_torque_N_m", default.wheel_torque),
            ..default
        };
        let plant = Plant::new(forces.vehicle, noise)?;
        let maps = SoilMaps::new(set.clone(), &forces.vehicle)?;
        let use_speed = rover.filter.ground_speed != GroundSpeedSource::None;
        let finite = |v: Option<f64>| v.filter(|v| v.is_finite());
        let samples = forces
            .steps
            .iter()
            .map(|step| {
                let row = step.row;
                let wheel = |q: usize| finite(log.wheel_speed[q].get(row));
                let other =
                    |s: &Option<terra_data::Series>| s.as_ref().and_then(|s| finite(s.get(row)));
                MotionSample {
                    time: step.time,
                    group: step.segment,
                    torque: step.torque,
                    pitch: step.vehicle.pitch - forces.vehicle.pitch,
                    payload: step.vehicle.mass - forces.vehicle.mass,
                    channels: [
                        other(&log.accel_x),
                        wheel(0),
                        wheel(1),
                        wheel(2),
                        wheel(3),
                        other(&log.ground_speed).filter(|_| use_speed),
                        other(&log.yaw_rate),
                    ],
                }
            })
            .collect();
        Ok(Motion {
            plant,
            maps,
            samples,
        })
    }

    /// No row has a ground speed.
    pub(super) fn without_ground_speed(&self) -> bool {
        self.samples.iter().all(|s| s.channels[AT_SPEED].is_none())
    }

    /// The groups of a bank: one soil under all wheels when `observations` has one entry, else one under each side.
    /// Observations serve the refinement alone. Also how many rows no soil of the set allows.
    pub(super) fn groups(
        &self,
        job: &Job<'_>,
        observations: &[&Vec<ForceObservation>],
    ) -> Result<(Vec<Group>, usize), CliError> {
        let (choice, history) = (&job.options.choice, job.options.history);
        let car = self.plant.vehicle();
        let standing = Contact::new(
            0.1,
            0.25 * car.mass * terra_sim::GRAVITY,
            car.wheel_radius,
            car.wheel_width,
        );
        let template = |o: &[ForceObservation]| {
            let first = o.first().and_then(|o| o.contacts.first());
            first.copied().unwrap_or(standing)
        };
        let mut refused = 0;
        let mut take = |told: Result<(), EstimatorError>| match told {
            Ok(()) => Ok(()),
            Err(EstimatorError::AllInfeasible { .. }) => {
                refused += 1;
                Ok(())
            }
            Err(e) => Err(CliError::from(e)),
        };
        let (maps, plant) = (self.maps.clone(), self.plant);
        let mut groups = vec![];
        if let [all] = observations {
            let mut bank = motion_estimator(job.estimator, maps, plant, choice, history)?;
            for sample in &self.samples {
                take(bank.update(sample))?;
            }
            groups.push(job.told("all", &*bank, all, &template(all))?);
        } else if let [left, right] = observations {
            let mut bank = side_bank(job.estimator, maps, plant, choice, history)?;
            for sample in &self.samples {
                take(bank.update(sample))?;
            }
            groups.push(job.told("left", &bank.left(), left, &template(left))?);
            groups.push(job.told("right", &bank.right(), right, &template(right))?);
        }
        if refused == self.samples.len() {
            return Err(CliError::data(
                "no row of the log could be weighed",
                "no soil of the set lets the vehicle drive like this",
            ));
        }
        Ok((groups, refused))
    }
}
