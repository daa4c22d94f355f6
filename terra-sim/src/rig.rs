//! A single-wheel testbed: steady trials on the grid slip x load x repeat, and ramps of slip.
//!
//! The grid is what the rig really does; slip and load in the log are what its sensors make of it. `roughness_N` and
//! `roughness_N_m` of `[noise]` scatter the steady pull and torque from row to row. At slip 1 the wheel spins in
//! place: its travel speed is 0 and its own speed unknown.

use terra_data::{Measured, RigLog, RigRow, Rover, WheelData};
use terra_model::{
    Channel, Contact, ForceLaw, Law, ModelError, Motion, Registry, Vehicle, library_slip,
};

use crate::effects::{ActiveEffects, LogKind};
use crate::error::SimError;
use crate::force_table::Forces;
use crate::noise::{Stream, White};
use crate::off_library::WheelView;
use crate::programme::{Point, contact, points};
use crate::robot::GRAVITY;
use crate::scenario::Scenario;
use crate::sensors::sd_of;
use crate::soil;
use crate::truth::RigTruth;

/// A simulated set of rig trials.
#[derive(Clone, Debug)]
pub struct RigRun {
    /// What the rig logged.
    pub log: RigLog,
    /// What really happened, row by row.
    pub truth: RigTruth,
}

/// Rows of one rig log before it is refused.
const MAX_ROWS: usize = 10_000_000;

/// Sensors of the rig. Pull, torque and sinkage exist where `[noise]` names them.
struct Sensors {
    slip: Option<White>,
    travel_speed: Option<White>,
    rim_speed: Option<White>,
    load: White,
    pull: Option<White>,
    torque: Option<White>,
    sinkage: Option<White>,
    force_roughness: White,
    torque_roughness: White,
}

impl Sensors {
    fn new(scenario: &Scenario, rover: &Rover) -> Result<Self, SimError> {
        let scale = scenario.noise_scale;
        let white = |stream: Stream, sd: f64| White::new(scenario.seed, scenario.run, stream, sd);
        let named =
            |key: &str, stream: Stream| rover.noise.get(key).map(|sd| white(stream, sd * scale));
        let (pull, torque, sinkage) = (
            named("drawbar_pull_N", Stream::RigDrawbarPull),
            named("torque_N_m", Stream::RigTorque),
            named("sinkage_m", Stream::RigSinkage),
        );
        if pull.is_none() && torque.is_none() && sinkage.is_none() {
            return Err(SimError::MissingNoise {
                key: "drawbar_pull_N, torque_N_m or sinkage_m".to_owned(),
            });
        }
        let (slip, travel_speed, rim_speed) = (
            named("slip", Stream::RigSlip),
            named("travel_speed_m_s", Stream::RigTravelSpeed),
            named("rim_speed_m_s", Stream::RigRimSpeed),
        );
        if slip.is_none() && travel_speed.is_none() && rim_speed.is_none() && scale > 0.0 {
            return Err(SimError::MissingNoise {
                key: "slip".to_owned(),
            });
        }
        let roughness = |key: &str| rover.noise.get(key).unwrap_or(0.0) * scale;
        Ok(Sensors {
            slip,
            travel_speed,
            rim_speed,
            load: white(
                Stream::RigLoad,
                sd_of(&rover.noise, "normal_load_N", scale)?,
            ),
            pull,
            torque,
            sinkage,
            force_roughness: white(Stream::RigForceRoughness, roughness("roughness_N")),
            torque_roughness: white(Stream::RigTorqueRoughness, roughness("roughness_N_m")),
        })
    }

    /// Slip, travel speed and rim speed as measured; drawn again while they are no slip at all (a truncated normal).
    fn slip(&mut self, truth: f64, speeds: Option<(f64, f64)>) -> (f64, Option<(f64, f64)>) {
        let draw = |white: &mut Option<White>| white.as_mut().map_or(0.0, White::draw);
        for _ in 0..1000 {
            let shift = draw(&mut self.slip);
            let (dv, du) = (draw(&mut self.travel_speed), draw(&mut self.rim_speed));
            let measured = speeds.map(|(v, u)| (v + dv, u + du));
            let from_speeds = match (measured, speeds) {
                (Some((v, u)), Some(_)) if (dv != 0.0 || du != 0.0) && v >= 0.0 && u >= 0.0 => {
                    library_slip(u, v)
                }
                (Some(_), Some(_)) if dv != 0.0 || du != 0.0 => f64::NAN,
                _ => truth,
            };
            let slip = if self.slip.is_some() {
                truth + shift
            } else {
                from_speeds
            };
            if (-1.0..=1.0).contains(&slip) {
                return (slip, measured);
            }
        }
        (truth, speeds)
    }
}

/// Simulates the trials of a rig.
///
/// # Errors
/// [`SimError`]; a soil that does not carry a load at some slip is [`ModelError::NoEquilibrium`] inside
/// [`SimError::Trial`].
pub fn simulate_rig(
    scenario: &Scenario,
    rover: &Rover,
    registry: &Registry,
) -> Result<RigRun, SimError> {
    if !rover.is_rig() {
        return Err(SimError::NotARig {
            missing: "the rover has [vehicle]",
        });
    }
    if scenario.trials.is_empty() {
        return Err(SimError::NotARig {
            missing: "the scenario has no [[trial]]",
        });
    }
    let rows: usize = scenario
        .trials
        .iter()
        .map(|t| {
            t.slip
                .len()
                .saturating_mul(t.normal_load.len())
                .saturating_mul(t.repeats as usize)
        })
        .fold(0, usize::saturating_add);
    if rows > MAX_ROWS {
        return Err(SimError::Value {
            quantity: "rows of the log".to_owned(),
            value: rows as f64,
            expected: "at most 1e7",
        });
    }
    let model = registry.model(&scenario.model)?;
    let effects = ActiveEffects::new(&scenario.effects, &model, registry, LogKind::Rig)?;
    let soil = soil::parameters(&scenario.left, &*model)?;
    let law = effects.law(&model)?;
    let parameters = effects.parameters(&soil);
    let mut sensors = Sensors::new(scenario, rover)?;

    let mut hold = White::new(
        scenario.seed,
        scenario.run,
        Stream::RigLoadHold,
        scenario.world.load_hold,
    );

    let mut truth = RigTruth {
        sinkage: Some(Vec::new()),
        ..RigTruth::default()
    };
    let mut log = RigLog::default();
    let mut number = 0;
    for trial in &scenario.trials {
        let wheel = rover.wheel_of(&trial.condition);
        for point in points(trial) {
            let Point { slip, load, .. } = point;
            number += usize::from(point.begins);
            let mut wanted = contact(trial, &wheel, slip, load)?;
            wanted.time = point.time.unwrap_or(0.0);
            wanted.path = trial.travel_speed * wanted.time;
            let speeds = (slip < 1.0).then_some((wanted.speed, wheel.radius * wanted.wheel_speed));
            let mut known: Option<(f64, Steady)> = None;
            for _ in 0..point.repeats {
                // A load held exactly needs the model once.
                let held = load * (1.0 + hold.draw()).max(0.1);
                let steady = match known {
                    Some((at, steady)) if at == held => steady,
                    _ => {
                        let mut at = wanted;
                        at.normal_load = held;
                        steady_state(&effects, &law, &parameters, &soil, &wheel, &at).map_err(
                            |source| SimError::Trial {
                                trial: number,
                                slip,
                                load: held,
                                source,
                            },
                        )?
                    }
                };
                known = Some((held, steady));
                let Steady { forces, seen, loss } = steady;
                let at = wanted;
                let pull = forces.drawbar_pull + sensors.force_roughness.draw();
                let resistive = forces.resistive_torque + sensors.torque_roughness.draw();
                let torque = resistive + loss;
                truth.slip.push(seen.slip);
                truth.normal_load.push(seen.normal_load);
                truth.drawbar_pull.push(pull);
                truth.torque.push(torque);
                truth.resistive_torque.push(resistive);
                truth.travel_speed.push(at.speed);
                if let Some(z) = &mut truth.sinkage {
                    z.push(forces.sinkage.unwrap_or(f64::NAN));
                }
                let report = |channel: Channel, value: f64, white: &mut Option<White>| {
                    white
                        .as_mut()
                        .map(|w| measured(effects.report(channel, value) + w.draw()))
                };
                // Slip is read from the speeds.
                let told = speeds.map(|(v, u)| (effects.report(Channel::GroundSpeed, v), u));
                let slip_told = match told {
                    Some((v, _)) if v < 0.0 => {
                        return Err(SimError::Value {
                            quantity: "reported travel speed in m/s".to_owned(),
                            value: v,
                            expected: "0 or more: the error of the speed is larger than the speed",
                        });
                    }
                    Some((v, u)) if told != speeds => library_slip(u, v),
                    _ => slip,
                };
                let (slip_read, speeds_read) = sensors.slip(slip_told, told);
                let load_read = effects.report(Channel::NormalLoad, held) + sensors.load.draw();
                log.rows.push(RigRow {
                    // Row of the file the log becomes, below its header.
                    line: log.rows.len() as u64 + 2,
                    trial: format!("trial_{number:03}"),
                    condition: trial.condition.clone(),
                    pass: trial.pass,
                    time: point.time,
                    slip: measured(slip_read),
                    normal_load: measured(load_read),
                    drawbar_pull: report(Channel::DrawbarPull, pull, &mut sensors.pull),
                    torque: report(Channel::WheelTorque, torque, &mut sensors.torque),
                    sinkage: forces
                        .sinkage
                        .and_then(|z| report(Channel::Sinkage, z, &mut sensors.sinkage)),
                    side_force: None,
                    slip_angle: None,
                    travel_speed: Some(speeds_read.map_or(0.0, |(v, _)| v)),
                    wheel_speed: speeds_read.map(|(_, u)| u / wheel.radius),
                });
            }
        }
    }
    if truth
        .sinkage
        .as_ref()
        .is_some_and(|z| z.iter().any(|z| z.is_nan()))
    {
        truth.sinkage = None;
    }
    Ok(RigRun { log, truth })
}

/// What a wheel settles to.
#[derive(Clone, Copy)]
struct Steady {
    forces: Forces,
    /// The contact the soil sees.
    seen: Contact<f64>,
    /// Torque beside the soil's \[N m\].
    loss: f64,
}

fn steady_state(
    effects: &ActiveEffects,
    law: &Law,
    parameters: &[f64],
    soil: &[f64],
    wheel: &WheelData,
    at: &Contact<f64>,
) -> Result<Steady, ModelError> {
    // A rig has no angle, no memory and one wheel.
    let view = WheelView {
        wheel: 0,
        angle: 0.0,
        wheel_speed: at.wheel_speed,
        mate_speed: at.wheel_speed,
        speed: at.speed,
        torque: 0.0,
        radius: wheel.radius,
        time: 0.0,
        memory: 0.0,
    };
    let at = effects.unlisted().fold(*at, |contact, (effect, e, _)| {
        effect.contact(e, &view, contact)
    });
    let mut forces = Forces::from(law.forces(parameters, &at)?);
    let mut loss = losses(effects, wheel, &at, forces.resistive_torque);
    for (effect, e, _) in effects.unlisted() {
        forces.drawbar_pull = effect.pull(e, &view, forces.drawbar_pull);
        loss += effect.loss(e, &view);
    }
    Ok(Steady {
        forces,
        seen: effects.contact(law.model(), soil, &at),
        loss,
    })
}

fn measured(value: f64) -> Measured {
    Measured { value, sd: None }
}

/// Torque beside the soil's that the motor delivers: bearing damping and what effects add \[N m\].
fn losses(effects: &ActiveEffects, wheel: &WheelData, at: &Contact<f64>, resistive: f64) -> f64 {
    let damping = wheel.damping * at.wheel_speed;
    // A rig is a wheel on a carriage: no body whose geometry an effect could ask for.
    let carriage = Vehicle {
        mass: at.normal_load / GRAVITY,
        yaw_inertia: 0.0,
        track: 0.0,
        wheelbase: 0.0,
        cg_to_front_axle: 0.0,
        cg_height: 0.0,
        yaw_damping: 0.0,
        wheel_radius: wheel.radius,
        wheel_width: wheel.width,
        wheel_inertia: wheel.inertia,
        wheel_damping: wheel.damping,
        pitch: 0.0,
    };
    let motion = Motion {
        speed: at.speed,
        acceleration: 0.0,
        yaw_rate: 0.0,
        wheel_speed: [at.wheel_speed; 4],
        wheel_torque: [resistive + damping; 4],
        path: at.path,
        time: at.time,
    };
    damping + effects.loads(&carriage, &motion).wheel_torque[0]
}
