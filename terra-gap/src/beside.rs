//! What may stand beside one cause unseen: a second one whose trace in this log is too small to ask for it.
//!
//! Drives show some effects poorly whatever else is there (a wheel that gives way, the friction of its rim), so that one cause
//! alone and the same with such a second one are explained alike. Which second ones they can be the tangent at the first
//! cause's fit says: a trace that would be seen and is not speaks against its effect.
//!
//! # Equation
//! P(b beside a) = ρ P(a) B_b / Σ_k B_k over all k that may stand beside a, B_b = Z(a + b) / Z(a); ρ by calibration.

use std::sync::Arc;

use crate::confirm::tangent_only;
use crate::evidence::log_sum_exp;
use crate::setup::Screened;
use crate::signatures::Asked;
use crate::weigh::{NEAR, Weighed};

/// Second causes that are listed beside one.
const LISTED: usize = 3;
/// Nats from the best single cause within which one may have a second beside it.
const WITHIN: f64 = 5.0;

/// Second causes beside one.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    /// The one.
    pub(crate) first: String,
    /// Its ln Z.
    pub(crate) log_evidence: f64,
    /// ln Σ B over all that may stand beside it.
    pub(crate) log_sum: f64,
    /// With those that were not fitted and that the tangent speaks least against.
    pub(crate) unseen: Vec<Weighed>,
}

impl Beside {
    /// Beside a cause that follows the data to the noise and is not far behind the `best`: those whose names are not among
    /// the `fitted`. `screen` and `asked` are of the second causes, at the first one's fit, in the `order` of their gain.
    pub(crate) fn of(
        first: &Weighed,
        best: f64,
        (screen, asked): (&[Screened], &Asked),
        order: &[usize],
        fitted: &[&str],
    ) -> Option<Self> {
        if first.chi2_per_value() >= NEAR || first.log_evidence < best - WITHIN {
            return None;
        }
        // Each name in the form that says most.
        let mut names: Vec<&str> = vec![];
        let mut each = order.to_vec();
        each.retain(|k| {
            let new = !names.contains(&screen[*k].name.as_str());
            names.push(&screen[*k].name);
            new
        });
        let gains = each.iter().map(|k| screen[*k].score.log_bayes_factor);
        let log_sum = log_sum_exp(gains);
        let rest = each
            .iter()
            .filter(|k| !fitted.contains(&screen[**k].name.as_str()));
        let unseen = rest.take(LISTED).filter_map(|k| {
            let h = first.hypothesis.with(Arc::clone(&asked[*k])).ok()?;
            Some(tangent_only(h, first, &screen[*k].score))
        });
        Some(Beside {
            first: first.hypothesis.effect_name(),
            log_evidence: first.log_evidence,
            log_sum,
            unseen: unseen.collect(),
        })
    }

    /// Share of the second causes' probability that this pair has.
    pub(crate) fn share(&self, pair: &Weighed) -> f64 {
        (pair.log_evidence - self.log_evidence - self.log_sum)
            .min(0.0)
            .exp()
    }
}
