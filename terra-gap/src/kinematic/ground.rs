//! The ground of an ideal differential drive: every wheel slips by the same share, and by more the more it pushes.

use terra_model::{Contact, Hook, ModelError, Param, Real, Scale, TerrainModel, WheelForces};

/// Slip i of every wheel at constant speed.
const SLIP: Param = Param {
    name: "slip",
    symbol: "i",
    unit: "1",
    min: -0.5,
    max: 0.95,
    scale: Scale::Linear,
    prior_sd: 0.1,
    doc: "longitudinal slip 1 - v/(R ω) at constant speed, the same at every wheel",
};

/// What slip an acceleration of 1 g would cost: below the traction limit, push is nearly proportional to slip.
const COMPLIANCE: Param = Param {
    name: "slip_per_acceleration",
    symbol: "c_t",
    unit: "1",
    min: -0.5,
    max: 2.0,
    scale: Scale::Linear,
    prior_sd: 0.3,
    doc: "slip per forward push, in weights of the vehicle: the ground's compliance along the wheel",
};

/// How much faster than its push a wheel's slip grows.
const BEND: Param = Param {
    name: "slip_bend",
    symbol: "b",
    unit: "1",
    min: -0.5,
    max: 10.0,
    scale: Scale::Linear,
    prior_sd: 1.0,
    doc: "relative growth of the compliance per push, in weights of the vehicle: half of one over the coefficient of traction",
};

/// How far the body lags behind wheels that change their speed.
const LAG: Param = Param {
    name: "lag",
    symbol: "τ",
    unit: "s",
    min: -0.5,
    max: 2.0,
    scale: Scale::Linear,
    prior_sd: 0.03,
    doc: "speed lost per acceleration, at any speed: ground gives way, tyres wind up and motors follow late, as a late sensor would show it",
};

/// Ground on which every wheel advances by (1 - i - c_t p (1 + b |p|)) of its rim speed, p = a/g + sin θ its push with θ the slope: the
/// simulator without terramechanics. (The shear curve of Janosi and Hanamoto, p = μ (1 - exp(-i/(c_t μ))), to second order: b = 1/(2 μ).)
///
/// It has no forces. An effect acts on it through the vehicle, the sensors, or two entries of the contact that have a
/// kinematic meaning: the radius, and the stiffness of the ground (a slip i under nominal ground is i/κ where the ground
/// is κ times as stiff: to first order slip is resistance over shear stiffness).
///
/// # Reference
/// J. Y. Wong, Theory of Ground Vehicles (slip); the reading of the stiffness is chosen.
#[derive(Clone, Copy, Debug, Default)]
pub struct UniformSlip;

impl TerrainModel for UniformSlip {
    const NAME: &'static str = "ideal-differential-drive";
    const SUMMARY: &'static str =
        "no forces: every wheel advances by the same share of its rim speed, less where it pushes";
    const PARAMS: &'static [Param] = &[SLIP, COMPLIANCE, BEND, LAG];
    const REFERENCE: &'static str = "A. Mandow et al., IROS 2007, with χ = 1";
    const HOOKS: &'static [Hook] = &[Hook::Stiffness];

    fn wheel_forces<T: Real>(
        &self,
        _p: &[T],
        _at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        Err(ModelError::Contact {
            quantity: "forces of a kinematic model",
            value: f64::NAN,
            expected: "a terrain model",
        })
    }
}
