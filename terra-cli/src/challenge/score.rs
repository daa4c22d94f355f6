//! Marks verdicts against a key.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::answer::Verdict;
use super::baselines::baselines;
use super::closing::closing;
use super::design::Design;
use super::key::{CaseKey, KeyFile};
use super::library::Library;
use super::marks::Marked;
use super::metrics::{Closing, Metrics, metrics};
use super::shares::Kind;
use super::statistics::Metric;
use crate::error::CliError;
use crate::output::{short, table};

/// What is marked.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Simulate the cases again, to see how far the gap truly closed.
    pub closing: bool,
}

/// All figures of a challenge.
#[derive(Clone, Debug)]
pub struct Score {
    cases: usize,
    missing: usize,
    metrics: Metrics,
    baselines: Vec<(&'static str, Metrics)>,
    by_kind: Vec<(String, Breakdown)>,
    by_effect: Vec<(String, Breakdown)>,
    misses: Vec<Value>,
}

/// Figures of one kind or one effect.
#[derive(Clone, Debug)]
struct Breakdown {
    right: Metric,
    in_three: Metric,
    alarmed: Metric,
    covered: Metric,
    answered_instead: Vec<(String, usize)>,
}

/// Marks the verdicts of a folder; a missing one is wrong. `step` is told of each case.
///
/// # Errors
/// No folder, a file that is no verdict, a key that is none.
pub fn score(
    key: &KeyFile,
    verdicts: &Path,
    options: &Options,
    step: &(dyn Fn() + Sync),
) -> Result<Score, CliError> {
    if !verdicts.is_dir() {
        return Err(CliError::BadData {
            message: format!("{}: no folder of verdicts", verdicts.display()),
            help: None,
        });
    }
    let mut cases = vec![];
    let mut keys: Vec<CaseKey> = vec![];
    for case in &key.cases {
        let sealed = case.read()?;
        let kind = Kind::named(&sealed.kind).ok_or_else(|| CliError::BadData {
            message: format!("{}: unknown kind '{}'", case.case, sealed.kind),
            help: None,
        })?;
        cases.push(Marked {
            case: case.case.clone(),
            kind,
            truth: sealed.truth(),
            effects: sealed.effects.iter().map(|e| e.name.clone()).collect(),
            verdict: Verdict::open(verdicts, &case.case)?,
        });
        keys.push(sealed);
    }
    let closings = closings(key, &keys, &cases, options, step);
    let all = metrics(&cases, closings.as_deref().map_err(String::as_str));
    let by_kind = Kind::ALL
        .into_iter()
        .filter_map(|kind| {
            let of: Vec<&Marked> = cases.iter().filter(|c| c.kind == kind).collect();
            (!of.is_empty()).then(|| (kind.name().to_owned(), Breakdown::of(&of)))
        })
        .collect();
    let mut effects: BTreeMap<String, Vec<&Marked>> = BTreeMap::new();
    for c in &cases {
        if matches!(c.kind, Kind::Single | Kind::FormVariant | Kind::OffLibrary) {
            let name = c.effects.first().cloned().unwrap_or_default();
            effects.entry(name).or_default().push(c);
        }
    }
    Ok(Score {
        cases: cases.len(),
        missing: cases.iter().filter(|c| c.verdict.is_none()).count(),
        metrics: all,
        baselines: baselines(&cases),
        by_kind,
        by_effect: effects
            .into_iter()
            .map(|(name, of)| (name, Breakdown::of(&of)))
            .collect(),
        misses: cases
            .iter()
            .zip(&keys)
            .filter(|(c, _)| !c.right())
            .map(miss)
            .collect(),
    })
}

/// True closings, or why there are none.
fn closings(
    key: &KeyFile,
    keys: &[CaseKey],
    cases: &[Marked],
    options: &Options,
    step: &(dyn Fn() + Sync),
) -> Result<Vec<Closing>, String> {
    if !options.closing {
        return Err("not asked for".to_owned());
    }
    let sealed = key
        .design
        .as_ref()
        .ok_or("the key holds no design to simulate the cases again with")?;
    let design = Design::of(sealed).map_err(|e| format!("the design of the key: {e}"))?;
    let library = Library::builtin();
    let found: Vec<Result<Option<Closing>, CliError>> = keys
        .par_iter()
        .zip(cases)
        .map(|(key, case)| {
            let found = match &case.verdict {
                Some(verdict) => closing(key, verdict, &design, &library),
                None => Ok(None),
            };
            step();
            found
        })
        .collect();
    // One case that cannot be simulated again takes only itself out.
    let kept: Vec<Closing> = found
        .iter()
        .filter_map(|f| f.as_ref().ok().copied().flatten())
        .collect();
    match found.iter().find_map(|f| f.as_ref().err()) {
        Some(e) if kept.is_empty() => Err(format!("no case could be simulated again: {e}")),
        _ => Ok(kept),
    }
}

fn miss((case, key): (&Marked, &CaseKey)) -> Value {
    let answer = case.first();
    let at_truth = case.verdict.as_ref().and_then(|v| {
        let ranked = v.ranked();
        ranked
            .iter()
            .find(|(a, _)| *a == case.truth)
            .map(|(_, p)| *p)
    });
    json!({
        "case": case.case,
        "kind": case.kind.name(),
        "truth": case.truth,
        "effects": key.effects,
        "verdict": case.verdict.as_ref().map(|v| v.verdict.clone()),
        "answer": answer.map(|a| a.0),
        "probability": answer.map(|a| a.1),
        "probability_of_truth": at_truth,
        "set": case.verdict.as_ref().map(|v| v.set.clone()),
        "in_group": case.first_in_group(),
    })
}

impl Breakdown {
    fn of(cases: &[&Marked]) -> Self {
        let rate = |hit: fn(&Marked) -> bool| {
            let hits: Vec<bool> = cases.iter().map(|c| hit(c)).collect();
            Metric::rate(&hits, "cases")
        };
        let mut instead: BTreeMap<String, usize> = BTreeMap::new();
        for c in cases.iter().filter(|c| !c.right()) {
            let said = c.first().map_or("no verdict", |a| a.0);
            *instead.entry(said.to_owned()).or_default() += 1;
        }
        let mut answered_instead: Vec<(String, usize)> = instead.into_iter().collect();
        answered_instead.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        Breakdown {
            right: rate(Marked::right),
            in_three: rate(|c| c.in_first(3)),
            alarmed: rate(Marked::alarmed),
            covered: rate(Marked::covered),
            answered_instead,
        }
    }

    fn to_json(&self) -> Value {
        let instead: Map<String, Value> = self
            .answered_instead
            .iter()
            .map(|(name, n)| (name.clone(), json!(n)))
            .collect();
        json!({
            "right": self.right.to_json(),
            "top3": self.in_three.to_json(),
            "alarm": self.alarmed.to_json(),
            "set_coverage": self.covered.to_json(),
            "answered_instead": instead,
        })
    }

    fn row(&self, name: &str) -> Vec<String> {
        let cell = |m: &Metric| m.value.map_or("-".to_owned(), |v| format!("{v:.2}"));
        let instead: Vec<String> = self
            .answered_instead
            .iter()
            .take(3)
            .map(|(name, n)| format!("{name} {n}"))
            .collect();
        vec![
            name.to_owned(),
            self.right.n.to_string(),
            cell(&self.right),
            cell(&self.in_three),
            cell(&self.alarmed),
            cell(&self.covered),
            instead.join(", "),
        ]
    }
}

impl Score {
    /// Schema `terra-challenge-score/1`.
    pub fn to_json(&self) -> Value {
        let all = |m: &Metrics| -> Map<String, Value> {
            m.iter()
                .map(|(name, m)| ((*name).to_owned(), m.to_json()))
                .collect()
        };
        let naive: Map<String, Value> = self
            .baselines
            .iter()
            .map(|(name, m)| ((*name).to_owned(), Value::Object(all(m))))
            .collect();
        let parts = |rows: &[(String, Breakdown)]| -> Map<String, Value> {
            rows.iter()
                .map(|(name, b)| (name.clone(), b.to_json()))
                .collect()
        };
        json!({
            "schema": "terra-challenge-score/1",
            "cases": self.cases,
            "missing": self.missing,
            "metrics": all(&self.metrics),
            "baselines": naive,
            "by_kind": parts(&self.by_kind),
            "by_effect": parts(&self.by_effect),
            "misses": self.misses,
        })
    }

    /// A figure by name.
    pub fn metric(&self, name: &str) -> Option<&Metric> {
        self.metrics
            .iter()
            .find(|(n, _)| *n == name)
            .map(|(_, m)| m)
    }

    /// Tables for a person: figures beside the baselines, kinds, effects.
    pub fn summary(&self) -> String {
        let cell = |m: &Metric| match (m.value, m.lo, m.hi) {
            (Some(v), Some(lo), Some(hi)) => {
                format!("{} [{}, {}]", short2(v), short2(lo), short2(hi))
            }
            (Some(v), ..) => short2(v),
            _ => "-".to_owned(),
        };
        let mut head = vec!["figure", "n", "value [95 %]"];
        head.extend(self.baselines.iter().map(|(name, _)| *name));
        let rows: Vec<Vec<String>> = self
            .metrics
            .iter()
            .enumerate()
            .map(|(k, (name, m))| {
                let mut row = vec![(*name).to_owned(), m.n.to_string(), cell(m)];
                row.extend(self.baselines.iter().map(|(_, b)| {
                    b.get(k)
                        .and_then(|(_, m)| m.value)
                        .map_or("-".to_owned(), short2)
                }));
                row
            })
            .collect();
        let mut out = table(&head, &rows);
        for (what, parts) in [("kind", &self.by_kind), ("effect", &self.by_effect)] {
            let rows: Vec<Vec<String>> = parts.iter().map(|(name, b)| b.row(name)).collect();
            let head = [
                what,
                "n",
                "right",
                "top3",
                "alarm",
                "in set",
                "answered instead",
            ];
            out.push('\n');
            out.push_str(&table(&head, &rows));
        }
        if self.missing > 0 {
            out.push_str(&format!(
                "\n{} of {} cases have no verdict and count as wrong\n",
                self.missing, self.cases
            ));
        }
        for (name, m) in &self.metrics {
            if let Some(reason) = &m.reason {
                out.push_str(&format!("{name}: {reason}\n"));
            }
        }
        out
    }
}

fn short2(x: f64) -> String {
    if x.abs() < 10.0 {
        format!("{x:.2}")
    } else {
        short(x)
    }
}
