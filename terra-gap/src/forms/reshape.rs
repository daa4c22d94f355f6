//! One effect by a formula of its own: terms chosen by their screened gain, fitted, and chosen again where more are asked for.

use std::sync::Arc;

use nalgebra::DVector;
use terra_model::AnyEffect;

use crate::fit::{Fit, Known, evaluate_from};
use crate::hypothesis::Hypothesis;
use crate::memory::Memory;
use crate::screen::{Tangent, within_reach};
use crate::weigh::{Weighed, contest, weigh, weigh_roughly};

use super::Ground;
use super::free::FreeForm;
use super::term::{Regime, Term};

/// Screened gain beyond its price \[nats\] that a term must promise.
const TERM_FROM: f64 = 2.0;
/// Size of an effect \[prior sd\] at which its terms are chosen, where the fit has less of it.
const SMALL: f64 = 0.5;

/// One effect with the terms chosen so far.
#[derive(Clone)]
pub(super) struct Reshaped {
    effect: Arc<dyn AnyEffect>,
    regime: Regime,
    chosen: Vec<Term>,
}

/// Where a formula is asked from: ln Z there, and the fit.
pub(super) struct Origin {
    pub log_evidence: f64,
    pub fit: Fit,
}

impl Origin {
    /// Of an effect that was weighed, as if it were there.
    pub(super) fn plain(ground: &Ground<'_, '_>, plain: &Weighed) -> Self {
        let fit = enlarged(ground, &plain.hypothesis, &plain.plain);
        Origin {
            log_evidence: plain.log_evidence,
            fit: fit.unwrap_or_else(|| plain.plain.clone()),
        }
    }

    /// Of an effect by another formula.
    pub(super) fn end(found: &Weighed) -> Self {
        Origin {
            log_evidence: found.log_evidence,
            fit: found.plain.clone(),
        }
    }

    /// Of an effect that was not weighed, at the nominal law's fit as if it were there; none where there is no answer.
    pub(super) fn nothing(
        ground: &Ground<'_, '_>,
        nominal: &Weighed,
        h: &Hypothesis,
    ) -> Option<Self> {
        let fit = Fit {
            x: nominal.plain.x.clone().push(0.0),
            ..nominal.plain.clone()
        };
        Some(Origin {
            log_evidence: nominal.log_evidence,
            fit: enlarged(ground, h, &fit)?,
        })
    }
}

/// A fit of one effect moved to where the effect is there: terms that reshape it have no slope where its size is next to
/// nothing. The tangent there promises what the one at the fit does. None where it is large enough, or has no answer there.
fn enlarged(ground: &Ground<'_, '_>, h: &Hypothesis, fit: &Fit) -> Option<Fit> {
    let soil = ground.null.len();
    if fit.x.len() != soil + 1 || fit.x[soil].abs() >= SMALL {
        return None;
    }
    let mut x = fit.x.clone();
    x[soil] = if x[soil] < 0.0 { -SMALL } else { SMALL };
    let memory = Memory::of(ground.predictor.contacts());
    let there = evaluate_from(ground.data, ground.predictor, h, x.as_slice(), 0, &memory).ok()?;
    let residual = ground.whitener.apply_vector(&there.residual);
    let jacobian = ground.whitener.apply(&there.jacobian);
    let mut all = residual.iter().chain(jacobian.iter());
    all.all(|v| v.is_finite()).then(|| Fit {
        at_bound: vec![false; x.len()],
        x,
        residual,
        jacobian,
        exact: true,
        ..fit.clone()
    })
}

impl Reshaped {
    /// An effect by the library's own formula.
    pub(super) fn new(effect: Arc<dyn AnyEffect>, regime: Regime) -> Self {
        Reshaped {
            effect,
            regime,
            chosen: vec![],
        }
    }

    /// All the ways in which its formula may differ.
    fn ways(&self, ground: &Ground<'_, '_>) -> Vec<Term> {
        Term::of(&*self.effect, ground.null.law.model().hooks())
    }

    fn hypothesis(&self, null: &Hypothesis, more: &[Term]) -> Option<Hypothesis> {
        let mut terms = self.chosen.clone();
        terms.extend(more);
        let free = FreeForm::new(Arc::clone(&self.effect), self.regime, terms);
        null.with(Arc::new(free)).ok()
    }

    /// Chooses more terms at a fit, one by one by their screened gain: the Jacobian with them, and what they promise.
    pub(super) fn choose(
        &mut self,
        ground: &Ground<'_, '_>,
        fit: &Fit,
        most: usize,
    ) -> Option<(Known, f64)> {
        let all = self.ways(ground);
        let price = (all.len() as f64).ln();
        let others: Vec<Term> = all
            .into_iter()
            .filter(|t| !self.chosen.contains(t))
            .collect();
        let h = self.hypothesis(ground.null, &others)?;
        let mut at = fit.x.as_slice().to_vec();
        at.resize(h.len(), 0.0);
        let (data, predictor) = (ground.data, ground.predictor);
        let memory = Memory::of(predictor.contacts());
        let columns = evaluate_from(data, predictor, &h, &at, fit.x.len(), &memory).ok()?;
        let columns = ground.whitener.apply(&columns.jacobian);
        let mut left: Vec<(Term, DVector<f64>)> = others
            .into_iter()
            .zip(columns.column_iter().map(|c| c.into_owned()))
            .filter(|(_, c)| c.iter().all(|v| v.is_finite()) && c.norm_squared() > 1e-8)
            .collect();
        let mut fit = fit.clone();
        let mut promised = 0.0;
        while self.chosen.len() < most {
            let tangent = Tangent::of(&fit);
            let scores = left.iter().map(|(_, c)| tangent.score(c.clone(), false));
            let best = scores
                .enumerate()
                .max_by(|a, b| a.1.log_bayes_factor.total_cmp(&b.1.log_bayes_factor));
            let Some((k, score)) = best.filter(|b| b.1.log_bayes_factor > price + TERM_FROM) else {
                break;
            };
            promised += score.log_bayes_factor - price;
            fit.jacobian = score.beside(&fit.jacobian);
            fit.x = fit.x.push(0.0);
            self.chosen.push(left.swap_remove(k).0);
        }
        let known = fit.known(fit.jacobian.clone());
        (promised > 0.0).then_some((known, promised))
    }

    /// Fits it with up to so many terms, where these promise to reach `rival`, ln Z of another answer. A way that was given up
    /// goes on without more terms too.
    pub(super) fn ask(
        &mut self,
        ground: &Ground<'_, '_>,
        from: &Origin,
        most: usize,
        rival: f64,
    ) -> Option<Weighed> {
        let more = self.choose(ground, &from.fit, most);
        let goes_on = || (from.fit.given_up && !self.chosen.is_empty()).then(|| from.fit.promise());
        let (known, promised) = match more {
            Some((known, promised)) => (known, promised),
            None => (from.fit.known(from.fit.jacobian.clone()), goes_on()?),
        };
        if from.log_evidence + within_reach(promised) < rival {
            return None;
        }
        self.fitted(ground, from, Some(known))
    }

    /// Weighs it with the terms that are chosen, from a fit with as many or fewer.
    pub(super) fn fitted(
        &self,
        ground: &Ground<'_, '_>,
        from: &Origin,
        known: Option<Known>,
    ) -> Option<Weighed> {
        let h = self.hypothesis(ground.null, &[])?;
        let start = self.start(from, &h);
        let (data, predictor, levels) = (ground.data, ground.predictor, ground.levels);
        let contest = contest(ground.setup.kind);
        let found = weigh(data, predictor, &h, levels, &[start], known, contest);
        Some(self.paid(ground, found.ok()?))
    }

    /// Where a way on few windows ends: the cost there, and what is weighed there.
    pub(super) fn roughly(
        &self,
        ground: &Ground<'_, '_>,
        from: &Origin,
        known: &Known,
    ) -> Option<(f64, Weighed)> {
        let h = self.hypothesis(ground.null, &[])?;
        let start = self.start(from, &h);
        let (data, predictor, levels) = (ground.data, ground.predictor, ground.levels);
        let (cost, end) = weigh_roughly(data, predictor, &h, levels, &start, Some(known))?;
        Some((cost, self.paid(ground, end?)))
    }

    fn start(&self, from: &Origin, h: &Hypothesis) -> Vec<f64> {
        let mut start = from.fit.x.as_slice().to_vec();
        start.resize(h.len(), 0.0);
        start
    }

    /// A set of terms is one choice among all such sets.
    fn paid(&self, ground: &Ground<'_, '_>, found: Weighed) -> Weighed {
        let price = choices(self.ways(ground).len(), self.chosen.len());
        Weighed {
            log_evidence: found.log_evidence - price,
            plain_log_evidence: found.plain_log_evidence - price,
            ..found
        }
    }
}

/// ln of the number of ways to choose `k` terms `of` many: every set of them was as probable as any other before.
fn choices(of: usize, k: usize) -> f64 {
    (0..k)
        .map(|i| ((of - i) as f64 / (i + 1) as f64).ln())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten pairs of five; the order in which they were chosen is none of the prior's business.
    #[test]
    fn a_set_of_terms_is_one_choice() {
        assert!((choices(5, 2) - 10.0_f64.ln()).abs() < 1e-12);
        assert!((choices(20, 3) - 1140.0_f64.ln()).abs() < 1e-12);
        assert_eq!(choices(7, 0), 0.0);
    }
}
