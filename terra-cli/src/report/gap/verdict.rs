//! The verdict in plain words, and the numbers behind it.

use terra_gap::{Cause, CauseKind, Diagnosis};

use super::super::block::Section;
use super::super::number::{count, number, percent, plain, share, shortened};
use super::super::words::{capital, factor, join, join_some, quantity};
use super::{accepted, effect, place, summary};

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    s.lead(sentence(d));
    for text in explanation(d) {
        s.text(text);
    }
    s.facts(facts(d));
}

/// The verdict in one sentence.
pub(super) fn sentence(d: &Diagnosis) -> String {
    match d.verdict {
        "none" => {
            let misfit = d.waterfall.refitted.map_or(String::new(), |v| {
                format!(" (misfit per value {}, pure noise gives 1)", number(v, 2))
            });
            format!(
                "Nothing is missing that this log could show: with its soil re-fitted, the simulator agrees with the measurements within their noise{misfit}."
            )
        }
        "named" => match d.causes.iter().find(|c| d.set.first() == Some(&c.name)) {
            Some(cause) => named(d, cause),
            None => format!("The gap has one known cause: {}.", join(&d.set, "and")),
        },
        "ambiguous" if d.set.iter().any(|n| n == "none") => format!(
            "This log leaves open whether anything is missing: 90\u{a0}% of the probability is shared by {}.",
            shared(d, "and")
        ),
        "ambiguous" => format!(
            "Something is missing, and this log cannot tell which of these it is: {}.",
            shared(d, "or")
        ),
        "unknown" => {
            "There is a gap, and no known effect explains it well enough to be named.".to_owned()
        }
        _ => format!(
            "This log cannot show whether anything is missing: {}.",
            shortened(
                d.reason
                    .as_deref()
                    .unwrap_or("it holds too little variety in slip and load")
            )
        ),
    }
}

fn named(d: &Diagnosis, cause: &Cause) -> String {
    match cause.kind {
        CauseKind::Effect => format!(
            "One known effect explains the gap: {} ({}).",
            cause.name,
            summary(d, cause)
        ),
        CauseKind::Structure => format!(
            "The terrain model explains the gap: {} fits this log, {} does not.",
            cause.weighed.hypothesis.law.model().name(),
            d.model
        ),
        CauseKind::Combination => {
            let parts: Vec<String> = cause
                .weighed
                .hypothesis
                .effects()
                .iter()
                .map(|e| format!("{} ({})", e.name(), e.summary()))
                .collect();
            format!(
                "Several known effects together explain the gap: {}.",
                join(&parts, "and")
            )
        }
    }
}

/// The 90 % set with probabilities, in words.
fn answers(d: &Diagnosis) -> Vec<String> {
    d.set
        .iter()
        .map(|name| format!("{} ({})", answer(name), percent(probability(d, name))))
        .collect()
}

/// Answers a sentence can carry; the rest of the set is counted there and listed below it.
const IN_A_SENTENCE: usize = 4;

fn shared(d: &Diagnosis, last: &str) -> String {
    let mut all = answers(d);
    let more = all.len().saturating_sub(IN_A_SENTENCE);
    if more > 1 {
        all.truncate(IN_A_SENTENCE);
        all.push(format!("{more} more"));
    }
    join(&all, last)
}

/// An answer's name in words.
pub(super) fn answer(name: &str) -> String {
    match (name, name.strip_prefix("structure:")) {
        ("none", _) => "nothing missing".to_owned(),
        ("unknown", _) => "something unknown".to_owned(),
        (_, Some(model)) => format!("the terrain model {model}"),
        _ => name.replace('+', " + "),
    }
}

fn probability(d: &Diagnosis, name: &str) -> f64 {
    match name {
        "none" => d.probability_none,
        "unknown" => d.probability_unknown,
        _ => d
            .causes
            .iter()
            .find(|c| c.name == name)
            .map_or(0.0, |c| c.probability),
    }
}

/// What a reader should take from the verdict, beyond the sentence.
fn explanation(d: &Diagnosis) -> Vec<String> {
    let mut out = vec![];
    if let Some(reason) = d
        .reason
        .as_deref()
        .filter(|_| d.verdict != "unidentifiable")
    {
        out.push(format!(
            "{}.",
            capital(shortened(reason).trim_end_matches('.'))
        ));
    }
    if let Some(cause) = accepted(d) {
        let role = match d.verdict {
            "unknown" => format!(
                "The figures below are drawn with {}, the one that comes closest ({}); that is an illustration, not a finding.",
                cause.name,
                summary(d, cause)
            ),
            "ambiguous" => format!(
                "The figures below are drawn with the most probable one, {} ({}).",
                cause.name,
                summary(d, cause)
            ),
            _ => String::new(),
        };
        if !role.is_empty() {
            out.push(role);
        }
        // An effect is weighed under every terrain model; its best fit need not be under the nominal one.
        let model = cause.weighed.hypothesis.law.model().name();
        if cause.kind != CauseKind::Structure && d.model.split('+').next() != Some(model) {
            out.push(format!(
                "It fits best on top of the terrain model {model}, not of {}; the curves and numbers with it are those of {model}.",
                d.model
            ));
        }
    }
    out
}

/// The numbers behind the verdict, one a line.
fn facts(d: &Diagnosis) -> Vec<(String, Vec<String>)> {
    let mut rows: Vec<(&str, Vec<String>)> = vec![];
    if !d.causes.is_empty() {
        let known: f64 = d.causes.iter().map(|c| c.probability).sum();
        rows.push((
            "Probability",
            vec![format!(
                "nothing missing {} · a known cause {} · something unknown {}",
                percent(d.probability_none),
                percent(known),
                percent(d.probability_unknown)
            )],
        ));
        rows.push(("90\u{a0}% set", vec![answers(d).join(", ")]));
    }
    if !d.heed.is_empty() {
        rows.push(("Before believing it", d.heed.clone()));
    }
    if !d.nearest.is_empty() {
        let nearest = d.nearest.iter().map(|name| match effect(d, name) {
            Some(e) => format!("{name}: {}", e.summary()),
            None => name.clone(),
        });
        rows.push(("Closest known causes", nearest.collect()));
    }
    if d.null.is_some() {
        rows.push(("Where it shows most", vec![place::strongest(d)]));
    }
    if let Some(cause) = d.causes.first().filter(|_| d.accepted_names.is_empty()) {
        let text = format!(
            "{} ({}): {}",
            cause.name,
            percent(cause.probability),
            summary(d, cause)
        );
        rows.push(("Most probable cause", vec![text]));
    }
    if d.held_out.is_some() {
        rows.push(("On held-out data", held_out(d)));
    }
    let open = not_separable(d);
    if !open.is_empty() {
        rows.push(("What stays open", open));
    }
    rows.into_iter().map(|(k, v)| (k.to_owned(), v)).collect()
}

fn held_out(d: &Diagnosis) -> Vec<String> {
    let Some(h) = &d.held_out else {
        return vec![];
    };
    let by = match h.by.name() {
        "slip" => "slip range",
        other => other,
    };
    let groups = count(h.groups, "group");
    let misfit = format!(
        "misfit per value {} before, {} after; {groups} by {by}",
        number(h.chi2_before, 3),
        number(h.chi2_after, 3)
    );
    let names = join(&d.accepted_names, "and");
    let mut out = match &h.closed {
        Some(c) if !c.tells() => vec![
            "no share can be given: held out, the re-fitted simulator is too near the noise to say how much of the gap closes".to_owned(),
        ],
        Some(c) => {
            let verb = if c.mean < 0.0 {
                format!("{names} widens the gap: closed share {}", share(c.mean))
            } else {
                format!("{names} closes {} of the explainable gap", share(c.mean))
            };
            vec![format!(
                "{verb} (95\u{a0}% interval {} to {})",
                share(c.lo),
                share(c.hi)
            )]
        }
        None => vec![format!("no share can be given: {}", h.why_open())],
    };
    out.push(misfit);
    let channels: Vec<String> = h
        .closed_by_channel
        .iter()
        .filter_map(|(name, closed)| {
            Some(format!(
                "{} {}",
                quantity(name, "").label,
                share((*closed)?)
            ))
        })
        .collect();
    if channels.len() > 1 && h.closed.is_some_and(|c| c.tells()) {
        out.push(format!("by channel: {}", channels.join(", ")));
    }
    if !h.failed.is_empty() {
        out.push(format!(
            "not predicted: {}",
            shortened(&join_some(&h.failed, 3))
        ));
    }
    out
}

fn not_separable(d: &Diagnosis) -> Vec<String> {
    let mut out = vec![];
    if let Some(cause) = accepted(d).or_else(|| d.causes.first())
        && !cause.indistinguishable_from.is_empty()
    {
        out.push(format!(
            "on this log {} leaves the same trace as {}",
            cause.name,
            join_some(&cause.indistinguishable_from, 4)
        ));
    }
    out.extend(
        d.undetermined
            .iter()
            .map(|u| format!("not determined: {u}")),
    );
    out
}

/// `slip 0.40 to 0.60`, `load 80 N`.
pub(super) fn range(name: &str, from: f64, to: f64) -> String {
    let (label, unit) = factor(name);
    let text = if (to - from).abs() <= 1e-9 * to.abs().max(from.abs()) {
        plain(from)
    } else {
        format!("{} to {}", plain(from), plain(to))
    };
    super::super::words::unit_after(&format!("{label} {text}"), unit)
}
