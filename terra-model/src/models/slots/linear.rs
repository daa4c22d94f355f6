//! Stresses that rise and fall linearly between exit, apex and entry: closed forms for any pressure and shear law.
//!
//! # Equation
//! With σm, τm at the apex θm, both stresses zero at θ1, σ = 0 and τ = τ0 at θ2:
//! A = (cos θm - cos θ1)/(θ1-θm) - (cos θ2 - cos θm)/(θm-θ2), B = (sin θm - sin θ2)/(θm-θ2) - (sin θ1 - sin θm)/(θ1-θm),
//! W = b (R σm A + Rs τm B + Rs τ0 C),  D = b (Rs τm A - R σm B + Rs τ0 C'),
//! T = b Rs a (τm (θ1-θ2) + τ0 (θm-θ2))/2 with C = cos θ2 - (sin θm - sin θ2)/(θm-θ2),
//! C' = (cos θ2 - cos θm)/(θm-θ2) - sin θ2, a the arm of the torque.
//! Iagnemma, Shibly: θ2 = 0, τ0 = c, Rs = R. Ding: θ2 = c3 θ1, τ0 = 0, Rs = R + λ h.

use super::contact_state::{Soil, Sums};
use crate::quadrature::{sinc, t_minus_sin};
use crate::real::Real;
use crate::stress::StressPoint;

/// The equations, for whoever looks them up by name.
pub(super) const EQUATION: &str = "\
With σm, τm at the apex θm, both stresses zero at θ1, σ = 0 and τ = τ0 at θ2:
A = (cos θm - cos θ1)/(θ1-θm) - (cos θ2 - cos θm)/(θm-θ2), B = (sin θm - sin θ2)/(θm-θ2) - (sin θ1 - sin θm)/(θ1-θm),
W = b (R σm A + Rs τm B + Rs τ0 C),  D = b (Rs τm A - R σm B + Rs τ0 C'),
T = b Rs a (τm (θ1-θ2) + τ0 (θm-θ2))/2 with C = cos θ2 - (sin θm - sin θ2)/(θm-θ2),
C' = (cos θ2 - cos θm)/(θm-θ2) - sin θ2, a the arm of the torque.
Iagnemma, Shibly: θ2 = 0, τ0 = c, Rs = R. Ding: θ2 = c3 θ1, τ0 = 0, Rs = R + λ h.";

/// Everything but the entry angle.
#[derive(Clone, Copy)]
pub(super) struct Linear<T> {
    pub(super) soil: Soil<T>,
    /// Kinematic slip.
    pub(super) slip: T,
    pub(super) apex_ratio: T,
    /// θ2/θ1.
    pub(super) exit_ratio: T,
    pub(super) radius: T,
    /// Radius at which soil is sheared, beside the arm of the torque there.
    pub(super) shear_radius: T,
    pub(super) torque_arm: T,
    pub(super) width: T,
    /// The cohesion acts at the exit, whatever the shear displacement.
    pub(super) bottom_shear: bool,
}

/// Stresses at apex and exit.
#[derive(Clone, Copy)]
struct Stresses<T> {
    sigma: T,
    tau: T,
    bottom: T,
}

impl<T: Real> Linear<T> {
    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Linear<S> {
        Linear {
            soil: self.soil.map(f),
            slip: f(self.slip),
            apex_ratio: f(self.apex_ratio),
            exit_ratio: f(self.exit_ratio),
            radius: f(self.radius),
            shear_radius: f(self.shear_radius),
            torque_arm: f(self.torque_arm),
            width: f(self.width),
            bottom_shear: self.bottom_shear,
        }
    }

    pub(super) fn apex(&self, entry: T) -> T {
        self.apex_ratio * entry
    }

    pub(super) fn exit(&self, entry: T) -> T {
        self.exit_ratio * entry
    }

    fn stresses(&self, entry: T) -> Stresses<T> {
        let apex = self.apex(entry);
        let (front, _) = entry.sin_cos();
        let (rear, _) = self.exit(entry).sin_cos();
        let soil = self.soil.under(self.radius * (front - rear));
        let sigma = soil.normal_stress(self.radius * (entry - apex) * fall(apex, entry));
        let j = self.slip * (entry - apex)
            + (T::one() - self.slip) * (t_minus_sin(entry) - t_minus_sin(apex));
        let e = soil
            .strength
            .mobilised(self.shear_radius * j.abs() / soil.strength.modulus);
        let e = j.select_lt(T::zero(), -e, e);
        Stresses {
            sigma,
            tau: (soil.strength.cohesion + sigma * soil.strength.tan_friction) * e,
            bottom: if self.bottom_shear {
                soil.strength.cohesion
            } else {
                T::zero()
            },
        }
    }

    pub(super) fn sums(&self, entry: T) -> Sums<T> {
        let (apex, exit) = (self.apex(entry), self.exit(entry));
        let (ahead, behind) = (entry - apex, apex - exit);
        let Stresses { sigma, tau, bottom } = self.stresses(entry);
        // Linear terms of the sines are cancelled by hand.
        let x = t_minus_sin(apex);
        let rear_x = (x - t_minus_sin(exit)) / behind;
        let rear_fall = fall(exit, apex);
        let a = fall(apex, entry) - rear_fall;
        let b = (t_minus_sin(entry) - x) / ahead - rear_x;
        let (sin_exit, _) = exit.sin_cos();
        let (sin_half, _) = (exit * 0.5).sin_cos();
        let c = rear_x - sin_half.squared() * 2.0;
        let normal = self.radius * self.width;
        let shear = self.shear_radius * self.width;
        Sums {
            load: (sigma * a) * normal + (tau * b + bottom * c) * shear,
            thrust: (tau * a + bottom * (rear_fall - sin_exit)) * shear,
            compaction: sigma * b * normal,
            torque: (tau * (entry - exit) + bottom * behind) * 0.5 * shear * self.torque_arm,
            ..Sums::zero()
        }
    }
}

/// (cos a - cos b)/(b - a), without cancellation.
fn fall<T: Real>(a: T, b: T) -> T {
    let (sin, _) = ((a + b) * 0.5).sin_cos();
    sin * sinc((b - a) * 0.5)
}

impl Linear<f64> {
    /// Stresses at one angle of the contact.
    pub(super) fn stress_at(&self, entry: f64, angle: f64) -> StressPoint {
        let (apex, exit) = (self.apex(entry), self.exit(entry));
        let Stresses { sigma, tau, bottom } = self.stresses(entry);
        // Where lugs shear at a larger radius, the stress on the rim that gives the same force.
        let (tau, bottom) = (
            tau * self.shear_radius / self.radius,
            bottom * self.shear_radius / self.radius,
        );
        let (normal_stress, shear_stress) = if angle >= apex {
            let share = (entry - angle) / (entry - apex);
            (sigma * share, tau * share)
        } else {
            let share = (angle - exit) / (apex - exit);
            (sigma * share, bottom + (tau - bottom) * share)
        };
        StressPoint {
            angle,
            normal_stress,
            shear_stress,
            shear_arm: self.torque_arm,
        }
    }
}
