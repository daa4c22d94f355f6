//! Joint fits of single effects.

use std::sync::Arc;

use terra_model::order::descending;

use crate::contenders::Contenders;
use crate::dataset::DataSet;
use crate::evidence::posterior;
use crate::hypothesis::Hypothesis;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::renewal::Before;
use crate::screen::{Score, within_reach};
use crate::settings::LogKind;
use crate::setup::{Screened, Setup};
use crate::signatures::Asked;
use crate::starts::{better_of, far_start, start_anew, weigh_from};
use crate::weigh::{Amplitudes, NEAR, Weighed, again, contest, weigh, weigh_at};

/// Screened gain up to which an effect of a drive, beyond the surest, is weighed by its screen alone: where the data do not ask
/// for it, its magnitude is small against its own noise and the tangent is as good as the law.
const LINEAR_UP_TO: f64 = 0.0;
/// Nats behind these from which another is not fitted any more.
const LOST: f64 = 15.0;
/// Other structures, the best by themselves, under which effects are weighed too.
const STRUCTURES: usize = 2;
/// Nats by which such a structure may fall short of the nominal one.
const STRUCTURE_WITHIN: f64 = 5.0;

/// One effect, by its row of the screen, under every structure tried.
type Single = (usize, Vec<Weighed>);

/// Confirms singles by joint fits, under the nominal structure and (on a rig) under the best other ones. `known`: the best
/// explanation there is beside them.
pub(crate) fn confirm_singles(
    data: &DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    null: &Hypothesis,
    null_weighed: &Weighed,
    structures: &[(String, Weighed)],
    levels: &Amplitudes,
    screen: &[Screened],
    asked: &Asked,
    previous: Option<Before<'_>>,
    known: Option<&Weighed>,
    anew: &mut Vec<String>,
) -> Vec<Single> {
    let kind = setup.kind;
    let chosen = Contenders::choose(
        data,
        predictor,
        kind,
        null,
        null_weighed,
        levels,
        screen,
        asked,
        previous,
    );
    let bases = bases(kind, null, null_weighed, structures);
    let confirm = |rank: usize, k: usize, levels: &Amplitudes, lost: &dyn Fn(f64) -> bool| {
        let effect = &asked[k];
        let score = &screen[k].score;
        // What a fit under another noise found is the best start.
        let before = previous.and_then(|p| Some((p, p.single(&**effect)?)));
        let promised = score.log_bayes_factor;
        let idle = rank >= chosen.sure && promised <= LINEAR_UP_TO;
        if kind == LogKind::Drive && before.is_none() && (idle || lost(promised)) {
            let h = null.with(Arc::clone(effect)).ok()?;
            return Some((k, vec![tangent_only(h, null_weighed, score)]));
        }
        if let Some((p, found)) = before
            && p.out(found)
        {
            let h = &found.hypothesis;
            let again = weigh_at(data, predictor, h, levels, &found.plain).ok()?;
            return Some((k, vec![again]));
        }
        let elsewhere = chosen.found(k);
        let weighed = bases.iter().enumerate().filter_map(|(rank, (base, x))| {
            let h = base.with(Arc::clone(effect)).ok()?;
            let beside = |soil: &[f64], magnitude: f64| {
                let mut start = soil.to_vec();
                start.resize(h.len(), magnitude);
                start
            };
            let near = beside(x, score.magnitude.clamp(-3.0, 3.0));
            let starts = match kind {
                // Another structure was fitted with its own soil already.
                LogKind::Rig if rank > 0 => vec![near, beside(x, 0.0)],
                LogKind::Rig => vec![near, beside(x, 0.0), beside(&vec![0.0; base.len()], 1.0)],
                LogKind::Kinematic => vec![near],
                // Far from the tangent's own ground a whole step of it lands anywhere: the descent takes as much of it as
                // helps.
                LogKind::Drive => {
                    let mut starts = vec![match (before, elsewhere) {
                        (Some((_, before)), _) => before.plain.x.as_slice().to_vec(),
                        (None, Some(found)) => found.to_vec(),
                        (None, None) => beside(x, 0.0),
                    }];
                    // Soil that stands for an effect is no start for it.
                    if chosen.all && before.is_none() {
                        starts.push(beside(&vec![0.0; base.len()], 1.0));
                    }
                    starts
                }
            };
            let at_the_null = kind == LogKind::Drive && before.is_none() && elsewhere.is_none();
            let known = at_the_null.then(|| score.beyond(&null_weighed.plain, &**effect));
            let effort = match before {
                Some(_) => again(kind),
                None => contest(kind),
            };
            let found = weigh(data, predictor, &h, levels, &starts, known, effort).ok()?;
            let far = far_start(&**effect, &found, kind).filter(|_| elsewhere.is_none());
            Some(better_of(found, far, |start, found| {
                weigh_from(data, predictor, levels, found, start)
            }))
        });
        let weighed: Vec<Weighed> = weighed.collect();
        (!weighed.is_empty()).then_some((k, weighed))
    };
    let (first, others) = chosen.order.split_at(chosen.first.min(chosen.order.len()));
    let of_first = for_each(first.len(), |rank| {
        confirm(rank, first[rank], levels, &|_| false)
    });
    let mut singles: Vec<Single> = of_first.into_iter().flatten().collect();
    let found = singles.iter().flat_map(|(_, w)| w);
    let best = found.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
    let gain = best.map_or(f64::NEG_INFINITY, |b| b.log_evidence) - null_weighed.log_evidence;
    let lost = |promised: f64| chosen.near && !chosen.all && within_reach(promised) + LOST < gain;
    // Where one of these explains the data there is no need to ask those that only the tangent speaks for, far from the data.
    let explained = best.is_some_and(|b| b.chi2_per_value() < NEAR);
    let asked_still = if explained && chosen.only_if_unexplained {
        &[]
    } else {
        others
    };
    let against_best = levels.against(best);
    let of_others = for_each(asked_still.len(), |rank| {
        confirm(rank + first.len(), asked_still[rank], &against_best, &lost)
    });
    singles.extend(of_others.into_iter().flatten());
    if kind == LogKind::Drive {
        // Who was found by a look around began near the prior centre already.
        let scouted = singles.iter().filter(|(k, _)| chosen.found(*k).is_some());
        anew.extend(
            scouted
                .flat_map(|(_, w)| w)
                .map(|w| w.hypothesis.effect_name()),
        );
        let mut all: Vec<&mut Weighed> = singles.iter_mut().flat_map(|(_, w)| w).collect();
        start_anew(data, predictor, levels, null.len(), &mut all, known, anew);
    }
    singles
}

/// The structures that effects are put on, each with its own fit: the nominal one, and on a rig the best others. On one that
/// is far from the data an effect would only be fitted to the structure's error.
fn bases(
    kind: LogKind,
    null: &Hypothesis,
    null_weighed: &Weighed,
    structures: &[(String, Weighed)],
) -> Vec<(Hypothesis, Vec<f64>)> {
    let fitted = |w: &Weighed| w.fit.x.as_slice().to_vec();
    let mut out = vec![(null.clone(), fitted(null_weighed))];
    if kind == LogKind::Rig {
        let near = null_weighed.log_evidence - STRUCTURE_WITHIN;
        let mut others: Vec<&Weighed> = structures
            .iter()
            .map(|(_, w)| w)
            // The nominal law on other soil is no other law.
            .filter(|w| w.hypothesis.law.model().name() != null.law.model().name())
            .filter(|w| w.log_evidence > near)
            .collect();
        descending(&mut others, |w| w.log_evidence);
        others.truncate(STRUCTURES);
        out.extend(others.iter().map(|w| (w.hypothesis.clone(), fitted(w))));
    }
    out
}

/// The rival as the screen at a fit has it, one effect more than there: the law replaced by its tangent at that fit.
pub(crate) fn tangent_only(hypothesis: Hypothesis, at: &Weighed, score: &Score) -> Weighed {
    let mut fit = at.plain.clone();
    fit.x = fit.x.push(0.0);
    fit.jacobian = score.beside(&at.plain.jacobian).into();
    (fit.exact, fit.tangent) = (false, true);
    fit.at_bound.push(false);
    let posterior = posterior(&hypothesis, &fit);
    let (low, high) = hypothesis.bounds();
    let to = fit.least_within(&low, &high);
    fit.residual -= &*fit.jacobian * (&to - &fit.x);
    fit.x = to;
    fit.cost = fit.chi2() + fit.x.norm_squared();
    Weighed {
        hypothesis,
        amplitude: 0.0,
        log_evidence: posterior.log_evidence,
        usual: 1.0,
        plain_log_evidence: posterior.log_evidence,
        posterior,
        plain: fit.clone(),
        fit,
        fitted: false,
    }
}
