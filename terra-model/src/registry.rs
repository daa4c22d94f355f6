//! Models and effects by name.

use std::sync::Arc;

use crate::effect::{AnyEffect, Effect};
use crate::error::ModelError;
use crate::law::Law;
use crate::model::{AnyModel, TerrainModel};
use crate::names::nearest;
use crate::{effects, models};

/// All models and effects that can be asked for by name.
///
/// A user's own join with one line: `Registry::builtin().with_model::<Mine>()`.
#[derive(Clone, Default)]
pub struct Registry {
    models: Vec<Arc<dyn AnyModel>>,
    named: Vec<Arc<dyn AnyModel>>,
    effects: Vec<Arc<dyn AnyEffect>>,
}

impl Registry {
    /// Nothing registered.
    pub fn empty() -> Self {
        Self::default()
    }

    /// Everything terra ships.
    pub fn builtin() -> Self {
        effects::register(models::register(Self::empty()))
    }

    /// Adds the other forms of the effects, [`effects::forms`], after their defaults, which bare names still mean.
    ///
    /// They are apart from [`builtin`](Self::builtin) because a diagnosis asks for one form a name first.
    #[must_use]
    pub fn with_forms(self) -> Self {
        effects::forms::register(self)
    }

    /// Adds a terrain model.
    #[must_use]
    pub fn with_model<M: TerrainModel>(mut self) -> Self {
        self.models.push(Arc::new(M::default()));
        self
    }

    /// Adds a terrain model that is found by its name and is no rival of the others: where a wheel drives it gives another
    /// model's own forces, so that a driven log could not tell the two apart.
    #[must_use]
    pub fn with_named_model<M: TerrainModel>(mut self) -> Self {
        self.named.push(Arc::new(M::default()));
        self
    }

    /// Adds a terrain model that is known only by name.
    #[must_use]
    pub fn with_shared(mut self, model: Arc<dyn AnyModel>) -> Self {
        self.models.push(model);
        self
    }

    /// Adds an effect, or another form of one.
    #[must_use]
    pub fn with_effect<E: Effect>(mut self) -> Self {
        self.effects.push(Arc::new(E::default()));
        self
    }

    /// Adds an effect that is shared with another registry.
    #[must_use]
    pub fn with_shared_effect(mut self, effect: Arc<dyn AnyEffect>) -> Self {
        self.effects.push(effect);
        self
    }

    /// The models.
    pub fn models(&self) -> &[Arc<dyn AnyModel>] {
        &self.models
    }

    /// Models that are found by name and are not among [`models`](Self::models).
    pub fn named_models(&self) -> &[Arc<dyn AnyModel>] {
        &self.named
    }

    /// The effects, each form on its own.
    pub fn effects(&self) -> &[Arc<dyn AnyEffect>] {
        &self.effects
    }

    /// A model by name: a registered one, or any wheel of the slots `wheel[:pressure[:shear]]`, e.g.
    /// `wong-reece:reece:wong-hump`. Slots that spell out a wheel's own defaults mean the wheel itself.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the nearest name of the slot in question; [`ModelError::Combination`] for slots that
    /// the model does not have or that do not go together.
    pub fn model(&self, name: &str) -> Result<Arc<dyn AnyModel>, ModelError> {
        if let Some(model) = self.registered(name) {
            return Ok(model);
        }
        let all = self.models.iter().chain(&self.named);
        let names: Vec<&'static str> = all.map(|m| m.name()).collect();
        if !name.contains(':') {
            return Err(ModelError::UnknownName {
                kind: "terrain model",
                name: name.to_owned(),
                nearest: nearest(name, names).map(str::to_owned),
            });
        }
        let composed = models::slots::by_name(name, &names)?;
        Ok(self
            .registered(composed.name())
            .unwrap_or_else(|| composed.shared()))
    }

    fn registered(&self, name: &str) -> Option<Arc<dyn AnyModel>> {
        let mut all = self.models.iter().chain(&self.named);
        all.find(|m| m.name() == name).cloned()
    }

    /// An effect by name: its default form (the first registered), or one form as `name/form`.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`].
    pub fn effect(&self, name: &str) -> Result<Arc<dyn AnyEffect>, ModelError> {
        if let Some((name, form)) = name.split_once('/') {
            return self.effect_form(name, form);
        }
        self.effects
            .iter()
            .find(|e| e.name() == name)
            .cloned()
            .ok_or_else(|| ModelError::UnknownName {
                kind: "effect",
                name: name.to_owned(),
                nearest: nearest(name, self.effects.iter().map(|e| e.name())).map(str::to_owned),
            })
    }

    /// One form of an effect.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`], naming the nearest form.
    pub fn effect_form(&self, name: &str, form: &str) -> Result<Arc<dyn AnyEffect>, ModelError> {
        self.effect(name)?;
        let mut forms = self.effects.iter().filter(|e| e.name() == name);
        forms
            .clone()
            .find(|e| e.form() == form)
            .cloned()
            .ok_or_else(|| ModelError::UnknownName {
                kind: "form",
                name: form.to_owned(),
                nearest: nearest(form, forms.by_ref().map(|e| e.form())).map(str::to_owned),
            })
    }

    /// `model+effect+effect/form`.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`], [`ModelError::EffectTwice`], or a combination the model cannot carry.
    pub fn law(&self, name: &str) -> Result<Law, ModelError> {
        let mut parts = name.split('+');
        let model = self.model(parts.next().unwrap_or_default())?;
        let effects = parts
            .map(|e| self.effect(e))
            .collect::<Result<Vec<_>, _>>()?;
        Law::new(model, effects)
    }
}
