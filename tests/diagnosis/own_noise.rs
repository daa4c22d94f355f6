//! Sensors that are noisier than the rover file states, that follow themselves, or that have a slower rate than the log's rows.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use terra::data::{DriveLog, Rover, Series};
use terra::gap::{Diagnosis, Settings, diagnose_drive};
use terra::model::Registry;
use terra::sim::{EffectSetting, Scenario, simulate_drive};

use crate::probability;
use crate::vehicle::{effect, example};

/// A torque sensor that is 12 % off, and nothing at all.
fn causes() -> [Vec<EffectSetting>; 2] {
    [vec![effect(("torque-scale", 0.12))], vec![]]
}

fn says(d: &Diagnosis, cause: &[EffectSetting]) {
    let expected = match cause.first() {
        Some(_) => ("named", "torque-scale"),
        None => ("none", "none"),
    };
    assert_eq!((d.verdict, d.set[0].as_str()), expected, "{:?}", d.set);
}

fn diagnosed(log: &DriveLog, rover: &Rover, registry: &Registry) -> Diagnosis {
    diagnose_drive(log, rover, registry, &Settings::of(rover)).unwrap()
}

fn simulated(
    rover: &Rover,
    registry: &Registry,
    scenario: &Scenario,
    effects: &[EffectSetting],
    noise_scale: f64,
) -> DriveLog {
    let scenario = Scenario {
        effects: effects.to_vec(),
        noise_scale,
        ..scenario.clone()
    };
    simulate_drive(&scenario, rover, registry).unwrap().log
}

/// Every noisy channel of the log, with the name of its noise.
fn channels(log: &mut DriveLog) -> Vec<(&'static str, &mut Series)> {
    let single = [
        ("ground_speed_m_s", log.ground_speed.as_mut()),
        ("yaw_rate_rad_s", log.yaw_rate.as_mut()),
        ("accel_x_m_s2", log.accel_x.as_mut()),
    ];
    let single = single.into_iter().filter_map(|(name, s)| Some((name, s?)));
    let wheels = log.wheel_speed.iter_mut();
    let torques = log.wheel_torque.iter_mut().flatten();
    single
        .chain(wheels.map(|s| ("wheel_speed_rad_s", s)))
        .chain(torques.map(|s| ("wheel_torque_N_m", s)))
        .collect()
}

/// Noise of the stated size, each sample correlated by one half with the one before, as a filter leaves it: a window's mean is 1.7
/// times as uncertain as by white noise. Read as white, all of that is something unknown.
#[test]
fn noise_that_follows_itself_is_nothing_unknown() {
    let (rover, registry, scenario) = example();
    for cause in causes() {
        let mut log = simulated(&rover, &registry, &scenario, &cause, 0.0);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for (name, series) in channels(&mut log) {
            let sd = rover.noise.get(name).unwrap();
            let mut last: f64 = StandardNormal.sample(&mut rng);
            *series = series
                .iter()
                .map(|truth| {
                    let new: f64 = StandardNormal.sample(&mut rng);
                    last = 0.5 * last + 0.75f64.sqrt() * new;
                    truth.map(|truth| truth + sd * last)
                })
                .collect();
        }
        let d = diagnosed(&log, &rover, &registry);
        says(&d, &cause);
        let told = |name: &str| {
            let mut notes = d.data.notes.iter();
            notes.any(|n| n.starts_with(name) && n.contains("inside the windows"))
        };
        assert!(told("ground_speed_m_s") && told("accel_x_m_s2"));
    }
}

/// White noise half as large again as stated.
#[test]
fn noise_that_is_understated_is_nothing_unknown() {
    let (rover, registry, scenario) = example();
    for cause in causes() {
        let log = simulated(&rover, &registry, &scenario, &cause, 1.5);
        says(&diagnosed(&log, &rover, &registry), &cause);
        // As stated, there is nothing to tell.
        let log = simulated(&rover, &registry, &scenario, &cause, 1.0);
        let d = diagnosed(&log, &rover, &registry);
        says(&d, &cause);
        let told = |n: &String| n.contains("inside the windows");
        assert!(!d.data.notes.iter().any(told), "{:?}", d.data.notes);
    }
}

/// A ground speed of half and of a tenth of the rows, the others blank: two samples a window are a slope, and no reason to refuse.
/// A value that is held in between says as much as a blank: the diagnosis is the same, and says so.
#[test]
fn a_sensor_of_a_slower_rate_has_blank_rows() {
    let (rover, registry, scenario) = example();
    let cause = &causes()[0];
    let whole = simulated(&rover, &registry, &scenario, cause, 1.0);
    let used = |d: &Diagnosis| d.data.observations.len();
    let all = used(&diagnosed(&whole, &rover, &registry));
    for every in [2, 10] {
        let mut log = whole.clone();
        let speed = log.ground_speed.as_mut().unwrap();
        *speed = speed
            .iter()
            .enumerate()
            .map(|(row, v)| v.filter(|_| row % every == 0))
            .collect();
        let d = diagnosed(&log, &rover, &registry);
        assert!(used(&d) * 10 > all * 9, "{} of {all}", used(&d));
        assert_eq!(d.causes[0].name, "torque-scale", "{:?}", d.set);
        assert!(d.set.contains(&"torque-scale".to_owned()));
        let mut value = None;
        let speed = log.ground_speed.as_mut().unwrap();
        *speed = speed
            .iter()
            .map(|v| {
                value = v.or(value);
                value
            })
            .collect();
        let held = diagnosed(&log, &rover, &registry);
        assert_eq!(
            probability(&held, "torque-scale"),
            probability(&d, "torque-scale")
        );
        assert_eq!(
            (&held.set, held.waterfall.refitted),
            (&d.set, d.waterfall.refitted)
        );
        let told = format!("ground_speed_m_s changes every {every} rows only");
        assert!(
            held.heed.iter().any(|h| h.starts_with(&told)),
            "{:?}",
            held.heed
        );
        assert!(d.heed.iter().all(|h| !h.starts_with(&told)));
    }
}

/// A missing cell is a missing sample: with one pitch in seven rows every window knows its slope, and all is as with every cell;
/// a window without any is left out, and counted. It was level ground before.
#[test]
fn a_missing_pitch_is_not_level_ground() {
    let (rover, registry, scenario) = example();
    let whole = simulated(&rover, &registry, &scenario, &[], 1.0);
    let mut tilted = whole.pitch.as_ref().unwrap().iter().flatten();
    assert!(tilted.any(|p| p.abs() > 0.05));
    let with = |keep: &dyn Fn(usize) -> bool| {
        let mut log = whole.clone();
        let pitch = log.pitch.as_mut().unwrap();
        *pitch = pitch
            .iter()
            .enumerate()
            .map(|(row, p)| p.filter(|_| keep(row)))
            .collect();
        diagnosed(&log, &rover, &registry)
    };
    let (all, some) = (with(&|_| true), with(&|row| row % 7 == 3));
    assert_eq!(
        all.waterfall.refitted.map(f64::to_bits),
        some.waterfall.refitted.map(f64::to_bits)
    );
    let gone = with(&|row| row >= 1000);
    let left_out = gone.data.dropped.get("window without pitch_rad");
    assert!(left_out.is_some_and(|n| *n > 20), "{:?}", gone.data.dropped);
    assert!(gone.data.observations.len() < all.data.observations.len());
}
