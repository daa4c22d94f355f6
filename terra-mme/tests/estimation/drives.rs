//! Simulated drives as a bank of vehicle filters is fed them.

use terra_mme::{MotionNoise, MotionSample, Plant, SoilMaps};
use terra_model::Registry;
use terra_sim::{Scenario, StartMotion, paper, simulate_drive};

use crate::common::wong21;

pub(crate) fn plant() -> Plant {
    let vehicle = paper::light_rover().nominal_vehicle().unwrap();
    Plant::new(vehicle, MotionNoise::default()).unwrap()
}

pub(crate) fn maps() -> SoilMaps {
    SoilMaps::new(wong21(), plant().vehicle()).unwrap()
}

pub(crate) fn drive(scenario: &Scenario) -> Vec<MotionSample> {
    let rover = paper::light_rover();
    let log = simulate_drive(scenario, &rover, &Registry::builtin())
        .unwrap()
        .log;
    let torque = log.wheel_torque.unwrap();
    let known = |column: &Option<terra_data::Series>, k: usize| {
        column.as_ref().and_then(|c| c.get(k)).unwrap_or(0.0)
    };
    (0..log.time.len())
        .map(|k| {
            let w = |q: usize| log.wheel_speed[q].get(k);
            MotionSample {
                time: log.time[k],
                group: 0,
                torque: std::array::from_fn(|q| torque[q].get(k).unwrap()),
                pitch: known(&log.pitch, k),
                payload: known(&log.payload, k),
                channels: [
                    log.accel_x.as_ref().unwrap().get(k),
                    w(0),
                    w(1),
                    w(2),
                    w(3),
                    log.ground_speed.as_ref().unwrap().get(k),
                    log.yaw_rate.as_ref().unwrap().get(k),
                ],
            }
        })
        .collect()
}

/// The torque ramp on a soil, noise draw `run`.
pub(crate) fn ramp(soil: &str, run: u64) -> Vec<MotionSample> {
    let mut scenario = paper::torque_ramp(soil, 1).unwrap();
    scenario.run = run;
    drive(&scenario)
}

/// One second of the ramp of `first`, then at once one second at the same torques on `second`.
pub(crate) fn switch(first: &str, second: &str, run: u64) -> (Vec<MotionSample>, usize) {
    let rover = paper::light_rover();
    let mut scenario = paper::torque_ramp(first, 1).unwrap();
    scenario.run = 2 * run;
    scenario.segments[0].duration = 1.0;
    let mut samples = drive(&scenario);
    let n = samples.len();
    let mut quiet = scenario.clone();
    quiet.segments[0].duration = 1.01;
    let truth = simulate_drive(&quiet, &rover, &Registry::builtin())
        .unwrap()
        .truth;
    let mut after = paper::torque_ramp(second, 1).unwrap();
    after.run = 2 * run + 1;
    after.segments[0].duration = 1.0;
    after.segments[0].start = Some(StartMotion {
        ground_speed: truth.ground_speed[n],
        wheel_speed: std::array::from_fn(|q| truth.wheel_speed[q][n]),
    });
    samples.extend(drive(&after).into_iter().map(|mut s| {
        s.time += 1.0;
        s
    }));
    (samples, n)
}
