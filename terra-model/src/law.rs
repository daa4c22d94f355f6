//! A model with effects on top, and what solvers see of it.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::batch::{Batch, BatchForces, Precision};
use crate::contact::Contact;
use crate::dual::{Dual8, jacobian};
use crate::effect::{AnyEffect, Channel, Circumstance, Touch};
use crate::error::ModelError;
use crate::forces::WheelForces;
use crate::guard::{count, guard};
use crate::lugs::LugPhase;
use crate::model::{AnyModel, Soil, TerrainModel};
use crate::param::Param;
use crate::real::Real;
use crate::scalar::Scalar;
use crate::stress::{StressField, StressProfile};

/// What solvers use: forces and their exact derivatives. Object safe.
///
/// Implemented for every [`TerrainModel`] and for [`Law`].
pub trait ForceLaw: Send + Sync {
    /// Name, `model+effect+effect`.
    fn name(&self) -> String;
    /// Parameters, model first, then the effects' magnitudes in order.
    fn params(&self) -> &[Param];
    /// Forces on one wheel.
    ///
    /// # Errors
    /// A typed [`ModelError`].
    fn forces(&self, p: &[f64], at: &Contact<f64>) -> Result<WheelForces<f64>, ModelError>;
    /// Forces and their derivatives: rows drawbar pull, resistive torque, sinkage (zero without one), lateral force;
    /// columns the parameters, then slip, then normal load.
    ///
    /// # Errors
    /// A typed [`ModelError`].
    fn jacobian(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<(WheelForces<f64>, DMatrix<f64>), ModelError>;
}

/// The rows of a Jacobian.
pub(crate) fn rows(f: &WheelForces<Dual8>) -> Vec<Dual8> {
    vec![
        f.drawbar_pull,
        f.resistive_torque,
        f.sinkage.unwrap_or_else(Dual8::zero),
        f.lateral_force,
    ]
}

/// A contact as constants, but for slip and load.
pub(crate) fn lift_with<T: Real>(at: &Contact<f64>, slip: T, normal_load: T) -> Contact<T> {
    Contact {
        slip,
        normal_load,
        ..at.lift()
    }
}

/// Forces and Jacobian out of one function at two scalars.
fn force_jacobian(
    p: &[f64],
    at: &Contact<f64>,
    dual: impl Fn(&[Dual8], &Contact<Dual8>) -> Result<WheelForces<Dual8>, ModelError>,
    value: impl Fn() -> Result<WheelForces<f64>, ModelError>,
) -> Result<(WheelForces<f64>, DMatrix<f64>), ModelError> {
    let n = p.len();
    let mut x = p.to_vec();
    x.extend([at.slip, at.normal_load]);
    let (_, jac) = jacobian(&x, |x| {
        dual(&x[..n], &lift_with(at, x[n], x[n + 1])).map(|f| rows(&f))
    })?;
    Ok((value()?, jac))
}

impl<M: TerrainModel> ForceLaw for M {
    fn name(&self) -> String {
        M::NAME.to_owned()
    }
    fn params(&self) -> &[Param] {
        M::PARAMS
    }
    fn forces(&self, p: &[f64], at: &Contact<f64>) -> Result<WheelForces<f64>, ModelError> {
        guard(M::NAME, M::PARAMS, p, at)?;
        self.wheel_forces(p, at)
    }
    fn jacobian(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<(WheelForces<f64>, DMatrix<f64>), ModelError> {
        guard(M::NAME, M::PARAMS, p, at)?;
        if let Some(known) = self.slopes(p, at)? {
            return Ok(known);
        }
        force_jacobian(
            p,
            at,
            |p, at| self.wheel_forces(p, at),
            || self.wheel_forces(p, at),
        )
    }
}

/// One effect and its magnitudes.
type Share<'s, 'p, T> = (&'s Arc<dyn AnyEffect>, &'p [T]);

/// A model with effects on top: `wong-reece+slip-sinkage+grousers`. Parameters are concatenated in that order.
#[derive(Clone)]
pub struct Law {
    model: Arc<dyn AnyModel>,
    effects: Vec<Arc<dyn AnyEffect>>,
    params: Vec<Param>,
}

impl std::fmt::Debug for Law {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Law({})", ForceLaw::name(self))
    }
}

impl Law {
    /// Composes a model and effects.
    ///
    /// # Errors
    /// [`ModelError::EffectNotApplicable`] when the model lacks a hook an effect needs, [`ModelError::SoilUnknown`]
    /// when it lacks a soil value: never a silent no-op. [`ModelError::EffectTwice`] for one form of an effect twice: two
    /// magnitudes of it would be two names for their sum. Several forms of one name may stand side by side, unless they set
    /// what there is one of ([`ModelError::HookTwice`]).
    pub fn new(
        model: Arc<dyn AnyModel>,
        effects: Vec<Arc<dyn AnyEffect>>,
    ) -> Result<Self, ModelError> {
        let probe: Vec<f64> = model.params().iter().map(|p| p.min.max(0.0)).collect();
        let soil: Soil<f64> =
            f64::of_model(&*model).soil_at(&probe, &Contact::new(0.1, 1.0, 1.0, 1.0));
        for (k, effect) in effects.iter().enumerate() {
            let same = |other: &Arc<dyn AnyEffect>| {
                (other.name(), other.form()) == (effect.name(), effect.form())
            };
            if effects[..k].iter().any(same) {
                return Err(ModelError::EffectTwice {
                    effect: effect.name().to_owned(),
                });
            }
            if let Some(hook) = effect.needs().iter().find(|h| !model.hooks().contains(h)) {
                return Err(ModelError::EffectNotApplicable {
                    model: model.name(),
                    effect: effect.name(),
                    hook: hook.name(),
                });
            }
            for hook in effect.needs().iter().filter(|h| h.holds_one()) {
                if let Some(first) = effects[..k].iter().find(|e| e.needs().contains(hook)) {
                    let full = |e: &Arc<dyn AnyEffect>| format!("{}/{}", e.name(), e.form());
                    return Err(ModelError::HookTwice {
                        first: full(first),
                        second: full(effect),
                        hook: hook.name(),
                    });
                }
            }
            for &quantity in effect.needs_soil() {
                let known = match quantity {
                    "cohesion" => soil.cohesion.is_some(),
                    "friction_angle" => soil.friction_angle.is_some(),
                    "stiffness" => soil.stiffness.is_some(),
                    "sinkage_exponent" => soil.sinkage_exponent.is_some(),
                    "shear_modulus" => soil.shear_modulus.is_some(),
                    _ => false,
                };
                if !known {
                    return Err(ModelError::SoilUnknown {
                        model: model.name(),
                        effect: effect.name(),
                        quantity,
                    });
                }
            }
        }
        let mut params = model.params().to_vec();
        params.extend(effects.iter().flat_map(|e| e.params()));
        Ok(Law {
            model,
            effects,
            params,
        })
    }

    /// The terrain model.
    pub fn model(&self) -> &dyn AnyModel {
        &*self.model
    }

    /// The terrain model, shared.
    pub fn shared_model(&self) -> Arc<dyn AnyModel> {
        Arc::clone(&self.model)
    }

    /// The effects.
    pub fn effects(&self) -> &[Arc<dyn AnyEffect>] {
        &self.effects
    }

    /// This law with more effects.
    ///
    /// # Errors
    /// As [`Law::new`].
    pub fn with_effects(
        &self,
        more: impl IntoIterator<Item = Arc<dyn AnyEffect>>,
    ) -> Result<Self, ModelError> {
        let mut effects = self.effects.clone();
        effects.extend(more);
        Law::new(Arc::clone(&self.model), effects)
    }

    /// The same law at less cost, see [`TerrainModel::quick`](crate::TerrainModel::quick).
    #[must_use]
    pub fn quick(&self) -> Self {
        let mut law = self.clone();
        if let Some(model) = self.model.quick_model() {
            law.model = model;
        }
        law
    }

    /// The model's parameters, and each effect with its magnitudes, out of one vector of the law's length.
    pub fn parts<'s, 'p, T>(
        &'s self,
        p: &'p [T],
    ) -> (&'p [T], impl Iterator<Item = Share<'s, 'p, T>>) {
        let mut at = self.model.params().len();
        let model = &p[..at];
        let effects = self.effects.iter().map(move |e| {
            let start = at;
            at += e.params().len();
            (e, &p[start..at])
        });
        (model, effects)
    }

    /// The effects that act at a place, each with its magnitudes, in the order they were named.
    pub fn acting<'s, 'p, T>(
        &'s self,
        p: &'p [T],
        touch: Touch,
    ) -> impl Iterator<Item = Share<'s, 'p, T>> {
        let effects = self.parts(p).1;
        effects.filter(move |(effect, _)| effect.touches().contains(&touch))
    }

    /// Whether an effect acts at a place.
    pub fn acts(&self, touch: Touch) -> bool {
        self.effects.iter().any(|e| e.touches().contains(&touch))
    }

    /// Whether an effect acts on what a sensor of this channel reports.
    pub fn acts_on(&self, channel: Channel) -> bool {
        let sensors = self.effects.iter();
        let mut sensors = sensors.filter(|e| e.touches().contains(&Touch::Sensor));
        sensors.any(|e| e.channels().contains(&channel))
    }

    /// What beside slip, load and wheel it is that pull and torque of a wheel follow from, on either side of zero slip without a jump
    /// or a bend, where no force acts sideways: what they are between contacts may then be interpolated. None: from anything.
    pub fn beside_slip_and_load(&self) -> Option<Vec<Circumstance>> {
        let mut beside = vec![];
        if !self.model.is_by_slip_and_load() {
            return None;
        }
        for effect in &self.effects {
            let touches = effect.touches();
            if touches.contains(&Touch::Contact) || touches.contains(&Touch::Forces) {
                beside.extend(effect.beside_slip_and_load()?);
            }
        }
        beside.sort_unstable();
        beside.dedup();
        Some(beside)
    }

    /// Forces at any scalar: contact effects, model, force effects, in the order the effects were named.
    ///
    /// # Errors
    /// A typed [`ModelError`].
    pub fn forces_at<T: Scalar>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        count(self.model.name(), self.params.len(), p.len())?;
        if self.effects.is_empty() {
            return T::of_model(&*self.model).wheel_forces_at(p, at);
        }
        self.forces_under(p, &mut at.clone())
    }

    /// The same, with the contact left as the model saw it: numbers with many derivatives are long to copy.
    ///
    /// # Errors
    /// As [`forces_at`](Self::forces_at).
    pub fn forces_under<T: Scalar>(
        &self,
        p: &[T],
        at: &mut Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        count(self.model.name(), self.params.len(), p.len())?;
        let model = T::of_model(&*self.model);
        let q = self.parts(p).0;
        if !self.acts(Touch::Contact) && !self.acts(Touch::Forces) {
            return model.wheel_forces_at(q, at);
        }
        let soil = model.soil_at(q, at);
        for (effect, e) in self.acting(p, Touch::Contact) {
            T::of_effect(&**effect).alter_contact(e, &soil, at);
        }
        let mut forces = model.wheel_forces_at(q, at)?;
        if at.hooks.pull_only {
            forces.lateral_force = T::zero();
        }
        for (effect, e) in self.acting(p, Touch::Forces) {
            T::of_effect(&**effect).alter_forces(e, &soil, at, &mut forces);
        }
        Ok(forces)
    }

    /// Forces of many contacts, each with its own status, side by side in lanes.
    ///
    /// # Errors
    /// [`ModelError::ParameterCount`], [`ModelError::BatchLength`]: columns that do not fit. Never for an item.
    pub fn solve_batch(
        &self,
        batch: &Batch<'_>,
        precision: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError> {
        if self.effects.is_empty() {
            return self.model.batch(batch, precision, out);
        }
        batch.check(self.model.name(), self.params.len())?;
        batch.side_by_side(
            out,
            false,
            |p, at| guard(self.model.name(), &self.params, p, at),
            |p, at| self.forces(p, at),
            |p, at| self.forces_at(p, at),
        );
        Ok(())
    }

    /// `points` stresses along the contact under the effects, from exit to entry, with their peaks; `None` for models
    /// without stresses.
    ///
    /// # Errors
    /// A typed [`ModelError`].
    pub fn stresses(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        points: usize,
    ) -> Result<Option<StressProfile>, ModelError> {
        let field = self.stress_field(p, at)?;
        Ok(field.map(|field| field.profile(points)))
    }

    /// Stresses at any angle of the contact under the effects; `None` for models without stresses.
    ///
    /// # Errors
    /// A typed [`ModelError`].
    pub fn stress_field(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<Option<StressField>, ModelError> {
        let (q, contact) = self.as_the_model_sees(p, at)?;
        self.model.stress_field(q, &contact)
    }

    /// What the lugs push during the passage of one, in so many moments; `None` for a wheel without lugs that push.
    ///
    /// # Errors
    /// A typed [`ModelError`].
    pub fn lug_cycle(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        moments: usize,
    ) -> Result<Option<Vec<LugPhase>>, ModelError> {
        let (q, contact) = self.as_the_model_sees(p, at)?;
        self.model.lug_cycle(q, &contact, moments)
    }

    /// The model's parameters, and the contact under the effects.
    fn as_the_model_sees<'p>(
        &self,
        p: &'p [f64],
        at: &Contact<f64>,
    ) -> Result<(&'p [f64], Contact<f64>), ModelError> {
        guard(self.model.name(), &self.params, p, at)?;
        let q = self.parts(p).0;
        let soil = f64::of_model(&*self.model).soil_at(q, at);
        let mut contact = *at;
        for (effect, e) in self.acting(p, Touch::Contact) {
            contact = f64::of_effect(&**effect).before_at(e, &soil, contact);
        }
        Ok((q, contact))
    }
}

impl ForceLaw for Law {
    fn name(&self) -> String {
        let mut name = self.model.name().to_owned();
        for effect in &self.effects {
            name.push('+');
            name.push_str(effect.name());
        }
        name
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn forces(&self, p: &[f64], at: &Contact<f64>) -> Result<WheelForces<f64>, ModelError> {
        guard(self.model.name(), &self.params, p, at)?;
        self.forces_at(p, at)
    }
    fn jacobian(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<(WheelForces<f64>, DMatrix<f64>), ModelError> {
        guard(self.model.name(), &self.params, p, at)?;
        if self.effects.is_empty()
            && let Some(known) = self.model.force_slopes(p, at)?
        {
            return Ok(known);
        }
        force_jacobian(
            p,
            at,
            |p, at| self.forces_at(p, at),
            || self.forces_at(p, at),
        )
    }
}
