//! Other formulas of the effects: one name, several forms, so that an effect whose formula is not the default's is still
//! called by its name.
//!
//! Forms of one name differ in the mechanism that carries the sign (stress, geometry, resistance, strength) where the
//! literature has such, and else in a curve that it has.
//!
//! One form only: what is a definition (the bias or scale of a sensor, a mass, a radius, a track width, a centre of
//! gravity, an inclination), and a towed load and air resistance, which are a constant and a square of speed. A shear stress
//! with a residual strength is also a slot of the models (`wong-hump`): that published hump has no value at which it is no
//! hump, so it is a structure and no form of `shear-hump`.

/// What a form has from the effect it is a form of: name, kind of log, where it shows, the experiment that isolates it.
macro_rules! form_of {
    ($effect:ty) => {
        const NAME: &'static str = <$effect as $crate::effect::Effect>::NAME;
        const SCOPE: $crate::effect::Scope = <$effect as $crate::effect::Effect>::SCOPE;
        const REGIME: &'static str = <$effect as $crate::effect::Effect>::REGIME;
        const ISOLATED_BY: &'static str = <$effect as $crate::effect::Effect>::ISOLATED_BY;
    };
}

mod bulldozing;
mod drivetrain_friction;
mod ground_speed_delay;
mod grousers;
mod interface_friction;
mod lateral_bulldozing;
mod lateral_contrast;
mod layered_soil;
mod multipass;
mod rate_stiffening;
mod rear_contact;
mod shear_hump;
mod skid_steer_lateral_slip;
mod slip_sinkage;
mod terrain_drift;
mod torque_droop;
mod wheel_compliance;

pub use bulldozing::{BearingCapacity, RubbingPile};
pub use drivetrain_friction::{Lubricant, Stribeck};
pub use ground_speed_delay::FirstOrder;
pub use grousers::{PassiveLug, SideWalls};
pub use interface_friction::{Adhesion, SkinAngle};
pub use lateral_bulldozing::{CuttingFlank, SweptPressure};
pub use lateral_contrast::StrengthContrast;
pub use layered_soil::{PressureBulb, ShallowLayer};
pub use multipass::{PackedStrength, Rut};
pub use rate_stiffening::{RimSpeed, ShearRate};
pub use rear_contact::{ElasticUnloading, EnergyReturn};
pub use shear_hump::PeakStrength;
pub use skid_steer_lateral_slip::PullOnly;
pub use slip_sinkage::{Excavation, Proportional};
pub use terrain_drift::{StrengthDrift, Undulating};
pub use torque_droop::{Hyperbola, Knee};
pub use wheel_compliance::{LinearSpring, SubstituteCircle};

use crate::contact::Contact;
use crate::forces::WheelForces;
use crate::model::Soil;
use crate::real::Real;
use crate::registry::Registry;

/// Depth at which magnitudes that depend on sinkage are quoted \[m\].
const REFERENCE_DEPTH: f64 = 0.02;

/// Bekker's sinkage of a rigid wheel at rest \[m\]; none where k or n is unknown.
///
/// # Equation
/// z_0 = \[3 W/(b (3 - n) k sqrt(2 R))\]^(2/(2n + 1)), n held at 2.5
fn bekker_sinkage<T: Real>(soil: &Soil<T>, at: &Contact<T>) -> Option<T> {
    let (k, n) = (soil.stiffness?, soil.sinkage_exponent?);
    let n = n.min_of(T::from(2.5));
    let share = -n + 3.0;
    let base = at.normal_load * 3.0 / (at.width * share * k * (at.radius * 2.0).sqrt());
    Some(base.pow_pos(T::from(2.0) / (n * 2.0 + 1.0)))
}

/// Work of compaction per length of the rut, b k z^(n+1)/(n+1) \[N\]; none where k, n or z is unknown.
fn compaction_work<T: Real>(soil: &Soil<T>, at: &Contact<T>, forces: &WheelForces<T>) -> Option<T> {
    let (k, n, z) = (soil.stiffness?, soil.sinkage_exponent?, forces.sinkage?);
    let power = n + 1.0;
    // What is not yet sunk at all still has a depth to take the power of.
    Some(at.width * k * z.max_of(T::from(1e-9)).pow_pos(power) / power)
}

/// Registers the forms after the defaults, which a bare name means.
pub(crate) fn register(registry: Registry) -> Registry {
    registry
        .with_effect::<Excavation>()
        .with_effect::<Proportional>()
        .with_effect::<Rut>()
        .with_effect::<PackedStrength>()
        .with_effect::<BearingCapacity>()
        .with_effect::<RubbingPile>()
        .with_effect::<SideWalls>()
        .with_effect::<PassiveLug>()
        .with_effect::<Adhesion>()
        .with_effect::<SkinAngle>()
        .with_effect::<CuttingFlank>()
        .with_effect::<SweptPressure>()
        .with_effect::<PullOnly>()
        .with_effect::<StrengthContrast>()
        .with_effect::<Stribeck>()
        .with_effect::<Lubricant>()
        .with_effect::<ElasticUnloading>()
        .with_effect::<EnergyReturn>()
        .with_effect::<RimSpeed>()
        .with_effect::<ShearRate>()
        .with_effect::<SubstituteCircle>()
        .with_effect::<LinearSpring>()
        .with_effect::<ShallowLayer>()
        .with_effect::<PressureBulb>()
        .with_effect::<PeakStrength>()
        .with_effect::<Hyperbola>()
        .with_effect::<Knee>()
        .with_effect::<FirstOrder>()
        .with_effect::<StrengthDrift>()
        .with_effect::<Undulating>()
}
