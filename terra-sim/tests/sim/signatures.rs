//! What each effect does to pull, torque and sinkage of a wheel at a given slip and load, against the published table of
//! effects: up, down, changed, or not touched to the last bit.

use terra_sim::{EffectSetting, Scenario, Trial, paper, simulate_rig};

use crate::rig::rig;
use crate::support::registry;

#[derive(Clone, Copy, Debug)]
enum Sign {
    Up,
    Down,
    Same,
    /// The table says that it shows, not which way.
    Changed,
    /// The table does not say.
    Any,
}
use Sign::{Any, Changed, Down, Same, Up};

const LIGHT: f64 = 245.25;
const HEAVY: f64 = 2452.5;

/// Effect, prior size, soil, slip, load, pass, and the signs of pull, torque and sinkage.
type Row = (&'static str, f64, &'static str, f64, f64, u32, [Sign; 3]);

const TABLE: &[Row] = &[
    (
        "slip-sinkage",
        0.4,
        "dry_sand",
        0.6,
        LIGHT,
        1,
        [Down, Up, Up],
    ),
    (
        "multipass",
        0.8,
        "dry_sand",
        0.3,
        LIGHT,
        2,
        [Any, Any, Down],
    ),
    (
        "multipass",
        0.8,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Same, Same, Same],
    ),
    (
        "grousers",
        0.015,
        "lean_clay_22",
        0.2,
        LIGHT,
        1,
        [Up, Up, Any],
    ),
    (
        "bulldozing",
        1.0,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Down, Same, Same],
    ),
    (
        "rear-contact",
        0.35,
        "lean_clay_22",
        0.3,
        LIGHT,
        1,
        [Up, Any, Down],
    ),
    (
        "rate-stiffening",
        0.35,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Changed, Any, Changed],
    ),
    ("shear-hump", 0.35, "dry_sand", 0.1, LIGHT, 1, [Up, Up, Any]),
    (
        "wheel-compliance",
        0.3,
        "dry_sand",
        0.3,
        HEAVY,
        1,
        [Any, Any, Down],
    ),
    // The layer lies at 30 mm or so: a heavy wheel reaches it, a light one on firm soil does not.
    (
        "layered-soil",
        2.0,
        "dry_sand",
        0.3,
        HEAVY,
        1,
        [Changed, Any, Down],
    ),
    (
        "layered-soil",
        2.0,
        "lean_clay_22",
        0.3,
        LIGHT,
        1,
        [Same, Same, Same],
    ),
    (
        "interface-friction",
        0.3,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Down, Down, Any],
    ),
    (
        "load-error",
        0.1,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Changed, Up, Up],
    ),
    (
        "drivetrain-coulomb-friction",
        2.0,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Same, Up, Same],
    ),
    (
        "drivetrain-viscous-friction",
        0.8,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Same, Up, Same],
    ),
    (
        "torque-scale",
        0.12,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Same, Down, Same],
    ),
    (
        "torque-bias",
        1.5,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Same, Up, Same],
    ),
    (
        "drawbar-gain",
        0.05,
        "upland_sandy_loam",
        0.3,
        LIGHT,
        1,
        [Up, Same, Same],
    ),
    (
        "drawbar-bias",
        2.0,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Up, Same, Same],
    ),
    (
        "sinkage-bias",
        0.002,
        "dry_sand",
        0.3,
        LIGHT,
        1,
        [Same, Same, Up],
    ),
];

/// Pull, torque and sinkage as the rig logs them, without noise.
fn logged(row: &Row, effect: bool) -> [f64; 3] {
    let (name, e, soil, slip, load, pass, _) = *row;
    let effect = effect.then(|| EffectSetting::new(name, e));
    wheel(soil, slip, load, pass, effect)
}

fn wheel(soil: &str, slip: f64, load: f64, pass: u32, effect: Option<EffectSetting>) -> [f64; 3] {
    let trial = Trial {
        slip: vec![slip],
        normal_load: vec![load],
        repeats: 1,
        travel_speed: 0.1,
        condition: String::new(),
        pass,
        ramp: None,
    };
    let mut scenario = Scenario {
        segments: Vec::new(),
        trials: vec![trial],
        noise_scale: 0.0,
        ..paper::torque_ramp(soil, 3).unwrap()
    };
    scenario.effects = effect.into_iter().collect();
    let log = simulate_rig(&scenario, &rig(), &registry()).unwrap().log;
    let row = &log.rows[0];
    [row.drawbar_pull, row.torque, row.sinkage].map(|m| m.unwrap().value)
}

#[test]
fn pull_torque_and_sinkage_move_as_the_table_says() {
    for row in TABLE {
        let (nominal, changed) = (logged(row, false), logged(row, true));
        let channels = ["pull", "torque", "sinkage"];
        for (k, sign) in row.6.iter().enumerate() {
            let (before, after) = (nominal[k], changed[k]);
            // Larger than any error of the solver: these are effects one can see.
            let size = 1e-4 * (before.abs() + 1e-6);
            let holds = match sign {
                Up => after > before + size,
                Down => after < before - size,
                Same => after == before,
                Changed => (after - before).abs() > size,
                Any => true,
            };
            assert!(
                holds,
                "{} on {} at slip {}, {} N: {} {before} -> {after}, expected {sign:?}",
                row.0, row.2, row.3, row.4, channels[k]
            );
        }
    }
}

/// "Torque down" in a rut is said of a wheel that carries no more than itself: at one slip the firmer soil may take more
/// of it, but less slip and less torque already give no pull.
#[test]
fn a_wheel_without_pull_needs_less_torque_in_a_rut() {
    for soil in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
        let self_propelled = |effect: bool| {
            let at = |slip: f64| {
                let effect = effect.then(|| EffectSetting::new("multipass", 0.8));
                wheel(soil, slip, LIGHT, 2, effect)
            };
            let (mut low, mut high) = (0.001, 0.3);
            assert!(at(low)[0] < 0.0 && at(high)[0] > 0.0, "{soil}");
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                *(if at(middle)[0] < 0.0 {
                    &mut low
                } else {
                    &mut high
                }) = middle;
            }
            at(low)[1]
        };
        let (fresh, rut) = (self_propelled(false), self_propelled(true));
        assert!(rut < 0.95 * fresh, "{soil}: {fresh} {rut}");
    }
}
