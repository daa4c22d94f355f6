//! Ground that loads the wheels of one diagonal more, and then those of the other.

use std::f64::consts::TAU;

use terra::data::{DriveLog, Rover, Series};
use terra::gap::{Diagnosis, Settings, diagnose_drive};
use terra::model::{Contact, ForceLaw, Registry, catalogue, library_slip};
use terra::sim::simulate_drive;

use crate::vehicle::{effect, example};

/// A standard deviation that torques answer nearly in proportion: to its square the body would be moved too.
const SHARE: f64 = 0.08;

/// Torques as the wheels have them under loads W (1 ± ε), with ε of this standard deviation in waves of 1.3 and .47 m along the path.
fn waved(log: &mut DriveLog, rover: &Rover, registry: &Registry, share: f64) {
    let law = registry.law("wong-reece").unwrap();
    let soil = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    let vehicle = rover.nominal_vehicle().unwrap();
    let load = vehicle.mass * 9.81 / 4.0;
    let all = |s: &Series| -> Vec<f64> { s.iter().map(Option::unwrap).collect() };
    let speed = all(log.ground_speed.as_ref().unwrap());
    let yaw = all(log.yaw_rate.as_ref().unwrap());
    let mut path = vec![0.0];
    for k in 1..speed.len() {
        let step = (log.time[k] - log.time[k - 1]).clamp(0.0, 0.1);
        path.push(path[k - 1] + step * speed[k].abs());
    }
    for (q, torque) in log.wheel_torque.as_mut().unwrap().iter_mut().enumerate() {
        let wheel = all(&log.wheel_speed[q]);
        let arm = vehicle.track * if q % 2 == 0 { -0.5 } else { 0.5 };
        let diagonal = if q == 0 || q == 3 { 1.0 } else { -1.0 };
        *torque = torque
            .iter()
            .enumerate()
            .map(|(k, torque)| {
                let (rim, travel) = (wheel[k] * vehicle.wheel_radius, speed[k] + yaw[k] * arm);
                // Standing or nearly so, a slip is anything.
                if rim * travel.signum() < 0.1 || travel.abs() < 0.1 {
                    return torque;
                }
                let of = |load: f64| {
                    let slip = library_slip(rim, travel);
                    let at = Contact::new(slip, load, vehicle.wheel_radius, vehicle.wheel_width);
                    law.forces(&soil, &at).unwrap().resistive_torque * rim.signum()
                };
                let waves = (TAU * path[k] / 1.3).sin() + (TAU * path[k] / 0.47 + 1.0).sin();
                torque.map(|t| t + of(load * (1.0 + diagonal * share * waves)) - of(load))
            })
            .collect();
    }
}

fn diagnosed(causes: &[(&str, f64)], share: f64) -> Diagnosis {
    let (rover, registry, mut scenario) = example();
    scenario.effects = causes.iter().copied().map(effect).collect();
    let mut log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    waved(&mut log, &rover, &registry, share);
    diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap()
}

fn told(d: &Diagnosis) -> bool {
    d.heed
        .iter()
        .any(|line| line.starts_with("the ground is uneven"))
}

/// Loads that swing by a twelfth leave the torques of a rover of 100 kg several times their noise off: no cause of the library does that,
/// and the ground is none.
#[test]
fn a_swing_of_the_loads_is_no_cause() {
    let d = diagnosed(&[], SHARE);
    assert!(told(&d), "{:?}", d.heed);
    assert!(
        d.set.iter().any(|name| name == "none") && d.verdict != "unknown",
        "{} {:?}",
        d.verdict,
        d.set
    );
}

/// On such ground errors of torque, mass and slope are still found, and what pulls at the rover, and a centre of mass that is elsewhere:
/// a swing of the loads leaves it where it is. These waves move no body, which the torques' sensors seem to deny: a second cause
/// may stand with the first, and something unknown beside both.
#[test]
fn a_cause_is_found_on_uneven_ground() {
    for cause in [
        ("torque-scale", 0.12),
        ("torque-bias", 2.0),
        ("mass-error", 0.2),
        ("slope", 0.03),
        ("tow-load", 60.0),
        ("cg-offset", 0.08),
    ] {
        let d = diagnosed(&[cause], SHARE);
        assert!(told(&d), "{cause:?}: {:?}", d.heed);
        let leading = &d.causes[0].name;
        let both = leading.split('+').any(|name| name == cause.0);
        let doubted = d.set.iter().any(|answer| answer == "unknown");
        assert!(leading == cause.0 || both && doubted, "{:?}", d.set);
    }
}

/// Two causes are found there too, but one wheel that is not as the others looks like two: something unknown stands beside them.
#[test]
fn two_causes_on_uneven_ground_are_not_the_only_answer() {
    let d = diagnosed(&[("torque-bias", 2.0), ("cg-offset", 0.08)], SHARE);
    assert!(told(&d), "{:?}", d.heed);
    assert_eq!(d.set, ["cg-offset+torque-bias", "unknown"]);
    let why = d.reason.as_deref().unwrap_or_default();
    assert!(why.contains("one wheel that is not as the others"), "{why}");
}

/// What one wheel does alone shows in the diagonals too, but loads that swing do not explain it: the answer stays unknown, with both
/// readings told.
#[test]
fn one_wheel_alone_stays_unknown() {
    let (rover, registry, scenario) = example();
    let mut log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    let first = &mut log.wheel_torque.as_mut().unwrap()[0];
    *first = first.iter().map(|t| t.map(|t| t + 6.0)).collect();
    let d = diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap();
    assert_eq!(
        (d.verdict, d.set.as_slice()),
        ("unknown", ["unknown".to_owned()].as_slice())
    );
    assert!(!told(&d), "{:?}", d.heed);
    let both = |line: &String| line.contains("where one wheel is not as the others");
    assert!(d.heed.iter().any(both), "{:?}", d.heed);
}
