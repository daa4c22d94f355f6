//! Reading numbers that must lie in a range, with errors that name them.

use crate::contact::Contact;
use crate::error::ModelError;
use crate::param::Param;
use crate::real::{Real, Root};

/// What a number must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::models) enum Must {
    BeFinite,
    BePositive,
    NotBeNegative,
    /// In \[0, π/2).
    BeAcute,
    /// In (0, 1\].
    BeShare,
}

impl Must {
    fn holds<T: Real>(self, x: T) -> bool {
        let x = x.primal();
        x.is_finite()
            && match self {
                Must::BeFinite => true,
                Must::BePositive => x.min_lane() > 0.0,
                Must::NotBeNegative => x.min_lane() >= 0.0,
                Must::BeAcute => x.min_lane() >= 0.0 && x.max_lane() < std::f64::consts::FRAC_PI_2,
                Must::BeShare => x.min_lane() > 0.0 && x.max_lane() <= 1.0,
            }
    }

    fn words(self) -> &'static str {
        match self {
            Must::BeFinite => "a finite value",
            Must::BePositive => "a finite value above 0",
            Must::NotBeNegative => "a finite value of at least 0",
            Must::BeAcute => "an angle in [0, π/2) rad",
            Must::BeShare => "a value in (0, 1]",
        }
    }
}

/// A quantity derived from parameters.
pub(in crate::models) fn quantity<T: Real>(
    model: &'static str,
    parameter: &'static str,
    value: T,
    must: Must,
) -> Result<T, ModelError> {
    if must.holds(value) {
        return Ok(value);
    }
    Err(ModelError::Parameter {
        model,
        parameter,
        value: value.primal().min_lane(),
        expected: must.words(),
    })
}

fn of_contact<T: Real>(quantity: &'static str, value: T, must: Must) -> Result<(), ModelError> {
    if must.holds(value) {
        return Ok(());
    }
    Err(ModelError::Contact {
        quantity,
        value: value.primal().min_lane(),
        expected: must.words(),
    })
}

/// The part of a parameter vector that belongs to one slot, read in the order it is declared.
pub(in crate::models) struct Values<'a, T> {
    pub(in crate::models) model: &'static str,
    pub(in crate::models) params: &'static [Param],
    pub(in crate::models) p: &'a [T],
}

impl<T: Real> Values<'_, T> {
    /// The parameter of that name.
    pub(in crate::models) fn get(&self, name: &'static str, must: Must) -> Result<T, ModelError> {
        let place = self.params.iter().position(|q| q.name == name);
        let Some(&value) = place.and_then(|k| self.p.get(k)) else {
            return Err(ModelError::ParameterCount {
                model: self.model.to_owned(),
                expected: self.params.len(),
                found: self.p.len(),
            });
        };
        quantity(self.model, name, value, must)
    }
}

/// Smallest 1 + s of a nearly locked wheel and 1 - s of one that spins in place: beyond it the shear stress is at its
/// limit to rounding.
const NEARLY: f64 = 1e-13;

/// Library slip to kinematic slip i: i = s driving, i = s/(1 + s) braking.
pub(in crate::models) fn kinematic<T: Real>(slip: T) -> T {
    let braking = (slip + 1.0).max_of(T::from(NEARLY));
    slip.select_lt(T::zero(), T::one() - T::one() / braking, slip)
}

/// Rim speed over travel speed less one, R ω/v - 1 = i/(1 - i): s/(1 - s) driving, s braking.
pub(in crate::models) fn rim_excess<T: Real>(slip: T) -> T {
    let driving = (T::one() - slip).max_of(T::from(NEARLY));
    slip.select_lt(T::zero(), slip, slip / driving)
}

/// The quantities of a contact that every wheel relies on.
///
/// # Errors
/// The first one out of its legal range, by name.
pub(in crate::models) fn contact<T: Real>(at: &Contact<T>) -> Result<(), ModelError> {
    of_contact("normal_load", at.normal_load, Must::BePositive)?;
    of_contact("radius", at.radius, Must::BePositive)?;
    of_contact("width", at.width, Must::BePositive)?;
    let slip = at.slip.primal();
    if !slip.is_finite() || at.slip.abs().primal().max_lane() > 1.0 {
        return Err(ModelError::Contact {
            quantity: "slip",
            value: slip.min_lane(),
            expected: "library slip in [-1, 1]",
        });
    }
    let hooks = &at.hooks;
    of_contact("stiffness factor", hooks.stiffness, Must::BePositive)?;
    of_contact("cohesion factor", hooks.cohesion, Must::NotBeNegative)?;
    of_contact("friction factor", hooks.friction, Must::NotBeNegative)?;
    of_contact(
        "shear modulus factor",
        hooks.shear_modulus,
        Must::BePositive,
    )?;
    of_contact(
        "contact radius factor",
        hooks.contact_radius,
        Must::BePositive,
    )?;
    of_contact("shear hump", hooks.shear_hump, Must::NotBeNegative)?;
    of_contact("lug height", hooks.lug_height, Must::NotBeNegative)?;
    of_contact("layer depth", hooks.layer_depth, Must::NotBeNegative)?;
    of_contact(
        "layer stiffness",
        hooks.layer_stiffness,
        Must::NotBeNegative,
    )?;
    let exit = hooks.exit_ratio.primal();
    if !(exit.is_finite() && exit.min_lane() >= 0.0 && exit.max_lane() < 1.0) {
        return Err(ModelError::Contact {
            quantity: "exit ratio",
            value: exit.min_lane(),
            expected: "a value in [0, 1)",
        });
    }
    if let Some(tan) = hooks.lateral_slip {
        of_contact("lateral slip", tan, Must::BeFinite)?;
    }
    Ok(())
}
