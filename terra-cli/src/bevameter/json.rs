//! `terra-bevameter/1`.

use serde_json::{Value, json};
use terra_model::bevameter::{Interval, LawFit};

use super::{Kind, Soil, Tests};

/// Finite numbers only; anything else is null.
fn finite(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}

fn law(l: &LawFit) -> Value {
    let parameters: serde_json::Map<String, Value> = l
        .parameters
        .iter()
        .map(|p| {
            (
                p.name.to_owned(),
                json!({ "value": finite(p.value), "lo": finite(p.low), "hi": finite(p.high), "unit": p.unit }),
            )
        })
        .collect();
    json!({
        "law": l.law, "rms_Pa": finite(l.rms), "rms_share": finite(l.rms_share), "delta_bic": finite(l.delta_bic),
        "interval": match l.interval { Interval::BetweenTests => "between-tests", Interval::WithinTests => "within-tests", Interval::NotKnown => "not-known" },
        "parameters": parameters,
    })
}

/// The whole answer.
pub(crate) fn to_json(kind: Kind, tests: &Tests, soils: &[Soil]) -> Value {
    let given = match kind {
        Kind::Plate => "plate_radius_m",
        Kind::Shear => "normal_stress_Pa",
    };
    let soils: Vec<Value> = soils
        .iter()
        .map(|s| {
            let null: serde_json::Map<String, Value> = s
                .fits
                .null
                .iter()
                .map(|(name, c)| ((*name).to_owned(), finite(*c)))
                .collect();
            json!({
                "soil": s.name,
                "best": s.fits.best().map(|l| l.law),
                "laws": s.fits.laws.iter().map(law).collect::<Vec<_>>(),
                "null_direction": if null.is_empty() { Value::Null } else { Value::Object(null) },
                "undetermined": s.fits.undetermined,
                "tests": s.fits.tests.iter().map(|t| json!({
                    "test": t.test, given: finite(t.given), "rows": t.rows, "loading": t.loading, "points": t.points.len(),
                    "peak_stress_Pa": finite(t.peak.1), "peak_at_m": finite(t.peak.0), "residual_stress_Pa": finite(t.residual),
                })).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "schema": "terra-bevameter/1",
        "kind": kind.name(),
        "rows": { "read": tests.rows, "missing": tests.missing, "left_out": tests.left_out },
        "soils": soils,
        "provenance": { "terra": env!("CARGO_PKG_VERSION"), "log_sha256": tests.sha256 },
    })
}
