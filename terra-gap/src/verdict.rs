//! The verdict as JSON, schema `terra-gap/1`. A number that cannot be given is null, with its name and reason in `reasons`.

use serde_json::{Map, Value, json};

use crate::cause::Cause;
use crate::diagnose::Diagnosis;

/// Where a verdict comes from.
#[derive(Clone, Debug, Default)]
pub struct Provenance {
    /// SHA-256 of the log.
    pub log_sha256: String,
    /// SHA-256 of the rover file.
    pub rover_sha256: String,
    /// Seed of what is random (nothing, unless calibrated).
    pub seed: u64,
}

/// The verdict as JSON.
pub fn to_json(d: &Diagnosis, provenance: &Provenance) -> Value {
    let mut reasons = Map::new();
    let mut number =
        |name: &str, value: Option<f64>, why: &str| match value.filter(|v| v.is_finite()) {
            Some(v) => json!(v),
            None => {
                reasons.insert(name.to_owned(), json!(why));
                Value::Null
            }
        };
    let why_not = d
        .reason
        .clone()
        .unwrap_or_else(|| "the model has no answer there".to_owned());
    let chi2 = json!({
        "nominal_as_given": number("gap.chi2_per_dof.nominal_as_given", d.waterfall.as_given, &why_not),
        "nominal_refitted": number("gap.chi2_per_dof.nominal_refitted", d.waterfall.refitted, &why_not),
        "noise_floor": if d.data.is_empty() { number("gap.chi2_per_dof.noise_floor", None, &why_not) } else { json!(1.0) },
    });
    let rms: Map<String, Value> = d
        .rms
        .iter()
        .map(|(name, value)| (name.clone(), json!(value)))
        .collect();
    let after = match (&d.accepted, &d.held_out) {
        (Some((_, fit)), held) => {
            let n = d.data.len() as f64;
            let (before, after) = (d.waterfall.refitted, d.waterfall.after);
            let closed = before
                .zip(after)
                .filter(|(b, _)| *b > 1.0)
                .map(|(b, a)| (b - a) / (b - 1.0));
            let held = held.as_ref().map(|h| {
                if h.closed.is_none() {
                    reasons.insert(
                        "after.held_out.closed".to_owned(),
                        json!(h.why_open()),
                    );
                }
                json!({
                    "by": h.by.name(),
                    "closed": h.closed,
                    "closed_by_channel": h.closed_by_channel.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
                    "chi2_per_dof": { "before": h.chi2_before, "after": h.chi2_after },
                    "groups": h.groups,
                    "failed": h.failed,
                })
            });
            json!({
                "effects": d.accepted_names,
                "held_out": held,
                "in_sample": { "closed": closed, "chi2_per_dof": { "before": before, "after": after } },
                "remainder": { "chi2_per_dof": fit.chi2() / n, "where": d.remainder },
            })
        }
        _ => Value::Null,
    };
    let mut out = json!({
        "schema": "terra-gap/1",
        "verdict": d.verdict,
        "gap": { "chi2_per_dof": chi2, "rms": rms, "where": d.places },
        "causes": d.causes.iter().map(cause).collect::<Vec<_>>(),
        "probability_none": d.probability_none,
        "probability_unknown": d.probability_unknown,
        "set": d.set,
        "accepted": d.accepted_names,
        "nearest": d.nearest,
        "after": after,
        "terrain": terrain(d),
        "next": d.next,
        "calibration": d.calibration,
        "evidence": d.evidence,
        "data": {
            "values": d.data.len(),
            "observations": d.data.observations.len(),
            "dropped": d.data.dropped,
            "notes": d.data.notes,
        },
        "not_asked": d.not_asked.iter().map(|(effect, reason)| json!({ "effect": effect, "reason": reason })).collect::<Vec<_>>(),
        "provenance": {
            "terra": env!("CARGO_PKG_VERSION"),
            "log_sha256": provenance.log_sha256,
            "rover_sha256": provenance.rover_sha256,
            "seed": provenance.seed,
        },
    });
    if let Value::Object(map) = &mut out {
        if let Some(reason) = &d.reason {
            map.insert("reason".to_owned(), json!(reason));
        }
        if let Some(logs) = &d.logs {
            map.insert("logs".to_owned(), json!(logs));
        }
        if let Some(baseline) = &d.baseline {
            map.insert("baseline".to_owned(), json!(baseline));
        }
        if !reasons.is_empty() {
            map.insert("reasons".to_owned(), Value::Object(reasons));
        }
    }
    out
}

fn cause(c: &Cause) -> Value {
    let h = &c.weighed.hypothesis;
    let start = h.soil_len();
    let effects = h.effects();
    let mut parameters = Map::new();
    let mut k = start;
    for effect in effects {
        for p in effect.params() {
            let name = if effects.len() > 1 {
                format!("{}.{}", effect.name(), p.name)
            } else {
                p.name.to_owned()
            };
            let sd = c.weighed.posterior.covariance[(k, k)].max(0.0).sqrt() * p.prior_sd;
            parameters.insert(
                name,
                json!({ "mean": c.weighed.fit.x[k] * p.prior_sd, "sd": sd, "unit": p.unit }),
            );
            k += 1;
        }
    }
    json!({
        "effect": c.name,
        "probability": c.probability,
        "log_evidence_gain": c.log_evidence_gain,
        "absorbed": c.absorbed,
        "power": c.power,
        "form": c.form,
        "under_model": h.law.model().name(),
        "parameters": parameters,
        "indistinguishable_from": c.indistinguishable_from,
        "unseen_second": c.unseen_second,
        "on_other_soil": c.on_other_soil,
    })
}

fn terrain(d: &Diagnosis) -> Value {
    let mut parameters = Map::new();
    let mut model = d.model.clone();
    if let Some((h, fit)) = d.accepted.as_ref().or(d.null.as_ref()) {
        model = h.law.model().name().to_owned();
        let post = crate::evidence::posterior(h, fit);
        let n = h.soil_len();
        let q: Vec<f64> = fit.x.iter().take(n).copied().collect();
        let covariance = post.covariance.view((0, 0), (n, n)).into_owned();
        let rows = h.soil.names().into_iter().zip(h.soil.units());
        let values = h
            .soil
            .physical(&q)
            .into_iter()
            .zip(h.soil.physical_sd(&q, &covariance));
        for (((name, unit), (mean, sd)), moved) in rows.zip(values).zip(&q) {
            parameters.insert(
                name,
                json!({ "mean": mean, "sd": sd, "unit": unit, "moved_prior_sd": moved }),
            );
        }
    }
    json!({ "model": model, "parameters": parameters, "undetermined": d.undetermined })
}
