//! The identification as JSON, schema `terra-identify/1`.

use serde_json::{Map, Value, json};
use terra_mme::{ForcePrediction, ParameterBelief, Spread};

use super::{Group, Identification, Refined};

/// The result as JSON.
pub(crate) fn to_json(id: &Identification, log_sha256: &str, rover_sha256: &str) -> Value {
    json!({
        "schema": "terra-identify/1",
        "log_kind": id.log_kind,
        "filter": id.filter,
        "estimator": id.estimator,
        "choice": { "kind": id.choice.kind(), "value": id.choice.value() },
        "prewhiten_rho": id.prewhiten_rho,
        "flags": id.flags,
        "near_duplicates": id.near_duplicates.iter().map(|d| json!({
            "pair": d.pair, "distance": d.distance,
        })).collect::<Vec<_>>(),
        "samples": {
            "rows": id.samples.rows, "used": id.samples.used, "waiting": id.samples.waiting,
            "rejected": id.samples.rejected, "missing": id.samples.missing,
        },
        "groups": id.groups.iter().map(group).collect::<Vec<_>>(),
        "provenance": {
            "terra": env!("CARGO_PKG_VERSION"), "log_sha256": log_sha256, "rover_sha256": rover_sha256, "seed": 0,
        },
    })
}

fn group(g: &Group) -> Value {
    let mut out = json!({
        "group": g.name,
        "posterior": g.posterior.iter().map(|p| json!({
            "id": p.id, "model": p.model, "probability": p.probability, "log_likelihood": p.log_likelihood,
            "infeasible_samples": p.infeasible_samples,
        })).collect::<Vec<_>>(),
        "map": g.map,
        "known_to": g.known_to,
        "parameter_mean": parameter_mean(&g.belief),
        "force_prediction": g.force_prediction.iter().map(prediction).collect::<Vec<_>>(),
        "consistency": consistency(g),
    });
    if let Value::Object(map) = &mut out {
        match &g.refined {
            Ok(r) => map.insert("refined".to_owned(), refined(r)),
            Err(reason) => {
                map.insert("reasons".to_owned(), json!({ "refined": reason }));
                map.insert("refined".to_owned(), Value::Null)
            }
        };
        if let Some(h) = &g.history {
            map.insert(
                "history".to_owned(),
                json!({ "step": h.step, "time_s": h.time, "ids": h.ids, "probability": h.probability }),
            );
        }
    }
    out
}

/// Posterior mean of the most probable structure. Never to be fed to a force model: forces of a mean are not the mean of
/// forces.
fn parameter_mean(belief: &ParameterBelief) -> Value {
    let Some(s) = belief.most_probable() else {
        return Value::Null;
    };
    let parameters: Map<String, Value> = s
        .names
        .iter()
        .zip(&s.units)
        .enumerate()
        .map(|(k, (name, unit))| {
            (
                (*name).to_owned(),
                json!({ "mean": s.mean[k], "sd": s.sd(k), "unit": unit }),
            )
        })
        .collect();
    json!({ "model": s.model, "parameters": parameters })
}

fn refined(r: &Refined) -> Value {
    let parameters: Map<String, Value> = r
        .fit
        .fitted()
        .iter()
        .map(|p| {
            (
                p.name.to_owned(),
                json!({ "mean": p.value, "sd": p.sd, "unit": p.unit }),
            )
        })
        .collect();
    json!({
        "start": r.start,
        "converged": r.fit.converged,
        "force_prediction": r.force_prediction.iter().map(prediction).collect::<Vec<_>>(),
        "chi2_per_dof": r.fit.chi2_per_dof,
        "parameters": parameters,
        "undetermined": r.fit.identifiability.undetermined,
        "directions": r.fit.identifiability.directions.iter().map(|d| json!({
            "combination": d.combination.iter().map(|(n, w)| ((*n).to_owned(), json!(w))).collect::<Map<_, _>>(),
            "sd_ln": d.sd_ln,
        })).collect::<Vec<_>>(),
    })
}

fn prediction(p: &ForcePrediction) -> Value {
    let spread = |s: &Option<Spread>| s.map(|s| json!({ "mean": s.mean, "sd": s.sd }));
    json!({
        "slip": p.slip, "normal_load_N": p.normal_load, "drawbar_pull_N": spread(&p.drawbar_pull),
        "torque_N_m": spread(&p.torque), "sinkage_m": spread(&p.sinkage), "status": p.status.name(),
    })
}

fn consistency(g: &Group) -> Value {
    let c = &g.consistency;
    let candidates: Vec<Value> = g
        .candidates
        .iter()
        .map(|c| {
            json!({
                "effect": c.effect,
                "magnitude": { "mean": c.magnitude, "sd": c.sd, "unit": c.unit },
                "map": c.map, "probability": c.probability,
                "log_evidence_gain": c.log_evidence_gain, "nis_per_dof": c.nis_per_dof, "explains": c.explains,
            })
        })
        .collect();
    json!({
        "nis_per_dof": c.nis_per_dof, "lag1": c.lag1, "alarm": c.alarm, "reason": c.reason, "candidates": candidates,
    })
}
