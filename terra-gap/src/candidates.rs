//! Which effects can be asked of this log: gated by what the log declares, with the reason where not.

use std::sync::Arc;

use terra_data::Rover;
use terra_model::{AnyEffect, Law, Registry, Scope, Touch};

use crate::dataset::{DataSet, Ranges};
use crate::error::GapError;
use crate::rig::is_bare;
use crate::settings::{LogKind, Settings};
use crate::wheel_size::WheelSize;

/// True where the formula of an effect is a definition (a sensor, a measure, the drivetrain) and none of the ground's, of
/// which every formula is somebody's choice.
pub fn is_instrument(effect: &dyn AnyEffect) -> bool {
    let touches = effect.touches();
    let of_the_ground = touches.contains(&Touch::Forces)
        || (touches.contains(&Touch::Contact) && !effect.needs().is_empty());
    !of_the_ground
}

/// Effects to weigh, and those that were not asked with the reason.
#[derive(Clone, Default)]
pub(crate) struct Candidates {
    /// To be weighed; forms of one effect side by side.
    pub effects: Vec<Arc<dyn AnyEffect>>,
    /// Name and reason.
    pub not_asked: Vec<(String, String)>,
    /// The wheel they are asked of.
    size: WheelSize,
}

impl Candidates {
    /// The library's other forms of these that can stand in a law.
    pub(crate) fn other_forms(&self, law: &Law) -> Vec<Arc<dyn AnyEffect>> {
        let asked = |form: &dyn AnyEffect| {
            let of = |e: &&Arc<dyn AnyEffect>| e.name() == form.name();
            let mut same = self.effects.iter().filter(of).peekable();
            same.peek().is_some() && same.all(|e| e.form() != form.form())
        };
        let forms = forms_in(law, asked).into_iter();
        forms.map(|form| self.size.suits(form)).collect()
    }

    /// Whether this is the form in which an effect is asked first.
    pub(crate) fn is_first(&self, effect: &dyn AnyEffect) -> bool {
        let mut all = self.effects.iter();
        let first = all.find(|e| e.name() == effect.name());
        first.is_some_and(|e| e.form() == effect.form())
    }
}

/// Gates the registry's effects. `before`: what a simulator's log went through, against which the log may differ by being otherwise as
/// a whole.
///
/// # Errors
/// An unknown name in the settings.
pub(crate) fn gate(
    registry: &Registry,
    law: &Law,
    data: &DataSet,
    rover: &Rover,
    kind: LogKind,
    settings: &Settings,
    before: Option<&Ranges>,
) -> Result<Candidates, GapError> {
    if let Some(names) = &settings.effects {
        for name in names {
            registry.effect(name)?;
        }
    }
    let mut out = Candidates {
        size: WheelSize::of(data, rover, kind),
        ..Candidates::default()
    };
    for effect in registry.effects() {
        let name = effect.name();
        if settings
            .effects
            .as_ref()
            .is_some_and(|names| !names.iter().any(|n| n == name))
        {
            continue;
        }
        let mut asked: Vec<Arc<dyn AnyEffect>> = vec![Arc::clone(effect)];
        if kind == LogKind::Drive && law.with_effects([Arc::clone(effect)]).is_err() {
            // A law without a shear stress has no hump of it, but it may have a strength.
            let forms = forms_in(law, |form| form.name() == name);
            if !forms.is_empty() {
                asked = forms;
            }
        } else if kind == LogKind::Drive {
            // Forms of one name have much the same slope at zero; what has none there is not seen by another's.
            asked.extend(forms_in(law, |form| form.name() == name && form.is_flat()));
        }
        let mut reasons = vec![];
        for effect in asked {
            match reason_against(&effect, law, data, rover, kind, before) {
                None => out.effects.push(out.size.suits(effect)),
                Some(reason) => reasons.push((name.to_owned(), reason)),
            }
        }
        reasons.dedup();
        out.not_asked.extend(reasons);
    }
    Ok(out)
}

/// The library's other forms that can stand in a law, of those that are `asked`.
fn forms_in(law: &Law, asked: impl Fn(&dyn AnyEffect) -> bool) -> Vec<Arc<dyn AnyEffect>> {
    let library = Registry::empty().with_forms();
    let forms = library.effects().iter().filter(|form| asked(&***form));
    let stands = |form: &&Arc<dyn AnyEffect>| law.with_effects([Arc::clone(*form)]).is_ok();
    forms.filter(stands).map(Arc::clone).collect()
}

fn reason_against(
    effect: &Arc<dyn AnyEffect>,
    law: &Law,
    data: &DataSet,
    rover: &Rover,
    kind: LogKind,
    before: Option<&Ranges>,
) -> Option<String> {
    let has = |stem: &str| {
        let mut read = data.observations.iter().flat_map(|o| &o.channels);
        read.any(|&c| data.channels[c].name.starts_with(stem))
    };
    match (effect.scope(), kind) {
        (Scope::Drive, LogKind::Rig) => return Some("shows only on a vehicle".to_owned()),
        (Scope::Rig, LogKind::Drive | LogKind::Kinematic) => {
            return Some("shows only on a rig".to_owned());
        }
        _ => {}
    }
    if law.effects().iter().any(|e| e.name() == effect.name()) {
        return Some("already in the nominal model".to_owned());
    }
    if let Err(e) = law.with_effects([Arc::clone(effect)]) {
        return Some(e.to_string());
    }
    let torque = has("torque") || has("wheel_torque");
    let missing = match effect.name() {
        "torque-scale"
        | "torque-bias"
        | "torque-droop"
        | "drivetrain-coulomb-friction"
        | "drivetrain-viscous-friction"
            if !torque =>
        {
            "no torque in the log"
        }
        "drawbar-gain" | "drawbar-bias" if !has("drawbar_pull") => "no drawbar pull in the log",
        "sinkage-bias" if !has("sinkage") => "no sinkage in the log",
        "accel-bias" if !has("accel_x") => "no acceleration in the log",
        "yaw-rate-bias" if !has("yaw") => "no yaw rate in the log",
        "grousers"
            if kind == LogKind::Rig
                && data
                    .observations
                    .iter()
                    .all(|o| is_bare(rover, false, &o.condition)) =>
        {
            "the log declares a smooth wheel"
        }
        "track-width-error" | "lateral-bulldozing" | "skid-steer-lateral-slip"
            if !turns(data, rover) =>
        {
            "the log holds no turns: its yaw rate stays at the sensor's noise"
        }
        "ground-speed-bias" if kind == LogKind::Rig && !tells(data, "speed") => {
            "no travel speed in the log"
        }
        "terrain-drift" if kind == LogKind::Rig && !tells(data, "path") => {
            "no path in the log: it takes time_s, travel_speed_m_s and trials of more than one row"
        }
        "multipass" if kind == LogKind::Rig && !varies(data, before, "pass", 0.0) => {
            "all rows are the same pass"
        }
        "rate-stiffening" if kind == LogKind::Rig && !varies(data, before, "speed", 0.2) => {
            "the travel speed is the same in all rows, so speed and stiffness cannot be told apart"
        }
        _ => return None,
    };
    Some(missing.to_owned())
}

/// True when the yaw rate leaves the sensor's noise; otherwise an effect of turning would only be fitted to that noise.
fn turns(data: &DataSet, rover: &Rover) -> bool {
    let noise = rover.noise.get("yaw_rate_rad_s").unwrap_or(0.0);
    data.observations
        .iter()
        .filter_map(|o| o.factors.get("yaw_rate"))
        .any(|r| r.abs() > 5.0 * noise.max(1e-3))
}

/// Whether a row tells more of it than 0.
fn tells(data: &DataSet, factor: &str) -> bool {
    let mut rows = data.observations.iter();
    rows.any(|o| o.factors.get(factor).is_some_and(|v| *v > 0.0))
}

/// Whether rows differ in it, from each other or from those before.
fn varies(data: &DataSet, before: Option<&Ranges>, factor: &str, relative: f64) -> bool {
    let own = data.range_of(factor);
    let before = before.and_then(|b| b.get(factor)).copied();
    let both = match (own, before) {
        (Some(own), Some(before)) => (own.0.min(before.0), own.1.max(before.1)),
        (own, _) => own.unwrap_or((f64::INFINITY, f64::NEG_INFINITY)),
    };
    both.1 - both.0 > relative * both.0.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A law without a shear stress has no hump of it and no lugs that reach below it, but the forms of these that act on the
    /// strength or on the forces; where the formulas themselves can stand they are asked alone.
    #[test]
    fn a_form_stands_where_the_effect_s_own_formula_cannot() {
        let registry = Registry::builtin();
        let rover = terra_data::parse_rover(crate::drive::ROVER, "rover.toml").unwrap();
        let asked = |model: &str, name: &str| {
            let law = registry.law(model).unwrap();
            let settings = Settings::of(&rover);
            let data = DataSet {
                channels: vec![],
                short_scatter: vec![],
                uneven: None,
                observations: vec![],
                dropped: std::collections::BTreeMap::new(),
                notes: vec![],
            };
            let kind = LogKind::Drive;
            let found = gate(&registry, &law, &data, &rover, kind, &settings, None).unwrap();
            let mine = found.effects.iter().filter(|e| e.name() == name);
            mine.map(|e| e.form()).collect::<Vec<_>>()
        };
        assert_eq!(asked("linear-stress", "shear-hump"), ["peak-strength"]);
        assert_eq!(
            asked("linear-stress", "grousers"),
            ["side-walls", "passive-lug"]
        );
        assert_eq!(asked("scm-column", "rear-contact"), ["energy-return"]);
        for name in ["shear-hump", "grousers", "rear-contact"] {
            assert_eq!(asked("wong-reece", name), ["default"]);
        }
    }
}
