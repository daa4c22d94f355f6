//! A drive: segments one after the other, sampled at the log's rate.

use std::array;
use std::cell::RefCell;

use terra_data::{DriveLog, Rover, Segment};
use terra_model::Registry;

use crate::control::Control;
use crate::effects::{ActiveEffects, LogKind};
use crate::error::SimError;
use crate::ground::{Ground, Ruts};
use crate::history::History;
use crate::instant::Warm;
use crate::integrate::{DormandPrince, Integrator, Pace, Step};
use crate::loads::LoadedVehicle;
use crate::noise::{RoughGround, Roughness, Stream};
use crate::record::{Columns, record};
use crate::robot::{Robot, SPEED, STATES, Surroundings, WHEELS_AT};
use crate::scenario::{DriveSegment, Scenario, SideSlip};
use crate::sensors;
use crate::truth::DriveTruth;

/// A simulated drive.
#[derive(Clone, Debug)]
pub struct DriveRun {
    /// What the vehicle logged.
    pub log: DriveLog,
    /// What really happened, row by row.
    pub truth: DriveTruth,
}

/// Rows of one drive before it is refused, eleven days at 10 Hz: a guard against a slip of the pen in a duration or a rate.
/// A drive is in memory as a whole, about 500 bytes a row.
const MAX_ROWS: f64 = 1e7;
/// Duration of one drive \[s\] before it is refused, eleven days: few rows may take as many steps.
const MAX_DURATION: f64 = 1e6;

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
/// Steps of an adaptive one run past the rows, whose states are those of the solution inside a step; the forces of a row
/// are evaluated at its state. On ground that changes on short stretches (patches, ruts, stones) steps are 10 ms at most.
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
    let roughness = |key: &str, stream: fn(usize) -> Stream| -> [Roughness; 4] {
        let sd = rover.noise.get(key).unwrap_or(0.0) * scenario.noise_scale;
        array::from_fn(|q| Roughness::new(scenario.seed, scenario.run, stream(q), sd))
    };
    let mut robot = Robot {
        ground: Ground::new(scenario, &model, &effects)?,
        effects: effects.clone(),
        rough: RoughGround::new(
            roughness("roughness_N", Stream::ForceRoughness),
            roughness("roughness_N_m", Stream::TorqueRoughness),
        ),
        slides: scenario.world.side_slip == SideSlip::Free,
        ruts: None,
        warm: Warm::COLD,
        known: None,
    };
    let watched = robot.watched(scenario.world.motor.lag > 0.0);

    let mut truth = DriveTruth::default();
    let mut history = History::new(sensors::any_late(scenario, &effects));
    let mut declared = Columns::default();
    let mut y = [0.0; STATES];
    let mut time = 0.0;
    let mut pass = 1;
    let mut pace = Pace::default();
    for (index, segment) in scenario.segments.iter().enumerate() {
        if index == 0 || segment.reset {
            y = initial(segment);
            pass = 1;
            robot.warm = Warm::COLD;
            robot.known = None;
            pace = Pace::default();
            robot.ruts = scenario.world.ruts.then(|| Ruts::new(rover.wheel.width));
            history.begin(time, &y);
        }
        pass = segment.pass.unwrap_or(pass);
        // Effects say what the vehicle of the file really is; what was loaded on purpose comes on top.
        let mut level = nominal;
        level.pitch = segment.pitch.unwrap_or(0.0);
        let real = robot.effects.vehicle(level);
        let mut loaded = LoadedVehicle::with_payload(
            real,
            segment.payload.unwrap_or(0.0),
            segment.payload_at.unwrap_or_default(),
        );
        loaded.roll = segment.roll.unwrap_or(0.0);
        loaded.upright = scenario.world.upright;
        let car = loaded.car;
        let around = Surroundings {
            vehicle: loaded,
            tow_load: segment.tow_load,
            pass,
        };
        let inertia = car.wheel_inertia + 0.25 * car.mass * car.wheel_radius * car.wheel_radius;
        robot.known = None;
        let control = Control::new(segment, scenario.world.motor, time, inertia);

        let first_row = truth.time.len();
        let rows = (segment.duration * scenario.rate - 1e-9).ceil().max(1.0) as usize;
        let end = time + segment.duration;
        let when = |k: usize| match k == rows {
            true => end,
            false => time + k as f64 / scenario.rate,
        };
        // Rates, rows and steps all need the robot, one after the other.
        let shared = RefCell::new(&mut robot);
        let rate = &mut |t: f64, y: &[f64; STATES]| {
            let mut robot = shared.borrow_mut();
            robot.instant(t, y, &around, &control).map(|i| i.rate)
        };
        let mut row = |t: f64, y: &[f64; STATES]| -> Result<(), SimError> {
            let mut robot = shared.borrow_mut();
            let now = robot.instant(t, y, &around, &control)?;
            record(&mut truth, t, y, &now, &robot, &around.vehicle);
            if let Some(currents) = control.current(t, y) {
                let columns = truth.motor_current.get_or_insert_with(Default::default);
                for (column, current) in columns.iter_mut().zip(currents) {
                    column.push(current);
                }
            }
            declared.push(segment, pass);
            Ok(())
        };
        match integrator {
            Integrator::Rk4(method) => {
                for k in 0..rows {
                    row(when(k), &y)?;
                    let behind = &mut |t: f64, y: &[f64; STATES]| {
                        history.push(t, y);
                        shared.borrow_mut().leave_ruts(y, &around.vehicle);
                    };
                    method.through(watched, rate, when(k), when(k + 1), &mut y, behind)?;
                }
            }
            Integrator::DormandPrince(method) => {
                let longest = method.max_step.min(shared.borrow().longest_step());
                let method = DormandPrince {
                    max_step: longest,
                    ..method
                };
                row(time, &y)?;
                let mut next = 1;
                let behind = &mut |step: &Step<STATES>| {
                    while next < rows && when(next) <= step.end() {
                        row(when(next), &step.at(when(next)))?;
                        next += 1;
                    }
                    history.follow(step);
                    Ok(shared.borrow_mut().leave_ruts(step.last(), &around.vehicle))
                };
                method.through(watched, &mut pace, rate, time, end, &mut y, behind)?;
                for k in next..rows {
                    row(when(k), &y)?;
                }
            }
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
    let duration: f64 = scenario.segments.iter().map(|s| s.duration).sum();
    if duration > MAX_DURATION {
        return value(
            "duration_s of all segments",
            duration,
            "at most 1e6 s: check duration_s",
        );
    }
    // A segment has a row however short it is.
    let total: f64 = scenario
        .segments
        .iter()
        .map(|s| (s.duration * scenario.rate).max(1.0))
        .sum();
    if total > MAX_ROWS {
        return value(
            "rows of the log",
            total,
            "at most 1e7: check duration_s and rate_hz",
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
