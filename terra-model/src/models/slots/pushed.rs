//! Soil that parts of a wheel push until it breaks: lugs along the wheel, its flank across.
//!
//! # Equation
//! A lug at an angle θ of the contact: F_p = b (γ h² N_p/2 + q h N_p + 2 c h sqrt(N_p)) E(j), N_p = tan²(45° + φ/2),
//! q = σ(θ), at right angles to the radius; the first term acts 2h/3 above the rim, the others h/2. With N lugs around the
//! wheel the mean over their places is N/(2π) ∫ F_p dθ. E(j) of the rim (chosen) lets the push begin at zero slip. Spread
//! over the rim that mean is a shear stress N F_p/(2π R b), farther from the axle than the rim's own.
//! Lugs so near to one another that the soil between them moves as a block are not described.
//!
//! A wheel under a slip angle β: j_y = R (1 - i)(θ1 - θ) tan β, τ_y = (c + σ tan φ)(1 - e^(-|j_y|/K_y)), and on the flank
//! R_s = D1 (c h + D2 γ h²/2) with D1 = cot X + tan(X + φ), D2 = cot X + cot² X tan φ, X = 45° - φ/2, h the local depth:
//! F_y = -∫ \[R b τ_y + R_s (R - h cos θ)\] dθ. R_s takes the sign of β by tanh(10 tan β) (chosen).

use super::shear::Strength;
use crate::error::ModelError;
use crate::real::{Real, Root};

/// The equations of pushing lugs.
pub(super) const LUGS: &str = "\
A lug at an angle θ of the contact: F_p = b (γ h² N_p/2 + q h N_p + 2 c h sqrt(N_p)) E(j), N_p = tan²(45° + φ/2),
q = σ(θ), at right angles to the radius; the first term acts 2h/3 above the rim, the others h/2. With N lugs around the
wheel the mean over their places is N/(2π) ∫ F_p dθ. E(j) of the rim (chosen) lets the push begin at zero slip. Spread
over the rim that mean is a shear stress N F_p/(2π R b), farther from the axle than the rim's own.
Lugs so near to one another that the soil between them moves as a block are not described.";
/// Those of a slip angle.
pub(super) const SIDE: &str = "\
A wheel under a slip angle β: j_y = R (1 - i)(θ1 - θ) tan β, τ_y = (c + σ tan φ)(1 - e^(-|j_y|/K_y)), and on the flank
R_s = D1 (c h + D2 γ h²/2) with D1 = cot X + tan(X + φ), D2 = cot X + cot² X tan φ, X = 45° - φ/2, h the local depth:
F_y = -∫ [R b τ_y + R_s (R - h cos θ)] dθ. R_s takes the sign of β by tanh(10 tan β) (chosen).";

/// What breaks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Broken<T> {
    pub(super) cohesion: T,
    pub(super) angle: T,
    pub(super) weight: T,
}

/// Lugs around the wheel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lugs<T> {
    pub(super) height: T,
    pub(super) count: T,
    /// N/(2π) times γ h² N_p/2, h N_p and 2 c h sqrt(N_p).
    weight: T,
    surcharge: T,
    cohesion: T,
}

impl<T: Real> Lugs<T> {
    pub(super) fn new(soil: Broken<T>, count: T, height: T) -> Self {
        let root = (soil.angle * 0.5 + std::f64::consts::FRAC_PI_4).tan();
        let density = count / std::f64::consts::TAU * height;
        Lugs {
            height,
            count,
            weight: density * soil.weight * height * root.squared() * 0.5,
            surcharge: density * root.squared(),
            cohesion: density * soil.cohesion * root * 2.0,
        }
    }

    pub(super) fn map<S>(self, f: impl Fn(T) -> S) -> Lugs<S> {
        Lugs {
            height: f(self.height),
            count: f(self.count),
            weight: f(self.weight),
            surcharge: f(self.surcharge),
            cohesion: f(self.cohesion),
        }
    }

    /// Force per width, and its moment about the rim, for σ dθ and dθ.
    pub(super) fn push(&self, normal: T, plain: T) -> (T, T) {
        let weight = self.weight * plain;
        let others = self.surcharge * normal + self.cohesion * plain;
        let moment = (weight * 2.0 / 3.0 + others * 0.5) * self.height;
        (weight + others, moment)
    }
}

/// A wheel under a slip angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<T> {
    tan: T,
    modulus: T,
    /// D1 c and D1 D2 γ/2, with the sign of the slip angle.
    cohesion: T,
    weight: T,
}

impl<T: Real> Side<T> {
    pub(super) fn new(soil: Broken<T>, modulus: T, slip_angle: T) -> Result<Self, ModelError> {
        let beta = slip_angle.primal();
        let quarter = std::f64::consts::FRAC_PI_2;
        if !(beta.is_finite() && beta.min_lane() > -quarter && beta.max_lane() < quarter) {
            return Err(ModelError::Contact {
                quantity: "slip_angle",
                value: beta.min_lane(),
                expected: "an angle in (-π/2, π/2) rad",
            });
        }
        let tan = slip_angle.tan();
        let x = T::from(std::f64::consts::FRAC_PI_4) - soil.angle * 0.5;
        let cot = T::one() / x.tan();
        let first = (cot + (x + soil.angle).tan()) * (tan * 10.0).tanh();
        let second = cot + cot.squared() * soil.angle.tan();
        Ok(Side {
            tan,
            modulus,
            cohesion: first * soil.cohesion,
            weight: first * second * soil.weight * 0.5,
        })
    }

    pub(super) fn map<S>(self, f: impl Fn(T) -> S) -> Side<S> {
        Side {
            tan: f(self.tan),
            modulus: f(self.modulus),
            cohesion: f(self.cohesion),
            weight: f(self.weight),
        }
    }

    /// E across the wheel after a way j_y/tan β.
    pub(super) fn mobilised(&self, strength: &Strength<T>, way: T) -> T {
        let y = way * self.tan / self.modulus;
        let e = strength.mobilised(y.abs());
        y.select_lt(T::zero(), -e, e)
    }

    /// R_s at a depth.
    pub(super) fn push(&self, depth: T) -> T {
        (self.cohesion + self.weight * depth) * depth
    }
}
