//! The ground of an ideal differential drive: every wheel slips by the same share.

use terra_model::{Contact, Hook, ModelError, Param, Real, Scale, TerrainModel, WheelForces};

/// The one free number: slip i of every wheel.
pub(crate) const SLIP: Param = Param {
    name: "slip",
    symbol: "i",
    unit: "1",
    min: -0.5,
    max: 0.95,
    scale: Scale::Linear,
    prior_sd: 0.1,
    doc: "longitudinal slip 1 - v/(R ω), the same at every wheel",
};

/// Ground on which every wheel advances by (1 - i) of its rim speed: the simulator without terramechanics.
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
        "no forces: every wheel advances by the same share of its rim speed";
    const PARAMS: &'static [Param] = &[SLIP];
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
