//! Other forms of rear contact: an elastic rebound that depends on sinkage, energy given back.

use super::{REFERENCE_DEPTH, bekker_sinkage, compaction_work};
use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::effects::RearContact;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// Soil rebounds by its unloading slope, most where it yields little.
///
/// # Equation
/// θ2 = -e (z_0/20 mm)^((n - 1)/2) θ1, held at .95, z_0 Bekker's sinkage: z_e/z = k z^(n-1)/k_u of an elastic rebound
/// z_e = p/k_u
///
/// # Reference
/// J. Y. Wong, Theory of Ground Vehicles (unloading and reloading); M. G. Bekker, 1969, for z_0.
#[derive(Clone, Copy, Debug, Default)]
pub struct ElasticUnloading;

impl Effect for ElasticUnloading {
    form_of!(RearContact);
    const FORM: &'static str = "elastic-unloading";
    const SUMMARY: &'static str =
        "soil rebounds by its unloading slope, most where it yields little";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 0.9],
        0.3,
        "exit over entry angle at 20 mm",
    )];
    const EQUATION: &'static str = "θ2 = -e (z_0/20 mm)^((n - 1)/2) θ1, held at .95, z_0 Bekker's sinkage: z_e/z = k z^(n-1)/k_u of an elastic rebound z_e = p/k_u";
    const REFERENCE: &'static str = "J. Y. Wong, Theory of Ground Vehicles (unloading and reloading); M. G. Bekker, 1969, for z_0";
    const NEEDS: &'static [Hook] = &[Hook::ExitRatio];
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let (Some(z), Some(n)) = (bekker_sinkage(soil, at), soil.sinkage_exponent) else {
            return;
        };
        let ratio = e[0] * (z * (1.0 / REFERENCE_DEPTH)).pow_pos((n - 1.0) * 0.5);
        at.hooks.exit_ratio += ratio.min_of(T::from(0.95));
    }
}

/// Rebounding soil pushes the wheel on and gives back part of the compaction work.
///
/// # Equation
/// D -> D + e b k z^(n+1)/(n+1), z -> z (1 - e/2): what stays behind of a rut that springs back
///
/// # Reference
/// energy balance of an elastic part e of the compaction work, as J. Y. Wong, Theory of Ground Vehicles; chosen form.
#[derive(Clone, Copy, Debug, Default)]
pub struct EnergyReturn;

impl Effect for EnergyReturn {
    form_of!(RearContact);
    const FORM: &'static str = "energy-return";
    const SUMMARY: &'static str =
        "rebounding soil pushes the wheel on and gives back part of the compaction work";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 0.9],
        0.3,
        "share of the compaction work given back",
    )];
    const EQUATION: &'static str = "D -> D + e b k z^(n+1)/(n+1), z -> z (1 - e/2): what stays behind of a rut that springs back";
    const REFERENCE: &'static str = "energy balance of an elastic part e of the compaction work, as J. Y. Wong, Theory of Ground Vehicles; chosen form";
    const NEEDS_SOIL: &'static [&'static str] = &["stiffness", "sinkage_exponent"];
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);

    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let Some(work) = compaction_work(soil, at, forces) else {
            return;
        };
        let returned = work * e[0];
        forces.drawbar_pull += returned;
        forces.parts.other += returned;
        forces.sinkage = forces.sinkage.map(|z| z * (T::one() - e[0] * 0.5));
    }
}
