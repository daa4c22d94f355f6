//! `rover.toml` and `rig.toml`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_data::{
    Rover, Start, WheelData, parse_rover_with, read_drive_log_from, read_rig_log_from,
};
use terra_fuzz::run;
use terra_model::Registry;

static REGISTRY: LazyLock<Registry> = LazyLock::new(Registry::builtin);

const DRIVE: &str = "t,time_s,wheel_speed_fl_rad_s,wheel_speed_fr_rad_s,wheel_speed_rl_rad_s,wheel_speed_rr_rad_s,ground_speed_m_s\n0,0,1,1,1,1,.2\n1,1,1,1,1,1,.2\n";
const RIG: &str = "slip,normal_load_N,drawbar_pull_N,x\n.1,80,2,1\n";

fn positive(values: &[f64]) -> bool {
    values.iter().all(|v| v.is_finite() && *v > 0.0)
}

fn not_negative(values: &[f64]) -> bool {
    values.iter().all(|v| v.is_finite() && *v >= 0.0)
}

fn wheel(w: &WheelData) -> bool {
    positive(&[w.radius, w.width]) && not_negative(&[w.inertia, w.damping, w.grouser_height])
}

fn check(rover: &Rover) {
    assert!(wheel(&rover.wheel), "{:?}", rover.wheel);
    assert!(rover.conditions.values().all(|c| wheel(&c.wheel)));
    if let Some(v) = &rover.vehicle {
        assert!(
            positive(&[v.mass, v.yaw_inertia, v.track, v.wheelbase]),
            "{v:?}"
        );
        assert!(not_negative(&[v.cg_height, v.yaw_damping]), "{v:?}");
        assert!((0.0..=v.wheelbase).contains(&v.cg_to_front_axle), "{v:?}");
    }
    if let Some(d) = &rover.drivetrain {
        assert!(
            positive(&[d.torque_constant, d.gear_ratio, d.efficiency]) && d.efficiency <= 1.0,
            "{d:?}"
        );
    }
    let gap = &rover.gap;
    assert!(
        positive(&[gap.window]) && gap.slip_range.0 < gap.slip_range.1,
        "{gap:?}"
    );
    assert!(
        gap.prior_none + gap.prior_unknown <= 1.0
            && not_negative(&[gap.prior_none, gap.prior_unknown]),
        "{gap:?}"
    );
    assert!(not_negative(&[
        rover.filter.torque_walk,
        rover.filter.force_walk
    ]));
    assert!(rover.noise.0.values().all(|v| not_negative(&[*v])));
    let terrain = &rover.terrain;
    assert!(
        terrain
            .prior_sd
            .values()
            .chain(terrain.prior_abs_sd.values())
            .all(|v| positive(&[*v]))
    );
    if let Some(Start::Values(values)) = &terrain.start {
        assert!(values.values().all(|v| v.is_finite()));
    }
    assert_eq!(rover.is_rig(), rover.nominal_vehicle().is_none());
    REGISTRY
        .law(&terrain.model)
        .expect("a model that the reader took");
    // Whatever its columns say, a log is read or refused.
    let _ = read_drive_log_from(DRIVE.as_bytes(), "x", rover);
    let _ = read_rig_log_from(RIG.as_bytes(), "x", rover);
}

fuzz_target!(|data: &[u8]| run(|| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    if let Ok(rover) = parse_rover_with(text, "x", &REGISTRY) {
        check(&rover);
    }
}));
