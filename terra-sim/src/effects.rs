//! The effects of a scenario: what the truth has and the nominal simulator lacks.

use std::sync::Arc;

use terra_model::{
    AnyEffect, AnyModel, BodyLoads, Channel, Contact, Late, Law, ModelError, Motion, Registry,
    Scope, Soil, Touch, Vehicle,
};

use crate::error::SimError;
use crate::forms;
use crate::off_library::{self, TruthOnly, Unlisted};
use crate::scenario::EffectSetting;

/// Kind of log that is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LogKind {
    Drive,
    Rig,
}

/// The effects that act, with their magnitudes, in the scenario's order.
#[derive(Clone)]
pub(crate) struct ActiveEffects {
    effects: Vec<(Arc<dyn AnyEffect>, Vec<f64>)>,
    /// Effects that only the truth has, with their magnitude and where they remember.
    unlisted: Vec<(&'static dyn Unlisted, f64, Option<usize>)>,
}

/// Effects with a memory that one run may have.
pub(crate) const MEMORIES: usize = 2;

impl ActiveEffects {
    /// Looks the effects up and checks them against model, range and kind of log.
    ///
    /// An effect whose magnitude (its first number) is zero is checked and then left out: zero magnitude is the nominal world, bit
    /// for bit.
    pub(crate) fn new(
        settings: &[EffectSetting],
        model: &Arc<dyn AnyModel>,
        registry: &Registry,
        kind: LogKind,
    ) -> Result<Self, SimError> {
        let mut effects = Vec::new();
        let mut unlisted = Vec::new();
        let mut memories = 0;
        for (k, setting) in settings.iter().enumerate() {
            let form = |s: &EffectSetting| s.form.clone().unwrap_or_else(|| "default".to_owned());
            let same =
                |other: &EffectSetting| other.name == setting.name && form(other) == form(setting);
            if settings.iter().take(k).any(same) {
                return Err(SimError::Model(ModelError::EffectTwice {
                    effect: setting.name.clone(),
                }));
            }
            if let Some(effect) = off_library::find(&setting.name) {
                let e = off_library_magnitude(effect.entry(), setting, kind)?;
                if e != 0.0 {
                    let memory = effect.remembers().then_some(memories);
                    memories += usize::from(effect.remembers());
                    unlisted.push((effect, e, memory));
                }
                continue;
            }
            let effect = library_effect(setting, registry)?;
            let wrong = match (effect.scope(), kind) {
                (Scope::Rig, LogKind::Drive) => Some("drive"),
                (Scope::Drive, LogKind::Rig) => Some("rig"),
                _ => None,
            };
            if let Some(kind) = wrong {
                return Err(SimError::EffectScope {
                    effect: setting.name.clone(),
                    kind,
                });
            }
            let params = effect.params();
            if params.len() != setting.magnitude.len() {
                return Err(SimError::MagnitudeCount {
                    effect: setting.name.clone(),
                    expected: params.len(),
                    found: setting.magnitude.len(),
                });
            }
            for (param, &value) in params.iter().zip(&setting.magnitude) {
                if !(value.is_finite() && (param.min..=param.max).contains(&value)) {
                    return Err(SimError::Magnitude {
                        effect: setting.name.clone(),
                        parameter: param.name,
                        value,
                        min: param.min,
                        max: param.max,
                        unit: param.unit,
                    });
                }
            }
            Law::new(Arc::clone(model), vec![Arc::clone(&effect)])?;
            if setting.magnitude.first().is_some_and(|e| *e != 0.0) {
                effects.push((effect, setting.magnitude.clone()));
            }
        }
        if memories > MEMORIES {
            return Err(SimError::Value {
                quantity: "effects with a memory in one run".to_owned(),
                value: memories as f64,
                expected: "at most 2",
            });
        }
        Ok(ActiveEffects { effects, unlisted })
    }

    /// The effects that only the truth has.
    pub(crate) fn unlisted(
        &self,
    ) -> impl Iterator<Item = (&'static dyn Unlisted, f64, Option<usize>)> + '_ {
        self.unlisted.iter().copied()
    }

    /// True when some effect remembers.
    pub(crate) fn remember(&self) -> bool {
        self.unlisted.iter().any(|(_, _, memory)| memory.is_some())
    }

    /// The model under these effects.
    pub(crate) fn law(&self, model: &Arc<dyn AnyModel>) -> Result<Law, SimError> {
        Ok(Law::new(
            Arc::clone(model),
            self.effects.iter().map(|(e, _)| Arc::clone(e)).collect(),
        )?)
    }

    /// The law's parameters: the soil's, then the magnitudes.
    pub(crate) fn parameters(&self, soil: &[f64]) -> Vec<f64> {
        let mut p = soil.to_vec();
        p.extend(self.effects.iter().flat_map(|(_, e)| e));
        p
    }

    /// The contact that the soil really sees.
    pub(crate) fn contact(
        &self,
        model: &dyn AnyModel,
        soil: &[f64],
        at: &Contact<f64>,
    ) -> Contact<f64> {
        let roles: Soil<f64> = model.soil_at(soil, at);
        self.effects.iter().fold(*at, |contact, (effect, e)| {
            effect.before_at(e, &roles, contact)
        })
    }

    /// The vehicle as it really is.
    pub(crate) fn vehicle(&self, nominal: Vehicle<f64>) -> Vehicle<f64> {
        self.effects.iter().fold(nominal, |vehicle, (effect, e)| {
            effect.vehicle_at(e, vehicle)
        })
    }

    /// Loads beside the wheel forces.
    pub(crate) fn loads(&self, vehicle: &Vehicle<f64>, motion: &Motion<f64>) -> BodyLoads<f64> {
        self.effects
            .iter()
            .fold(BodyLoads::none(), |loads, (effect, e)| {
                effect.loads_at(e, vehicle, motion, loads)
            })
    }

    /// True when some effect acts at this place.
    pub(crate) fn touch(&self, place: Touch) -> bool {
        self.effects
            .iter()
            .any(|(e, _)| e.touches().contains(&place))
    }

    /// True when some effect may pull on the body or the drivetrain.
    pub(crate) fn any_loads(&self) -> bool {
        self.touch(Touch::Loads) || !self.unlisted.is_empty()
    }

    /// How late a channel is \[s\], in one of the ways.
    ///
    /// [`terra_model::Effect::report`] is of first order in the rate for estimators: truth - e·rate. A real sensor has
    /// a history, so here the coefficient of the rate is read off and taken as the delay or the time constant it stands for.
    pub(crate) fn behind(&self, channel: Channel, late: Late) -> f64 {
        self.effects
            .iter()
            .filter(|(effect, _)| effect.late() == late)
            .map(|(effect, e)| {
                let at = |rate: f64| effect.report_at(e, channel, 0.0, rate);
                at(0.0) - at(1.0)
            })
            .sum::<f64>()
            .max(0.0)
    }

    /// What the sensor says of a truth (already delayed).
    pub(crate) fn report(&self, channel: Channel, truth: f64) -> f64 {
        self.effects.iter().fold(truth, |value, (effect, e)| {
            effect.report_at(e, channel, value, 0.0)
        })
    }
}

/// An effect of the registry, in a form of the registry or one that only the truth has.
fn library_effect(
    setting: &EffectSetting,
    registry: &Registry,
) -> Result<Arc<dyn AnyEffect>, SimError> {
    if let Some(form) = &setting.form {
        if let Some(effect) = forms::find(&setting.name, form) {
            return Ok(effect);
        }
        return Ok(registry
            .clone()
            .with_forms()
            .effect_form(&setting.name, form)?);
    }
    registry.effect(&setting.name).map_err(|error| match error {
        ModelError::UnknownName {
            kind,
            name,
            nearest: None,
        } => SimError::Model(ModelError::UnknownName {
            kind,
            nearest: off_library::nearest_name(&name).map(str::to_owned),
            name,
        }),
        other => SimError::Model(other),
    })
}

/// The magnitude of an off-library effect, checked like a library one's.
fn off_library_magnitude(
    entry: &TruthOnly,
    setting: &EffectSetting,
    kind: LogKind,
) -> Result<f64, SimError> {
    if kind == LogKind::Rig && entry.scope == Scope::Drive {
        return Err(SimError::EffectScope {
            effect: setting.name.clone(),
            kind: "rig",
        });
    }
    if let Some(form) = setting.form.as_ref().filter(|f| *f != entry.form) {
        return Err(SimError::Model(ModelError::UnknownName {
            kind: "form",
            name: form.clone(),
            nearest: Some(entry.form.to_owned()),
        }));
    }
    let &[e] = setting.magnitude.as_slice() else {
        return Err(SimError::MagnitudeCount {
            effect: setting.name.clone(),
            expected: 1,
            found: setting.magnitude.len(),
        });
    };
    if !(0.0..=entry.largest()).contains(&e) {
        return Err(SimError::Magnitude {
            effect: setting.name.clone(),
            parameter: "magnitude",
            value: e,
            min: 0.0,
            max: entry.largest(),
            unit: entry.unit,
        });
    }
    Ok(e)
}
