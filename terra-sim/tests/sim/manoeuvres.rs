//! The manoeuvres of the examples do what they are called, by mechanics alone: signs, weights, and who pulls whom.

use std::path::Path;

use terra_sim::{DriveTruth, EffectSetting, Scenario, paper};

use crate::support::{adaptive, drive};

/// Quiet, with an effect or without.
fn example(effect: Option<(&str, f64)>) -> DriveTruth {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drive/manoeuvres.toml");
    let mut scenario = Scenario::read(&path).unwrap();
    scenario.noise_scale = 0.0;
    scenario.effects = effect
        .map(|(name, e)| EffectSetting::new(name, e))
        .into_iter()
        .collect();
    drive(&scenario, &paper::light_rover(), adaptive()).truth
}

/// The last row of a manoeuvre, and its means.
struct Part<'a> {
    truth: &'a DriveTruth,
    rows: std::ops::Range<usize>,
}

impl Part<'_> {
    fn mean(&self, column: &[f64]) -> f64 {
        self.rows.clone().map(|i| column[i]).sum::<f64>() / self.rows.len() as f64
    }

    fn last(&self, column: &[f64]) -> f64 {
        column[self.rows.end - 1]
    }

    fn load(&self) -> f64 {
        let total = |i: usize| (0..4).map(|q| self.truth.normal_load[q][i]).sum::<f64>();
        total(self.rows.end - 1)
    }
}

fn part<'a>(truth: &'a DriveTruth, name: &str) -> Part<'a> {
    let segment = truth.segments.iter().find(|s| s.name == name).unwrap();
    let rows = segment.rows.clone();
    Part { truth, rows }
}

#[test]
fn each_does_what_it_is_called() {
    let t = example(None);
    let of = |name: &str| part(&t, name);
    let (pull, slip, speed) = (&t.drawbar_pull, &t.slip, &t.ground_speed);

    // Slip falls with torque.
    let ramp = of("torque ramp");
    assert!(slip[0][ramp.rows.start + 5] > 0.7 && ramp.last(&slip[0]) < 0.1);

    // Speed follows the wheels up and down; wheels slower than the ground hold the vehicle back.
    let (slow, fast, braking) = (of("slow"), of("fast"), of("braking"));
    assert!(fast.last(speed) > slow.last(speed) + 0.2);
    assert!(braking.last(speed) < fast.last(speed) - 0.2);
    assert!(braking.mean(&t.accel_x) < -0.3 && braking.last(&slip[0]) < 0.0);
    assert!(braking.last(&pull[0]) < 0.0 && braking.last(&pull[2]) < 0.0);

    let fight = of("fight");
    assert!(fight.last(&slip[0]) > 0.0 && fight.last(&slip[2]) < 0.0);
    assert!(fight.last(&pull[0]) > 0.0 && fight.last(&pull[2]) < 0.0);

    // Held vehicles turn by their pull alone: each turn is the other in a mirror.
    let (left, right) = (of("turn left"), of("turn right"));
    assert!(left.last(&t.yaw_rate) > 0.05);
    for (i, j) in left.rows.clone().zip(right.rows.clone()) {
        assert!((t.yaw_rate[i] + t.yaw_rate[j]).abs() < 1e-7);
        assert!((t.wheel_torque[1][i] - t.wheel_torque[0][j]).abs() < 1e-5);
    }

    // More slip uphill; the accelerometer reads g sin(pitch) in steady motion; cos(pitch) of the weight presses.
    let (up, down) = (of("up"), of("down"));
    assert!(up.last(&slip[0]) > down.last(&slip[0]) && up.last(speed) < down.last(speed));
    let slope = 9.81 * 0.0873f64.sin();
    assert!(
        (up.last(&t.accel_x) - slope).abs() < 0.1 && (down.last(&t.accel_x) + slope).abs() < 0.1
    );
    assert!((up.load() - 981.0 * 0.0873f64.cos()).abs() < 1e-9);

    // Before the turn that follows from it: the accelerometer reads g sin(roll), and the right side carries the more.
    let row = of("side slope").rows.start;
    let [high, low] = [0, 1].map(|q| t.normal_load[q][row] + t.normal_load[q + 2][row]);
    let shift = 2.0 * 0.22 * 0.0873f64.tan() / 0.6;
    assert!(((low - high) / (low + high) - shift).abs() < 1e-9);
    assert!((t.accel_y[row] - 9.81 * 0.0873f64.sin()).abs() < 1e-9);

    assert!((of("payload").load() - 9.81 * 120.0).abs() < 1e-9);
    // In steady motion the wheels together pull what is towed.
    let tow = of("tow");
    let towed: f64 = (0..4).map(|q| tow.last(&pull[q])).sum();
    assert!((towed - 60.0 - 100.0 * tow.last(&t.accel_x)).abs() < 1e-6);
    assert!(tow.last(&slip[0]) > of("own rut").last(&slip[0]));

    let reverse = of("reverse");
    assert!(reverse.mean(speed) < -0.5 && reverse.last(&t.distance) < -0.5);
}

/// A soil that passes compact carries more in the rut: the wheels sink less there than on the same ground anew.
#[test]
fn the_rut_is_a_rut() {
    let t = example(Some(("multipass", 0.8)));
    let plain = example(None);
    let sinkage = |t: &DriveTruth| part(t, "own rut").last(&t.sinkage.as_ref().unwrap()[0]);
    assert!(sinkage(&t) < 0.9 * sinkage(&plain));
}
