//! A stiffer layer lies some way below the surface.
//!
//! # Equation
//! σ -> σ + k_h (z - z_h) below z_h, k_h = e k z_h^(n - 1), z_h = 30 mm
//!
//! # Reference
//! J. Y. Wong, Theory of Ground Vehicles (layered terrain); chosen form and prior.

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// A stiffer layer lies some way below the surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct LayeredSoil;

/// z_h of the default form \[m\].
const DEPTH: f64 = 0.03;

/// Puts a layer of e times the secant stiffness of the soil above it below `depth` \[m\].
pub(super) fn add_layer<T: Real>(e: T, soil: &Soil<T>, at: &mut Contact<T>, depth: f64) {
    // `NEEDS_SOIL` keeps models without k and n away.
    let (Some(k), Some(n)) = (soil.stiffness, soil.sinkage_exponent) else {
        return;
    };
    let depth = T::from(depth);
    at.hooks.layer_depth = depth;
    at.hooks.layer_stiffness += e * k * depth.pow_pos(n - 1.0);
}

impl Effect for LayeredSoil {
    const NAME: &'static str = "layered-soil";
    const SUMMARY: &'static str = "a stiffer layer lies 30 mm below the surface";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 100.0],
        2.0,
        "stiffness of the layer over the secant stiffness of the soil above it",
    )];
    const EQUATION: &'static str =
        "σ -> σ + k_h (z - z_h) below z_h, k_h = e k z_h^(n - 1), z_h = 30 mm";
    const REFERENCE: &'static str =
        "J. Y. Wong, Theory of Ground Vehicles (layered terrain); chosen form and prior";
    const NEEDS: &'static [Hook] = &[Hook::Layer];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "sinkage and pull, suddenly, where the load reaches the layer";
    const ISOLATED_BY: &'static str =
        "a plate test to 100 mm, or two loads that sink less and more than the layer's depth";

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        add_layer(e[0], soil, at, DEPTH);
    }
}
