//! Two causes at once: partners of the best single ones, and the pairs that the tangent ranks first.

use std::sync::Arc;

use terra_model::AnyEffect;
use terra_model::order::descending;

use crate::beside::Beside;
use crate::candidates::is_instrument;
use crate::dataset::DataSet;
use crate::fit::Known;
use crate::hypothesis::Hypothesis;
use crate::noise::Whitener;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::renewal::{Before, out};
use crate::screen::within_reach;
use crate::settings::LogKind;
use crate::setup::Screened;
use crate::signatures::{Asked, by_the_law, screen_all};
use crate::weigh::{Amplitudes, NEAR, Weighed, again, contest, weigh, weigh_at, weigh_roughly};

/// Screened gain that a second cause of a drive must promise to be fitted: calibrated thresholds ask for more.
const PARTNER_FROM: f64 = 1.0;
/// Pairs confirmed because the tangent at the nominal fit ranks them first among all pairs.
const PAIRS_BY_SCREEN: usize = 4;
/// Effects that get partners, on a rig.
const PAIR_SEEDS: usize = 3;
/// The same on a drive, where every seed costs a screen of all effects.
const PAIR_SEEDS_DRIVE: usize = 2;
/// Pairs confirmed around each.
const PAIRS_PER_SEED: usize = 4;
/// Nats by which a pair must beat its better half: a raw threshold, to be replaced by a calibrated one.
const SECOND_CAUSE: f64 = 3.0;
/// The same against the noise alone, where an inadequate nominal model asks for a second cause.
const SECOND_CAUSE_PLAIN: f64 = 7.5;

/// Two rows of the screen, a start, and what is known there.
type Job = (usize, usize, Vec<f64>, Known);

/// The pairs that the tangent at the nominal fit ranks first, where they beat the best single there.
fn by_screen(
    null: &Weighed,
    screen: &[Screened],
    eligible: impl Fn(usize, usize, f64) -> bool,
) -> Vec<Job> {
    let single = screen
        .iter()
        .map(|s| s.score.log_bayes_factor)
        .fold(0.0, f64::max);
    let mut found = vec![];
    for (a, first) in screen.iter().enumerate() {
        for (b, second) in screen.iter().enumerate().skip(a + 1) {
            if first.name == second.name {
                continue;
            }
            if let Some((gain, magnitudes)) = first.score.with(&second.score)
                && gain > single + PARTNER_FROM
                && eligible(a, b, gain)
            {
                found.push((gain, a, b, magnitudes));
            }
        }
    }
    descending(&mut found, |f| f.0);
    found
        .into_iter()
        .take(PAIRS_BY_SCREEN)
        .map(|(_, a, b, magnitudes)| {
            let mut start = null.plain.x.as_slice().to_vec();
            start.extend(magnitudes.map(|m| m.clamp(-3.0, 3.0)));
            let first = screen[a].score.beside(&null.plain.jacobian);
            let both = screen[b].score.beside(&first);
            (a, b, start, Known::nearby(both.into(), &null.plain.near))
        })
        .collect()
}

/// Best partners of the best singles, screened around them, then fitted jointly; on few windows where the noise will be taken
/// anew at the best of them (`roughly`), and only the way there is asked for. Beside them, on a drive, what may stand unseen
/// beside one of the singles.
pub(crate) fn confirm_pairs(
    data: &DataSet,
    predictor: &dyn Predictor,
    null: &Hypothesis,
    levels: &Amplitudes,
    null_weighed: &Weighed,
    screen: &[Screened],
    singles: &[(usize, Vec<Weighed>)],
    asked: &Asked,
    whitener: &Whitener,
    kind: LogKind,
    contrast: bool,
    previous: Option<Before<'_>>,
    roughly: bool,
) -> (Vec<Weighed>, Vec<Beside>) {
    // Against another simulator's log the wheel law's form is off, and a second cause beside an effect of the ground would only
    // mend that: 14 of 38 mock contrasts (seed 12011) with one physical cause were explained by it and another one.
    let may_pair = |e: &dyn AnyEffect| !contrast || is_instrument(e);
    let mut seeds: Vec<(usize, &Weighed)> = singles
        .iter()
        .filter(|(k, _)| may_pair(&*asked[*k]))
        .filter_map(|(k, w)| Some((*k, w.first()?)))
        .collect();
    let by = |evidence: fn(&Weighed) -> f64| {
        let mut order = seeds.clone();
        descending(&mut order, |o| evidence(o.1));
        let mut names: Vec<&str> = vec![];
        order.retain(|(k, _)| {
            let new = !names.contains(&asked[*k].name());
            names.push(asked[*k].name());
            new
        });
        order.truncate(if kind == LogKind::Drive {
            PAIR_SEEDS_DRIVE
        } else {
            PAIR_SEEDS
        });
        order
    };
    let mut chosen = by(|w| w.log_evidence);
    for seed in by(|w| w.plain_log_evidence) {
        if chosen.iter().all(|c| c.0 != seed.0) {
            chosen.push(seed);
        }
    }
    seeds = chosen;
    if kind == LogKind::Drive {
        let all = || singles.iter().flat_map(|(_, w)| w);
        seeds.retain(|(_, w)| !out(w, all()));
    }
    let best = singles
        .iter()
        .flat_map(|(_, w)| w)
        .map(|w| w.log_evidence)
        .fold(f64::NEG_INFINITY, f64::max);
    // A pair that cannot reach the best single cause has nothing to say.
    let in_reach = |seed: &Weighed, promised: f64| {
        seed.chi2_per_value() > NEAR || seed.log_evidence + within_reach(promised) > best
    };
    let mut jobs: Vec<Job> = vec![];
    let mut beside = vec![];
    for (first, weighed) in &seeds {
        let partners: Asked = asked
            .iter()
            .filter(|e| e.name() != asked[*first].name() && may_pair(&***e))
            .map(Arc::clone)
            .collect();
        let (h, end) = (&weighed.hypothesis, &weighed.plain);
        let Ok(here) = by_the_law(data, predictor, h, end, whitener) else {
            continue;
        };
        let (screen, kept) =
            screen_all(data, predictor, h, &here, &partners, whitener, &mut vec![]);
        let mut order: Vec<usize> = (0..kept.len()).collect();
        descending(&mut order, |&k| screen[k].score.log_bayes_factor);
        let mut fitted = vec![];
        for &k in order.iter().take(PAIRS_PER_SEED) {
            let promised = screen[k].score.log_bayes_factor;
            let asks = promised > PARTNER_FROM && in_reach(weighed, promised);
            let own = (kept[k].name(), kept[k].form());
            let second = asked.iter().position(|e| (e.name(), e.form()) == own);
            if let Some(second) = second.filter(|_| kind != LogKind::Drive || asks) {
                let mut start = weighed.plain.x.as_slice().to_vec();
                start.push(screen[k].score.magnitude.clamp(-3.0, 3.0));
                let known = screen[k].score.beyond(&here, &*kept[k]);
                fitted.push(kept[k].name());
                jobs.push((*first, second, start, known));
            }
        }
        if kind == LogKind::Drive && !roughly {
            beside.extend(Beside::of(weighed, best, (&screen, &kept), &order, &fitted));
        }
    }
    if kind == LogKind::Drive {
        let first = by_screen(null_weighed, screen, |a, b, promised| {
            may_pair(&*asked[a]) && may_pair(&*asked[b]) && in_reach(null_weighed, promised)
        });
        // Around a cause that explains the data by itself its partners are chosen already, by a better tangent.
        let explains = |name: &str| {
            let mut near = seeds.iter().filter(|(_, w)| w.chi2_per_value() < NEAR);
            near.any(|(k, _)| asked[*k].name() == name)
        };
        let open = |(a, b, ..): &Job| !explains(asked[*a].name()) && !explains(asked[*b].name());
        jobs.extend(first.into_iter().filter(open));
    }
    // One pair of names in one pair of forms, the first.
    let mut seen: Vec<(&str, &str)> = vec![];
    let mut unique = vec![];
    for (a, b, start, known) in jobs {
        let (first, second) = (asked[a].name(), asked[b].name());
        let key = (first.min(second), first.max(second));
        if !seen.contains(&key) {
            seen.push(key);
            unique.push((a, b, start, known));
        }
    }
    let both = |a: usize, b: usize| {
        let first = null.with(Arc::clone(&asked[a])).ok()?;
        first.with(Arc::clone(&asked[b])).ok()
    };
    let mut pairs = vec![];
    if roughly {
        let fresh = |h: &Hypothesis| previous.is_none_or(|p| p.pair(h).is_none());
        (pairs, unique) = lead(data, predictor, levels, unique, |a, b| {
            both(a, b).filter(fresh)
        });
    }
    let fitted: Vec<Weighed> = for_each(unique.len(), |k| {
        let (a, b, start, known) = &unique[k];
        let (a, b) = (*a, *b);
        let h = both(a, b)?;
        let before = previous.and_then(|p| Some((p, p.pair(&h)?)));
        if let Some((p, found)) = before {
            let h = &found.hypothesis;
            if p.out(found) {
                return weigh_at(data, predictor, h, levels, &found.plain).ok();
            }
            let starts = [found.plain.x.as_slice().to_vec()];
            return weigh(data, predictor, h, levels, &starts, None, again(kind)).ok();
        }
        let starts = match kind {
            LogKind::Rig => vec![start.clone(), without_second(start)],
            LogKind::Drive => vec![without_second(start)],
            LogKind::Kinematic => vec![start.clone()],
        };
        let known = (kind == LogKind::Drive).then_some(known);
        let pair = weigh(
            data,
            predictor,
            &h,
            levels,
            &starts,
            known.cloned(),
            contest(kind),
        )
        .ok()?;
        if kind == LogKind::Drive {
            // How much a second cause must gain there is a matter of calibration.
            return Some(pair);
        }
        // A second cause must earn its place against the better of the two alone.
        let alone = |evidence: fn(&Weighed) -> f64| {
            singles
                .iter()
                .filter(|(k, _)| *k == a || *k == b)
                .filter_map(|(_, w)| w.first())
                .map(evidence)
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let earned = pair.log_evidence > alone(|w| w.log_evidence) + SECOND_CAUSE
            || pair.plain_log_evidence > alone(|w| w.plain_log_evidence) + SECOND_CAUSE_PLAIN;
        earned.then_some(pair)
    })
    .into_iter()
    .flatten()
    .collect();
    pairs.extend(fitted);
    (pairs, beside)
}

/// The start with its second cause left out.
fn without_second(start: &[f64]) -> Vec<f64> {
    let mut off = start.to_vec();
    if let Some(last) = off.last_mut() {
        *last = 0.0;
    }
    off
}

/// How a pair's way on few windows ended.
enum Led {
    /// At this cost on them, and weighed there on all unless some other window has no answer there.
    At(f64, Option<Box<Weighed>>),
    Nowhere,
    /// Not led: it has to be weighed in full.
    InFull,
}

/// Pairs of a drive weighed where their ways on few windows end, and the jobs that are left: those that `fresh` has no
/// hypothesis for, and the best of all where it cannot stand in every window.
fn lead(
    data: &DataSet,
    predictor: &dyn Predictor,
    levels: &Amplitudes,
    jobs: Vec<Job>,
    fresh: impl Fn(usize, usize) -> Option<Hypothesis> + Sync,
) -> (Vec<Weighed>, Vec<Job>) {
    let led = |(a, b, start, known): &Job| {
        let Some(h) = fresh(*a, *b) else {
            return Led::InFull;
        };
        let start = without_second(start);
        match weigh_roughly(data, predictor, &h, levels, &start, Some(known)) {
            Some((cost, there)) => Led::At(cost, there.map(Box::new)),
            None => Led::Nowhere,
        }
    };
    let ended: Vec<(Job, Led)> = {
        let ends = for_each(jobs.len(), |k| led(&jobs[k]));
        jobs.into_iter().zip(ends).collect()
    };
    let costs = ended.iter().filter_map(|(_, end)| match end {
        Led::At(cost, _) => Some(*cost),
        _ => None,
    });
    let least = costs.fold(f64::INFINITY, f64::min);
    let (mut found, mut left) = (vec![], vec![]);
    for (job, end) in ended {
        match end {
            Led::At(_, Some(there)) => found.push(*there),
            Led::At(cost, None) if cost <= least => left.push(job),
            Led::InFull => left.push(job),
            Led::At(..) | Led::Nowhere => {}
        }
    }
    (found, left)
}
