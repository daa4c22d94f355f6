//! What could cause the gap, what looks the same, and which experiment would tell.

use terra_gap::{Cause, Diagnosis};

use super::super::block::{Cell, Item, Section, Table};
use super::super::number::{UNKNOWN, number, percent, share, shortened, with_sd};
use super::super::words::{capital, join_some, unit, unit_after};
use super::verdict::answer;
use super::{effect, summary};

/// Rows of the table of causes.
const ROWS: usize = 12;
/// Look-alikes explained.
const LOOK_ALIKES: usize = 8;
/// Probability from which a cause outside the set is worth explaining.
const WORTH: f64 = 0.01;

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    if d.causes.is_empty() {
        return;
    }
    s.heading("Causes");
    let mut t = Table::new(
        "Known causes by probability. Gain: logarithm of the evidence over the simulator with re-fitted soil. Absorbed: share of the cause's trace that a re-fit of the soil would hide. Power: how much of its trace this log could show; below 4 a name is mostly luck.",
        &[
            "Cause",
            "#Probability",
            "#Gain, nats",
            "#Magnitude",
            "#Absorbed",
            "#Power",
            "Looks the same on this log",
        ],
    );
    for c in d.causes.iter().take(ROWS) {
        let alike = if c.indistinguishable_from.is_empty() {
            String::new()
        } else {
            join_some(&c.indistinguishable_from, 3)
        };
        let note = match (c.unseen_second, c.form.as_str()) {
            (true, _) => {
                "one alone does as well, and the second would hardly show in this log".to_owned()
            }
            (false, "default") => summary(d, c),
            _ => summary(d, c) + ", by another formula than the library's",
        };
        t.rows.push(vec![
            Cell::from(c.name.replace('+', " + ")).with_note(note),
            percent(c.probability).into(),
            gain(c.log_evidence_gain).into(),
            Cell::lines(magnitudes(c)),
            c.absorbed.map_or(String::new(), share).into(),
            c.power.map_or(String::new(), power).into(),
            alike.into(),
        ]);
    }
    s.table(t);
    let rest: Vec<&Cause> = d.causes.iter().skip(ROWS).collect();
    if !rest.is_empty() {
        let p: f64 = rest.iter().map(|c| c.probability).sum();
        s.text(format!(
            "{} more were weighed, with {} between them.",
            rest.len(),
            percent(p)
        ));
    }
}

/// Gains are known to a tenth of a nat at best.
fn gain(nats: f64) -> String {
    if nats.is_finite() {
        // Rounded first, so that no zero has a sign.
        let tenths = (nats * 10.0).round() / 10.0;
        if tenths == 0.0 {
            "0.0".to_owned()
        } else {
            format!("{tenths:+.1}").replace('-', "\u{2212}")
        }
    } else {
        UNKNOWN.to_owned()
    }
}

/// Below a tenth it makes no difference how small it is.
fn power(lambda: f64) -> String {
    if lambda < 0.1 {
        "<\u{a0}0.1".to_owned()
    } else {
        number(lambda, 2)
    }
}

/// Magnitudes of a cause's effects with sd and unit, then by name what else shapes them; empty for a structure.
pub(crate) fn magnitudes(cause: &Cause) -> Vec<String> {
    let h = &cause.weighed.hypothesis;
    let effects = h.effects();
    let params = effects
        .iter()
        .flat_map(|e| e.params().iter().map(move |p| (e.name(), p)));
    params
        .enumerate()
        .map(|(i, (effect, p))| {
            let k = h.soil_len() + i;
            let x = cause.weighed.fit.x.get(k).copied().unwrap_or(f64::NAN);
            let variance = cause.weighed.posterior.covariance.get((k, k));
            let sd = variance.map_or(f64::NAN, |v| v.max(0.0).sqrt());
            let value = unit_after(&with_sd(x * p.prior_sd, sd * p.prior_sd), &unit(p.unit));
            // Of several effects each number is told by its own: their order is not the name's.
            match p.name {
                "magnitude" if effects.len() > 1 => format!("{effect} {value}"),
                "magnitude" => value,
                other => format!("{} {value}", other.replace('_', " ")),
            }
        })
        .collect()
}

/// Candidates that matter and cannot be told from another, with what would isolate each.
pub(super) fn write_look_alikes(s: &mut Section, d: &Diagnosis) {
    let matters = |c: &&Cause| {
        let worth = c.probability > WORTH && !c.unseen_second;
        d.set.contains(&c.name) || d.nearest.contains(&c.name) || worth
    };
    let mut singles: Vec<String> = vec![];
    for c in d.causes.iter().filter(matters) {
        let mut names: Vec<String> = c
            .weighed
            .hypothesis
            .effects()
            .iter()
            .map(|e| e.name().to_owned())
            .collect();
        names.extend(c.indistinguishable_from.iter().cloned());
        for name in names {
            if !singles.contains(&name) {
                singles.push(name);
            }
        }
    }
    s.heading(match singles.len() {
        0 => return,
        1 => "How to confirm it",
        _ => "How to tell them apart",
    });
    let mut t = Table::new(
        "The test that isolates each candidate, whatever this log can show.",
        &["Candidate", "Test that isolates it", "Shows itself"],
    );
    for name in singles.iter().take(LOOK_ALIKES) {
        let Some(e) = effect(d, name) else {
            continue;
        };
        t.rows.push(vec![
            name.clone().into(),
            capital(e.isolated_by()).into(),
            e.regime().into(),
        ]);
    }
    s.table(t);
    if singles.len() > LOOK_ALIKES {
        s.text(format!(
            "{} less probable candidates are left out here.",
            singles.len() - LOOK_ALIKES
        ));
    }
}

pub(super) fn write_next(s: &mut Section, d: &Diagnosis) {
    if d.causes.is_empty() {
        return;
    }
    s.heading("Next experiments");
    if d.next.is_empty() {
        s.text("None is proposed: fewer than two explanations remain in question.");
        return;
    }
    let mut t = Table::new(
        "Experiments this set-up could do, by the information expected about which explanation is right; one nat is odds of 2.7 to 1.",
        &["Experiment", "#Expected, nats", "Tells apart"],
    );
    for e in &d.next {
        let separates = if e.separates.is_empty() {
            "no two of them clearly".to_owned()
        } else {
            {
                let names: Vec<String> = e.separates.iter().map(|n| answer(n)).collect();
                join_some(&names, 5)
            }
        };
        let nats = if e.expected_nats.is_finite() {
            format!("{:.1}", e.expected_nats)
        } else {
            UNKNOWN.to_owned()
        };
        t.rows.push(vec![
            capital(&e.manoeuvre).into(),
            nats.into(),
            separates.into(),
        ]);
    }
    s.table(t);
}

/// Effects that were not asked, grouped by reason.
pub(super) fn not_asked(d: &Diagnosis) -> Vec<Item> {
    let mut by_reason: Vec<(&str, Vec<&str>)> = vec![];
    for (name, reason) in &d.not_asked {
        match by_reason.iter_mut().find(|r| r.0 == reason) {
            Some(entry) if !entry.1.contains(&name.as_str()) => entry.1.push(name),
            Some(_) => {}
            None => by_reason.push((reason, vec![name])),
        }
    }
    by_reason
        .into_iter()
        .map(|(reason, names)| Item {
            name: format!("{}:", names.join(", ")),
            text: shortened(reason),
        })
        .collect()
}
