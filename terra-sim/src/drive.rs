//! A drive: segments one after the other, sampled at the log's rate.

use std::array;

use terra_data::{DriveLog, Rover, Segment, Start};
use terra_model::Registry;

use crate::control::Control;
use crate::effects::{ActiveEffects, LogKind};
use crate::error::SimError;
use crate::force_table::ForceTable;
use crate::integrate::Integrator;
use crate::noise::{Roughness, Stream};
use crate::robot::{Instant, PATH, Robot, SPEED, STATES, Surroundings, WHEELS_AT, YAW_RATE};
use crate::scenario::{DriveSegment, Scenario};
use crate::sensors::{self, Declared, SpeedHistory};
use crate::soil;
use crate::truth::DriveTruth;

/// A simulated drive.
#[derive(Clone, Debug)]
pub struct DriveRun {
    /// What the vehicle logged.
    pub log: DriveLog,
    /// What really happened, row by row.
    pub truth: DriveTruth,
}

/// Rows of one drive before it is refused: a guard against a slip of the pen in a duration or a rate.
const MAX_ROWS: f64 = 5e7;

/// Simulates a drive with 1 ms Runge-Kutta steps.
///
/// The torque of a scenario is what the motors deliver; the logged torque is what the torque sensor makes of it.
/// A segment of duration d has rows at its start, start + 1/rate, ... before its end; time runs on through segments.
///
/// # Errors
/// [`SimError`], with time and wheel when it happens on the way.
pub fn simulate_drive(
    scenario: &Scenario,
    rover: &Rover,
    registry: &Registry,
) -> Result<DriveRun, SimError> {
    simulate_drive_with(scenario, rover, registry, Integrator::default())
}

/// [`simulate_drive`] with another integrator.
///
/// # Errors
/// As there.
pub fn simulate_drive_with(
    scenario: &Scenario,
    rover: &Rover,
    registry: &Registry,
    integrator: Integrator,
) -> Result<DriveRun, SimError> {
    let nominal = rover.nominal_vehicle().ok_or(SimError::NotADrive {
        missing: "[vehicle]",
    })?;
    if scenario.segments.is_empty() {
        return Err(SimError::NotADrive {
            missing: "[[segment]]",
        });
    }
    check(scenario, rover)?;
    integrator.check()?;
    let model = registry.model(&scenario.model)?;
    let effects = ActiveEffects::new(&scenario.effects, &model, registry, LogKind::Drive)?;
    let ground = |terrain: &Start| -> Result<ForceTable, SimError> {
        ForceTable::new(&model, &effects, soil::parameters(terrain, &*model)?)
    };
    let roughness = |key: &str, stream: fn(usize) -> Stream| -> [Roughness; 4] {
        let sd = rover.noise.get(key).unwrap_or(0.0) * scenario.noise_scale;
        array::from_fn(|q| Roughness::new(scenario.seed, scenario.run, stream(q), sd))
    };
    let mut robot = Robot {
        ground: [ground(&scenario.left)?, ground(&scenario.right)?],
        effects: effects.clone(),
        force_roughness: roughness("roughness_N", Stream::ForceRoughness),
        torque_roughness: roughness("roughness_N_m", Stream::TorqueRoughness),
        warm: (0.0, -1.0),
    };

    let mut truth = DriveTruth::default();
    let mut history = SpeedHistory::default();
    let mut declared = Columns::default();
    let mut y = [0.0; STATES];
    let mut time = 0.0;
    let mut pass = 1;
    for (index, segment) in scenario.segments.iter().enumerate() {
        if index == 0 || segment.reset {
            y = initial(segment);
            pass = 1;
            robot.warm = (0.0, -1.0);
            history.begin(time, y[SPEED]);
        }
        pass = segment.pass.unwrap_or(pass);
        // Effects say what the vehicle of the file really is; what was loaded on purpose comes on top.
        let mut level = nominal;
        level.pitch = segment.pitch.unwrap_or(0.0);
        let mut car = robot.effects.vehicle(level);
        car.mass += segment.payload.unwrap_or(0.0);
        let around = Surroundings {
            vehicle: car,
            tow_load: segment.tow_load,
            pass,
        };
        let inertia = car.wheel_inertia + 0.25 * car.mass * car.wheel_radius * car.wheel_radius;
        let control = Control::new(segment, time, inertia);

        let first_row = truth.time.len();
        let rows = (segment.duration * scenario.rate - 1e-9).ceil().max(1.0) as usize;
        let end = time + segment.duration;
        for k in 0..rows {
            let from = time + k as f64 / scenario.rate;
            let to = if k + 1 == rows {
                end
            } else {
                time + (k + 1) as f64 / scenario.rate
            };
            let now = robot.instant(from, &y, &around, &control)?;
            record(&mut truth, from, &y, &now, &robot, car.pitch);
            declared.push(segment, pass);
            integrator.advance(
                &mut |t, y: &[f64; STATES]| robot.instant(t, y, &around, &control).map(|i| i.rate),
                from,
                to,
                &mut y,
                &mut |t, y| history.push(t, y[SPEED]),
            )?;
        }
        control.hand_over(&mut y);
        truth.segments.push(Segment {
            name: segment.name.clone(),
            rows: first_row..truth.time.len(),
        });
        time = end;
    }
    if let Some(z) = &truth.sinkage
        && z.iter().flatten().any(|z| z.is_nan())
    {
        truth.sinkage = None;
    }
    let declared = declared.finish(&scenario.segments);
    let log = sensors::log(&truth, &history, declared, scenario, rover, &robot.effects)?;
    Ok(DriveRun { log, truth })
}

fn check(scenario: &Scenario, rover: &Rover) -> Result<(), SimError> {
    let value = |quantity: &str, value: f64, expected: &'static str| {
        Err(SimError::Value {
            quantity: quantity.to_owned(),
            value,
            expected,
        })
    };
    if !(scenario.rate.is_finite() && scenario.rate > 0.0) {
        return value("rate_hz", scenario.rate, "a rate above 0");
    }
    if !(scenario.noise_scale.is_finite() && scenario.noise_scale >= 0.0) {
        return value("noise_scale", scenario.noise_scale, "a factor from 0");
    }
    if let Some(segment) = scenario
        .segments
        .iter()
        .find(|s| !(s.duration.is_finite() && s.duration > 0.0))
    {
        return value("duration_s", segment.duration, "a duration above 0");
    }
    let total: f64 = scenario
        .segments
        .iter()
        .map(|s| s.duration * scenario.rate)
        .sum();
    if total > MAX_ROWS {
        return value(
            "rows of the log",
            total,
            "at most 5e7: check duration_s and rate_hz",
        );
    }
    if !(rover.wheel.inertia > 0.0 && rover.wheel.inertia.is_finite()) {
        return value(
            "wheel.inertia_kg_m2",
            rover.wheel.inertia,
            "an inertia above 0 to turn a wheel",
        );
    }
    if let Some(v) = rover.vehicle {
        for (name, x) in [
            ("vehicle.mass_kg", v.mass),
            ("vehicle.yaw_inertia_kg_m2", v.yaw_inertia),
            ("vehicle.track_m", v.track),
            ("vehicle.wheelbase_m", v.wheelbase),
        ] {
            if !(x.is_finite() && x > 0.0) {
                return value(name, x, "a value above 0");
            }
        }
    }
    Ok(())
}

fn initial(segment: &DriveSegment) -> [f64; STATES] {
    let mut y = [0.0; STATES];
    let start = segment.start.unwrap_or_default();
    y[SPEED] = start.ground_speed;
    y[WHEELS_AT..WHEELS_AT + 4].copy_from_slice(&start.wheel_speed);
    y
}

fn record(
    truth: &mut DriveTruth,
    time: f64,
    y: &[f64; STATES],
    now: &Instant,
    robot: &Robot,
    pitch: f64,
) {
    truth.time.push(time);
    truth.ground_speed.push(y[SPEED]);
    truth.yaw_rate.push(y[YAW_RATE]);
    truth.accel_x.push(now.specific_force);
    truth.pitch.push(pitch);
    truth.distance.push(y[PATH]);
    truth
        .standstill
        .push(now.wheels.iter().any(|w| w.standstill));
    let sinkage = truth.sinkage.get_or_insert_with(Default::default);
    for (q, wheel) in now.wheels.iter().enumerate() {
        truth.wheel_speed[q].push(y[WHEELS_AT + q]);
        truth.wheel_torque[q].push(now.motor_torque[q]);
        truth.drawbar_pull[q].push(wheel.drawbar_pull);
        truth.resistive_torque[q].push(wheel.resistive_torque);
        sinkage[q].push(wheel.sinkage.unwrap_or(f64::NAN));
        let seen = wheel.contact.map(|c| robot.ground[q % 2].seen(&c));
        truth.slip[q].push(seen.map_or(wheel.slip, |c| c.slip));
        truth.normal_load[q].push(seen.map_or(wheel.normal_load, |c| c.normal_load));
    }
}

/// Declared columns under construction.
#[derive(Default)]
struct Columns {
    pitch: Vec<f64>,
    payload: Vec<f64>,
    pass: Vec<f64>,
}

impl Columns {
    fn push(&mut self, segment: &DriveSegment, pass: u32) {
        self.pitch.push(segment.pitch.unwrap_or(0.0));
        self.payload.push(segment.payload.unwrap_or(0.0));
        self.pass.push(f64::from(pass));
    }

    /// Only the columns that some segment declared.
    fn finish(self, segments: &[DriveSegment]) -> Declared {
        let keep =
            |values: Vec<f64>, given: bool| given.then(|| values.into_iter().map(Some).collect());
        Declared {
            pitch: keep(self.pitch, segments.iter().any(|s| s.pitch.is_some())),
            payload: keep(self.payload, segments.iter().any(|s| s.payload.is_some())),
            pass: keep(self.pass, segments.iter().any(|s| s.pass.is_some())),
        }
    }
}
