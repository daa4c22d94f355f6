//! Drive logs without torques: a kinematic diagnosis.
//!
//! Wheel speeds in, motion out. The nominal simulator is an ideal differential drive on ground with one longitudinal slip, one
//! compliance that may grow with the push, and one lag of the body, which are re-fitted as a soil's parameters are where forces are
//! logged. What the wheels push with is not asked, so an effect takes part only if it has a kinematic reading ([`effects`]).
//!
//! # Equation
//! u_q = R ω_q (1 - i_q/κ_q), i_q = i_0 + c_t sign(ω_q) p (1 + b |p|), p = a/g + sin θ, V_s = mean of a side's u_q;
//! v = (V_r + V_l)/2 - drag - τ a, r = (V_r - V_l)/(χ t_w), v_y = x_cg r,
//! with i_q the slip, i_0 at constant speed on level ground and more while a wheel pushes the vehicle the way it turns, to speed it up by
//! a = R ω' or to hold it on a slope θ that the log tells of, κ_q the
//! stiffness of the ground under the wheel relative to nominal, τ how far the body lags behind its wheels, χ the effective track over the
//! geometric one, and x_cg the centre of mass ahead of the middle of the axles.
//!
//! # Reference
//! J. L. Martínez, A. Mandow, J. Morales, S. Pedraza, A. García-Cerezo, Int. J. Robotics Research 24(10):867-878, 2005;
//! A. Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007 (instantaneous centres of
//! rotation of the treads, steering efficiency χ).

mod effects;
mod form;
mod ground;
mod predict;
mod read;
mod scatter;

use std::collections::BTreeMap;
use std::sync::Arc;

use terra_data::{DriveLog, Rover};
use terra_mme::{Centre, FitSpace, Priors};
use terra_model::{Law, Param, Registry, TerrainModel};

use crate::candidates::Candidates;
use crate::contrast::against;
use crate::dataset::{DataSet, Observation, Ranges};
use crate::diagnose::{Diagnosis, diagnose};
use crate::error::GapError;
use crate::logs::Logs;
use crate::settings::{LogKind, Settings};
use crate::setup::Setup;
use crate::soil_space::SoilSpace;

pub use effects::{SkidSteerCentres, SkidSteerDrag};
pub(crate) use form::MotionError;
pub use ground::UniformSlip;
pub use predict::KinematicPredictor;

/// Fewest windows from which something is said: below it, a scatter between windows cannot be told from an effect.
const FEWEST: usize = 8;
/// Yaw rates over their noise, averaged over a window, from which a log holds turns.
const TURNING: f64 = 5.0;

/// How much sharper than a simulator's a turn may be, as a share of turning on the spot, to be as sharp.
const AS_SHARP: f64 = 0.05;

/// What to heed.
const BY_MOTION: &str = "no torques: a diagnosis by motion alone, in which [terrain] is not used and the ground is one re-fitted slip";
const TURNS: &str = "an ideal drive slips alike on both sides, and on no soil does a vehicle turn by as much as its wheels ask for: what is named of turns may be the soil's own, which a simulator with wheel forces has too (--sim compares with its log)";
const AGAINST: &str = "a log holds no torques: the two are compared by their motion alone, in which [terrain] is not used and the ground is one re-fitted slip";

/// Diagnoses a drive log by its motion alone.
///
/// # Errors
/// A rover file without vehicle, a used channel without noise level, or an unknown effect name.
pub fn diagnose_kinematic(
    log: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    diagnose_logs(&Logs::one(log), None, rover, registry, settings)
}

/// The same of several logs, alone or against an outside simulator's, which comes with whether it was given this very soil.
///
/// # Errors
/// As there; a simulator's log that tells nothing by its motion.
pub(crate) fn diagnose_logs(
    logs: &Logs<'_, DriveLog>,
    sim: Option<(&DriveLog, bool)>,
    rover: &Rover,
    registry: &Registry,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    let (known, silent) = effects::readable(registry, sim.is_some());
    let mut settings = settings.clone();
    if let Some(names) = &mut settings.effects {
        for name in names.iter() {
            registry.effect(name)?;
        }
        // Those that forces alone would show are reported as not asked, not refused.
        names.retain(|name| known.effect(name).is_ok());
    }
    let kind = LogKind::Kinematic;
    let (setup, baseline) = match sim {
        None => {
            let law = ideal_drive()?;
            let ground = free_ground(&law, rover)?;
            let setup = Setup {
                registry: &known,
                rover,
                law,
                soil: Arc::new(SoilSpace::new(ground, logs.labels())),
                structures: vec![],
                without: vec![],
                kind,
                inherited: None,
            };
            (setup, None)
        }
        Some((sim, same_soil)) => {
            let sim = Logs::one(sim);
            let (data, predictor) = read::from_logs(&sim, rover, true)?;
            if let Some(reason) = refusal(&data, &sim, rover) {
                return Err(GapError::Simulator(reason));
            }
            let labels = logs.labels();
            let (setup, baseline) = against(
                data, &predictor, &known, rover, kind, &settings, same_soil, labels,
            )?;
            (setup, Some(baseline))
        }
    };
    let (mut data, predictor) = read::from_logs(logs, rover, baseline.is_some())?;
    if let Some(inherited) = &setup.inherited {
        within(&mut data, &inherited.ranges);
    }
    let mut found = match refusal(&data, logs, rover) {
        Some(reason) => Diagnosis::unidentifiable(data, &setup, Candidates::default(), reason),
        None => diagnose(data, &predictor, &setup, &settings)?,
    };
    let (how, alone) = match baseline {
        Some(_) => (AGAINST, false),
        None => (BY_MOTION, true),
    };
    found.notice(how.to_owned());
    let skids = |answer: &String| answer.split('+').any(|name| name == effects::SKID);
    if alone && found.set.iter().any(skids) {
        found.notice(TURNS.to_owned());
    }
    found.baseline = baseline;
    found.not_asked.extend(silent);
    found.logs = logs.joined();
    isolate(&mut found, registry);
    Ok(found)
}

/// The nominal simulator.
///
/// # Errors
/// None that its own parameters cause.
pub(crate) fn ideal_drive() -> Result<Law, GapError> {
    Ok(Law::new(Arc::new(UniformSlip), vec![])?)
}

/// Its ground, re-fitted.
///
/// # Errors
/// A wheel without width.
pub(crate) fn free_ground(law: &Law, rover: &Rover) -> Result<FitSpace, GapError> {
    let zero = |p: &Param| (p.name.to_owned(), 0.0);
    let start: BTreeMap<String, f64> = UniformSlip::PARAMS.iter().map(zero).collect();
    let (centre, widths) = (Centre::Values(&start), [rover.wheel.width]);
    let space = FitSpace::new(law, centre, &widths, &Priors::default());
    space.map_err(|e| GapError::Soil(e.to_string()))
}

/// Leaves out windows that turn more sharply than any of the simulator's: what that would do there is not known.
fn within(data: &mut DataSet, ranges: &Ranges) {
    let (right, left) = ranges.get("turning").copied().unwrap_or_default();
    let most = left.abs().max(right.abs()) + AS_SHARP;
    let turning = |o: &Observation| o.factors.get("turning").map_or(0.0, |t| t.abs());
    let before = data.observations.len();
    data.observations.retain(|o| turning(o) <= most);
    let beyond = before - data.observations.len();
    if beyond > 0 {
        let reason = "turns more sharply than any of the simulator's";
        data.dropped.insert(reason.to_owned(), beyond);
    }
}

/// Why a log can say nothing, and what to record instead.
fn refusal(data: &DataSet, logs: &Logs<'_, DriveLog>, rover: &Rover) -> Option<String> {
    if logs.iter().all(|(_, log)| log.ground_speed.is_none()) {
        return Some(
            "no ground speed in the log: record ground_speed_m_s (visual odometry, lidar, GNSS), or wheel torques for a diagnosis of forces"
                .to_owned(),
        );
    }
    if logs.iter().all(|(_, log)| log.yaw_rate.is_none()) {
        return Some(
            "no yaw rate in the log: without it a turn cannot be seen; record yaw_rate_rad_s (a gyro, or the heading of the odometry)"
                .to_owned(),
        );
    }
    let count: usize = data.observations.len();
    if count == 0
        && data
            .dropped
            .keys()
            .any(|why| why.starts_with(read::STANDSTILL))
    {
        return Some(
            "standstill only: no wheel moves faster than 0.12 m/s; record drives at two speeds, straight and turning both ways"
                .to_owned(),
        );
    }
    if count < FEWEST {
        return Some(format!(
            "too short: {count} usable windows, fewer than {FEWEST}; record at least {FEWEST} windows ([gap] window_s) of driving, straight and turning both ways"
        ));
    }
    // The wheels' yaw rate is noisy by R/t_w times a wheel speed, two wheels a side.
    let arm = rover
        .nominal_vehicle()
        .map_or(0.0, |v| v.wheel_radius / v.track);
    let turns = data.observations.iter().any(|o| {
        let sd = |k: usize| o.raw_sd.get(k).copied().unwrap_or(0.0);
        let noise = sd(predict::YAW_RATE).max(arm * sd(predict::WHEEL));
        let yaw = ["yaw_rate", "measured_yaw_rate"]
            .iter()
            .filter_map(|f| o.factors.get(f))
            .fold(0.0, |most: f64, r| most.max(r.abs()));
        yaw > TURNING * noise
    });
    (!turns).then(|| {
        "no turning: straight driving shows one ratio of ground speed to wheel speed, which slip, wheel radius and the speed sensor's scale share; record turns both ways at two yaw rates"
            .to_owned()
    })
}

/// Says what would tell apart the causes that no drive can.
fn isolate(found: &mut Diagnosis, registry: &Registry) {
    let notes: Vec<String> = found
        .causes
        .iter()
        .filter(|c| found.set.contains(&c.name))
        .flat_map(|c| {
            c.indistinguishable_from.iter().filter_map(|other| {
                let how = registry.effect(other).ok()?.isolated_by();
                Some(format!(
                    "{} and {other} move the vehicle alike; only their priors tell them apart here. To be sure: {how}",
                    c.name
                ))
            })
        })
        .collect();
    found.data.notes.extend(notes);
}
