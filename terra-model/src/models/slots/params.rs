//! The parameters of the slots, one place for names, units and ranges.

use crate::models::bekker::PARAMS as BEKKER;
use crate::param::{Param, Scale};

pub(super) const K_C: Param = BEKKER[0];
pub(super) const K_PHI: Param = BEKKER[1];
pub(super) const EXPONENT: Param = BEKKER[2];
pub(super) const COHESION: Param = BEKKER[3];
pub(super) const FRICTION_ANGLE: Param = BEKKER[4];
pub(super) const SHEAR_MODULUS: Param = BEKKER[5];
pub(super) const C1: Param = BEKKER[6];
pub(super) const C2: Param = BEKKER[7];

/// A positive number that is fitted by its logarithm.
const fn positive(
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    (min, max): (f64, f64),
    prior_sd: f64,
    doc: &'static str,
) -> Param {
    Param {
        name,
        symbol,
        unit,
        min,
        max,
        scale: Scale::Log,
        prior_sd,
        doc,
    }
}

/// A number that is fitted as it is.
const fn plain(
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    (min, max): (f64, f64),
    prior_sd: f64,
    doc: &'static str,
) -> Param {
    Param {
        name,
        symbol,
        unit,
        min,
        max,
        scale: Scale::Linear,
        prior_sd,
        doc,
    }
}

pub(super) const K_C_PRIME: Param = positive(
    "k_c_prime",
    "k_c'",
    "1",
    (0.0, 1e5),
    0.5,
    "cohesive modulus of Reece's law",
);
pub(super) const K_PHI_PRIME: Param = positive(
    "k_phi_prime",
    "k_φ'",
    "1",
    (0.0, 1e6),
    0.5,
    "frictional modulus of Reece's law",
);
pub(super) const UNIT_WEIGHT: Param = positive(
    "unit_weight",
    "γ",
    "N/m^3",
    (0.0, 1e5),
    0.1,
    "weight of the soil per volume, ρ g",
);
pub(super) const SLIP_EXPONENT: Param = plain(
    "slip_exponent",
    "n1",
    "1",
    (0.0, 3.0),
    0.4,
    "growth of the sinkage exponent with slip",
);
pub(super) const SNOW_PRESSURE: Param = positive(
    "snow_pressure",
    "p_w",
    "Pa",
    (1.0, 1e8),
    0.5,
    "pressure at which the snow gives way",
);
pub(super) const SNOW_DEPTH: Param = positive(
    "snow_depth",
    "z_w",
    "m",
    (1e-4, 10.0),
    0.5,
    "a third of the depth at which the pressure is 95 % of that",
);
pub(super) const PEAT_STIFFNESS: Param = positive(
    "peat_stiffness",
    "k_p",
    "N/m^3",
    (1.0, 1e9),
    0.5,
    "stiffness of the peat",
);
pub(super) const MAT_STIFFNESS: Param = positive(
    "mat_stiffness",
    "m_m",
    "N/m^3",
    (0.0, 1e9),
    0.5,
    "strength of the surface mat",
);
pub(super) const UNLOADING_STIFFNESS: Param = positive(
    "unloading_stiffness",
    "k_0",
    "N/m^3",
    (1.0, 1e12),
    0.5,
    "slope of unloading and reloading at the surface",
);
pub(super) const UNLOADING_GROWTH: Param = positive(
    "unloading_growth",
    "A_u",
    "N/m^4",
    (0.0, 1e13),
    0.5,
    "its growth with the depth unloaded from",
);
pub(super) const PAST_SINKAGE: Param = plain(
    "past_sinkage",
    "z_u",
    "m",
    (0.0, 1.0),
    0.01,
    "largest sinkage of earlier passes over this place",
);
pub(super) const LAYER_STIFFNESS: Param = positive(
    "layer_stiffness",
    "k_h",
    "N/m^3",
    (0.0, 1e11),
    1.0,
    "extra stiffness of the lower layer",
);
pub(super) const LAYER_DEPTH: Param = positive(
    "layer_depth",
    "z_h",
    "m",
    (0.0, 1.0),
    0.5,
    "depth of the lower layer",
);
pub(super) const RESIDUAL: Param = positive(
    "residual_ratio",
    "K_r",
    "1",
    (0.01, 1.0),
    0.3,
    "residual over peak shear stress",
);
pub(super) const ADHESION: Param = positive(
    "adhesion",
    "c_a",
    "Pa",
    (0.0, 1e6),
    0.5,
    "adhesion of soil to the rim",
);
pub(super) const INTERFACE_ANGLE: Param = positive(
    "interface_friction_angle",
    "δ",
    "rad",
    (0.0, 1.5),
    0.15,
    "angle of friction between soil and rim",
);
pub(super) const C3: Param = plain(
    "c3",
    "c3",
    "1",
    (-0.95, 0.5),
    0.2,
    "exit angle over entry angle; below 0 behind the bottom",
);
pub(super) const LUG_REACH: Param = plain(
    "lug_reach",
    "λ h",
    "m",
    (0.0, 0.5),
    0.005,
    "height of the lugs times the share of it that shears soil",
);
pub(super) const LUG_HEIGHT: Param = plain(
    "lug_height",
    "h",
    "m",
    (0.0, 0.2),
    0.003,
    "height of the lugs above the rim",
);
pub(super) const LUG_COUNT: Param = plain(
    "lug_count",
    "N",
    "1",
    (0.0, 200.0),
    1.0,
    "lugs around the wheel",
);
pub(super) const TYRE_PRESSURE: Param = crate::models::compliant_tyre::PRESSURE;
pub(super) const LATERAL_MODULUS: Param = positive(
    "lateral_shear_modulus",
    "K_y",
    "m",
    (1e-5, 1.0),
    0.4,
    "shear deformation modulus across the wheel",
);
