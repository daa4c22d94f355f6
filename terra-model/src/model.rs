//! The trait a terrain model's author writes, and its erased form.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::batch::{Batch, BatchForces, Precision};
use crate::contact::{Contact, Hook};
use crate::dual::Dual8;
use crate::error::ModelError;
use crate::forces::WheelForces;
use crate::guard::guard;
use crate::lanes::{LaneDual, Lanes};
use crate::lugs::LugPhase;
use crate::param::Param;
use crate::real::Real;
use crate::stress::StressField;

/// Soil values by role, for effects that need them; `None` where the model has no such number.
#[derive(Clone, Copy, Debug)]
pub struct Soil<T> {
    /// c \[Pa\].
    pub cohesion: Option<T>,
    /// φ \[rad\].
    pub friction_angle: Option<T>,
    /// k of σ = k z^n for this wheel's width \[N/m^(n+2)\].
    pub stiffness: Option<T>,
    /// n \[1\].
    pub sinkage_exponent: Option<T>,
    /// K \[m\].
    pub shear_modulus: Option<T>,
}

impl<T> Soil<T> {
    /// A model without soil values.
    pub fn unknown() -> Self {
        Soil {
            cohesion: None,
            friction_angle: None,
            stiffness: None,
            sinkage_exponent: None,
            shear_modulus: None,
        }
    }
}

/// Forces with their Jacobian.
pub type ForceSlopes = (WheelForces<f64>, DMatrix<f64>);

/// What an author writes: one generic function from parameters and contact to forces.
///
/// Everything else (exact Jacobian, estimators, command-line name, table row) follows from it.
pub trait TerrainModel: Default + Send + Sync + 'static {
    /// Kebab-case name.
    const NAME: &'static str;
    /// One line: what the model is.
    const SUMMARY: &'static str;
    /// Its parameters, in the order `wheel_forces` takes them.
    const PARAMS: &'static [Param];
    /// The equations in the field's symbols, in lines; empty where they are left unsaid.
    const EQUATION: &'static str = "";
    /// Where the equations come from.
    const REFERENCE: &'static str;
    /// The hooks of [`Contact`] this model honours.
    const HOOKS: &'static [Hook] = &[];
    /// Whether pull and torque follow from slip, load, wheel and hooks alone, and without a jump or a bend on either side of zero
    /// slip: what they are between contacts may then be interpolated.
    const BY_SLIP_AND_LOAD: bool = false;
    /// Whether a diagnosis asks for this model, from the first of its [`typical`](Self::typical) soils, also where the rover file's
    /// start does not give its parameters. Not so for models of other ground than soil, or of another wheel, whose typical
    /// parameters say nothing of the soil at hand.
    const RIVAL: bool = true;

    /// Forces of the ground on one wheel.
    ///
    /// # Errors
    /// A typed [`ModelError`]: parameters or contact out of range, or no equilibrium.
    fn wheel_forces<T: Real>(&self, p: &[T], at: &Contact<T>)
    -> Result<WheelForces<T>, ModelError>;

    /// Forces and their Jacobian (as [`ForceLaw::jacobian`](crate::ForceLaw::jacobian)) by formula, for a model that has
    /// one; none: they are found with dual numbers.
    ///
    /// # Errors
    /// As [`wheel_forces`](Self::wheel_forces).
    fn slopes(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<ForceSlopes>, ModelError> {
        let _ = (p, at);
        Ok(None)
    }

    /// Forces of many contacts, each with its own status: eight at a time in lanes unless the model knows better.
    ///
    /// # Errors
    /// [`ModelError::ParameterCount`], [`ModelError::BatchLength`]: columns that do not fit. Never for an item.
    fn forces_batch(
        &self,
        batch: &Batch<'_>,
        precision: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError> {
        let _ = precision;
        batch.check(Self::NAME, Self::PARAMS.len())?;
        batch.side_by_side(
            out,
            true,
            |p, at| guard(Self::NAME, Self::PARAMS, p, at),
            |p, at| self.wheel_forces(p, at),
            |p, at| self.wheel_forces(p, at),
        );
        Ok(())
    }

    /// The same law at less cost, to a part in ten thousand of the forces, or a thousand where the soil is about to give way: for
    /// fits, whose data know them to a hundredth. None: this is it.
    fn quick(&self) -> Option<Arc<dyn AnyModel>> {
        None
    }

    /// The soil values by role, for effects such as bulldozing.
    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        let _ = (p, at);
        Soil::unknown()
    }

    /// Parameter vectors of typical soils, for models whose parameters the catalogue does not give. A diagnosis starts from the first
    /// where the rover file's start does not give them.
    fn typical() -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Stresses along the contact; `None` for models without stresses.
    ///
    /// # Errors
    /// As [`wheel_forces`](Self::wheel_forces).
    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        let _ = (p, at);
        Ok(None)
    }
}

/// A model at one scalar: generic methods are not object safe, so the scalar moves to the trait.
pub trait ModelAt<T: Real>: Send + Sync {
    /// See [`TerrainModel::wheel_forces`].
    ///
    /// # Errors
    /// As there.
    fn wheel_forces_at(&self, p: &[T], at: &Contact<T>) -> Result<WheelForces<T>, ModelError>;
    /// See [`TerrainModel::soil`].
    fn soil_at(&self, p: &[T], at: &Contact<T>) -> Soil<T>;
}

impl<M: TerrainModel, T: Real> ModelAt<T> for M {
    fn wheel_forces_at(&self, p: &[T], at: &Contact<T>) -> Result<WheelForces<T>, ModelError> {
        self.wheel_forces(p, at)
    }
    fn soil_at(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        self.soil(p, at)
    }
}

/// Any model, known only by name.
pub trait AnyModel: ModelAt<f64> + ModelAt<Dual8> + ModelAt<Lanes> + ModelAt<LaneDual> {
    /// Kebab-case name.
    fn name(&self) -> &'static str;
    /// One line of meaning.
    fn summary(&self) -> &'static str;
    /// Parameters.
    fn params(&self) -> &'static [Param];
    /// The equations; may be empty.
    fn equation(&self) -> &'static str;
    /// Source.
    fn reference(&self) -> &'static str;
    /// Hooks it honours.
    fn hooks(&self) -> &'static [Hook];
    /// See [`TerrainModel::BY_SLIP_AND_LOAD`].
    fn is_by_slip_and_load(&self) -> bool {
        false
    }
    /// See [`TerrainModel::slopes`].
    ///
    /// # Errors
    /// As there.
    fn force_slopes(&self, p: &[f64], at: &Contact<f64>)
    -> Result<Option<ForceSlopes>, ModelError>;
    /// See [`TerrainModel::forces_batch`].
    ///
    /// # Errors
    /// As there.
    fn batch(
        &self,
        batch: &Batch<'_>,
        precision: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError>;
    /// See [`TerrainModel::quick`].
    fn quick_model(&self) -> Option<Arc<dyn AnyModel>> {
        None
    }
    /// See [`TerrainModel::typical`].
    fn typical_parameters(&self) -> Vec<Vec<f64>>;
    /// See [`TerrainModel::RIVAL`].
    fn is_rival(&self) -> bool {
        true
    }
    /// See [`TerrainModel::stresses`].
    ///
    /// # Errors
    /// As there.
    fn stress_field(&self, p: &[f64], at: &Contact<f64>)
    -> Result<Option<StressField>, ModelError>;
    /// The passage of one lug in so many moments; `None` for a wheel without lugs that push.
    ///
    /// # Errors
    /// As [`TerrainModel::wheel_forces`].
    fn lug_cycle(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        moments: usize,
    ) -> Result<Option<Vec<LugPhase>>, ModelError> {
        let _ = (p, at, moments);
        Ok(None)
    }
}

impl<M: TerrainModel> AnyModel for M {
    fn name(&self) -> &'static str {
        M::NAME
    }
    fn summary(&self) -> &'static str {
        M::SUMMARY
    }
    fn params(&self) -> &'static [Param] {
        M::PARAMS
    }
    fn equation(&self) -> &'static str {
        M::EQUATION
    }
    fn reference(&self) -> &'static str {
        M::REFERENCE
    }
    fn hooks(&self) -> &'static [Hook] {
        M::HOOKS
    }
    fn is_by_slip_and_load(&self) -> bool {
        M::BY_SLIP_AND_LOAD
    }
    fn force_slopes(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<Option<ForceSlopes>, ModelError> {
        self.slopes(p, at)
    }
    fn batch(
        &self,
        batch: &Batch<'_>,
        precision: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError> {
        self.forces_batch(batch, precision, out)
    }
    fn quick_model(&self) -> Option<Arc<dyn AnyModel>> {
        self.quick()
    }
    fn typical_parameters(&self) -> Vec<Vec<f64>> {
        M::typical()
    }
    fn is_rival(&self) -> bool {
        M::RIVAL
    }
    fn stress_field(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<Option<StressField>, ModelError> {
        self.stresses(p, at)
    }
}
