//! Soil of the Bekker pressure-sinkage and Janosi-Hanamoto shear laws, shared by the wheel models built on it.
//!
//! # Equation
//! σ = k z^n, k = k_c/b + k_φ;  τ = (c + σ tan φ)(1 - e^(-j/K)).
//!
//! # Reference
//! M. G. Bekker, *Introduction to Terrain-Vehicle Systems* (1969); Z. Janosi and B. Hanamoto (1961).

use std::f64::consts::FRAC_PI_2;

use crate::contact::Contact;
use crate::error::ModelError;
use crate::model::Soil;
use crate::param::{Param, Scale};
use crate::real::{Real, Root};

/// Eight parameters, in this order.
pub(crate) const PARAMS: &[Param] = &[
    Param {
        name: "k_c",
        symbol: "k_c",
        unit: "N/m^(n+1)",
        min: -1e9,
        max: 1e9,
        scale: Scale::Linear,
        prior_sd: 1e4,
        doc: "cohesive modulus of sinkage; one wheel width shows only k_c/b + k_phi",
    },
    Param {
        name: "k_phi",
        symbol: "k_φ",
        unit: "N/m^(n+2)",
        min: 0.0,
        max: 1e10,
        scale: Scale::Log,
        prior_sd: 0.5,
        doc: "frictional modulus of sinkage",
    },
    Param {
        name: "sinkage_exponent",
        symbol: "n",
        unit: "1",
        min: 0.05,
        max: 3.0,
        scale: Scale::Log,
        prior_sd: 0.12,
        doc: "exponent of the pressure-sinkage law",
    },
    Param {
        name: "cohesion",
        symbol: "c",
        unit: "Pa",
        min: 0.0,
        max: 1e6,
        scale: Scale::Log,
        prior_sd: 0.5,
        doc: "shear strength without normal stress",
    },
    Param {
        name: "friction_angle",
        symbol: "φ",
        unit: "rad",
        min: 0.0,
        max: 1.5,
        scale: Scale::Log,
        prior_sd: 0.15,
        doc: "angle of internal friction",
    },
    Param {
        name: "shear_modulus",
        symbol: "K",
        unit: "m",
        min: 1e-5,
        max: 1.0,
        scale: Scale::Log,
        prior_sd: 0.4,
        doc: "shear deformation modulus",
    },
    Param {
        name: "c1",
        symbol: "c1",
        unit: "1",
        min: 0.0,
        max: 1.0,
        scale: Scale::Log,
        prior_sd: 0.2,
        doc: "angle of maximum stress over entry angle at zero slip",
    },
    Param {
        name: "c2",
        symbol: "c2",
        unit: "1",
        min: 0.0,
        max: 1.0,
        scale: Scale::Log,
        prior_sd: 0.3,
        doc: "its growth with slip",
    },
];

/// What the parameters and hooks of a contact mean, checked once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<T> {
    pub(crate) stiffness: T,
    pub(crate) exponent: T,
    pub(crate) cohesion: T,
    pub(crate) tan_friction: T,
    pub(crate) shear_modulus: T,
    /// Kinematic slip i = 1 - v/(R ω).
    pub(crate) slip: T,
    /// θm/θ1.
    pub(crate) apex_ratio: T,
    pub(crate) apex_limited: bool,
}

/// Smallest 1 + s of a nearly locked wheel: beyond it the shear stress is at its limit to rounding.
const LOCKED: f64 = 1e-13;

/// Between which a braked wheel's apex ratio is held; a soil whose c1 lies outside holds it at c1, so that the forces have no
/// jump at zero slip.
const APEX_LIMITS: (f64, f64) = (0.02, 0.98);

/// θm/θ1 = c1 + c2 i, and whether it was held inside the contact (braking only), from the library's and the kinematic slip.
///
/// # Errors
/// An apex outside the contact: c1 + c2 i of a driven wheel, c1 of a braked one, not between 0 and 1.
pub(crate) fn apex_ratio<T: Real>(
    model: &'static str,
    [c1, c2]: [T; 2],
    slip: T,
    kinematic: T,
) -> Result<(T, bool), ModelError> {
    let inside = |x: T| x.primal().min_lane() > 0.0 && x.primal().max_lane() < 1.0;
    let outside = |parameter, value: T| {
        Err(ModelError::Parameter {
            model,
            parameter,
            value: value.primal().min_lane(),
            expected: "a value between 0 and 1: the angle of maximum stress lies inside the contact",
        })
    };
    let free = c1 + c2 * kinematic;
    let braking = slip.primal().any_lt(T::Primal::zero());
    if !free.primal().is_finite() || (!braking && !inside(free)) {
        return outside("c1 + c2 slip", free);
    }
    if braking && !inside(c1) {
        return outside("c1", c1);
    }
    if !braking {
        return Ok((free, false));
    }
    let (low, high) = APEX_LIMITS;
    let held = free
        .max_of(c1.min_of(T::from(low)))
        .min_of(c1.max_of(T::from(high)));
    let ratio = slip.select_lt(T::zero(), held, free);
    let limited = (ratio - free).abs().primal().max_lane() > 0.0;
    Ok((ratio, limited))
}

impl<T: Real> Ground<T> {
    /// Reads parameters and hooks.
    ///
    /// # Errors
    /// A parameter, or a quantity of the contact, out of its legal range, by name.
    pub(crate) fn read(model: &'static str, p: &[T], at: &Contact<T>) -> Result<Self, ModelError> {
        let &[k_c, k_phi, n, c, phi, shear, c1, c2] = p else {
            return Err(ModelError::ParameterCount {
                model: model.to_owned(),
                expected: 8,
                found: p.len(),
            });
        };
        let parameter = |ok: bool, parameter, value: T, expected| {
            if ok {
                Ok(())
            } else {
                Err(ModelError::Parameter {
                    model,
                    parameter,
                    value: value.primal().min_lane(),
                    expected,
                })
            }
        };
        let contact = |ok: bool, quantity, value: T, expected| {
            if ok {
                Ok(())
            } else {
                Err(ModelError::Contact {
                    quantity,
                    value: value.primal().min_lane(),
                    expected,
                })
            }
        };
        let finite = |x: T| x.primal().is_finite();
        let positive = |x: T| finite(x) && x.primal().min_lane() > 0.0;
        let not_negative = |x: T| finite(x) && x.primal().min_lane() >= 0.0;

        contact(
            positive(at.normal_load),
            "normal_load",
            at.normal_load,
            "a finite load above 0 N",
        )?;
        contact(
            positive(at.radius),
            "radius",
            at.radius,
            "a finite radius above 0 m",
        )?;
        contact(
            positive(at.width),
            "width",
            at.width,
            "a finite width above 0 m",
        )?;
        contact(
            finite(at.slip) && at.slip.abs().primal().max_lane() <= 1.0,
            "slip",
            at.slip,
            "library slip in [-1, 1]",
        )?;

        let stiffness = (k_c / at.width + k_phi) * at.hooks.stiffness;
        let exponent = n + at.hooks.sinkage_exponent;
        let friction = phi.primal();
        parameter(
            positive(stiffness),
            "k_c/b + k_phi",
            stiffness,
            "a finite value above 0",
        )?;
        parameter(
            positive(exponent),
            "sinkage_exponent",
            exponent,
            "a finite value above 0",
        )?;
        let hooks = &at.hooks;
        let (cohesion, shear_modulus) = (c * hooks.cohesion, shear * hooks.shear_modulus);
        parameter(
            not_negative(cohesion),
            "cohesion",
            cohesion,
            "a finite value of at least 0 Pa",
        )?;
        parameter(
            finite(phi) && friction.min_lane() >= 0.0 && friction.max_lane() < FRAC_PI_2,
            "friction_angle",
            phi,
            "an angle in [0, π/2) rad",
        )?;
        parameter(
            positive(shear_modulus),
            "shear_modulus",
            shear_modulus,
            "a finite value above 0 m",
        )?;
        let at_least_zero = "a finite value of at least 0";
        contact(
            not_negative(hooks.friction),
            "friction factor",
            hooks.friction,
            at_least_zero,
        )?;
        contact(
            positive(hooks.contact_radius),
            "contact radius factor",
            hooks.contact_radius,
            "a finite value above 0",
        )?;
        contact(
            not_negative(hooks.exit_ratio) && hooks.exit_ratio.primal().max_lane() < 1.0,
            "exit ratio",
            hooks.exit_ratio,
            "a value in [0, 1)",
        )?;
        contact(
            not_negative(hooks.shear_hump),
            "shear hump",
            hooks.shear_hump,
            at_least_zero,
        )?;
        contact(
            not_negative(hooks.lug_height),
            "lug height",
            hooks.lug_height,
            "a finite height of at least 0 m",
        )?;
        contact(
            not_negative(hooks.layer_depth),
            "layer depth",
            hooks.layer_depth,
            "a finite depth of at least 0 m",
        )?;
        contact(
            not_negative(hooks.layer_stiffness),
            "layer stiffness",
            hooks.layer_stiffness,
            at_least_zero,
        )?;
        if let Some(tan) = hooks.lateral_slip {
            contact(finite(tan), "lateral slip", tan, "a finite tangent")?;
        }

        // Library slip to kinematic slip: i = s driving, i = s/(1 + s) braking.
        let braking = (at.slip + 1.0).max_of(T::from(LOCKED));
        let slip = at
            .slip
            .select_lt(T::zero(), T::one() - T::one() / braking, at.slip);
        let (apex_ratio, apex_limited) = apex_ratio(model, [c1, c2], at.slip, slip)?;
        Ok(Ground {
            stiffness,
            exponent,
            cohesion,
            tan_friction: phi.tan() * hooks.friction,
            shear_modulus,
            slip,
            apex_ratio,
            apex_limited,
        })
    }

    /// The same values as another scalar.
    pub(crate) fn map<S>(self, f: impl Fn(T) -> S) -> Ground<S> {
        Ground {
            stiffness: f(self.stiffness),
            exponent: f(self.exponent),
            cohesion: f(self.cohesion),
            tan_friction: f(self.tan_friction),
            shear_modulus: f(self.shear_modulus),
            slip: f(self.slip),
            apex_ratio: f(self.apex_ratio),
            apex_limited: self.apex_limited,
        }
    }

    /// Entry angle of a smooth wheel that only compacts the soil: the starting point of the iteration.
    ///
    /// W = b k sqrt(2R) z^(n + 1/2) (3 - n)/3.
    pub(crate) fn compaction_guess(&self, load: T, radius: T, width: T) -> T {
        let shape = (T::from(3.0) - self.exponent).max_of(T::from(0.5)) / 3.0;
        let z = (load / (width * self.stiffness * (radius * 2.0).sqrt() * shape))
            .pow_pos(T::one() / (self.exponent + 0.5));
        (z * 2.0 / radius).sqrt()
    }
}

/// Soil values by role for effects.
pub(crate) fn soil<T: Real>(p: &[T], at: &Contact<T>) -> Soil<T> {
    match p {
        &[k_c, k_phi, n, c, phi, shear, ..] => Soil {
            cohesion: Some(c),
            friction_angle: Some(phi),
            stiffness: Some(k_c / at.width + k_phi),
            sinkage_exponent: Some(n),
            shear_modulus: Some(shear),
        },
        _ => Soil::unknown(),
    }
}
