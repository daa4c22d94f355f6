//! The right physics by another formula: the single causes of a drive once more, with their formula left free where the data
//! ask for it.
//!
//! No library holds nature's formula. An effect whose curve is not quite the library's leaves a remainder that a second
//! effect, another one, or something unknown, would be blamed for. So all of them are asked again with smooth terms that can only
//! reshape what the effect does ([`free::FreeForm`]). Terms are chosen one by one by their screened gain, and a set of them is
//! paid for as one choice among all such sets. Where nothing follows the drive, the soil may become another one at a place
//! ([`edge::Edge`]), which is no smooth factor.

mod edge;
mod free;
mod reshape;
mod term;

use edge::EDGE;
pub(crate) use free::FREE;

use std::sync::Arc;

use terra_model::AnyEffect;
use terra_model::order::{ascending, descending};

use crate::dataset::DataSet;
use crate::hypothesis::Hypothesis;
use crate::noise::Whitener;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::setup::{Screened, Setup};
use crate::weigh::{Amplitudes, Weighed, contest, weigh};

use reshape::{Origin, Reshaped};
use term::Regime;

/// True for a form that is made for the log at hand: a formula left free, or another soil from one place on.
pub(crate) fn is_made(form: &str) -> bool {
    [FREE, EDGE].contains(&form)
}

/// Manoeuvres from which a formula can be asked about: on a single ramp slip, speed and path are one variable, and a free
/// formula would imitate what is in no library.
pub(crate) const MANOEUVRES: usize = 3;
/// Terms that a formula may differ by, in as many rounds.
const TERMS: [usize; 2] = [4, 6];
/// Gain \[nats\] of the best single cause from which its formula can be asked about at all.
pub(crate) const EFFECT: f64 = 6.0;
/// Misfit per value of the nearest explanation above which none follows the drive.
const UNEXPLAINED: f64 = 1.3;
/// Effects that are followed on few windows, and on all of them, where nothing explains a drive.
const FOLLOWED: (usize, usize) = (8, 2);
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

impl Ground<'_, '_> {
    /// Only a few windows of it.
    fn on_few(&self) -> Option<Self> {
        let (data, whitener) = self.levels.thin.as_ref()?.windows();
        Some(Ground {
            data,
            whitener,
            ..*self
        })
    }
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

/// Asks the single causes again with a free formula, where one of these is far above the nominal law, and puts what is found
/// beside their other forms. By the library's own formula the right one may be far behind: it is the terms' promise that tells.
///
/// First every confirmed one and the parts of the best pair, where its terms promise to reach all others and `rival`, ln Z of a
/// pair or of something unknown; then once more those that are behind another's formula; and where nothing follows the drive, all
/// effects. Those that were asked `before`, by name and form, are the only ones the next time; gives back which these are.
pub(crate) fn ask_again(
    ground: &Ground<'_, '_>,
    (screen, effects): (&[Screened], &[Arc<dyn AnyEffect>]),
    singles: &mut Vec<(usize, Vec<Weighed>)>,
    pairs: &[Weighed],
    nominal: &Weighed,
    rival: f64,
    before: Option<&[Named]>,
) -> Vec<Named> {
    if ground.data.groups().len() < MANOEUVRES {
        return vec![];
    }
    let best = best_of(singles.iter().flat_map(|(_, w)| w));
    if best < nominal.log_evidence + EFFECT {
        return vec![];
    }
    let named = |k: usize| (screen[k].name.clone(), screen[k].form.clone());
    let is_asked = |k: usize| before.is_none_or(|before| before.contains(&named(k)));
    let by_evidence = |a: &&Weighed, b: &&Weighed| a.log_evidence.total_cmp(&b.log_evidence);
    if let Some(pair) = pairs.iter().max_by(by_evidence) {
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
    order.retain(|&i| is_asked(singles[i].0));
    let bar = rival.max(best);
    let first = for_each(order.len(), |rank| {
        let plain = &singles[order[rank]].1[0];
        let effect = Arc::clone(plain.hypothesis.effects().first()?);
        asked(ground, Reshaped::new(effect, regime), plain, bar)
    });
    let places = order.iter().map(|&i| singles[i].0);
    let mut found: Vec<(usize, Found)> = places
        .zip(first)
        .filter_map(|(k, f)| Some((k, f?)))
        .collect();
    let ahead = |found: &[(usize, Found)]| best.max(best_of(found.iter().map(|(_, f)| &f.1)));
    // A formula that followed the data well enough by itself may need another term beside one that follows them better.
    let bar = ahead(&found);
    let again = for_each(found.len(), |n| {
        let (shape, w) = &found[n].1;
        let mut shape = shape.clone();
        let more = (w.log_evidence < bar).then(|| shape.ask(ground, w, TERMS[1], bar))??;
        (more.log_evidence > w.log_evidence).then_some((shape, more))
    });
    for ((_, before), more) in found.iter_mut().zip(again) {
        *before = more.unwrap_or_else(|| before.clone());
    }
    let fitted = singles.iter().flat_map(|(_, w)| w).chain(pairs);
    let all = fitted.chain(found.iter().map(|(_, f)| &f.1));
    let nearest = all
        .map(Weighed::chi2_per_value)
        .fold(f64::INFINITY, f64::min);
    let mut edges = vec![];
    if nearest > UNEXPLAINED
        && let Some(k) = screen.iter().position(|s| s.name == edge::OF)
        && before.is_none_or(|before| before.contains(&(screen[k].name.clone(), EDGE.to_owned())))
        && let Some(effect) = effects.iter().find(|e| e.name() == edge::OF)
    {
        edges.extend(edge::look(ground, effect, nominal).map(|w| (k, w)));
    }
    let with_edges = edges.iter().map(|(_, w)| w.chi2_per_value());
    if with_edges.fold(nearest, f64::min) > UNEXPLAINED {
        let row = |k: usize| {
            let weighed = singles.iter().find(|(row, w)| *row == k && !w.is_empty());
            let s = &screen[k];
            let same = |e: &&Arc<dyn AnyEffect>| e.name() == s.name && e.form() == s.form;
            let at = weighed.and_then(|(_, w)| w.first()).unwrap_or(nominal);
            Some((k, effects.iter().find(same)?, at))
        };
        let rows = (0..screen.len()).filter(|k| !order.iter().any(|&i| singles[i].0 == *k));
        let rows: Vec<_> = rows.filter(|&k| is_asked(k)).filter_map(row).collect();
        found.extend(look_everywhere(ground, regime, &rows, rival));
    }
    let mut asked: Vec<Named> = found.iter().map(|(k, _)| named(*k)).collect();
    asked.extend(
        edges
            .iter()
            .map(|(k, _)| (screen[*k].name.clone(), EDGE.to_owned())),
    );
    let found = found.into_iter().map(|(k, (_, w))| (k, w));
    for (k, w) in found.chain(edges) {
        match singles
            .iter_mut()
            .find(|(row, all)| *row == k && !all.is_empty())
        {
            Some((_, all)) => all.push(w),
            None => singles.push((k, vec![w])),
        }
    }
    asked
}

/// An effect's name and form.
pub(crate) type Named = (String, String);

/// An effect and what was found for it.
type Found = (Reshaped, Weighed);

/// The largest ln Z.
fn best_of<'a>(all: impl Iterator<Item = &'a Weighed>) -> f64 {
    all.map(|w| w.log_evidence)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Effects that were not asked yet, where nothing else explains the drive: far from the data the tangent promises much less than
/// there is, so on few windows those that promise most are followed, whatever it is, and those that come nearest there on all.
/// `rows`: effects of the screen, each with where it, or the nominal law without it, was weighed.
fn look_everywhere(
    ground: &Ground<'_, '_>,
    regime: Regime,
    rows: &[(usize, &Arc<dyn AnyEffect>, &Weighed)],
    rival: f64,
) -> Vec<(usize, Found)> {
    let (Some(few), Some(on_few)) = (&ground.levels.thin, ground.on_few()) else {
        return vec![];
    };
    let promised = for_each(rows.len(), |n| {
        let (k, effect, at) = rows[n];
        let h = ground.null.with(Arc::clone(effect)).ok()?;
        let from = Origin::at(&on_few, at, &h)?;
        let mut shape = Reshaped::new(Arc::clone(effect), regime);
        let (known, promised) = shape.choose(&on_few, &from.fit, TERMS[0])?;
        let promised = promised - 0.5 * few.cost_of(&at.plain);
        Some((k, shape, from, known, promised))
    });
    let mut promised: Vec<_> = promised.into_iter().flatten().collect();
    descending(&mut promised, |(.., promised)| *promised);
    promised.truncate(FOLLOWED.0);
    let roughly = for_each(promised.len(), |n| {
        let (k, shape, from, known, _) = &promised[n];
        let end = shape.roughly(ground, few, from, known.clone())?;
        Some((*k, shape.clone(), end))
    });
    let mut roughly: Vec<_> = roughly.into_iter().flatten().collect();
    ascending(&mut roughly, |(_, _, end)| end.fit.cost);
    roughly.truncate(FOLLOWED.1);
    let found = for_each(roughly.len(), |n| {
        let (k, shape, from) = &roughly[n];
        let shape = shape.clone();
        let w = shape.fitted(ground, from, None)?;
        let near = w.chi2_per_value() < FAR;
        let more = (!near).then(|| asked(ground, shape.clone(), &w, rival));
        let found = match more.flatten() {
            Some(more) if more.1.log_evidence > w.log_evidence => more,
            _ => (shape, w),
        };
        Some((*k, found))
    });
    found.into_iter().flatten().collect()
}

/// An effect by another formula, where the data ask for one that could stand against `rival`, ln Z of another answer.
fn asked(ground: &Ground<'_, '_>, shape: Reshaped, from: &Weighed, rival: f64) -> Option<Found> {
    let (mut shape, mut from) = (shape, from.clone());
    let mut found: Option<Found> = None;
    for most in TERMS {
        let Some(next) = shape.ask(ground, &from, most, rival) else {
            break;
        };
        let better = next.log_evidence > from.log_evidence;
        let near = next.chi2_per_value() < FAR;
        from = next.clone();
        if better || found.is_none() {
            found = Some((shape.clone(), next));
        }
        if near || !better {
            break;
        }
    }
    found
}
