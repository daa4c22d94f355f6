//! What a verdict file answers, as far as marking needs it.

use std::path::Path;

use serde::Deserialize;

use super::key::read_json;
use crate::error::CliError;

/// Schema of a verdict.
const SCHEMA: &str = "terra-gap/1";
/// A set is the smallest that holds this probability.
const SET: f64 = 0.9;

/// One rival.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Named {
    pub(crate) effect: String,
    pub(crate) probability: f64,
    #[serde(default)]
    pub(crate) log_evidence_gain: Option<f64>,
    #[serde(default)]
    pub(crate) indistinguishable_from: Vec<String>,
}

/// A share with its interval.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct Closed {
    pub(crate) mean: f64,
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct HeldOut {
    pub(crate) by: String,
    #[serde(default)]
    pub(crate) closed: Option<Closed>,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct After {
    #[serde(default)]
    pub(crate) effects: Vec<String>,
    #[serde(default)]
    pub(crate) held_out: Option<HeldOut>,
}

#[derive(Clone, Debug, Default, Deserialize)]
struct Misfit {
    #[serde(default)]
    nominal_refitted: Option<f64>,
}

#[derive(Clone, Debug, Default, Deserialize)]
struct Gap {
    #[serde(default)]
    chi2_per_dof: Misfit,
}

/// A verdict.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Verdict {
    schema: String,
    pub(crate) verdict: String,
    pub(crate) causes: Vec<Named>,
    pub(crate) probability_none: f64,
    pub(crate) probability_unknown: f64,
    pub(crate) set: Vec<String>,
    #[serde(default)]
    pub(crate) after: Option<After>,
    #[serde(default)]
    gap: Gap,
}

impl Verdict {
    /// The verdict of a case; none when its file is missing.
    ///
    /// # Errors
    /// A file that is no verdict, with line and column.
    pub(crate) fn open(folder: &Path, case: &str) -> Result<Option<Self>, CliError> {
        let path = folder.join(format!("{case}.json"));
        if !path.exists() {
            return Ok(None);
        }
        let mut v: Verdict = read_json(&path)?;
        let bad = |message: String| {
            Err(CliError::BadData {
                message: format!("{}:1:1: {message}", path.display()),
                help: None,
            })
        };
        if v.schema != SCHEMA {
            return bad(format!("schema '{}', expected '{SCHEMA}'", v.schema));
        }
        let all = v.causes.iter().map(|c| c.probability);
        if let Some(p) = all
            .chain([v.probability_none, v.probability_unknown])
            .find(|p| !(-1e-9..=1.0 + 1e-9).contains(p))
        {
            return bad(format!("a probability is {p}"));
        }
        v.causes
            .sort_by(|a, b| b.probability.total_cmp(&a.probability));
        Ok(Some(v))
    }

    /// A verdict from probabilities alone: the most probable answer is given, the set holds 90 %.
    pub(crate) fn of(causes: Vec<(String, f64)>, none: f64, unknown: f64) -> Self {
        let mut causes: Vec<Named> = causes
            .into_iter()
            .map(|(effect, probability)| Named {
                effect,
                probability,
                log_evidence_gain: None,
                indistinguishable_from: vec![],
            })
            .collect();
        causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let mut v = Verdict {
            schema: SCHEMA.to_owned(),
            verdict: String::new(),
            causes,
            probability_none: none,
            probability_unknown: unknown,
            set: vec![],
            after: None,
            gap: Gap::default(),
        };
        let ranked: Vec<(String, f64)> = v
            .ranked()
            .into_iter()
            .map(|(a, p)| (a.to_owned(), p))
            .collect();
        v.verdict = match ranked.first() {
            Some((a, _)) if a == "none" => "none",
            Some((a, _)) if a == "unknown" => "unknown",
            _ => "named",
        }
        .to_owned();
        let mut held = 0.0;
        for (answer, p) in ranked {
            if held >= SET || p <= 0.0 {
                break;
            }
            held += p;
            v.set.push(answer);
        }
        v
    }

    /// All answers with their probabilities, the most probable first; names before `none` before `unknown` at ties.
    pub(crate) fn ranked(&self) -> Vec<(&str, f64)> {
        let mut all: Vec<(&str, f64)> = self
            .causes
            .iter()
            .map(|c| (c.effect.as_str(), c.probability))
            .collect();
        all.push(("none", self.probability_none));
        all.push(("unknown", self.probability_unknown));
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all
    }

    /// Misfit per value of the re-fitted nominal simulator.
    pub(crate) fn refitted(&self) -> Option<f64> {
        self.gap.chi2_per_dof.nominal_refitted
    }

    /// True when the verdict is not that nothing is missing: `none` may be among the answers, but does not stand.
    pub(crate) fn notices(&self) -> bool {
        matches!(self.verdict.as_str(), "named" | "unknown" | "ambiguous")
    }

    /// True when the verdict claims that something is missing: a set that still holds `none` does not.
    pub(crate) fn alarms(&self) -> bool {
        match self.verdict.as_str() {
            "named" | "unknown" => true,
            "ambiguous" => !self.set.iter().any(|s| s == "none"),
            _ => false,
        }
    }
}
