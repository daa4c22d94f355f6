//! What a drive leaves behind row by row: the truth, and the columns the operator declared.

use terra_data::Series;

use crate::instant::Instant;
use crate::loads::LoadedVehicle;
use crate::robot::{
    HEADING, LATERAL_SPEED, PATH, POSITION, Robot, SPEED, STATES, WHEELS_AT, YAW_RATE,
};
use crate::scenario::DriveSegment;
use crate::sensors::Declared;
use crate::truth::DriveTruth;

/// Appends one row of truth.
pub(crate) fn record(
    truth: &mut DriveTruth,
    time: f64,
    y: &[f64; STATES],
    now: &Instant,
    robot: &Robot,
    vehicle: &LoadedVehicle,
) {
    truth.time.push(time);
    truth.ground_speed.push(y[SPEED]);
    truth.lateral_speed.push(y[LATERAL_SPEED]);
    truth.yaw_rate.push(y[YAW_RATE]);
    truth.accel_x.push(now.specific_force);
    truth.accel_y.push(now.side_force);
    truth.pitch.push(vehicle.car.pitch);
    truth.roll.push(vehicle.roll);
    truth.distance.push(y[PATH]);
    truth.heading.push(y[HEADING]);
    truth.position[0].push(y[POSITION]);
    truth.position[1].push(y[POSITION + 1]);
    truth
        .standstill
        .push(now.wheels.iter().any(|w| w.standstill));
    let sinkage = truth.sinkage.get_or_insert_with(Default::default);
    for (q, wheel) in now.wheels.iter().enumerate() {
        let (torque, speed) = readings(time, y, now, robot, vehicle, q);
        truth.torque_reading[q].push(torque);
        truth.speed_reading[q].push(speed);
        truth.wheel_speed[q].push(y[WHEELS_AT + q]);
        truth.wheel_torque[q].push(now.motor_torque[q]);
        truth.drawbar_pull[q].push(wheel.drawbar_pull);
        truth.lateral_force[q].push(wheel.lateral_force);
        truth.resistive_torque[q].push(wheel.resistive_torque);
        sinkage[q].push(wheel.sinkage.unwrap_or(f64::NAN));
        let position = y[PATH] + vehicle.wheel(q).0;
        let seen = wheel.contact.map(|c| robot.ground.seen(q, position, &c));
        truth.slip[q].push(seen.map_or(wheel.slip, |c| c.slip));
        truth.slip_angle[q].push(wheel.contact.map_or(0.0, |c| c.slip_angle));
        truth.normal_load[q].push(seen.map_or(wheel.normal_load, |c| c.normal_load));
    }
}

/// Torque and wheel speed as off-library effects let the sensors see them.
fn readings(
    time: f64,
    y: &[f64; STATES],
    now: &Instant,
    robot: &Robot,
    vehicle: &LoadedVehicle,
    q: usize,
) -> (f64, f64) {
    let torque = now.motor_torque[q];
    let view = robot.view(q, time, y, vehicle.car.wheel_radius, torque);
    robot
        .effects
        .unlisted()
        .fold((torque, y[WHEELS_AT + q]), |(t, w), (effect, e, memory)| {
            let at = Robot::recall(&view, memory, y);
            (
                effect.torque_reading(e, &at, t),
                effect.speed_reading(e, &at, w),
            )
        })
}

/// Declared columns under construction.
#[derive(Default)]
pub(crate) struct Columns {
    pitch: Vec<f64>,
    roll: Vec<f64>,
    payload: Vec<f64>,
    pass: Vec<f64>,
}

impl Columns {
    pub(crate) fn push(&mut self, segment: &DriveSegment, pass: u32) {
        self.pitch.push(segment.pitch.unwrap_or(0.0));
        self.roll.push(segment.roll.unwrap_or(0.0));
        self.payload.push(segment.payload.unwrap_or(0.0));
        self.pass.push(f64::from(pass));
    }

    /// Only the columns that some segment declared.
    pub(crate) fn finish(self, segments: &[DriveSegment]) -> Declared {
        let keep = |values: Vec<f64>, given: bool| -> Option<Series> {
            given.then(|| values.into_iter().map(Some).collect())
        };
        Declared {
            pitch: keep(self.pitch, segments.iter().any(|s| s.pitch.is_some())),
            roll: keep(self.roll, segments.iter().any(|s| s.roll.is_some())),
            payload: keep(self.payload, segments.iter().any(|s| s.payload.is_some())),
            pass: keep(self.pass, segments.iter().any(|s| s.pass.is_some())),
        }
    }
}
