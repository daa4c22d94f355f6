//! Joint fits of single effects.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use crate::dataset::{DataSet, Predictor};
use crate::evidence::posterior;
use crate::hypothesis::Hypothesis;
use crate::renewal::Before;
use crate::scout::scout;
use crate::screen::{Score, within_reach};
use crate::settings::LogKind;
use crate::setup::{Screened, Setup};
use crate::signatures::Asked;
use crate::starts::{better_of, far_start, start_anew, weigh_elsewhere};
use crate::weigh::{Amplitudes, NEAR, Weighed, again, contest, weigh, weigh_at};

/// Nats from the best within which a screened effect is confirmed.
const CONFIRM_WITHIN: f64 = 10.0;
/// Effects confirmed at least.
const CONFIRM_AT_LEAST: usize = 5;
/// Screened gain up to which an effect of a drive, beyond those, is weighed by its screen alone: where the data do not ask
/// for it, its magnitude is small against its own noise and the tangent is as good as the law.
const LINEAR_UP_TO: f64 = 0.0;
/// Effects that are confirmed before the others where the nominal law is near the data.
const FIRST: usize = 3;
/// Nats behind these from which another is not fitted any more.
const LOST: f64 = 15.0;
/// Effects of a drive that are confirmed where the nominal law is far from the data: so many that come near from elsewhere,
/// and so many by the tangent.
const SCOUTED: usize = 5;
const BY_SCREEN: usize = 2;
/// Other structures, the best by themselves, under which effects are weighed too.
const STRUCTURES: usize = 2;
/// Nats by which such a structure may fall short of the nominal one.
const STRUCTURE_WITHIN: f64 = 5.0;
/// Effects confirmed at least, once the noise is renewed, where the best gains more than this: the tangent then ranks poorly.
const CONFIRM_AT_LEAST_LARGE: (usize, f64) = (9, 50.0);

/// Confirms singles by joint fits, under the nominal structure and (on a rig) under the best other ones.
pub(crate) fn confirm_singles<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    setup: &Setup<'_>,
    null: &Hypothesis,
    null_weighed: &Weighed,
    structures: &[(String, Weighed)],
    levels: &Amplitudes,
    screen: &[Screened],
    asked: &Asked,
    previous: Option<Before<'_>>,
    anew: &mut Vec<String>,
) -> Vec<(usize, Vec<Weighed>)> {
    let mut order: Vec<usize> = (0..asked.len()).collect();
    order.sort_by(|&a, &b| {
        screen[b]
            .score
            .log_bayes_factor
            .total_cmp(&screen[a].score.log_bayes_factor)
    });
    let best = order
        .first()
        .map_or(0.0, |&k| screen[k].score.log_bayes_factor);
    let at_least = if previous.is_some() && best > CONFIRM_AT_LEAST_LARGE.1 {
        CONFIRM_AT_LEAST_LARGE.0
    } else {
        CONFIRM_AT_LEAST
    };
    let is_near = setup.kind != LogKind::Drive || null_weighed.chi2_per_value() < NEAR;
    // Far from the data the tangent says little: who comes near from elsewhere is confirmed, and stays in the contest.
    let scouted = match &levels.scout {
        Some(windows) if !is_near && previous.is_none() => {
            scout(predictor, null, windows, asked, SCOUTED)
        }
        _ => vec![],
    };
    let known = |k: usize| previous.is_some_and(|p| p.single(&*asked[k]).is_some());
    let confirmed: Vec<usize> = if !scouted.is_empty() {
        let by_screen = order.iter().take(BY_SCREEN).copied();
        let by_screen = by_screen.filter(|k| scouted.iter().all(|(s, _)| s != k));
        scouted.iter().map(|(k, _)| *k).chain(by_screen).collect()
    } else if previous.is_some() && !is_near {
        // Who else could, the tangent says as badly as ever, but as long as nobody explains the data it is asked.
        let explained = previous.is_some_and(|p| p.0.all().any(|w| w.chi2_per_value() < NEAR));
        let more = if explained { 0 } else { at_least };
        let ranked = order.into_iter().enumerate();
        let confirmed = ranked.filter(|&(rank, k)| known(k) || rank < more);
        confirmed.map(|(_, k)| k).collect()
    } else {
        // Contrasts on rigs are large and the linear screen may only order work there, never exclude.
        let confirm = |&(rank, k): &(usize, usize)| {
            setup.kind == LogKind::Rig
                || rank < at_least
                || known(k)
                || screen[k].score.log_bayes_factor > best - CONFIRM_WITHIN
        };
        let ranked = order.into_iter().enumerate().filter(confirm);
        ranked.map(|(_, k)| k).collect()
    };
    // An effect on top of a structure that is far from the data would only be fitted to the structure's error.
    let near = null_weighed.log_evidence - STRUCTURE_WITHIN;
    let mut others: Vec<&Weighed> = structures
        .iter()
        // The nominal law on other soil is no other law.
        .filter(|(_, w)| w.hypothesis.law.model().name() != null.law.model().name())
        .map(|(_, w)| w)
        .filter(|w| w.log_evidence > near)
        .collect();
    others.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    others.truncate(STRUCTURES);
    let effort = contest(setup.kind);
    // Near the data the first ones tell which others cannot win any more.
    let (first, others_in_turn) = confirmed.split_at(if is_near && setup.kind == LogKind::Drive {
        FIRST.min(confirmed.len())
    } else {
        confirmed.len()
    });
    let confirm = |rank: usize, k: usize, lost: &dyn Fn(f64) -> bool| {
        let effect = &asked[k];
        let promised = screen[k].score.log_bayes_factor;
        // What a fit under another noise found is the best start.
        let before = previous.and_then(|p| Some((p, p.single(&**effect)?)));
        if setup.kind == LogKind::Drive
            && before.is_none()
            && (rank >= at_least && promised <= LINEAR_UP_TO || lost(promised))
        {
            let h = null.with(Arc::clone(effect)).ok()?;
            return Some((k, vec![tangent_only(h, null_weighed, &screen[k].score)]));
        }
        if let Some((p, found)) = before
            && p.out(found)
        {
            let h = &found.hypothesis;
            let again = weigh_at(data, predictor, h, levels, &found.plain).ok()?;
            return Some((k, vec![again]));
        }
        let found_by_scout = scouted.iter().find(|(s, _)| *s == k).map(|(_, x)| x);
        let mut bases = vec![(null.clone(), null_weighed.fit.x.as_slice().to_vec())];
        if setup.kind == LogKind::Rig {
            bases.extend(
                others
                    .iter()
                    .map(|w| (w.hypothesis.clone(), w.fit.x.as_slice().to_vec())),
            );
        }
        let weighed: Vec<Weighed> = bases
            .into_iter()
            .enumerate()
            .filter_map(|(rank, (base, x))| {
                let h = base.with(Arc::clone(effect)).ok()?;
                let mut near = x.clone();
                near.resize(h.len(), screen[k].score.magnitude.clamp(-3.0, 3.0));
                let mut off = x;
                off.resize(h.len(), 0.0);
                let mut other = vec![0.0; base.len()];
                other.resize(h.len(), 1.0);
                let starts = match setup.kind {
                    // Another structure was fitted with its own soil already.
                    LogKind::Rig if rank > 0 => vec![near, off],
                    LogKind::Rig => vec![near, off, other],
                    LogKind::Kinematic => vec![near],
                    LogKind::Drive => {
                        // Far from the tangent's own ground a whole step of it lands anywhere: the descent takes as
                        // much of it as helps.
                        vec![match (before, found_by_scout) {
                            (Some((_, before)), _) => before.plain.x.as_slice().to_vec(),
                            (None, Some(found)) => found.clone(),
                            (None, None) => off,
                        }]
                    }
                };
                let tangent = before.is_none() && found_by_scout.is_none();
                let guess = (setup.kind == LogKind::Drive && tangent)
                    .then(|| screen[k].score.beside(&null_weighed.plain.jacobian));
                let effort = if before.is_some() {
                    again(setup.kind)
                } else {
                    effort
                };
                let found = weigh(data, predictor, &h, levels, &starts, guess, effort).ok()?;
                let far = far_start(&**effect, &found, setup.kind);
                let far = far.filter(|_| found_by_scout.is_none());
                Some(better_of(found, far, |start, found| {
                    weigh_elsewhere(data, predictor, levels, found, &start)
                }))
            })
            .collect();
        (!weighed.is_empty()).then_some((k, weighed))
    };
    let first: Vec<(usize, Vec<Weighed>)> = first
        .par_iter()
        .enumerate()
        .filter_map(|(rank, &k)| confirm(rank, k, &|_| false))
        .collect();
    let best = first
        .iter()
        .flat_map(|(_, w)| w)
        .map(|w| w.log_evidence - null_weighed.log_evidence)
        .fold(f64::NEG_INFINITY, f64::max);
    let lost = |promised: f64| within_reach(promised) + LOST < best;
    let others_in_turn: Vec<(usize, Vec<Weighed>)> = others_in_turn
        .par_iter()
        .enumerate()
        .filter_map(|(rank, &k)| confirm(rank + FIRST, k, &lost))
        .collect();
    let mut singles = first;
    singles.extend(others_in_turn);
    if setup.kind == LogKind::Drive {
        let mut all: Vec<&mut Weighed> = singles.iter_mut().flat_map(|(_, w)| w).collect();
        start_anew(data, predictor, levels, null.len(), &mut all, anew);
    }
    singles
}

/// The rival as the screen has it: the law replaced by its tangent at the nominal fit.
fn tangent_only(hypothesis: Hypothesis, null: &Weighed, score: &Score) -> Weighed {
    let mut fit = null.plain.clone();
    fit.x = fit.x.push(0.0);
    fit.jacobian = score.beside(&null.plain.jacobian);
    fit.at_bound.push(false);
    let posterior = posterior(&hypothesis, &fit);
    let (low, high) = hypothesis.bounds();
    let to = DVector::from_fn(fit.x.len(), |k, _| posterior.mean[k].clamp(low[k], high[k]));
    fit.residual -= &fit.jacobian * (&to - &fit.x);
    fit.x = to;
    fit.cost = fit.chi2() + fit.x.norm_squared();
    Weighed {
        hypothesis,
        amplitude: 0.0,
        log_evidence: posterior.log_evidence,
        plain_log_evidence: posterior.log_evidence,
        posterior,
        plain: fit.clone(),
        fit,
    }
}
