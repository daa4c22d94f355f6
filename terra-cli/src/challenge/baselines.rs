//! Naive answers, marked the same way: what a method must beat.

use std::collections::{BTreeMap, BTreeSet};

use super::answer::Verdict;
use super::marks::Marked;
use super::metrics::{Metrics, metrics};
use super::random::Draws;
use super::shares::Kind;

const SEED: u64 = 19_560_101;

/// Name and figures of each.
pub(crate) fn baselines(cases: &[Marked]) -> Vec<(&'static str, Metrics)> {
    let names: Vec<String> = {
        let said = cases
            .iter()
            .filter_map(|c| c.verdict.as_ref())
            .flat_map(|v| v.causes.iter().map(|c| c.effect.clone()));
        let true_ones = cases
            .iter()
            .filter(|c| c.kind != Kind::OffLibrary)
            .flat_map(|c| c.effects.iter().cloned());
        let all: BTreeSet<String> = said
            .chain(true_ones)
            .filter(|n| !n.contains('+') && !n.starts_with("structure:"))
            .collect();
        all.into_iter().collect()
    };
    let frequent = most_frequent(cases);
    let answer = |f: &dyn Fn(usize, &Marked) -> Option<Verdict>| -> Metrics {
        let answered: Vec<Marked> = cases
            .iter()
            .enumerate()
            .map(|(k, c)| Marked {
                verdict: f(k, c),
                ..c.clone()
            })
            .collect();
        metrics(&answered, Err("a baseline predicts no closing"))
    };
    vec![
        (
            "always-none",
            answer(&|_, _| Some(Verdict::of(vec![], 1.0, 0.0))),
        ),
        (
            "always-unknown",
            answer(&|_, _| Some(Verdict::of(vec![], 0.0, 1.0))),
        ),
        (
            "most-frequent-effect",
            answer(&|_, _| {
                let (name, share) = frequent.clone()?;
                Some(Verdict::of(vec![(name, share)], 0.0, 0.0))
            }),
        ),
        (
            "uniform-guess",
            answer(&|k, _| {
                let mut order = names.clone();
                Draws::new(SEED, k as u64).shuffle(&mut order);
                let p = 1.0 / order.len().max(1) as f64;
                Some(Verdict::of(
                    order.into_iter().map(|n| (n, p)).collect(),
                    0.0,
                    0.0,
                ))
            }),
        ),
        (
            "largest-evidence-gain",
            answer(&|_, c| c.verdict.as_ref().map(by_gain)),
        ),
        (
            "misfit-after-refit",
            answer(&|_, c| c.verdict.as_ref().map(by_misfit)),
        ),
    ]
}

/// The name that single cases hold most often, with its share of all cases; the first in the alphabet at ties.
fn most_frequent(cases: &[Marked]) -> Option<(String, f64)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for c in cases.iter().filter(|c| c.kind == Kind::Single) {
        *counts.entry(c.truth.as_str()).or_default() += 1;
    }
    let most = counts.values().copied().max()?;
    let (name, n) = counts.into_iter().find(|(_, n)| *n == most)?;
    Some((name.to_owned(), n as f64 / cases.len() as f64))
}

/// In-sample evidence as it stands: P ∝ exp(gain) and 1 for `none`, no threshold, no calibration, nothing unknown.
fn by_gain(v: &Verdict) -> Verdict {
    let gains: Vec<(&str, f64)> = v
        .causes
        .iter()
        .filter_map(|c| Some((c.effect.as_str(), c.log_evidence_gain?)))
        .collect();
    let top = gains.iter().map(|g| g.1).fold(0.0, f64::max);
    let total: f64 = (-top).exp() + gains.iter().map(|g| (g.1 - top).exp()).sum::<f64>();
    let causes = gains
        .iter()
        .map(|(name, g)| ((*name).to_owned(), (g - top).exp() / total))
        .collect();
    Verdict::of(causes, (-top).exp() / total, 0.0)
}

/// What the re-fit leaves above noise is "unknown", its excess against 1; no name is ever given.
fn by_misfit(v: &Verdict) -> Verdict {
    let excess = v.refitted().map_or(0.0, |c| (c - 1.0).max(0.0));
    let unknown = excess / (1.0 + excess);
    Verdict::of(vec![], 1.0 - unknown, unknown)
}
