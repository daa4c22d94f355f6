//! Screen, then joint fits: of single effects, and of pairs around the best of them.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use terra_model::{AnyEffect, Touch};

use crate::dataset::{DataSet, Predictor};
use crate::evidence::posterior;
use crate::fit::{Fit, evaluate, fit_near};
use crate::hypothesis::Hypothesis;
use crate::noise::Whitener;
use crate::round::Round;
use crate::screen::{Score, Tangent};
use crate::settings::LogKind;
use crate::setup::{Screened, Setup};
use crate::weigh::{Amplitudes, Weighed, weigh};

/// Nats from the best within which a screened effect is confirmed.
const CONFIRM_WITHIN: f64 = 10.0;
/// Effects confirmed at least.
const CONFIRM_AT_LEAST: usize = 5;
/// Screened gain up to which an effect of a drive, beyond those, is weighed by its screen alone: where the data do not ask
/// for it, its magnitude is small against its own noise and the tangent is as good as the law.
const LINEAR_UP_TO: f64 = 0.0;
/// Screened gain that a second cause of a drive must promise to be fitted: calibrated thresholds ask for more.
const PARTNER_FROM: f64 = 0.0;
/// Other structures, the best by themselves, under which effects are weighed too.
const STRUCTURES: usize = 2;
/// Nats by which such a structure may fall short of the nominal one.
const STRUCTURE_WITHIN: f64 = 5.0;
/// Effects confirmed at least, once the noise is renewed, where the best gains more than this: the tangent then ranks poorly.
const CONFIRM_AT_LEAST_LARGE: (usize, f64) = (9, 50.0);
/// Prior sd that a soil parameter moves at most before a fit starts anew from the prior centre.
const FAR_SOIL: f64 = 3.0;
/// Misfit per value above which it does.
const FAR_FIT: f64 = 1.3;
/// How many of the best singles, and of the best pairs.
const ANEW: usize = 3;
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

pub(crate) type Asked = Vec<Arc<dyn AnyEffect>>;

/// Screens every candidate at a fit; effects without a trace are set aside with that reason.
///
/// All candidates stand in one law at magnitude zero, where each leaves the others alone, so one exact Jacobian holds every
/// signature.
pub(crate) fn screen_all<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    base: &Hypothesis,
    fit: &Fit,
    effects: &[Arc<dyn AnyEffect>],
    whitener: &Whitener,
    not_asked: &mut Vec<(String, String)>,
) -> (Vec<Screened>, Asked) {
    let mut together = base.clone();
    let mut asked: Asked = vec![];
    for effect in effects {
        match together.with(Arc::clone(effect)) {
            Ok(more) => {
                together = more;
                asked.push(Arc::clone(effect));
            }
            Err(e) => not_asked.push((effect.name().to_owned(), e.to_string())),
        }
    }
    let mut x = fit.x.as_slice().to_vec();
    x.resize(together.len(), 0.0);
    let Ok(s) = evaluate(data, predictor, &together, &x) else {
        return (vec![], vec![]);
    };
    let (residual, jacobian) = (
        whitener.apply_vector(&s.residual),
        whitener.apply(&s.jacobian),
    );
    let at_base = Fit {
        residual,
        jacobian: jacobian.columns(0, base.len()).into_owned(),
        ..fit.clone()
    };
    let tangent = Tangent::of(&at_base);
    if asked.len() > 1 && !jacobian.iter().all(|v| v.is_finite()) {
        // One effect without a slope here spoils the slopes of all: ask each by itself.
        let mut found = (vec![], vec![]);
        for effect in asked {
            let alone = [effect];
            let (rows, kept) = screen_all(data, predictor, base, fit, &alone, whitener, not_asked);
            found.0.extend(rows);
            found.1.extend(kept);
        }
        return found;
    }
    let mut at = base.len();
    let mut screen = vec![];
    asked.retain(|effect| {
        let column = jacobian.column(at).into_owned();
        at += effect.params().len();
        let reason = if !column.iter().all(|v| v.is_finite()) {
            "its signature is not finite on this data"
        } else if column.norm_squared() < 1e-8 {
            "leaves no trace in these channels"
        } else {
            let one_sided = effect.params().first().is_some_and(|p| p.one_sided());
            screen.push(Screened {
                name: effect.name().to_owned(),
                form: effect.form().to_owned(),
                score: tangent.score(column, one_sided),
            });
            return true;
        };
        not_asked.push((effect.name().to_owned(), reason.to_owned()));
        false
    });
    (screen, asked)
}

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
    previous: Option<&Round>,
) -> Vec<(usize, Vec<Weighed>)> {
    // What a fit under another noise found is the best start.
    let before = |effect: &Arc<dyn AnyEffect>| {
        let round = previous?;
        let same = |s: &Screened| s.name == effect.name() && s.form == effect.form();
        let found = round.singles.iter().find(|(k, _)| same(&round.screen[*k]));
        Some(found?.1.first()?.plain.x.as_slice().to_vec())
    };
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
    // Contrasts on rigs are large and the linear screen may only order work there, never exclude.
    let confirmed: Vec<usize> = order
        .iter()
        .enumerate()
        .filter(|(rank, k)| {
            setup.kind == LogKind::Rig
                || *rank < at_least
                || screen[**k].score.log_bayes_factor > best - CONFIRM_WITHIN
        })
        .map(|(_, k)| *k)
        .collect();
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
    let mut singles: Vec<(usize, Vec<Weighed>)> = confirmed
        .par_iter()
        .enumerate()
        .filter_map(|(rank, &k)| {
            let effect = &asked[k];
            if setup.kind == LogKind::Drive
                && rank >= at_least
                && screen[k].score.log_bayes_factor <= LINEAR_UP_TO
            {
                let h = null.with(Arc::clone(effect)).ok()?;
                return Some((k, vec![tangent_only(h, null_weighed, &screen[k].score)]));
            }
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
                .filter_map(|(base, x)| {
                    let h = base.with(Arc::clone(effect)).ok()?;
                    let mut near = x.clone();
                    near.resize(h.len(), screen[k].score.magnitude.clamp(-3.0, 3.0));
                    let mut off = x;
                    off.resize(h.len(), 0.0);
                    let mut other = vec![0.0; base.len()];
                    other.resize(h.len(), 1.0);
                    let starts = match setup.kind {
                        LogKind::Rig => vec![near, off, other],
                        LogKind::Drive | LogKind::Kinematic => {
                            vec![before(effect).unwrap_or(near)]
                        }
                    };
                    let guess = (setup.kind == LogKind::Drive)
                        .then(|| screen[k].score.beside(&null_weighed.plain.jacobian));
                    let found = weigh(data, predictor, &h, levels, &starts, guess).ok()?;
                    let far = far_start(&**effect, &found, setup.kind);
                    Some(better_of(found, far, |start| {
                        weigh(data, predictor, &h, levels, &[start], None).ok()
                    }))
                })
                .collect();
            (!weighed.is_empty()).then_some((k, weighed))
        })
        .collect();
    if setup.kind == LogKind::Drive {
        let mut all: Vec<&mut Weighed> = singles.iter_mut().flat_map(|(_, w)| w).collect();
        start_anew(data, predictor, levels, null.len(), &mut all);
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

/// Another start for a fit of a drive: physics at the contact is far from linear, and a one-sided effect can end at its bound
/// although it is there, the soil having moved the other way. Instruments are nearly linear and need one start.
fn far_start(effect: &dyn AnyEffect, found: &Weighed, kind: LogKind) -> Option<Vec<f64>> {
    let physical = [Touch::Contact, Touch::Forces]
        .iter()
        .any(|t| effect.touches().contains(t));
    let mut far = found.plain.x.as_slice().to_vec();
    let last = far.last_mut()?;
    if kind != LogKind::Drive || !physical || *last > 0.1 {
        return None;
    }
    *last = 1.0;
    Some(far)
}

/// The prior centre of the soil as another start, where a drive's fit ended at a soil that is hard to believe or far from the
/// data: fits go on from the nominal law's own, which a missing effect may have driven into a corner.
fn fresh_start(found: &Weighed, soil: usize) -> Option<Vec<f64>> {
    let x = &found.plain.x;
    let moved = x.iter().take(soil).any(|q| q.abs() > FAR_SOIL);
    if !(moved || found.chi2_per_value() > FAR_FIT) {
        return None;
    }
    let size = |s: f64| {
        if s.abs() < 0.1 {
            0.5
        } else {
            s.clamp(-2.0, 2.0)
        }
    };
    let fresh = x.iter().enumerate();
    Some(
        fresh
            .map(|(k, v)| if k < soil { 0.0 } else { size(*v) })
            .collect(),
    )
}

/// Fits the best explanations anew from there.
fn start_anew<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    levels: &Amplitudes,
    soil: usize,
    all: &mut [&mut Weighed],
) {
    all.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    all.par_iter_mut().take(ANEW).for_each(|w| {
        let h = w.hypothesis.clone();
        let found = better_of(w.clone(), fresh_start(w, soil), |start| {
            // With the noise taken ten times larger the prior holds the soil back until the rest is about right.
            let loose = levels.loose.as_ref()?;
            let near = fit_near(data, predictor, &h, loose, &start, None, false).ok()?;
            weigh(
                data,
                predictor,
                &h,
                levels,
                &[near.x.as_slice().to_vec()],
                None,
            )
            .ok()
        });
        **w = found;
    });
}

/// The best of a fit and those from other starts.
fn better_of(
    found: Weighed,
    starts: impl IntoIterator<Item = Vec<f64>>,
    weigh: impl Fn(Vec<f64>) -> Option<Weighed>,
) -> Weighed {
    starts
        .into_iter()
        .filter_map(weigh)
        .fold(found, |best, other| {
            if other.log_evidence > best.log_evidence {
                other
            } else {
                best
            }
        })
}

/// Two rows of the screen, a start, and a Jacobian there.
type Job = (usize, usize, Vec<f64>, DMatrix<f64>);

/// The pairs that the tangent at the nominal fit ranks first, where they beat the best single there.
fn by_screen(null: &Weighed, screen: &[Screened]) -> Vec<Job> {
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
            {
                found.push((gain, a, b, magnitudes));
            }
        }
    }
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    found
        .into_iter()
        .take(PAIRS_BY_SCREEN)
        .map(|(_, a, b, magnitudes)| {
            let mut start = null.plain.x.as_slice().to_vec();
            start.extend(magnitudes.map(|m| m.clamp(-3.0, 3.0)));
            let first = screen[a].score.beside(&null.plain.jacobian);
            (a, b, start, screen[b].score.beside(&first))
        })
        .collect()
}

/// Best partners of the best singles, screened around them, then fitted jointly.
pub(crate) fn confirm_pairs<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    null: &Hypothesis,
    levels: &Amplitudes,
    null_weighed: &Weighed,
    screen: &[Screened],
    singles: &[(usize, Vec<Weighed>)],
    asked: &Asked,
    whitener: &Whitener,
    kind: LogKind,
) -> Vec<Weighed> {
    let mut seeds: Vec<(usize, &Weighed)> = singles
        .iter()
        .filter_map(|(k, w)| Some((*k, w.first()?)))
        .collect();
    let by = |evidence: fn(&Weighed) -> f64| {
        let mut order = seeds.clone();
        order.sort_by(|a, b| evidence(b.1).total_cmp(&evidence(a.1)));
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
    let mut jobs: Vec<Job> = seeds
        .iter()
        .flat_map(|(first, weighed)| {
            let partners: Asked = asked
                .iter()
                .filter(|e| e.name() != asked[*first].name())
                .map(Arc::clone)
                .collect();
            let (screen, kept) = screen_all(
                data,
                predictor,
                &weighed.hypothesis,
                &weighed.plain,
                &partners,
                whitener,
                &mut vec![],
            );
            let mut order: Vec<usize> = (0..kept.len()).collect();
            order.sort_by(|&a, &b| {
                screen[b]
                    .score
                    .log_bayes_factor
                    .total_cmp(&screen[a].score.log_bayes_factor)
            });
            order
                .into_iter()
                .take(PAIRS_PER_SEED)
                .filter(|&k| {
                    kind != LogKind::Drive || screen[k].score.log_bayes_factor > PARTNER_FROM
                })
                .filter_map(|k| {
                    let second = asked
                        .iter()
                        .position(|e| e.name() == kept[k].name() && e.form() == kept[k].form())?;
                    let mut start = weighed.plain.x.as_slice().to_vec();
                    start.push(screen[k].score.magnitude.clamp(-3.0, 3.0));
                    let guess = screen[k].score.beside(&weighed.plain.jacobian);
                    Some((*first, second, start, guess))
                })
                .collect::<Vec<_>>()
        })
        .collect();
    if kind == LogKind::Drive {
        jobs.extend(by_screen(null_weighed, screen));
    }
    // One pair of names in one pair of forms, the first.
    let mut seen: Vec<(&str, &str)> = vec![];
    let mut unique = vec![];
    for (a, b, start, guess) in jobs {
        let (first, second) = (asked[a].name(), asked[b].name());
        let key = (first.min(second), first.max(second));
        if !seen.contains(&key) {
            seen.push(key);
            unique.push((a, b, start, guess));
        }
    }
    let mut pairs: Vec<Weighed> = unique
        .into_par_iter()
        .filter_map(|(a, b, start, guess)| {
            let h = null
                .with(Arc::clone(&asked[a]))
                .ok()?
                .with(Arc::clone(&asked[b]))
                .ok()?;
            let mut off = start.clone();
            if let Some(last) = off.last_mut() {
                *last = 0.0;
            }
            let starts = match kind {
                LogKind::Rig => vec![start.clone(), off],
                LogKind::Drive | LogKind::Kinematic => vec![start.clone()],
            };
            let guess = (kind == LogKind::Drive).then_some(guess);
            let pair = weigh(data, predictor, &h, levels, &starts, guess).ok()?;
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
        .collect();
    if kind == LogKind::Drive {
        let mut all: Vec<&mut Weighed> = pairs.iter_mut().collect();
        start_anew(data, predictor, levels, null.len(), &mut all);
    }
    pairs
}
