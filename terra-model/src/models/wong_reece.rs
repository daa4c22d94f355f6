//! The rigid wheel of Wong and Reece on Bekker soil: the reference for how a terrain model is written.
//!
//! # Equation
//! With u in \[0, 1\] from each end of the contact to the angle of maximum stress, both branches have the same normal
//! stress at equal u, θF = θ1 - u (θ1 - θm), θB = θ2 + u (θm - θ2):
//!
//! - σ = k R^n (cos θF - cos θ1)^n,   τ = (c + σ tan φ) E(j),   E = sign(j)(1 - e^(-|j|/K))
//! - j(θ) = R \[(θ1 - θ) - (1 - i)(sin θ1 - sin θ)\],   θm = (c1 + c2 i) θ1
//! - W = R b ∫(σ cos θ + τ sin θ) dθ,   D = R b ∫(τ cos θ - σ sin θ) dθ,   T = R² b ∫ τ dθ
//!
//! W is given; θ1 follows from it (unique for i >= 0), then D, T and z = R(1 - cos θ1).
//!
//! # Units
//! SI: N, m, Pa, rad.
//!
//! # Reference
//! J. Y. Wong and A. R. Reece, "Prediction of rigid wheel performance based on the analysis of soil-wheel stresses",
//! J. Terramechanics 4 (1967) 1:81-98 and 2:7-25; L. E. Ray, SPIE 2008, eqs 13-20. Braking is an extension.

mod batch;
mod general;
mod gradient;
mod kernel;
mod pieces;
mod quick;
mod slopes;
mod solve;
mod wheel;

use std::sync::Arc;

use crate::batch::{Batch, BatchForces, Precision};
use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Flags, WheelForces};
use crate::model::{AnyModel, ForceSlopes, Soil, TerrainModel};
use crate::models::bekker::{self, Ground};
use crate::param::Param;
use crate::real::{Real, Root};
use crate::root::MAX_ENTRY_ANGLE;
use crate::stress::StressField;
use gradient::STRAIGHT;
use solve::Start;
use wheel::{Integrals, Wheel};

/// Nodes a piece in the first steps of the iteration, and in the last.
const COARSE: usize = 8;
const FINE: usize = 16;

/// How exactly the stresses are integrated: max(|Δθ1|/θ1, |ΔT|/|T|, |ΔD|/(|D| + |T|/R)) over 21 soils x 5 slips x 3 loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Accuracy {
    /// Eight nodes a branch: 1e-7. What a batch computes.
    Default,
    /// Sixteen: 1e-11. What `wong-reece` itself computes.
    #[default]
    Fine,
    /// Twenty-four: 1e-12, where two independent quadratures agree.
    Reference,
}

/// The Wong-Reece rigid wheel.
#[derive(Clone, Copy, Debug, Default)]
pub struct WongReece;

impl WongReece {
    /// The vertical force \[N\] of the ground on the wheel at a given entry angle \[rad\]: eq 18 with θ1 in place of W.
    ///
    /// For non-negative slip it rises strictly with the entry angle, so a load has one sinkage; braking on snow it does
    /// not. The contact's `normal_load` plays no part, but must be legal.
    ///
    /// # Errors
    /// As [`TerrainModel::wheel_forces`]; [`ModelError::Contact`] for an angle outside (0, π/2\].
    pub fn supported_load(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        entry_angle: f64,
    ) -> Result<f64, ModelError> {
        Self::legal(entry_angle)?;
        let wheel = Self::wheel(p, at)?;
        Ok(solve::load::<f64, FINE>(&wheel, entry_angle))
    }

    fn wheel<T: Real>(p: &[T], at: &Contact<T>) -> Result<Wheel<T>, ModelError> {
        Ok(Wheel::new(Ground::read(Self::NAME, p, at)?, at))
    }

    /// Forces by name, from the integrals per R b.
    fn named<T: Real>(
        wheel: &Wheel<T>,
        at: &Contact<T>,
        entry: T,
        integrals: Integrals<T>,
    ) -> WheelForces<T> {
        let area = wheel.radius * wheel.width;
        let torque_arm = at.radius + at.hooks.lug_height;
        let mut forces = WheelForces::from_thrust(
            integrals.thrust * area,
            integrals.compaction * area,
            integrals.shear * area * torque_arm,
        );
        let (sin_half, _) = (entry * 0.5).sin_cos();
        let sinkage = wheel.radius * sin_half.squared() * 2.0;
        // A wheel that slides to the left is pushed to the right.
        forces.lateral_force = -(integrals.lateral * area);
        forces.sinkage = Some(sinkage);
        forces.angles = Some(Angles {
            entry,
            exit: wheel.exit(entry),
            max_stress: wheel.apex(entry),
        });
        forces.flags = Flags {
            braking: wheel.braking,
            apex_limited: wheel.ground.apex_limited,
            deep_sinkage: (at.radius * 0.5).primal().any_lt(sinkage.primal()),
        };
        forces
    }

    /// As [`TerrainModel::wheel_forces`], starting from the entry angle \[rad\] of a nearby contact: the last sample of a
    /// log, say. The result does not depend on it but for the last digits.
    ///
    /// # Errors
    /// As there; [`ModelError::Contact`] for an angle outside (0, π/2\].
    pub fn forces_from(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        entry_angle: f64,
    ) -> Result<WheelForces<f64>, ModelError> {
        Self::legal(entry_angle)?;
        let wheel = Self::wheel(p, at)?;
        let (entry, integrals) = if wheel.lateral.is_some() {
            solve::rare::<f64, COARSE, FINE>(&wheel, at)?
        } else {
            let start = Start::From(entry_angle.ln());
            solve::balance::<f64, COARSE, FINE, STRAIGHT>(&wheel, at, start)?
        };
        Ok(Self::named(&wheel, at, entry, integrals))
    }

    /// As [`TerrainModel::wheel_forces`], by the rule of a tier. A sideways slip has one rule only.
    ///
    /// # Errors
    /// As there.
    pub fn forces_within(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        accuracy: Accuracy,
    ) -> Result<WheelForces<f64>, ModelError> {
        let wheel = Self::wheel(p, at)?;
        let (entry, integrals) = match accuracy {
            _ if wheel.lateral.is_some() => solve::rare::<f64, COARSE, FINE>(&wheel, at)?,
            Accuracy::Default => solve::balance::<f64, 8, 8, STRAIGHT>(&wheel, at, Start::Guess)?,
            Accuracy::Fine => {
                solve::balance::<f64, COARSE, FINE, STRAIGHT>(&wheel, at, Start::Guess)?
            }
            Accuracy::Reference => {
                solve::balance::<f64, 8, 24, STRAIGHT>(&wheel, at, Start::Guess)?
            }
        };
        Ok(Self::named(&wheel, at, entry, integrals))
    }

    fn legal(entry_angle: f64) -> Result<(), ModelError> {
        if entry_angle > 0.0 && entry_angle <= MAX_ENTRY_ANGLE {
            return Ok(());
        }
        Err(ModelError::Contact {
            quantity: "entry_angle",
            value: entry_angle,
            expected: "an angle in (0, π/2] rad",
        })
    }

    fn solve<T: Real>(wheel: &Wheel<T>, at: &Contact<T>) -> Result<(T, Integrals<T>), ModelError> {
        if wheel.lateral.is_some() {
            return solve::rare::<T, COARSE, FINE>(wheel, at);
        }
        solve::balance::<T, COARSE, FINE, STRAIGHT>(wheel, at, Start::Guess)
    }
}

impl TerrainModel for WongReece {
    const NAME: &'static str = "wong-reece";
    const SUMMARY: &'static str =
        "rigid wheel on Bekker soil with Janosi-Hanamoto shear and an apex that moves with slip";
    const PARAMS: &'static [Param] = bekker::PARAMS;
    const EQUATION: &'static str = "\
With u in [0, 1] from each end of the contact to the angle of maximum stress, both branches have the same normal
stress at equal u, θF = θ1 - u (θ1 - θm), θB = θ2 + u (θm - θ2):

- σ = k R^n (cos θF - cos θ1)^n,   τ = (c + σ tan φ) E(j),   E = sign(j)(1 - e^(-|j|/K))
- j(θ) = R [(θ1 - θ) - (1 - i)(sin θ1 - sin θ)],   θm = (c1 + c2 i) θ1
- W = R b ∫(σ cos θ + τ sin θ) dθ,   D = R b ∫(τ cos θ - σ sin θ) dθ,   T = R² b ∫ τ dθ

W is given; θ1 follows from it (unique for i >= 0), then D, T and z = R(1 - cos θ1).";
    const REFERENCE: &'static str = "J. Y. Wong, A. R. Reece, J. Terramechanics 4(1):81-98 and 4(2):7-25, 1967; L. E. Ray, Proc. SPIE, 2008";
    const HOOKS: &'static [Hook] = &[
        Hook::Stiffness,
        Hook::Cohesion,
        Hook::Friction,
        Hook::ShearModulus,
        Hook::SinkageExponent,
        Hook::ContactRadius,
        Hook::ExitRatio,
        Hook::ShearHump,
        Hook::LugHeight,
        Hook::Layer,
        Hook::LateralSlip,
    ];
    const BY_SLIP_AND_LOAD: bool = true;

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        if const { T::FOR_FITS } {
            return quick::Quick.wheel_forces(p, at);
        }
        let wheel = Self::wheel(p, at)?;
        let (entry, integrals) = Self::solve(&wheel, at)?;
        Ok(Self::named(&wheel, at, entry, integrals))
    }

    fn slopes(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<ForceSlopes>, ModelError> {
        slopes::slopes(p, at)
    }

    fn forces_batch(
        &self,
        batch: &Batch<'_>,
        precision: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError> {
        batch.check(Self::NAME, Self::PARAMS.len())?;
        batch::solve_batch(batch, precision, out);
        Ok(())
    }

    fn quick(&self) -> Option<Arc<dyn AnyModel>> {
        Some(Arc::new(quick::Quick))
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        bekker::soil(p, at)
    }

    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        let wheel = Self::wheel(p, at)?;
        let (entry, _) = Self::solve(&wheel, at)?;
        let (exit, apex) = (wheel.exit(entry), wheel.apex(entry));
        let arm = at.radius + at.hooks.lug_height;
        Ok(Some(StressField::new(exit, apex, entry, move |angle| {
            wheel.stress_at(entry, angle, arm)
        })))
    }
}

#[cfg(test)]
mod tests;
