//! The shear slot: how shear stress follows from normal stress and shear displacement.
//!
//! # Equation
//! τ = (c + σ tan φ) E(j/K) with the sign of j, and y = |j|/K:
//! - `janosi-hanamoto`: E = 1 - e^(-y)
//! - `wong-hump`: E = K_r {1 + [1/(K_r (1 - 1/e)) - 1] e^(1 - y)} (1 - e^(-y)), K_r the residual over the stress at y = 1,
//!   which is the peak to within 8 % for every K_r in (0, 1] and exactly at K_r = .661
//! - `muskeg`: E = y e^(1 - y)
//! - `interface`: adhesion and friction of soil on a smooth rim, (c_a + σ tan δ)(1 - e^(-y))

use std::f64::consts::E;

use super::checks::{Must, Values};
use super::params as par;
use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::param::Param;
use crate::real::Real;

/// The laws by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ShearKind {
    JanosiHanamoto,
    WongHump,
    Muskeg,
    Interface,
}

impl ShearKind {
    pub(super) const ALL: [ShearKind; 4] = [
        ShearKind::JanosiHanamoto,
        ShearKind::WongHump,
        ShearKind::Muskeg,
        ShearKind::Interface,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            ShearKind::JanosiHanamoto => "janosi-hanamoto",
            ShearKind::WongHump => "wong-hump",
            ShearKind::Muskeg => "muskeg",
            ShearKind::Interface => "interface",
        }
    }

    pub(super) fn summary(self) -> &'static str {
        match self {
            ShearKind::JanosiHanamoto => "Janosi-Hanamoto shear",
            ShearKind::WongHump => "shear that peaks and settles lower",
            ShearKind::Muskeg => "shear that peaks and vanishes",
            ShearKind::Interface => "shear of soil on a smooth rim",
        }
    }

    pub(super) fn equation(self) -> &'static str {
        match self {
            ShearKind::JanosiHanamoto => "τ = (c + σ tan φ)(1 - e^(-j/K))",
            ShearKind::WongHump => {
                "τ = (c + σ tan φ) K_r {1 + [1/(K_r (1 - 1/e)) - 1] e^(1 - j/K)} (1 - e^(-j/K))"
            }
            ShearKind::Muskeg => "τ = (c + σ tan φ) (j/K) e^(1 - j/K)",
            ShearKind::Interface => "τ = (c_a + σ tan δ)(1 - e^(-j/K))",
        }
    }

    pub(super) fn reference(self) -> &'static str {
        match self {
            ShearKind::JanosiHanamoto => "Z. Janosi, B. Hanamoto, 1961",
            ShearKind::WongHump | ShearKind::Muskeg => {
                "J. Y. Wong, J. Preston-Thomas, J. Terramechanics 19(4), 1983 (formula recalled)"
            }
            ShearKind::Interface => "Coulomb's law on the interface",
        }
    }

    pub(super) fn params(self) -> Vec<Param> {
        match self {
            ShearKind::JanosiHanamoto | ShearKind::Muskeg => {
                vec![par::COHESION, par::FRICTION_ANGLE, par::SHEAR_MODULUS]
            }
            ShearKind::WongHump => vec![
                par::COHESION,
                par::FRICTION_ANGLE,
                par::SHEAR_MODULUS,
                par::RESIDUAL,
            ],
            ShearKind::Interface => {
                vec![par::ADHESION, par::INTERFACE_ANGLE, par::SHEAR_MODULUS]
            }
        }
    }

    /// True where the law's c and φ are those of the soil itself.
    pub(super) fn is_of_the_soil(self) -> bool {
        self != ShearKind::Interface
    }

    /// True where the stress falls again after a peak.
    pub(super) fn falls(self) -> bool {
        matches!(self, ShearKind::WongHump | ShearKind::Muskeg)
    }

    pub(super) fn hooks(self) -> &'static [Hook] {
        match self {
            ShearKind::JanosiHanamoto | ShearKind::Interface => &[
                Hook::Cohesion,
                Hook::Friction,
                Hook::ShearModulus,
                Hook::ShearHump,
            ],
            _ => &[Hook::Cohesion, Hook::Friction, Hook::ShearModulus],
        }
    }

    /// c or c_a, and φ or δ, as given.
    pub(super) fn raw<T: Real>(self, values: &Values<'_, T>) -> Result<(T, T), ModelError> {
        let (c, phi) = if self.is_of_the_soil() {
            ("cohesion", "friction_angle")
        } else {
            ("adhesion", "interface_friction_angle")
        };
        Ok((
            values.get(c, Must::NotBeNegative)?,
            values.get(phi, Must::BeAcute)?,
        ))
    }

    /// The law with its numbers.
    pub(super) fn read<T: Real>(
        self,
        values: &Values<'_, T>,
        at: &Contact<T>,
    ) -> Result<Strength<T>, ModelError> {
        let (cohesion, angle) = self.raw(values)?;
        let form = match self {
            ShearKind::JanosiHanamoto | ShearKind::Interface => Form::Rising {
                hump: at.hooks.shear_hump,
            },
            ShearKind::WongHump => Form::Settling {
                residual: values.get("residual_ratio", Must::BeShare)?,
            },
            ShearKind::Muskeg => Form::Vanishing,
        };
        Ok(Strength {
            cohesion: cohesion * at.hooks.cohesion,
            tan_friction: angle.tan() * at.hooks.friction,
            modulus: values.get("shear_modulus", Must::BePositive)? * at.hooks.shear_modulus,
            form,
        })
    }
}

/// How the strength is mobilised.
#[derive(Clone, Copy, Debug)]
enum Form<T> {
    Rising { hump: T },
    Settling { residual: T },
    Vanishing,
}

/// A law with its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strength<T> {
    pub(super) cohesion: T,
    pub(super) tan_friction: T,
    pub(super) modulus: T,
    form: Form<T>,
}

impl<T: Real> Strength<T> {
    pub(super) fn map<S>(self, f: impl Fn(T) -> S) -> Strength<S> {
        Strength {
            cohesion: f(self.cohesion),
            tan_friction: f(self.tan_friction),
            modulus: f(self.modulus),
            form: match self.form {
                Form::Rising { hump } => Form::Rising { hump: f(hump) },
                Form::Settling { residual } => Form::Settling {
                    residual: f(residual),
                },
                Form::Vanishing => Form::Vanishing,
            },
        }
    }

    /// E at y >= 0.
    pub(super) fn mobilised(&self, y: T) -> T {
        let rise = -(-y).exp_m1();
        let rest = T::one() - rise;
        match self.form {
            Form::Rising { hump } => rise * (hump * y * rest * E + 1.0),
            Form::Settling { residual } => {
                // K_r (1 + A e^(-y)) with A K_r = e (1/(1 - 1/e) - K_r)
                let lift = (T::from(1.0 / (1.0 - 1.0 / E)) - residual) * E;
                rise * (residual + lift * rest)
            }
            Form::Vanishing => y * rest * E,
        }
    }

    /// E with the sign of y = j/K.
    pub(super) fn signed(&self, y: T) -> T {
        let e = self.mobilised(y.abs());
        y.select_lt(T::zero(), -e, e)
    }

    /// True where more displacement can mean less shear stress, so that more sinkage can carry less.
    pub(super) fn falls(&self) -> bool {
        !matches!(self.form, Form::Rising { .. })
    }
}
