//! All rival explanations of one data set, each fitted and weighed: the nominal model, single effects, other structures,
//! pairs, and something unknown.

use std::sync::Arc;

use terra_model::order::descending;

use crate::beside::Beside;
use crate::candidates::Candidates;
use crate::dataset::DataSet;
use crate::error::GapError;
use crate::fit::Fit;
use crate::forms::{Ground, Named, ask_again, is_made};
use crate::hypothesis::Hypothesis;
use crate::loads::{self, Doubt};
use crate::noise::{NoiseModel, Whitener};
use crate::null::{NOT_CARRIED, Refit, drop_unanswered, refit};
use crate::other_soil::{OtherSoil, weigh_on_other_soil};
use crate::predictor::{AnyPredictor, Predictor};
use crate::round::{Common, Round, explained, settle};
use crate::settings::{LogKind, Settings};
use crate::setup::{ADEQUATE, Screened, Setup};
use crate::structures::weigh_structures;
use crate::uneven::Uneven;
use crate::unknown;
use crate::ways;
use crate::weigh::{Weighed, unknown_amplitudes};

/// Misfit per value up to which an explanation of a drive is adequate.
const ADEQUATE_DRIVE: f64 = 1.3;
/// Nats by which something unknown then stays behind it.
const BEHIND_ADEQUATE: f64 = 8.0;

/// Nats by which two causes must beat one by another formula: no library holds nature's formula, and the second cause was chosen
/// among thirty. Of 136 development drives four with two causes came to be asked, which did so by 47 at least, and 49 with
/// another formula, which did by 13 at most; of 160 more, four of two causes (in two of these the best pair was another) and
/// fifteen of another formula lay between.
const FORMULA: f64 = 20.0;

/// What makes every wheel sink out of sight before any soil is fitted.
const SINKS: &str =
    "; a stiffness in kPa, a load in another unit or a wheel of another size would do that";

/// What was weighed.
pub(crate) struct Rivals {
    /// The nominal law, its soil free.
    pub null: Hypothesis,
    /// Its fit against the noise alone.
    pub fitted: Fit,
    /// Whitened misfit of the nominal law as given.
    pub given: f64,
    /// The noise, shared by all.
    pub noise: NoiseModel,
    /// The nominal law weighed.
    pub null_weighed: Weighed,
    /// Signatures.
    pub screen: Vec<Screened>,
    /// Effects alone, by their row of the screen, under every structure tried.
    pub singles: Vec<(usize, Vec<Weighed>)>,
    /// Other terrain models.
    pub structures: Vec<(String, Weighed)>,
    /// Effects on other soil than a baseline's.
    pub other_soil: OtherSoil,
    /// How many terrain models fell out of the contest before they were fitted to all of the data.
    pub structures_out: usize,
    /// Effects by two.
    pub pairs: Vec<Weighed>,
    /// Second causes that may stand unseen beside one.
    pub beside: Vec<Beside>,
    /// Effects by two that say more than one by another formula, by less than [`FORMULA`].
    pub behind: Vec<Weighed>,
    /// ln Z of something unknown.
    pub log_unknown: f64,
    /// The same where no second cause has earned its place: what a pair leaves over then says nothing of what one cause does.
    pub log_unknown_alone: f64,
    /// Effects that were not asked, with the reason.
    pub not_asked: Vec<(String, String)>,
    /// What predicts the log as it was measured, where that is not what was given: along another way, or otherwise loaded.
    pub measured: Option<AnyPredictor>,
    /// What is to be heeded for it.
    pub heed: Vec<String>,
}

impl Rivals {
    pub(crate) fn all(&self) -> impl Iterator<Item = &Weighed> {
        let singles = self.singles.iter().flat_map(|(_, w)| w);
        singles.chain(&self.pairs).chain([&self.null_weighed])
    }

    /// ln Z of the best, [less](loads::says) what a second cause must gain.
    fn say(&self) -> f64 {
        self.all()
            .map(loads::says)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the nominal law or a single effect explains the data, and best.
    fn are_settled(&self) -> bool {
        let by_evidence = |a: &&Weighed, b: &&Weighed| loads::says(a).total_cmp(&loads::says(b));
        let best = self.all().max_by(by_evidence);
        best.is_some_and(|w| explained(w) && w.hypothesis.effects().len() < 2)
    }
}

/// Fits and weighs all rivals, and gives the predictor of where the inputs most probably were; the inner error is the reason why the
/// data cannot tell.
///
/// # Errors
/// A configuration that makes no sense.
pub(crate) fn weigh_rivals(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    settings: &Settings,
    candidates: &Candidates,
) -> Result<Found, GapError> {
    let as_read = data.clone();
    let weigh = |data: &mut DataSet, by: &dyn Predictor, asked: &[Doubt]| {
        weigh_by(data, by, setup, settings, candidates, asked)
    };
    let mut loaded: Option<AnyPredictor> = None;
    let mut turned_out: Vec<Doubt> = vec![];
    let found = loop {
        let asked: &[Doubt] = match turned_out.last() {
            None => &[Doubt::Nominal, Doubt::Best],
            Some(Doubt::Nominal) => &[Doubt::Best],
            Some(Doubt::Best) => &[],
        };
        match weigh(data, loaded.as_deref().unwrap_or(predictor), asked)? {
            Outcome::Found(found) => break *found,
            Outcome::OtherwiseLoaded(doubt, other) => {
                turned_out.push(doubt);
                loaded = Some(other);
                *data = as_read.clone();
            }
        }
    };
    // By the nominal law alone it may only have looked like the other vehicle.
    if turned_out == [Doubt::Nominal] && !found.as_ref().is_ok_and(|(r, _)| r.are_settled()) {
        let mut as_given = as_read;
        let says = |found: &Found| found.as_ref().map_or(f64::NEG_INFINITY, |(r, _)| r.say());
        if let Outcome::Found(by_given) = weigh(&mut as_given, predictor, &[])?
            && says(&by_given) > says(&found)
        {
            *data = as_given;
            return Ok(*by_given);
        }
    }
    Ok(found.map(|(mut rivals, centred)| {
        rivals.measured = rivals.measured.or(loaded);
        (rivals, centred)
    }))
}

/// The rivals with the predictor of where the inputs most probably were, or why the data cannot tell.
type Found = Result<(Rivals, AnyPredictor), String>;

/// What comes of one way to predict the log.
enum Outcome {
    Found(Box<Found>),
    /// It is explained better by a vehicle that is loaded otherwise, this one: where that turned out.
    OtherwiseLoaded(Doubt, AnyPredictor),
}

impl Outcome {
    fn found(found: Found) -> Self {
        Outcome::Found(Box::new(found))
    }
}

/// The same by one predictor, until one of a vehicle that is loaded otherwise turns out to be better where that is `asked`.
fn weigh_by(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    settings: &Settings,
    candidates: &Candidates,
    asked: &[Doubt],
) -> Result<Outcome, GapError> {
    let null = Hypothesis::null(setup.law.clone(), Arc::clone(&setup.soil));
    drop_unanswered(data, predictor, &null, &vec![0.0; null.len()]);
    let as_read = data.clone();
    let free = null.len();
    if data.len() < free + 3 {
        let dropped: Vec<String> = data
            .dropped
            .iter()
            .map(|(why, n)| format!("{n} {why}"))
            .collect();
        let sinks = data.is_empty() && data.dropped.keys().all(|why| why == NOT_CARRIED);
        return Ok(Outcome::found(Err(format!(
            "{} usable values for {free} soil parameters{}{}{}",
            data.len(),
            if dropped.is_empty() {
                ""
            } else {
                "; left out: "
            },
            dropped.join(", "),
            if sinks { SINKS } else { "" }
        ))));
    }
    let Some(found) = refit(data, predictor, setup, &null)? else {
        let why = "the re-fit of the nominal model did not converge";
        return Ok(Outcome::found(Err(why.to_owned())));
    };
    let other = |doubt: Doubt| {
        let other = || predictor.otherwise_loaded();
        asked.contains(&doubt).then(other).flatten()
    };
    if let Some(other) = other(Doubt::Nominal)
        && loads::better_at_the_null(data, &null, &found)?
    {
        return Ok(Outcome::OtherwiseLoaded(Doubt::Nominal, other));
    }
    let Refit {
        fitted,
        noise,
        given,
        predictor: centred,
    } = found;
    let common = Common {
        predictor,
        setup,
        settings,
        candidates,
        null: &null,
    };
    let (mut round, mut predictor) = settle(data, &common, &fitted, noise, centred)?;
    if let Some(other) = other(Doubt::Best)
        && loads::better_at_the_best(data, &*predictor, &round)
    {
        return Ok(Outcome::OtherwiseLoaded(Doubt::Best, other));
    }
    if let Some(k) = ways::better(data, &common, &*predictor, &round)
        && let Some(way) = common.predictor.other_ways().into_iter().nth(k)
    {
        *data = as_read;
        way.take(data);
        let found = weigh_rivals(data, &*way.predictor, setup, settings, candidates)?;
        let found = found.map(|(mut rivals, predictor)| {
            rivals.heed.push(way.heed());
            rivals.measured = rivals.measured.or(Some(way.predictor));
            (rivals, predictor)
        });
        return Ok(Outcome::found(found));
    }
    let mut reshaped = None;
    if setup.kind == LogKind::Drive {
        let (mut found, asked) = reshape(data, &*predictor, setup, &null, &round, None);
        let misfits = round.all().all(|w| w.chi2_per_value() >= ADEQUATE_DRIVE);
        let all = found.iter().flat_map(|(_, w)| w);
        let best = all.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
        // Where it takes another formula to come near, noise and inputs are taken there too.
        if let Some(best) = best.filter(|b| misfits && is_free(b) && round.is_bettered(b))
            && let Some(next) = round.renewed(best, data, &common, &fitted, &mut predictor, true)?
        {
            round = next;
            (found, _) = reshape(data, &*predictor, setup, &null, &round, Some(&asked));
        }
        reshaped = Some(found);
    }
    let Round {
        noise,
        plain,
        levels,
        null_weighed,
        screen,
        mut singles,
        mut pairs,
        beside,
        mut not_asked,
        mut found,
        asked,
        ..
    } = round;
    let data = &*data;
    if setup.kind != LogKind::Rig {
        let rivals: Vec<&Weighed> = singles
            .iter()
            .flat_map(|(_, w)| w)
            .chain(&pairs)
            .chain([&null_weighed])
            .collect();
        found = weigh_structures(data, &*predictor, setup, &noise, &levels, &rivals)?;
    }
    let other_soil = match setup.kind {
        LogKind::Rig => weigh_on_other_soil(
            data,
            &*predictor,
            setup.kind,
            &found.weighed,
            &null_weighed,
            &asked,
            &levels,
        ),
        LogKind::Drive | LogKind::Kinematic => OtherSoil::default(),
    };
    let structures_out = found.out.len();
    not_asked.extend(found.out);
    not_asked.extend(setup.without.iter().cloned());
    let mut behind = vec![];
    if let Some(reshaped) = reshaped {
        singles = reshaped;
        behind = take_needless(&mut pairs, &singles, data.uneven.as_deref());
    }
    let alone: Vec<&Weighed> = singles.iter().flat_map(|(_, w)| w).collect();
    let unknown_with =
        |pairs: &[Weighed]| log_unknown(data, setup.kind, &plain, &null_weighed, &alone, pairs);
    let log_unknown = unknown_with(&pairs);
    let log_unknown_alone = unknown_with(&[]).min(log_unknown);
    let fitted = match setup.kind {
        LogKind::Rig => fitted,
        LogKind::Drive | LogKind::Kinematic => null_weighed.plain.clone(),
    };

    let rivals = Rivals {
        null,
        fitted,
        given,
        noise,
        null_weighed,
        screen,
        singles,
        structures: found.weighed,
        other_soil,
        structures_out,
        pairs,
        beside,
        behind,
        log_unknown,
        log_unknown_alone,
        not_asked,
        measured: None,
        heed: vec![],
    };
    Ok(Outcome::found(Ok((rivals, predictor))))
}

/// The single causes with their formulas left free where the data ask for it, and which were asked; only those of `before`.
fn reshape(
    data: &DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    null: &Hypothesis,
    round: &Round,
    before: Option<&[Named]>,
) -> (Vec<(usize, Vec<Weighed>)>, Vec<Named>) {
    let ground = Ground {
        data,
        predictor,
        setup,
        null,
        levels: &round.levels,
        whitener: &round.plain,
    };
    let (nominal, pairs) = (&round.null_weighed, &round.pairs);
    let alone: Vec<&Weighed> = round.singles.iter().flat_map(|(_, w)| w).collect();
    let unknown = log_unknown(data, setup.kind, &round.plain, nominal, &alone, pairs);
    let rival = pairs.iter().map(|w| w.log_evidence).fold(unknown, f64::max);
    let mut singles = round.singles.clone();
    let effects = (round.screen.as_slice(), round.asked.as_slice());
    let asked = ask_again(
        &ground,
        effects,
        &mut singles,
        pairs,
        nominal,
        rival,
        before,
    );
    (singles, asked)
}

/// True for an effect by a formula of its own.
fn is_free(rival: &Weighed) -> bool {
    let mut effects = rival.hypothesis.effects().iter();
    effects.any(|e| is_made(e.form()))
}

/// Takes out the pairs that need no second cause, because one cause by another formula explains nearly as much, or any does on
/// uneven ground, whose waves a second one follows too, and gives back those that explain more than it.
fn take_needless(
    pairs: &mut Vec<Weighed>,
    singles: &[(usize, Vec<Weighed>)],
    uneven: Option<&Uneven>,
) -> Vec<Weighed> {
    let by_evidence = |a: &&Weighed, b: &&Weighed| a.log_evidence.total_cmp(&b.log_evidence);
    let best = singles.iter().flat_map(|(_, w)| w).max_by(by_evidence);
    // One that is behind another cause is not the answer instead of the two.
    let needed = |w: &Weighed| match uneven {
        _ if is_free(w) => Some(FORMULA),
        Some(uneven) => Some(uneven.comes_to()),
        None => None,
    };
    let Some((alone, more)) = best.and_then(|w| Some((w.log_evidence, needed(w)?))) else {
        return vec![];
    };
    let (needed, mut needless): (Vec<_>, Vec<_>) = pairs
        .drain(..)
        .partition(|pair| pair.log_evidence > alone + more);
    *pairs = needed;
    needless.retain(|pair| pair.log_evidence > alone);
    needless
}

/// ln Z of something unknown: a discrepancy larger than any hypothesis may use, on top of explanations that are not adequate
/// by themselves. An adequate one with a larger discrepancy is still that explanation.
fn log_unknown(
    data: &DataSet,
    kind: LogKind,
    plain: &Whitener,
    null: &Weighed,
    singles: &[&Weighed],
    pairs: &[Weighed],
) -> f64 {
    let by_evidence = |a: &&Weighed, b: &&Weighed| a.log_evidence.total_cmp(&b.log_evidence);
    let mut bases = singles.to_vec();
    descending(&mut bases, |w| w.log_evidence);
    bases.truncate(3);
    bases.retain(|w| kind == LogKind::Drive || w.chi2_per_value() > ADEQUATE);
    bases.push(null);
    let discrepancy = unknown::Discrepancy::new(data, plain);
    let smooth =
        |w: &&Weighed| w.plain_log_evidence + discrepancy.gain(&w.plain, unknown_amplitudes(kind));
    let smooth = bases.iter().map(smooth).fold(f64::NEG_INFINITY, f64::max);
    if kind != LogKind::Drive {
        return smooth;
    }
    // On a rig a discrepancy inside every hypothesis takes up what scatters beyond the noise.
    let best_pair = pairs.iter().max_by(by_evidence);
    let out = bases
        .into_iter()
        .chain(best_pair)
        .map(|w| w.plain_log_evidence + unknown::scatter_gain(data, &w.plain))
        .fold(smooth, f64::max);
    // An explanation that follows the data to the noise is not made unknown by what windows and first orders leave over.
    let best = singles.iter().copied().chain(pairs).max_by(by_evidence);
    match best.filter(|w| w.chi2_per_value() < ADEQUATE_DRIVE) {
        Some(best) => out.min(best.log_evidence - BEHIND_ADEQUATE),
        None => out,
    }
}
