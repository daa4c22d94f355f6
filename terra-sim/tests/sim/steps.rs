//! Adaptive steps run past the rows: what is logged inside a step is as exact as what is logged at its end.

use terra_sim::integrate::DormandPrince;
use terra_sim::{DriveTruth, EffectSetting, Integrator, Scenario, StartMotion, paper};

use crate::support::{drive, quiet_ramp};

/// A ramp from motion, off the kinks of the standstill rules.
fn smooth(terrain: &str) -> Scenario {
    let mut scenario = quiet_ramp(terrain);
    scenario.segments[0].start = Some(StartMotion {
        ground_speed: 1.0,
        wheel_speed: [6.0; 4],
    });
    scenario
}

fn by(scenario: &Scenario, tolerance: f64, max_step: f64) -> DriveTruth {
    let method = DormandPrince {
        relative: tolerance,
        absolute: tolerance,
        max_step,
    };
    let integrator = Integrator::DormandPrince(method);
    drive(scenario, &paper::light_rover(), integrator).truth
}

/// Largest difference of a speed or of the path between rows that both have, `every` rows of `b` apart.
fn distance(a: &DriveTruth, b: &DriveTruth, every: usize) -> f64 {
    let columns = |t: &DriveTruth| {
        let [w, _, _, z] = t.wheel_speed.clone();
        [t.ground_speed.clone(), t.distance.clone(), w, z]
    };
    let mut worst: f64 = 0.0;
    for (a, b) in columns(a).iter().zip(&columns(b)) {
        for (x, y) in a.iter().zip(b.iter().step_by(every)) {
            worst = worst.max((x - y).abs() / (1.0 + y.abs()));
        }
    }
    worst
}

/// Rows inside steps of up to a tenth of a second, against steps of a millisecond at a ten thousandth of the tolerance.
#[test]
fn rows_inside_long_steps_keep_the_tolerance() {
    for terrain in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
        let scenario = smooth(terrain);
        let exact = by(&scenario, 1e-10, 1e-3);
        for tolerance in [1e-5, 1e-6, 1e-7] {
            let worst = distance(&by(&scenario, tolerance, 0.1), &exact, 1);
            assert!(
                worst < 10.0 * tolerance,
                "{terrain}, {tolerance:e}: {worst:e}"
            );
        }
    }
}

/// Ten times the rows are the same motion: no step is taken for a row's sake.
#[test]
fn rows_do_not_steer_the_steps() {
    let mut scenario = smooth("dry_sand");
    let few = by(&scenario, 1e-4, 0.1);
    scenario.rate = 1000.0;
    let many = by(&scenario, 1e-4, 0.1);
    // At this tolerance shorter steps would show: they are better by more than that.
    let short = by(&scenario, 1e-4, 1e-3);
    let (same, other) = (distance(&few, &many, 10), distance(&few, &short, 10));
    assert!(same < 1e-7 && other > 10.0 * same, "{same:e} {other:e}");
}

/// A late sensor looks back into long steps: v_rep(t) = v(t - e).
#[test]
fn late_sensors_read_inside_steps() {
    let mut scenario = smooth("upland_sandy_loam");
    scenario.effects = vec![EffectSetting::new("ground-speed-delay", 0.035)];
    let run = drive(
        &scenario,
        &paper::light_rover(),
        Integrator::DormandPrince(DormandPrince::default()),
    );
    scenario.rate = 200.0;
    let fine = by(&scenario, 1e-10, 1e-3);
    let reported = run.log.ground_speed.unwrap();
    for i in 4..run.truth.len() {
        // 35 ms are seven rows of the fine log.
        let then = fine.ground_speed[2 * i - 7];
        assert!((reported.get(i).unwrap() - then).abs() < 1e-6, "row {i}");
    }
}
