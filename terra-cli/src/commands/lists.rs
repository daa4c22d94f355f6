//! What is registered: models, effects, terrains, filters, estimators.

use std::sync::Arc;

use serde_json::{Value, json};
use terra_model::catalogue::Terrain;
use terra_model::models::{Filling, Slots};
use terra_model::{AnyEffect, AnyModel, Param, Registry, Scale, catalogue};

use crate::error::CliError;
use crate::output::{self, short, table};

fn emit(as_json: bool, json: Value, text: String) -> Result<(), CliError> {
    if as_json {
        output::json(None, &json)
    } else {
        output::stdout(&text)
    }
}

fn param(p: &Param) -> Value {
    // JSON has no infinity: an open end is null.
    let end = |x: f64| if x.is_finite() { json!(x) } else { Value::Null };
    json!({
        "name": p.name, "symbol": p.symbol, "unit": p.unit, "min": end(p.min), "max": end(p.max),
        "scale": match p.scale { Scale::Linear => "linear", Scale::Log => "log" },
        "prior_sd": p.prior_sd, "doc": p.doc,
    })
}

/// Every model that has a name of its own, and whether a diagnosis weighs it as a rival structure.
pub(crate) fn named_models(
    registry: &Registry,
) -> impl Iterator<Item = (&Arc<dyn AnyModel>, bool)> {
    let rivals = registry.models().iter().map(|m| (m, true));
    rivals.chain(registry.named_models().iter().map(|m| (m, false)))
}

fn filling(f: &Filling) -> Value {
    json!({
        "name": f.name, "default": f.default, "summary": f.summary, "reference": f.reference,
        "parameters": f.params.iter().map(param).collect::<Vec<_>>(),
    })
}

/// The terrain models as JSON.
pub(crate) fn models_json(registry: &Registry) -> Value {
    json!(
        named_models(registry)
            .map(|(m, rival)| json!({
                "name": m.name(), "summary": m.summary(), "equation": m.equation(), "reference": m.reference(), "in_diagnosis": rival,
                "hooks": m.hooks().iter().map(|h| h.name()).collect::<Vec<_>>(),
                "parameters": m.params().iter().map(param).collect::<Vec<_>>(),
                "slots": Slots::of(m.name()).map(|s| json!({
                    "pressure": s.pressure.iter().map(filling).collect::<Vec<_>>(),
                    "shear": s.shear.iter().map(filling).collect::<Vec<_>>(),
                })),
            }))
            .collect::<Vec<_>>()
    )
}

fn parameter_table(params: &[Param]) -> String {
    let row = |p: &Param| {
        vec![
            format!("  {}", p.name),
            p.symbol.to_owned(),
            p.unit.to_owned(),
            p.doc.to_owned(),
        ]
    };
    let rows: Vec<Vec<String>> = params.iter().map(row).collect();
    table(&["  parameter", "symbol", "unit", "meaning"], &rows)
}

/// The laws that slots can hold, each with the wheels that take it.
fn slots_text(registry: &Registry) -> String {
    let wheels: Vec<(&'static str, Slots)> = named_models(registry)
        .filter_map(|(m, _)| Some((m.name(), Slots::of(m.name())?)))
        .collect();
    let names: Vec<&str> = wheels.iter().map(|(name, _)| *name).collect();
    let mut text = format!(
        "slots, wheel[:pressure[:shear]], e.g. wong-reece:reece:wong-hump: {} combinations\n  wheel: {}\n\n",
        Slots::combinations().count(),
        names.join(", ")
    );
    for (slot, of) in [
        ("pressure", (|s| &s.pressure) as fn(&Slots) -> &Vec<Filling>),
        ("shear", |s| &s.shear),
    ] {
        let mut known: Vec<&Filling> = vec![];
        for law in wheels.iter().flat_map(|(_, s)| of(s)) {
            if known.iter().all(|k| k.name != law.name) {
                known.push(law);
            }
        }
        for law in known {
            text.push_str(&format!("{slot} {}: {}\n", law.name, law.summary));
            text.push_str(&parameter_table(&law.params));
            let takes = |s: &Slots| of(s).iter().any(|f| f.name == law.name);
            let takers = wheels.iter().filter(|(_, s)| takes(s));
            let takers: Vec<&str> = takers.map(|(name, _)| *name).collect();
            text.push_str(&format!(
                "  wheels: {}\n  source: {}\n\n",
                if takers.len() == wheels.len() {
                    "all".to_owned()
                } else {
                    takers.join(", ")
                },
                law.reference
            ));
        }
    }
    text
}

pub(crate) fn models(as_json: bool) -> Result<(), CliError> {
    let registry = Registry::builtin();
    let mut text = String::new();
    for (m, rival) in named_models(&registry) {
        text.push_str(&format!("{}: {}\n", m.name(), m.summary()));
        text.push_str(&parameter_table(m.params()));
        if !rival {
            text.push_str(
                "  no rival structure in a diagnosis: a driven wheel of it is another model's\n",
            );
        }
        let hooks: Vec<&str> = m.hooks().iter().map(|h| h.name()).collect();
        text.push_str(&format!(
            "  effects may act on: {}\n  source: {}\n\n",
            hooks.join(", "),
            m.reference()
        ));
    }
    text.push_str(&slots_text(&registry));
    let json = models_json(&registry);
    emit(as_json, json, text)
}

/// Every form of the effects, and whether a diagnosis tries it: those of the registry it does, the other forms not.
pub(crate) fn forms(registry: &Registry) -> Vec<(Arc<dyn AnyEffect>, bool)> {
    let others = Registry::empty().with_forms();
    let tried = registry.effects().iter().map(|e| (e.clone(), true));
    let known = |e: &Arc<dyn AnyEffect>| {
        let same = |r: &Arc<dyn AnyEffect>| r.name() == e.name() && r.form() == e.form();
        registry.effects().iter().any(same)
    };
    let others = others.effects().iter().filter(|e| !known(e));
    tried.chain(others.map(|e| (e.clone(), false))).collect()
}

/// The effects as JSON.
pub(crate) fn effects_json(registry: &Registry) -> Value {
    json!(
        forms(registry)
            .iter()
            .map(|(e, tried)| json!({
                "name": e.name(), "form": e.form(), "in_diagnosis": tried,
                "summary": e.summary(), "equation": e.equation(), "reference": e.reference(),
                "scope": match e.scope() {
                    terra_model::Scope::Any => "any",
                    terra_model::Scope::Drive => "drive",
                    terra_model::Scope::Rig => "rig",
                },
                "regime": e.regime(), "isolated_by": e.isolated_by(),
                "prior_share": e.share(),
                "parameters": e.params().iter().map(param).collect::<Vec<_>>(),
            }))
            .collect::<Vec<_>>()
    )
}

pub(crate) fn effects(as_json: bool) -> Result<(), CliError> {
    let registry = Registry::builtin();
    let mut all = forms(&registry);
    // Forms beside each other: a stable sort by where their effect stands in the registry.
    all.sort_by_key(|(e, _)| {
        let mut effects = registry.effects().iter();
        effects.position(|r| r.name() == e.name())
    });
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|(e, tried)| {
            let magnitude = e.params().first();
            let unit = magnitude.map_or("", |p| p.unit);
            let prior = magnitude.map_or(String::new(), |p| short(p.prior_sd));
            vec![
                e.name().to_owned(),
                e.form().to_owned(),
                if *tried { "yes" } else { "-" }.to_owned(),
                unit.to_owned(),
                prior,
                e.summary().to_owned(),
                e.regime().to_owned(),
                e.isolated_by().to_owned(),
                e.reference().to_owned(),
            ]
        })
        .collect();
    let header = [
        "effect",
        "form",
        "diagnosed",
        "unit",
        "prior sd",
        "what happens",
        "where it shows",
        "isolated by",
        "source",
    ];
    let mut text = table(&header, &rows);
    text.push_str(
        "\ndiagnosed: `terra gap` tries this form. Its weights are calibrated for one form a name; the others are for programs \
         that ask for them.\n",
    );
    emit(as_json, effects_json(&registry), text)
}

/// The soils as JSON.
pub(crate) fn terrains_json() -> Value {
    json!(
        catalogue::terrains()
            .iter()
            .map(terrain_json)
            .collect::<Vec<_>>()
    )
}

/// A soil as JSON.
pub(crate) fn terrain_json(t: &Terrain) -> Value {
    json!({
        "id": t.id, "set": t.set, "name": t.name, "moisture_pct": t.moisture,
        "sinkage_exponent": t.sinkage_exponent, "k_c": t.k_c, "k_phi": t.k_phi, "cohesion": t.cohesion,
        "friction_angle": t.friction_angle, "shear_modulus": t.shear_modulus, "c1": t.c1, "c2": t.c2,
        "class": t.class, "confidence": t.confidence.mark(), "source": t.source,
    })
}

pub(crate) fn terrains(as_json: bool) -> Result<(), CliError> {
    let number = |x: Option<f64>| x.map_or("-".to_owned(), short);
    let rows: Vec<Vec<String>> = catalogue::terrains()
        .iter()
        .map(|t| {
            vec![
                t.id.to_string(),
                t.set.to_string(),
                short(t.sinkage_exponent),
                short(t.k_c / 1e3),
                short(t.k_phi / 1e3),
                short(t.cohesion / 1e3),
                short(t.friction_angle.to_degrees()),
                number(t.shear_modulus),
                number(t.c1),
                number(t.c2),
                t.confidence.mark().to_owned(),
                t.name.to_string(),
            ]
        })
        .collect();
    let header = [
        "id",
        "set",
        "n",
        "k_c kN/m^(n+1)",
        "k_phi kN/m^(n+2)",
        "c kPa",
        "phi deg",
        "K m",
        "c1",
        "c2",
        "trust",
        "name",
    ];
    let mut text = table(&header, &rows);
    text.push_str(
        "\ntrust: A several public copies agree, B one copy, C recalled: check before use.\n\
         '-': the source gives no value. A model that needs K refuses such a soil (--value shear_modulus=... gives one); c1 and c2 \
         are then .5 and 0, the apex at half the entry angle. What belongs to the wheel (tyre pressure, lugs) and what other \
         pressure or shear laws ask for is in no row: see `terra models`.\n",
    );
    let json = terrains_json();
    emit(as_json, json, text)
}

/// The filters as JSON.
pub(crate) fn filters_json() -> Value {
    let registry = terra_ekf::Registry::builtin();
    json!(
        registry
            .filters()
            .iter()
            .map(|f| json!({ "name": f.name, "summary": f.summary, "reference": f.reference, "linear_only": f.linear_only }))
            .collect::<Vec<_>>()
    )
}

pub(crate) fn filters(as_json: bool) -> Result<(), CliError> {
    let registry = terra_ekf::Registry::builtin();
    let rows: Vec<Vec<String>> = registry
        .filters()
        .iter()
        .map(|f| {
            vec![
                f.name.to_owned(),
                f.summary.to_owned(),
                f.reference.to_owned(),
            ]
        })
        .collect();
    let json = filters_json();
    emit(
        as_json,
        json,
        table(&["filter", "what it is", "source"], &rows),
    )
}

/// The estimators as JSON.
pub(crate) fn estimators_json() -> Value {
    json!(
        terra_mme::estimators()
            .iter()
            .map(|e| json!({ "name": e.name, "summary": e.summary, "reference": e.reference }))
            .collect::<Vec<_>>()
    )
}

pub(crate) fn estimators(as_json: bool) -> Result<(), CliError> {
    let all = terra_mme::estimators();
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|e| {
            vec![
                e.name.to_owned(),
                e.summary.to_owned(),
                e.reference.to_owned(),
            ]
        })
        .collect();
    let json = estimators_json();
    emit(
        as_json,
        json,
        table(&["estimator", "what it is", "source"], &rows),
    )
}
