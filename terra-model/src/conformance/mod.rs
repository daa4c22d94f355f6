//! Does a model, or an effect, keep the promises that every solver of terra relies on?
//!
//! A user's own work is checked from a user's own test:
//!
//! ```
//! use terra_model::conformance::{check_effect, check_model};
//! use terra_model::{effects::Grousers, models::WongReece};
//! check_model::<WongReece>()?;
//! check_effect::<Grousers>()?;
//! # Ok::<(), terra_model::conformance::Failures>(())
//! ```
//!
//! # What is checked
//! A model ([`check_model`]): it is described (names, units, ranges); it returns finite numbers or a typed error over
//! its declared domain; its derivatives are those of finite differences; it has no jumps in slip, load or parameters;
//! soil and load times one factor give forces times that factor; its stresses join at the apex, carry the load and give its pull and
//! torque; the load it cannot carry is a typed error with the largest it can; eight lanes give what eight calls give.
//!
//! An effect ([`check_effect`]): it is described; magnitude zero changes nothing, bit for bit; it acts where it says
//! and through the hooks it says; it stays finite, its derivatives are right, lanes agree; and every shipped model
//! either carries it, with all of this, or refuses it with a typed error ([`check_pair`]).

mod derivatives;
mod effect;
mod model;
mod numeric;
mod promises;
mod sample;

use std::fmt;

pub use effect::{check_effect, check_effect_dyn, check_pair};
pub use model::{check_model, check_model_dyn, check_model_with};

/// What a passed examination amounts to: a check that had nothing to compare would be no check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checked {
    /// Name of the model, the effect or the pair.
    pub subject: String,
    /// Single comparisons made.
    pub comparisons: usize,
    /// Derivatives among them.
    pub derivatives: usize,
}

/// What was found wrong, one line each, with the numbers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Failures {
    /// Name of the model, the effect or the pair.
    pub subject: String,
    /// The findings; at most three of a kind.
    pub findings: Vec<String>,
}

impl fmt::Display for Failures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} does not conform:", self.subject)?;
        self.findings
            .iter()
            .try_for_each(|finding| write!(f, "\n  {finding}"))
    }
}

/// The examination under way.
struct Record {
    subject: String,
    comparisons: usize,
    derivatives: usize,
    findings: Vec<(&'static str, String)>,
}

impl Record {
    fn new(subject: impl Into<String>) -> Self {
        Record {
            subject: subject.into(),
            comparisons: 0,
            derivatives: 0,
            findings: vec![],
        }
    }

    /// Counts one comparison and keeps what is wrong with it.
    fn expect(&mut self, ok: bool, kind: &'static str, finding: impl FnOnce() -> String) {
        self.comparisons += 1;
        if !ok && self.findings.iter().filter(|(k, _)| *k == kind).count() < 3 {
            self.findings.push((kind, finding()));
        }
    }

    fn finish(self) -> Result<Checked, Failures> {
        let Record {
            subject,
            comparisons,
            derivatives,
            findings,
        } = self;
        if findings.is_empty() {
            return Ok(Checked {
                subject,
                comparisons,
                derivatives,
            });
        }
        let findings = findings
            .into_iter()
            .map(|(kind, text)| format!("{kind}: {text}"))
            .collect();
        Err(Failures { subject, findings })
    }
}

/// Names, units and ranges of anything registered.
fn described(record: &mut Record, texts: [(&str, &str); 3], params: &[crate::Param]) {
    let [(_, name), ..] = texts;
    let kebab = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let snake = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    // Models put together from slots are named slot by slot.
    let named = name
        .split(':')
        .all(|slot| !slot.is_empty() && slot.chars().all(kebab));
    record.expect(named, "name", || format!("'{name}' is not kebab-case"));
    for (what, text) in texts {
        record.expect(!text.trim().is_empty(), "description", || {
            format!("no {what}")
        });
    }
    for (k, p) in params.iter().enumerate() {
        let twice = params.iter().take(k).any(|q| q.name == p.name);
        record.expect(!twice, "parameters", || {
            format!("'{}' appears twice", p.name)
        });
        let named = !p.name.is_empty() && p.name.chars().all(snake);
        record.expect(named, "parameters", || {
            format!("'{}' is not snake_case", p.name)
        });
        record.expect(
            !p.unit.is_empty() && !p.doc.is_empty() && !p.symbol.is_empty(),
            "parameters",
            || format!("{} lacks a unit, a symbol or a meaning", p.name),
        );
        record.expect(promises::is_si(p.unit), "parameters", || {
            format!(
                "{}: unit '{}' is not put together of SI symbols (m, s, kg, rad, N, Pa, ...; 1 for none)",
                p.name, p.unit
            )
        });
        record.expect(p.min < p.max, "parameters", || {
            format!("{}: range [{}, {}]", p.name, p.min, p.max)
        });
        record.expect(
            p.prior_sd.is_finite() && p.prior_sd > 0.0,
            "parameters",
            || format!("{}: prior sd {}", p.name, p.prior_sd),
        );
        let log_ok = p.scale == crate::Scale::Linear || (p.min >= 0.0 && p.max.is_finite());
        record.expect(log_ok, "parameters", || {
            format!("{} is fitted by its logarithm but may be negative", p.name)
        });
    }
}
