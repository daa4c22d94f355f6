//! Other forms of layered soil: a layer nearer the surface, and hard ground that only the pressure reaches.

use super::bekker_sinkage;
use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::LayeredSoil;
use crate::effects::layered_soil::add_layer;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// A stiffer layer lies 10 mm below the surface.
///
/// # Equation
/// σ -> σ + k_h (z - z_h) below z_h, k_h = e k z_h^(n - 1), z_h = 10 mm
///
/// # Reference
/// J. Y. Wong, Theory of Ground Vehicles (layered terrain); chosen depth and prior.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShallowLayer;

impl Effect for ShallowLayer {
    form_of!(LayeredSoil);
    const FORM: &'static str = "shallow";
    const SUMMARY: &'static str = "a stiffer layer lies 10 mm below the surface";
    const PARAMS: &'static [Param] = <LayeredSoil as Effect>::PARAMS;
    const EQUATION: &'static str =
        "σ -> σ + k_h (z - z_h) below z_h, k_h = e k z_h^(n - 1), z_h = 10 mm";
    const REFERENCE: &'static str =
        "J. Y. Wong, Theory of Ground Vehicles (layered terrain); chosen depth and prior";
    const NEEDS: &'static [Hook] = &[Hook::Layer];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        add_layer(e[0], soil, at, 0.01);
    }
}

/// Hard ground lies deeper than the wheel sinks, but its pressure reaches it, the more so the longer the contact.
///
/// # Equation
/// k -> k (1 + 3.5 (l/2) e), e = 1/H, l = sqrt(2 R z_0), z_0 Bekker's sinkage: a strip of width l on a stratum of depth H
///
/// # Reference
/// G. Gazetas, J. Geotech. Eng. 109, 1983: vertical stiffness of a strip on a stratum over rigid ground (recalled).
#[derive(Clone, Copy, Debug, Default)]
pub struct PressureBulb;

impl Effect for PressureBulb {
    form_of!(LayeredSoil);
    const FORM: &'static str = "pressure-bulb";
    const SUMMARY: &'static str = "hard ground lies deeper than the wheel sinks, but its pressure reaches it, the more so the longer the contact";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1/m",
        [0.0, 1000.0],
        15.0,
        "one over the depth of the hard ground",
    )];
    const EQUATION: &'static str = "k -> k (1 + 3.5 (l/2) e), e = 1/H, l = sqrt(2 R z_0), z_0 Bekker's sinkage: a strip of width l on a stratum of depth H";
    const REFERENCE: &'static str = "G. Gazetas, J. Geotech. Eng. 109, 1983: vertical stiffness of a strip on a stratum over rigid ground (recalled)";
    const NEEDS: &'static [Hook] = &[Hook::Stiffness];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let Some(z) = bekker_sinkage(soil, at) else {
            return;
        };
        let half = (z.max_of(T::from(1e-12)) * at.radius * 2.0).sqrt() * 0.5;
        at.hooks.stiffness *= e[0] * half * 3.5 + 1.0;
    }
}
