//! Typical values of all parameters of the slots, on four soils of the catalogue.

use crate::catalogue;
use crate::param::Param;

/// Values for parameters that the catalogue does not give, for a sandy, a loamy and a clayey soil under a wheel of .15 m.
fn value(name: &str, soil: usize, soft: bool) -> Option<f64> {
    let three = |values: [f64; 3]| values.get(soil).copied();
    match name {
        "cohesion" if soft => three([900.0, 2500.0, 1500.0]),
        "k_c_prime" => three([30.0, 69.0, 10.0]),
        "k_phi_prime" => three([83.0, 550.0, 40.0]),
        "unit_weight" => three([15_000.0, 14_000.0, 17_000.0]),
        "slip_exponent" => three([0.3, 0.1, 0.05]),
        "snow_pressure" => three([80e3, 40e3, 150e3]),
        "snow_depth" => three([0.05, 0.02, 0.1]),
        "peat_stiffness" => three([3e5, 8e5, 4e5]),
        "mat_stiffness" => three([5e4, 2e4, 1e5]),
        "unloading_stiffness" => three([2e7, 3e7, 4e7]),
        "unloading_growth" => three([1e8, 0.0, 5e8]),
        "past_sinkage" => three([0.012, 0.006, 0.03]),
        "layer_stiffness" => three([3e6, 1e7, 5e6]),
        "layer_depth" => three([0.02, 0.01, 0.015]),
        "residual_ratio" => three([0.7, 0.5, 0.8]),
        "adhesion" => three([300.0, 900.0, 9e3]),
        "interface_friction_angle" => three([0.32, 0.4, 0.2]),
        "c3" => three([-0.1, -0.2, -0.05]),
        "lug_height" => three([0.01, 0.005, 0.015]),
        "lug_count" => three([24.0, 30.0, 18.0]),
        "lateral_shear_modulus" => three([0.02, 0.015, 0.01]),
        "tyre_pressure" => three([1.5e4, 7e4, 1.5e5]),
        "lug_reach" => three([0.005, 0.0, 0.01]),
        _ => None,
    }
}

/// Vectors with all of these parameters; none where one is not known.
pub(super) fn parameters(params: &[Param]) -> Vec<Vec<f64>> {
    // Snow and peat are weak as well as soft.
    let soft = params
        .iter()
        .any(|p| matches!(p.name, "snow_pressure" | "peat_stiffness"));
    [
        ("dry_sand", 0),
        ("upland_sandy_loam", 1),
        ("lean_clay_22", 2),
        ("chrono_soft", 0),
    ]
    .into_iter()
    .filter_map(|(id, k)| {
        let terrain = catalogue::find(id).ok()?;
        params
            .iter()
            .map(|p| value(p.name, k, soft).or_else(|| terrain.value(p.name)))
            .collect()
    })
    .collect()
}
