//! The effects of a scenario: what the truth has and the nominal simulator lacks.

use std::sync::Arc;

use terra_model::{
    AnyEffect, AnyModel, BodyLoads, Channel, Contact, Law, Motion, Registry, Scope, Soil, Touch,
    Vehicle,
};

use crate::error::SimError;
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
}

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
        for setting in settings {
            let effect = match &setting.form {
                Some(form) => registry.effect_form(&setting.name, form)?,
                None => registry.effect(&setting.name)?,
            };
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
        Ok(ActiveEffects { effects })
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
        self.touch(Touch::Loads)
    }

    /// How late a channel is \[s\].
    ///
    /// [`terra_model::Effect::report`] is of first order in the rate for estimators: truth - e·rate. A real sensor has
    /// a history, so here the coefficient of the rate is read off and taken as the delay it stands for.
    pub(crate) fn delay(&self, channel: Channel) -> f64 {
        self.effects
            .iter()
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
