use terra_sim::integrate::{DormandPrince, Rk4};
use terra_sim::{Integrator, Scenario, SimError, paper, simulate_drive};

use crate::support::{adaptive, drive, quiet_ramp, registry};

const SOILS: [&str; 3] = ["dry_sand", "upland_sandy_loam", "lean_clay_22"];

/// "Light vehicle: drawbar pull positive on all three at high slip": it gains speed on each.
#[test]
fn the_light_robot_accelerates_on_all_three_soils() {
    for soil in SOILS {
        let truth = drive(&quiet_ramp(soil), &paper::light_rover(), adaptive()).truth;
        assert!(
            truth.ground_speed[199] > 1.0,
            "{soil}: {}",
            truth.ground_speed[199]
        );
        assert!(truth.accel_x[10..150].iter().all(|a| *a > 0.0), "{soil}");
    }
}

/// "Heavy vehicle immobile on dry sand": its pull is negative at every slip. It spins where it stands.
#[test]
fn the_heavy_robot_is_immobile_on_dry_sand() {
    let rover = paper::heavy_rover();
    let mut scenario = Scenario {
        noise_scale: 0.0,
        ..paper::torque_ramp_of(&rover, "dry_sand", 1).unwrap()
    };
    scenario.segments[0].duration = 1.0;
    let truth = drive(&scenario, &rover, Integrator::Rk4(Rk4 { step: 2e-3 })).truth;
    assert!(truth.ground_speed.iter().all(|v| v.abs() < 1e-3));
    assert!(truth.distance.iter().all(|x| x.abs() < 1e-3));
    assert!(
        truth.wheel_speed[0].iter().any(|w| *w > 0.05),
        "the wheels do turn"
    );
    assert!(truth.standstill.iter().all(|s| *s), "and the rows say so");
}

/// "Heavy on sandy loam borderline", and it does move on lean clay.
#[test]
fn the_heavy_robot_creeps_on_loam_and_runs_on_clay() {
    let rover = paper::heavy_rover();
    let speed = |soil: &str| {
        let scenario = Scenario {
            noise_scale: 0.0,
            ..paper::torque_ramp_of(&rover, soil, 1).unwrap()
        };
        drive(&scenario, &rover, adaptive()).truth.ground_speed[199]
    };
    let (loam, clay) = (speed("upland_sandy_loam"), speed("lean_clay_22"));
    assert!(loam > 0.0 && loam < 0.5, "{loam}");
    assert!(clay > 2.0, "{clay}");
}

/// The mean slip of the wheels sweeps down through the span the hypotheses are told apart in: .78 to about .05 (the
/// torque ends at 1.02 T(.05), less what damping takes and more what inertia gives).
#[test]
fn the_ramp_sweeps_slip() {
    for soil in SOILS {
        let truth = drive(&quiet_ramp(soil), &paper::light_rover(), adaptive()).truth;
        let mean = |row: usize| (0..4).map(|q| truth.slip[q][row]).sum::<f64>() / 4.0;
        let slips: Vec<f64> = (0..truth.len()).map(mean).collect();
        assert!(slips.iter().copied().fold(0.0, f64::max) >= 0.78, "{soil}");
        assert!(
            slips.iter().copied().fold(1.0, f64::min) <= 0.065,
            "{soil}: {}",
            slips[199]
        );
    }
}

/// At every row the wheel forces are the model's at the row's slip and load: loads, slip and forces belong together.
#[test]
fn truth_columns_belong_together() {
    use terra_model::{Contact, ForceLaw, catalogue};
    let truth = drive(&quiet_ramp("dry_sand"), &paper::light_rover(), adaptive()).truth;
    let law = registry().law("wong-reece").unwrap();
    let p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    for row in (1..200).step_by(7) {
        for q in 0..4 {
            let at = Contact::new(truth.slip[q][row], truth.normal_load[q][row], 0.254, 0.15);
            let f = law.forces(&p, &at).unwrap();
            assert!((f.drawbar_pull - truth.drawbar_pull[q][row]).abs() < 1e-4);
            assert!((f.resistive_torque - truth.resistive_torque[q][row]).abs() < 1e-4);
            assert!((f.sinkage.unwrap() - truth.sinkage.as_ref().unwrap()[q][row]).abs() < 1e-7);
            let rim = 0.254 * truth.wheel_speed[q][row];
            assert!((truth.slip[q][row] - (1.0 - truth.ground_speed[row] / rim)).abs() < 1e-12);
        }
        let total: f64 = (0..4).map(|q| truth.normal_load[q][row]).sum();
        assert!((total - 981.0).abs() < 1e-9);
        // h a m/L between the axles.
        let transfer = truth.normal_load[2][row] - truth.normal_load[0][row];
        assert!((transfer - 100.0 * 0.22 * truth.accel_x[row] / 0.6).abs() < 1e-7);
    }
}

/// Snow that carries the standing vehicle but not a wheel that slips: typed, with time, wheel and both loads.
#[test]
fn soil_that_gives_way_is_a_typed_error() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.left = terra_data::Start::Id("snow_us_harrison_1".to_owned());
    scenario.right = scenario.left.clone();
    for integrator in [
        Integrator::default(),
        Integrator::DormandPrince(DormandPrince::default()),
    ] {
        let result = terra_sim::simulate_drive_with(
            &scenario,
            &paper::light_rover(),
            &registry(),
            integrator,
        );
        match result {
            Err(SimError::NoEquilibrium {
                time,
                wheel,
                load,
                max_load,
            }) => {
                assert!(time >= 0.0 && wheel < 4 && load > max_load && max_load > 0.0);
            }
            other => panic!("{:?}", other.map(|r| r.truth.len())),
        }
    }
}

/// Torque that drives the wheels backwards while the vehicle runs forward leaves the model's domain.
#[test]
fn wheels_against_their_motion_are_a_typed_error() {
    let mut scenario = quiet_ramp("dry_sand");
    scenario.segments[0].start = Some(terra_sim::StartMotion {
        ground_speed: 2.0,
        wheel_speed: [8.0; 4],
    });
    scenario.segments[0].command =
        terra_sim::Command::Torque([terra_sim::Profile::constant(-60.0); 4]);
    match simulate_drive(&scenario, &paper::light_rover(), &registry()) {
        Err(SimError::AgainstMotion {
            time,
            rim_speed,
            travel_speed,
            ..
        }) => {
            assert!(time > 0.0 && rim_speed < 0.0 && travel_speed > 0.0);
        }
        other => panic!("{:?}", other.map(|r| r.truth.ground_speed)),
    }
}

/// Load transfer makes the soil take more torque from the rear wheels than the motors give: they stall for a moment.
/// On stiff clay, whose braked contact the model cannot carry, that is still a run and no error.
#[test]
fn wheels_that_stall_on_clay_are_no_error() {
    let mut scenario = quiet_ramp("lean_clay_22");
    scenario.segments[0].duration = 0.05;
    scenario.rate = 1000.0;
    scenario
        .effects
        .push(terra_sim::EffectSetting::new("slip-sinkage", 0.3));
    let truth = drive(&scenario, &paper::light_rover(), adaptive()).truth;
    assert!(truth.wheel_speed[2].iter().any(|w| 0.254 * w.abs() < 0.03));
    assert!(truth.standstill.iter().any(|s| *s));
    assert!(truth.normal_load[2].iter().all(|n| *n < 600.0));
}
