//! The right physics by another formula: the single causes of a drive once more, with their formula left free where the data
//! ask for it.
//!
//! No library holds nature's formula. An effect whose curve is not quite the library's leaves a remainder that a second
//! effect, or something unknown, would be blamed for. So where one of these gains more than every single cause, all of them
//! are asked again with smooth terms that can only reshape what the effect does ([`free::FreeForm`]). Terms are chosen one by
//! one by their screened gain, and a set of them is paid for as one choice among all such sets.

mod free;
mod term;

pub(crate) use free::FREE;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::AnyEffect;
use terra_model::order::{ascending, descending};

use crate::dataset::DataSet;
use crate::fit::{Fit, evaluate_from};
use crate::hypothesis::Hypothesis;
use crate::memory::Memory;
use crate::noise::Whitener;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::screen::{Tangent, within_reach};
use crate::setup::{Screened, Setup};
use crate::weigh::{Amplitudes, Weighed, contest, weigh};

use free::FreeForm;
use term::{Regime, Term};

/// Manoeuvres from which a formula can be asked about: on a single ramp slip, speed and path are one variable, and a free
/// formula would imitate what is in no library.
pub(crate) const MANOEUVRES: usize = 3;
/// Terms that a formula may differ by, in as many rounds.
const TERMS: [usize; 2] = [4, 6];
/// Screened gain beyond its price \[nats\] that a term must promise.
const TERM_FROM: f64 = 2.0;
/// Gain \[nats\] of the best single cause from which its formula can be asked about at all.
pub(crate) const EFFECT: f64 = 6.0;
/// Nats that it must be behind another answer.
const BEHIND: f64 = 2.0;
/// Misfit per value from which a second round of terms is asked for.
const FAR: f64 = 1.1;

/// The regime of a drive.
fn regime(data: &DataSet, setup: &Setup<'_>) -> Regime {
    let most = |name: &str| {
        let all = data.observations.iter().filter_map(|o| o.factors.get(name));
        all.fold(1e-3, |most: f64, v| most.max(v.abs()))
    };
    let mut paths: Vec<f64> = data
        .observations
        .iter()
        .filter_map(|o| o.factors.get("path").copied())
        .collect();
    ascending(&mut paths, |p| *p);
    let torque = data
        .observations
        .iter()
        .flat_map(|o| o.channels.iter().zip(&o.values))
        .filter(|(c, _)| data.channels[**c].name.starts_with("wheel_torque"))
        .fold(1e-3, |most: f64, (_, v)| most.max(v.abs()));
    let speed = most("speed");
    Regime {
        load: most("load") / 4.0,
        speed,
        path: paths.get(paths.len() / 2).map_or(1.0, |p| p.max(0.1)),
        torque,
        wheel_speed: speed / setup.rover.wheel.radius,
    }
}

/// The log and what is common to all fits to it.
pub(crate) struct Ground<'a, 'b> {
    pub data: &'a DataSet,
    pub predictor: &'a dyn Predictor,
    pub setup: &'a Setup<'b>,
    pub null: &'a Hypothesis,
    pub levels: &'a Amplitudes,
    pub whitener: &'a Whitener,
}

/// One effect with the terms chosen so far.
struct Reshaped {
    effect: Arc<dyn AnyEffect>,
    regime: Regime,
    chosen: Vec<Term>,
}

impl Reshaped {
    fn hypothesis(&self, null: &Hypothesis, more: &[Term]) -> Option<Hypothesis> {
        let mut terms = self.chosen.clone();
        terms.extend(more);
        let free = FreeForm::new(Arc::clone(&self.effect), self.regime, terms);
        null.with(Arc::new(free)).ok()
    }

    /// Chooses more terms at a fit, one by one by their screened gain: the Jacobian with them, and what they promise.
    fn choose(
        &mut self,
        ground: &Ground<'_, '_>,
        fit: &Fit,
        most: usize,
    ) -> Option<(DMatrix<f64>, f64)> {
        let all = Term::of(&*self.effect, ground.null.law.model().hooks());
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
        (promised > 0.0).then_some((fit.jacobian, promised))
    }
}

/// ln of the number of ways to choose `k` terms `of` many: every set of them was as probable as any other before.
fn choices(of: usize, k: usize) -> f64 {
    (0..k)
        .map(|i| ((of - i) as f64 / (i + 1) as f64).ln())
        .sum()
}

/// An effect by another formula, where the data ask for one that could stand against `rival`, ln Z of another answer.
fn reshape(
    ground: &Ground<'_, '_>,
    regime: Regime,
    plain: &Weighed,
    rival: f64,
) -> Option<Weighed> {
    let effect = Arc::clone(plain.hypothesis.effects().first()?);
    let of = Term::of(&*effect, ground.null.law.model().hooks()).len();
    let mut shape = Reshaped {
        effect,
        regime,
        chosen: vec![],
    };
    let mut found: Option<Weighed> = None;
    for most in TERMS {
        let from = found.as_ref().unwrap_or(plain);
        if found.is_some() && from.chi2_per_value() < FAR {
            break;
        }
        let Some((guess, promised)) = shape.choose(ground, &from.plain, most) else {
            break;
        };
        if from.log_evidence + within_reach(promised) < rival {
            break;
        }
        let h = shape.hypothesis(ground.null, &[])?;
        let mut start = from.plain.x.as_slice().to_vec();
        start.resize(h.len(), 0.0);
        let mut next = weigh(
            ground.data,
            ground.predictor,
            &h,
            ground.levels,
            &[start],
            Some(guess),
            contest(ground.setup.kind),
        )
        .ok()?;
        let paid = choices(of, shape.chosen.len());
        next.log_evidence -= paid;
        next.plain_log_evidence -= paid;
        let worse = next.log_evidence <= from.log_evidence;
        if found
            .as_ref()
            .is_none_or(|f| next.log_evidence > f.log_evidence)
        {
            found = Some(next);
        }
        if worse {
            break;
        }
    }
    found
}

/// The parts of a pair that are too weak to have been confirmed alone: another formula may do what the other part does.
fn parts_alone(
    ground: &Ground<'_, '_>,
    screen: &[Screened],
    singles: &[(usize, Vec<Weighed>)],
    pair: &Weighed,
) -> Vec<(usize, Vec<Weighed>)> {
    let soil = ground.null.len();
    let mut next = soil;
    let alone = |effect: &Arc<dyn AnyEffect>| {
        let place = next;
        next += effect.params().len();
        let confirmed = singles
            .iter()
            .any(|(k, w)| !w.is_empty() && screen[*k].name == effect.name());
        if confirmed || effect.params().len() != 1 {
            return None;
        }
        let row = screen.iter().position(|s| s.name == effect.name())?;
        let h = ground.null.with(Arc::clone(effect)).ok()?;
        let mut start = pair
            .plain
            .x
            .rows(0, soil)
            .iter()
            .copied()
            .collect::<Vec<_>>();
        start.push(*pair.plain.x.get(place)?);
        let contest = contest(ground.setup.kind);
        let (data, predictor, levels) = (ground.data, ground.predictor, ground.levels);
        let w = weigh(data, predictor, &h, levels, &[start], None, contest).ok()?;
        Some((row, vec![w]))
    };
    pair.hypothesis.effects().iter().filter_map(alone).collect()
}

/// Asks every confirmed single cause and the parts of the best pair again with a free formula, where `rival`, ln Z of a pair or
/// of something unknown, stands above every single cause and one of these is far above `null`, and puts what is found beside
/// their other forms. By the library's own formula the right one may be far behind: it is the terms' promise that tells.
pub(crate) fn ask_again(
    ground: &Ground<'_, '_>,
    screen: &[Screened],
    singles: &mut Vec<(usize, Vec<Weighed>)>,
    pairs: &[Weighed],
    null: f64,
    rival: f64,
) {
    if ground.data.groups().len() < MANOEUVRES {
        return;
    }
    let by_evidence = |a: &Weighed, b: &Weighed| a.log_evidence.total_cmp(&b.log_evidence);
    let all = singles.iter().flat_map(|(_, w)| w);
    let best = all
        .map(|w| w.log_evidence)
        .fold(f64::NEG_INFINITY, f64::max);
    if best < null + EFFECT || best + BEHIND > rival {
        return;
    }
    if let Some(pair) = pairs.iter().max_by(|a, b| by_evidence(a, b)) {
        let parts = parts_alone(ground, screen, singles, pair);
        singles.extend(parts);
    }
    let regime = regime(ground.data, ground.setup);
    let mut order: Vec<usize> = (0..singles.len())
        .filter(|i| !singles[*i].1.is_empty())
        .collect();
    descending(&mut order, |&i| singles[i].1[0].log_evidence);
    let name = |i: usize| screen[singles[i].0].name.as_str();
    let mut names: Vec<&str> = vec![];
    order.retain(|i| {
        let new = !names.contains(&name(*i));
        names.push(name(*i));
        new
    });
    let found: Vec<(usize, Weighed)> = for_each(order.len(), |rank| {
        let i = order[rank];
        let w = reshape(ground, regime, &singles[i].1[0], rival)?;
        Some((i, w))
    })
    .into_iter()
    .flatten()
    .collect();
    for (i, w) in found {
        singles[i].1.push(w);
    }
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
