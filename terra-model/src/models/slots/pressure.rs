//! The pressure slot: normal stress against sinkage.
//!
//! # Equation
//! - `bekker`: p = k z^n, k = k_c/b + k_φ
//! - `reece`: p = (c k_c' + γ b k_φ') (z/b)^n
//! - `slip-exponent`: p = k z^(n0 + n1 |s|)
//! - `exponential-snow`: p = p_w (1 - e^(-z/z_w))
//! - `peat`: p = k_p z + 4 m_m z²/D_h, D_h = 4 area/perimeter = 2 b L/(b + L), L the length of the contact
//! - `unload-reload`: p = p_u - k_u (z_u - z) down to zero below the largest past sinkage z_u, p_u = k z_u^n,
//!   k_u = k_0 + A_u z_u; p = k z^n beyond it
//! - `layered`: p = k z^n + k_h (z - z_h) below z_h

use super::checks::{Must, Values, quantity};
use super::params as par;
use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::param::Param;
use crate::real::{Real, Root};

/// The laws by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PressureKind {
    Bekker,
    Reece,
    SlipExponent,
    ExponentialSnow,
    Peat,
    UnloadReload,
    Layered,
}

impl PressureKind {
    pub(super) const ALL: [PressureKind; 7] = [
        PressureKind::Bekker,
        PressureKind::Reece,
        PressureKind::SlipExponent,
        PressureKind::ExponentialSnow,
        PressureKind::Peat,
        PressureKind::UnloadReload,
        PressureKind::Layered,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            PressureKind::Bekker => "bekker",
            PressureKind::Reece => "reece",
            PressureKind::SlipExponent => "slip-exponent",
            PressureKind::ExponentialSnow => "exponential-snow",
            PressureKind::Peat => "peat",
            PressureKind::UnloadReload => "unload-reload",
            PressureKind::Layered => "layered",
        }
    }

    pub(super) fn summary(self) -> &'static str {
        match self {
            PressureKind::Bekker => "Bekker pressure",
            PressureKind::Reece => "Reece's pressure, which knows cohesion, weight and width",
            PressureKind::SlipExponent => "Bekker pressure whose exponent grows with slip",
            PressureKind::ExponentialSnow => "the exponential pressure of snow",
            PressureKind::Peat => "the pressure of peat under a mat",
            PressureKind::UnloadReload => "Bekker pressure in the rut of an earlier pass",
            PressureKind::Layered => "Bekker pressure above a stiffer layer",
        }
    }

    pub(super) fn equation(self) -> &'static str {
        match self {
            PressureKind::Bekker => "p = k z^n, k = k_c/b + k_φ",
            PressureKind::Reece => "p = (c k_c' + γ b k_φ') (z/b)^n",
            PressureKind::SlipExponent => "p = k z^(n0 + n1 |s|)",
            PressureKind::ExponentialSnow => "p = p_w (1 - e^(-z/z_w))",
            PressureKind::Peat => "p = k_p z + 4 m_m z²/D_h, D_h = 2 b L/(b + L)",
            PressureKind::UnloadReload => {
                "p = p_u - k_u (z_u - z), down to zero, where z < z_u, k_u = k_0 + A_u z_u; p = k z^n beyond"
            }
            PressureKind::Layered => "p = k z^n + k_h (z - z_h) below z_h",
        }
    }

    pub(super) fn reference(self) -> &'static str {
        match self {
            PressureKind::Bekker => "M. G. Bekker, Introduction to Terrain-Vehicle Systems, 1969",
            PressureKind::Reece => {
                "A. R. Reece, Proc. Inst. Mech. Eng. 180(2):45-66, 1965 (formula recalled)"
            }
            PressureKind::SlipExponent => {
                "L. Ding et al., J. Field Robotics 28(6), 2011 (formula recalled; |s| in braking is chosen)"
            }
            PressureKind::ExponentialSnow => {
                "J. Y. Wong, Theory of Ground Vehicles (formula recalled)"
            }
            PressureKind::Peat => {
                "J. Y. Wong, J. R. Radforth, J. Preston-Thomas, J. Terramechanics 19(4), 1982 (formula recalled)"
            }
            PressureKind::UnloadReload => {
                "J. Y. Wong, Theory of Ground Vehicles (formula recalled)"
            }
            PressureKind::Layered => {
                "J. Y. Wong, Theory of Ground Vehicles (recalled); chosen form"
            }
        }
    }

    /// Parameters; Reece's law needs a cohesion of its own where the shear law has none of the soil.
    pub(super) fn params(self, shear_has_cohesion: bool) -> Vec<Param> {
        let mut out = match self {
            PressureKind::Bekker => vec![],
            PressureKind::Reece => {
                vec![
                    par::K_C_PRIME,
                    par::K_PHI_PRIME,
                    par::EXPONENT,
                    par::UNIT_WEIGHT,
                ]
            }
            PressureKind::SlipExponent => vec![par::SLIP_EXPONENT],
            PressureKind::ExponentialSnow => vec![par::SNOW_PRESSURE, par::SNOW_DEPTH],
            PressureKind::Peat => vec![par::PEAT_STIFFNESS, par::MAT_STIFFNESS],
            PressureKind::UnloadReload => {
                vec![
                    par::UNLOADING_STIFFNESS,
                    par::UNLOADING_GROWTH,
                    par::PAST_SINKAGE,
                ]
            }
            PressureKind::Layered => vec![par::LAYER_STIFFNESS, par::LAYER_DEPTH],
        };
        if self.is_bekker() {
            out.splice(0..0, [par::K_C, par::K_PHI, par::EXPONENT]);
        }
        if self == PressureKind::Reece && !shear_has_cohesion {
            out.push(par::COHESION);
        }
        out
    }

    /// True where k_c, k_φ and n mean what they do in Bekker's law.
    pub(super) fn is_bekker(self) -> bool {
        !matches!(
            self,
            PressureKind::Reece | PressureKind::ExponentialSnow | PressureKind::Peat
        )
    }

    pub(super) fn hooks(self) -> &'static [Hook] {
        match self {
            PressureKind::ExponentialSnow | PressureKind::Peat => &[Hook::Stiffness, Hook::Layer],
            _ => &[Hook::Stiffness, Hook::SinkageExponent, Hook::Layer],
        }
    }

    /// The law with its numbers, and a layer of its own below a depth.
    pub(super) fn read<T: Real>(
        self,
        values: &Values<'_, T>,
        at: &Contact<T>,
    ) -> Result<(Pressure<T>, Option<Layer<T>>), ModelError> {
        let factor = at.hooks.stiffness;
        let model = values.model;
        let exponent = |more: T| {
            let n = values.get("sinkage_exponent", Must::BeFinite)?;
            quantity(
                model,
                "sinkage_exponent",
                n + more + at.hooks.sinkage_exponent,
                Must::BePositive,
            )
        };
        let bekker = || {
            let k_c = values.get("k_c", Must::BeFinite)?;
            let k_phi = values.get("k_phi", Must::BeFinite)?;
            quantity(
                model,
                "k_c/b + k_phi",
                (k_c / at.width + k_phi) * factor,
                Must::BePositive,
            )
        };
        let power = |stiffness, exponent| Pressure::Power {
            stiffness,
            exponent,
        };
        let law = match self {
            PressureKind::Bekker => power(bekker()?, exponent(T::zero())?),
            PressureKind::Layered => {
                let depth = values.get("layer_depth", Must::NotBeNegative)?;
                let stiffness = values.get("layer_stiffness", Must::NotBeNegative)? * factor;
                let layer = Layer { depth, stiffness };
                return Ok((power(bekker()?, exponent(T::zero())?), Some(layer)));
            }
            PressureKind::SlipExponent => {
                let growth = values.get("slip_exponent", Must::BeFinite)?;
                power(bekker()?, exponent(growth * at.slip.abs())?)
            }
            PressureKind::Reece => {
                // The soil's own: no effect's factor on the shear stress.
                let c = values.get("cohesion", Must::NotBeNegative)?;
                let n = exponent(T::zero())?;
                let weight = values.get("unit_weight", Must::NotBeNegative)? * at.width;
                let sum = c * values.get("k_c_prime", Must::NotBeNegative)?
                    + weight * values.get("k_phi_prime", Must::NotBeNegative)?;
                let stiffness = sum * at.width.pow_pos(-n) * factor;
                let stiffness = quantity(
                    model,
                    "cohesion k_c_prime + unit_weight b k_phi_prime",
                    stiffness,
                    Must::BePositive,
                )?;
                power(stiffness, n)
            }
            PressureKind::ExponentialSnow => Pressure::Plateau {
                pressure: values.get("snow_pressure", Must::BePositive)? * factor,
                depth: values.get("snow_depth", Must::BePositive)?,
            },
            PressureKind::Peat => Pressure::Peat {
                stiffness: values.get("peat_stiffness", Must::BePositive)? * factor,
                mat: values.get("mat_stiffness", Must::NotBeNegative)? * factor,
                width: at.width,
            },
            PressureKind::UnloadReload => {
                let (stiffness, exponent) = (bekker()?, exponent(T::zero())?);
                // A wheel ahead of all others runs on virgin soil.
                let passed = at.earlier_passes.min_of(T::one()).max_of(T::zero());
                let deepest = values.get("past_sinkage", Must::NotBeNegative)? * passed;
                let unloading = (values.get("unloading_stiffness", Must::BePositive)?
                    + values.get("unloading_growth", Must::NotBeNegative)? * deepest)
                    * factor;
                let held = deepest.max_of(T::from(SHALLOW));
                let pressure = stiffness * held.pow_pos(exponent);
                let floor = quantity(
                    model,
                    "past_sinkage less its elastic part",
                    held - pressure / unloading,
                    Must::NotBeNegative,
                );
                // No rut to speak of: virgin soil, whatever the unloading line.
                let none = !T::Primal::from(SHALLOW).any_lt(deepest.primal());
                if none {
                    return Ok((power(stiffness, exponent), None));
                }
                let floor = floor?;
                Pressure::Rut {
                    stiffness,
                    exponent,
                    unloading,
                    floor,
                    elastic: held - floor,
                }
            }
        };
        Ok((law, None))
    }
}

/// A rut shallower than this \[m\] is none.
const SHALLOW: f64 = 1e-9;

/// Deeper than any wheel \[m\].
const NEVER: f64 = 1e9;

/// k_h (z - z_h) more below z_h.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer<T> {
    pub(super) depth: T,
    pub(super) stiffness: T,
}

impl<T: Real> Layer<T> {
    pub(super) fn map<S>(self, f: impl Fn(T) -> S) -> Layer<S> {
        Layer {
            depth: f(self.depth),
            stiffness: f(self.stiffness),
        }
    }

    pub(super) fn extra(&self, depth: T) -> T {
        let below = depth - self.depth;
        zero_below(below) * self.stiffness
    }
}

fn zero_below<T: Real>(x: T) -> T {
    x.select_lt(T::zero(), T::zero(), x)
}

/// A law with its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pressure<T> {
    Power {
        stiffness: T,
        exponent: T,
    },
    Plateau {
        pressure: T,
        depth: T,
    },
    Peat {
        stiffness: T,
        mat: T,
        width: T,
    },
    /// Peat under a contact of known length.
    Quadratic {
        linear: T,
        quadratic: T,
    },
    Rut {
        stiffness: T,
        exponent: T,
        unloading: T,
        /// Depth of the rut's floor, where the contact begins.
        floor: T,
        /// From there to the largest past sinkage.
        elastic: T,
    },
}

impl<T: Real> Pressure<T> {
    pub(super) fn map<S>(self, f: impl Fn(T) -> S) -> Pressure<S> {
        match self {
            Pressure::Power {
                stiffness,
                exponent,
            } => Pressure::Power {
                stiffness: f(stiffness),
                exponent: f(exponent),
            },
            Pressure::Plateau { pressure, depth } => Pressure::Plateau {
                pressure: f(pressure),
                depth: f(depth),
            },
            Pressure::Peat {
                stiffness,
                mat,
                width,
            } => Pressure::Peat {
                stiffness: f(stiffness),
                mat: f(mat),
                width: f(width),
            },
            Pressure::Quadratic { linear, quadratic } => Pressure::Quadratic {
                linear: f(linear),
                quadratic: f(quadratic),
            },
            Pressure::Rut {
                stiffness,
                exponent,
                unloading,
                floor,
                elastic,
            } => Pressure::Rut {
                stiffness: f(stiffness),
                exponent: f(exponent),
                unloading: f(unloading),
                floor: f(floor),
                elastic: f(elastic),
            },
        }
    }

    /// The law under a contact of this length.
    pub(super) fn under(self, length: T) -> Self {
        match self {
            Pressure::Peat {
                stiffness,
                mat,
                width,
            } => Pressure::Quadratic {
                linear: stiffness,
                // 4/D_h = 2 (1/L + 1/b)
                quadratic: mat * (T::one() / length + T::one() / width) * 2.0,
            },
            law => law,
        }
    }

    /// True where a depth alone does not tell p.
    pub(super) fn feels_length(&self) -> bool {
        matches!(self, Pressure::Peat { .. })
    }

    /// Depth at which p reaches a pressure; [`NEVER`] where it does not.
    pub(super) fn depth_at(&self, pressure: T) -> T {
        let power = |stiffness: T, exponent: T| ((pressure / stiffness).ln() / exponent).exp();
        match *self {
            Pressure::Power {
                stiffness,
                exponent,
            } => power(stiffness, exponent),
            Pressure::Plateau {
                pressure: most,
                depth,
            } => {
                let left = T::one() - pressure / most;
                let held = T::zero().select_lt(left, left, T::one());
                T::zero().select_lt(left, -(held.ln() * depth), T::from(NEVER))
            }
            Pressure::Peat { stiffness, .. } => pressure / stiffness,
            Pressure::Quadratic { linear, quadratic } => {
                let root = (linear.squared() + quadratic * pressure * 4.0).sqrt();
                pressure * 2.0 / (linear + root)
            }
            Pressure::Rut {
                stiffness,
                exponent,
                unloading,
                floor,
                elastic,
            } => (pressure / unloading).select_lt(
                elastic,
                pressure / unloading,
                power(stiffness, exponent) - floor,
            ),
        }
    }

    /// m of p ~ z^m at the surface.
    pub(super) fn exponent(&self) -> T {
        match self {
            Pressure::Power { exponent, .. } => *exponent,
            _ => T::one(),
        }
    }

    /// p at a depth below the surface that the wheel meets.
    pub(super) fn at(&self, depth: T) -> T {
        self.over_power(depth, T::one())
    }

    /// p/u^m at the depth `base` u.
    pub(super) fn over_power(&self, base: T, u: T) -> T {
        match *self {
            Pressure::Power {
                stiffness,
                exponent,
            } => stiffness * base.pow_pos(exponent),
            Pressure::Plateau { pressure, depth } => -(-(base * u / depth)).exp_m1() * pressure / u,
            Pressure::Peat { stiffness, .. } => stiffness * base,
            Pressure::Quadratic { linear, quadratic } => (linear + quadratic * base * u) * base,
            Pressure::Rut {
                stiffness,
                exponent,
                unloading,
                floor,
                elastic,
            } => {
                let depth = base * u;
                let virgin =
                    stiffness * (depth + floor).max_of(T::from(SHALLOW)).pow_pos(exponent) / u;
                depth.select_lt(elastic, unloading * base, virgin)
            }
        }
    }

    /// Depth at which p has a bend.
    pub(super) fn bend(&self) -> Option<T> {
        match self {
            Pressure::Rut { elastic, .. } => Some(*elastic),
            _ => None,
        }
    }

    /// Depth over which p is nearly a straight line, where it has such a length.
    pub(super) fn length(&self) -> Option<T> {
        match self {
            Pressure::Plateau { depth, .. } => Some(*depth),
            _ => None,
        }
    }

    /// How far the surface that the wheel meets lies below the undisturbed one.
    pub(super) fn floor(&self) -> T {
        match self {
            Pressure::Rut { floor, .. } => *floor,
            _ => T::zero(),
        }
    }

    /// Entry angle of a smooth wheel that only compacts this soil: the starting point of the iteration.
    ///
    /// W = b k sqrt(2R) z^(n + 1/2) (3 - n)/3.
    pub(super) fn entry_guess(&self, load: T, radius: T, width: T) -> T {
        let (k, n) = match *self {
            Pressure::Power {
                stiffness,
                exponent,
            }
            | Pressure::Rut {
                stiffness,
                exponent,
                ..
            } => (stiffness, exponent),
            Pressure::Plateau { pressure, depth } => (pressure / depth, T::one()),
            Pressure::Peat { stiffness, .. } => (stiffness, T::one()),
            Pressure::Quadratic { linear, .. } => (linear, T::one()),
        };
        let shape = (T::from(3.0) - n).max_of(T::from(0.5)) / 3.0;
        let z = (load / (width * k * (radius * 2.0).sqrt() * shape)).pow_pos(T::one() / (n + 0.5));
        (z * 2.0 / radius).sqrt()
    }
}
