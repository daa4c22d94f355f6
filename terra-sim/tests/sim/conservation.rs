use terra_sim::{DriveTruth, paper};

use crate::support::{adaptive, drive, quiet_ramp, simpson};

/// A turning run on two soils, sampled finely, past the first instants at standstill.
fn turning() -> DriveTruth {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.right = terra_data::Start::Id("sandy_loam_15".to_owned());
    scenario.segments[0].start = Some(terra_sim::StartMotion {
        ground_speed: 1.0,
        wheel_speed: [6.0; 4],
    });
    scenario.segments[0].duration = 1.001;
    scenario.rate = 1000.0;
    drive(&scenario, &paper::light_rover(), adaptive()).truth
}

/// Work of the motors = kinetic energy + heat in soil, bearings and scrub, to 1e-6 of the work.
#[test]
fn energy_is_balanced() {
    let t = turning();
    let kinetic = |i: usize| {
        50.0 * t.ground_speed[i].powi(2)
            + 5.0 * t.yaw_rate[i].powi(2)
            + (0..4)
                .map(|q| 0.125 * t.wheel_speed[q][i].powi(2))
                .sum::<f64>()
    };
    let work = simpson(&t.time, |i| {
        (0..4)
            .map(|q| t.wheel_torque[q][i] * t.wheel_speed[q][i])
            .sum()
    });
    let heat = simpson(&t.time, |i| {
        let wheels: f64 = (0..4)
            .map(|q| {
                let side = if q % 2 == 0 { -0.3 } else { 0.3 };
                let travel = t.ground_speed[i] + side * t.yaw_rate[i];
                let w = t.wheel_speed[q][i];
                t.resistive_torque[q][i] * w + 0.1 * w * w - t.drawbar_pull[q][i] * travel
            })
            .sum();
        wheels + 8.0 * t.yaw_rate[i].powi(2)
    });
    let change = kinetic(t.len() - 1) - kinetic(0);
    assert!(heat > 0.0 && t.yaw_rate[1000].abs() > 0.05);
    assert!(
        (work - heat - change).abs() < 1e-6 * work,
        "{work} {heat} {change}"
    );
}

/// Linear and angular momentum change by the impulses of the forces.
#[test]
fn momentum_is_balanced() {
    let t = turning();
    let last = t.len() - 1;
    let pull = |i: usize, q: usize| t.drawbar_pull[q][i];
    let impulse = simpson(&t.time, |i| (0..4).map(|q| pull(i, q)).sum());
    let gained = 100.0 * (t.ground_speed[last] - t.ground_speed[0]);
    assert!(
        (impulse - gained).abs() < 1e-6 * gained.abs(),
        "{impulse} {gained}"
    );
    let twist = simpson(&t.time, |i| {
        0.3 * (pull(i, 1) + pull(i, 3) - pull(i, 0) - pull(i, 2)) - 8.0 * t.yaw_rate[i]
    });
    let turned = 10.0 * (t.yaw_rate[last] - t.yaw_rate[0]);
    assert!(
        (twist - turned).abs() < 1e-6 * turned.abs(),
        "{twist} {turned}"
    );
    let spin = simpson(&t.time, |i| {
        t.wheel_torque[2][i] - t.resistive_torque[2][i] - 0.1 * t.wheel_speed[2][i]
    });
    let spun = 0.25 * (t.wheel_speed[2][last] - t.wheel_speed[2][0]);
    assert!((spin - spun).abs() < 1e-6 * spun.abs(), "{spin} {spun}");
}
