//! One effect by a formula of its own: terms chosen by their screened gain, fitted, and chosen again where more are asked for.

use std::sync::Arc;

use nalgebra::DVector;
use terra_model::AnyEffect;

use crate::fit::{Fit, Known, evaluate_from};
use crate::hypothesis::Hypothesis;
use crate::memory::Memory;
use crate::screen::{Tangent, within_reach};
use crate::thin::Thin;
use crate::weigh::{Weighed, contest, weigh};

use super::Ground;
use super::free::FreeForm;
use super::term::{Regime, Term};

/// Screened gain beyond its price \[nats\] that a term must promise.
const TERM_FROM: f64 = 2.0;
/// Misfit per value from which few windows tell the terms.
const FROM_AFAR: f64 = 3.0;
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
    fn of(ground: &Ground<'_, '_>, found: &Weighed) -> Self {
        let enlarged = as_if_there(ground, &found.plain.x)
            .and_then(|x| there(ground, &found.hypothesis, &x, &found.plain));
        Origin {
            log_evidence: found.log_evidence,
            fit: enlarged.unwrap_or_else(|| found.plain.clone()),
        }
    }

    /// Of an effect at the end of a fit to other windows, or at that of the nominal law, as if it were there; none where there is
    /// no answer.
    pub(super) fn at(ground: &Ground<'_, '_>, at: &Weighed, h: &Hypothesis) -> Option<Self> {
        let mut x = at.plain.x.clone();
        x.extend((x.len()..h.len()).map(|_| 0.0));
        let fit = there(ground, h, &as_if_there(ground, &x).unwrap_or(x), &at.plain)?;
        Some(Origin {
            log_evidence: at.log_evidence,
            fit,
        })
    }
}

/// A fit vector with its one effect enlarged: terms that reshape it have no slope where its size is next to nothing, and the
/// tangent there promises what the one at the fit does. None where it is large enough, or not one.
fn as_if_there(ground: &Ground<'_, '_>, x: &DVector<f64>) -> Option<DVector<f64>> {
    let soil = ground.null.len();
    if x.len() != soil + 1 || x[soil].abs() >= SMALL {
        return None;
    }
    let mut x = x.clone();
    x[soil] = if x[soil] < 0.0 { -SMALL } else { SMALL };
    Some(x)
}

/// A fit moved to another place, with the law's slopes there; none where there is no answer.
fn there(ground: &Ground<'_, '_>, h: &Hypothesis, x: &DVector<f64>, fit: &Fit) -> Option<Fit> {
    let memory = Memory::after(&fit.near, ground.predictor.contacts());
    let there = evaluate_from(ground.data, ground.predictor, h, x.as_slice(), 0, &memory).ok()?;
    let residual = ground.whitener.apply_vector(&there.residual);
    let jacobian = ground.whitener.apply(&there.jacobian);
    let mut all = residual.iter().chain(jacobian.iter());
    all.all(|v| v.is_finite()).then(|| Fit {
        at_bound: vec![false; x.len()],
        x: x.clone(),
        residual,
        jacobian: jacobian.into(),
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
        let memory = Memory::after(&fit.near, predictor.contacts());
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
            fit.jacobian = score.beside(&fit.jacobian).into();
            fit.x = fit.x.push(0.0);
            self.chosen.push(left.swap_remove(k).0);
        }
        let known = fit.known(fit.jacobian.clone());
        (promised > 0.0).then_some((known, promised))
    }

    /// Fits it with up to so many terms, where these promise to reach `rival`, ln Z of another answer, from where it was weighed with
    /// those that it has. A way that was given up goes on without more terms too. Far from the data few windows tell the terms.
    pub(super) fn ask(
        &mut self,
        ground: &Ground<'_, '_>,
        found: &Weighed,
        most: usize,
        rival: f64,
    ) -> Option<Weighed> {
        let far = found.chi2_per_value() > FROM_AFAR;
        let few = far.then(|| ground.on_few()).flatten();
        let (from, on) = match few.as_ref() {
            Some(few) => (Origin::at(few, found, &found.hypothesis)?, few),
            None => (Origin::of(ground, found), ground),
        };
        let more = self.choose(on, &from.fit, most);
        let goes_on = || (from.fit.given_up && !self.chosen.is_empty()).then(|| from.fit.promise());
        let (known, promised) = match more {
            Some((known, promised)) => (known, promised),
            None => (from.fit.known(from.fit.jacobian.clone()), goes_on()?),
        };
        let share = on.data.len() as f64 / ground.data.len() as f64;
        if from.log_evidence + within_reach(promised / share) < rival {
            return None;
        }
        self.fitted(ground, &from, few.is_none().then_some(known))
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

    /// Where a way on few windows ends, from what is known there.
    pub(super) fn roughly(
        &self,
        ground: &Ground<'_, '_>,
        few: &Thin,
        from: &Origin,
        known: Known,
    ) -> Option<Origin> {
        let h = self.hypothesis(ground.null, &[])?;
        let starts = [self.start(from, &h)];
        let fit = few.end(ground.predictor, &h, &starts, Some(known)).ok()?;
        Some(Origin { fit, ..*from })
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
