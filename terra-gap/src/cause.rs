//! From evidences to probabilities, and the set of answers that holds 90 % of them.

use std::cmp::Ordering;

use terra_model::order::descending;

use crate::calibration::{Calibration, Evidence, Weight, best_behind};
use crate::candidates::is_instrument;
use crate::evidence::log_sum_exp;
use crate::forms::{FREE, is_made};
use crate::rivals::Rivals;
use crate::settings::{LogKind, Settings};
use crate::setup::{ADEQUATE, LOOK_ALIKE, Setup};
use crate::weigh::Weighed;

/// What kind of answer a cause is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CauseKind {
    /// One effect.
    Effect,
    /// Several effects together.
    Combination,
    /// Another terrain model, or other soil than a baseline's.
    Structure,
}

/// One rival explanation with its probability.
#[derive(Clone, Debug)]
pub struct Cause {
    /// `effect`, `effect+effect` (alphabetical), or `structure:model`.
    pub name: String,
    /// Kind.
    pub kind: CauseKind,
    /// Probability among all answers.
    pub probability: f64,
    /// ln Z less that of the nominal model.
    pub log_evidence_gain: f64,
    /// Share of its signature that a re-fit of the soil absorbs; none for structures and combinations.
    pub absorbed: Option<f64>,
    /// λ = h s²: how much of it this data could show.
    pub power: Option<f64>,
    /// Form with the largest evidence.
    pub form: String,
    /// Effects with nearly the same signature on this data.
    pub indistinguishable_from: Vec<String>,
    /// Of two causes: one would do, and what this log shows neither asks for the other nor rules it out.
    pub unseen_second: bool,
    /// Told beside other soil than a baseline's: both differ.
    pub on_other_soil: bool,
    /// Best-fitting version.
    pub weighed: Weighed,
}

/// All answers with their probabilities.
#[derive(Clone, Debug)]
pub(crate) struct Ranking {
    /// Sorted by probability.
    pub causes: Vec<Cause>,
    /// Probability that nothing is missing.
    pub probability_none: f64,
    /// Probability that something unknown is.
    pub probability_unknown: f64,
    /// Smallest set of answers that holds the truth in 90 % of calibration cases.
    pub set: Vec<String>,
    /// Probability of two answers together that stand for each other, and why they do.
    pub stand_in: Option<(f64, &'static str)>,
    /// The first cause, where it leaves a little over that something unknown explains.
    pub nearly: Option<String>,
    /// True where the explanation that leads still misfits.
    pub misfits: bool,
    /// Gain \[nats\] of the best explanation, a second cause counting where it has earned its place.
    pub heard: f64,
    /// One cause, the same with a second one that this log hardly shows, and the part of its probability that they have.
    unseen: Vec<(String, String, f64)>,
}

/// Nats by which another form must be better for a cause to be told by it: up to there its magnitude is told by the usual formula,
/// in which it is known. Not so where a formula is left free, which is told for what it is.
const ANOTHER_FORM: f64 = 3.0;
/// Prior of a pair relative to a single.
const PAIR_PRIOR: f64 = 0.1;

/// All answers with their priors and evidences, before any of them has a probability.
pub(crate) struct Answers {
    causes: Vec<Cause>,
    /// Of every cause, then of none, then of unknown.
    weights: Vec<Weight>,
    /// The effect that says most on other soil than a baseline's, and the one of the ground that says most on the baseline's.
    beside_soil: [Option<String>; 2],
    /// The nominal model misfits by more than noise and parameters explain.
    inadequate_null: bool,
}

impl Answers {
    /// Gathers all rivals.
    pub(crate) fn new(rivals: &Rivals, settings: &Settings, setup: &Setup<'_>) -> Self {
        let kind = setup.kind;
        let null = &rivals.null_weighed;
        let mut causes = singles(rivals);
        let whole = |name: String, kind, w: &Weighed| Cause {
            name,
            kind,
            probability: 0.0,
            log_evidence_gain: w.log_evidence - null.log_evidence,
            absorbed: None,
            power: None,
            form: "default".to_owned(),
            indistinguishable_from: vec![],
            unseen_second: false,
            on_other_soil: false,
            weighed: w.clone(),
        };
        causes.extend(
            rivals
                .structures
                .iter()
                .map(|(name, w)| whole(name.clone(), CauseKind::Structure, w)),
        );
        causes.extend(
            rivals
                .pairs
                .iter()
                .chain(unseen(rivals))
                .chain(&rivals.behind)
                .map(|w| whole(w.hypothesis.effect_name(), CauseKind::Combination, w)),
        );
        // By motion alone there is no wheel law to be another.
        let of_the_ground = match kind {
            LogKind::Kinematic => None,
            LogKind::Rig | LogKind::Drive => of_the_ground(&causes),
        };
        let beside_soil = [rivals.other_soil.first(), of_the_ground];
        rivals.other_soil.tell(&mut causes, null.log_evidence);
        let shares: Vec<f64> = causes
            .iter()
            .map(|c| match c.kind {
                CauseKind::Combination => PAIR_PRIOR,
                _ => 1.0,
            })
            .collect();
        let last_answer = causes.len() + 1;
        let (none, unknown) = (settings.gap.prior_none, settings.gap.prior_unknown);
        // What was set aside on the way held its share of the prior too.
        let mut aside: Vec<&str> = rivals
            .screen
            .iter()
            .map(|s| s.name.as_str())
            .filter(|name| causes.iter().all(|c| c.name != *name))
            .collect();
        aside.sort_unstable();
        aside.dedup();
        let others = aside.len() + rivals.structures_out;
        let rest =
            (1.0 - none - unknown).max(0.0) / (shares.iter().sum::<f64>() + others as f64).max(1.0);
        let two = |c: &Cause| c.kind == CauseKind::Combination;
        let alone_at = |effect: &str| {
            let mut all = causes.iter();
            all.position(|c| c.kind == CauseKind::Effect && c.name == effect)
        };
        let parts = |c: &Cause| -> [Option<usize>; 2] {
            let (a, b) = c.name.split_once('+').unwrap_or_default();
            [alone_at(a), alone_at(b)]
        };
        let stands = |k: usize| causes[k].log_evidence_gain;
        let first_behind = causes.len() - rivals.behind.len();
        // What they are behind: the one cause that says most by another formula.
        let leader = (0..causes.len())
            .filter(|k| is_made(&causes[*k].form))
            .max_by(|a, b| {
                let gain = |k: &usize| causes[*k].log_evidence_gain;
                gain(a).total_cmp(&gain(b))
            });
        let mut weights: Vec<Weight> = causes
            .iter()
            .zip(&shares)
            .enumerate()
            .map(|(k, (c, share))| {
                let behind = (k >= first_behind).then(|| leader.unwrap_or(last_answer));
                let two = two(c) && behind.is_none();
                let alone = if two { parts(c) } else { [None; 2] };
                let first = alone.into_iter().flatten();
                let first = first.max_by(|a, b| stands(*a).total_cmp(&stands(*b)));
                let beside = first.and_then(|k| {
                    let mut all = rivals.beside.iter();
                    let beside =
                        all.find(|b| b.first == causes[k].name && !is_made(&causes[k].form))?;
                    Some((k, beside.share(&c.weighed)))
                });
                // A pair that was not fitted has not earned its place, whatever the tangent promises.
                let unfitted = first.filter(|_| !c.weighed.fitted);
                Weight {
                    ln_prior: (share * rest).ln(),
                    gain: c
                        .log_evidence_gain
                        .min(unfitted.map_or(f64::INFINITY, stands)),
                    // On a rig it was held against the noise alone too, which its gain does not show.
                    second: two && kind == LogKind::Drive,
                    // A part that was not weighed by itself leaves its share to unknown.
                    parts: two.then_some(match alone {
                        [Some(a), Some(b)] => [a, b],
                        _ => [last_answer; 2],
                    }),
                    beside,
                    free: c.form == FREE,
                    behind,
                    misfits: kind != LogKind::Drive && c.weighed.chi2_per_value() > ADEQUATE,
                    without_pairs: None,
                }
            })
            .collect();
        let alone = |prior: f64, gain| Weight {
            ln_prior: prior.ln(),
            gain,
            second: false,
            parts: None,
            beside: None,
            free: false,
            behind: None,
            misfits: false,
            without_pairs: None,
        };
        // What the nominal law explains by a smooth error of its form that is larger than usual is not nothing: something is
        // missing. Against another simulator that error was learned from its log.
        let usual = match setup.inherited {
            None if kind == LogKind::Rig && unknown > 0.0 => null.usual.min(1.0),
            _ => 1.0,
        };
        let known = rivals.log_unknown - null.log_evidence;
        let bent = match usual < 1.0 {
            true => (none / unknown).ln() + (1.0 - usual).ln(),
            false => f64::NEG_INFINITY,
        };
        let without_pairs = rivals.log_unknown_alone - null.log_evidence;
        weights.push(alone(none, usual.ln()));
        weights.push(Weight {
            without_pairs: Some(log_sum_exp([without_pairs, bent])),
            ..alone(unknown, log_sum_exp([known, bent]))
        });
        for w in &mut weights {
            // An explanation with no probability at all has no finite evidence.
            if !w.gain.is_finite() {
                w.gain = f64::MIN;
            }
            w.without_pairs = w.without_pairs.filter(|gain| gain.is_finite());
        }
        Answers {
            causes,
            weights,
            beside_soil,
            // "None" means nothing beyond noise and parameters. Where only a discrepancy of form makes the nominal model
            // fit, what is missing is unknown.
            inadequate_null: kind == LogKind::Rig && null.chi2_per_value() > ADEQUATE,
        }
    }

    /// The answers without their fits.
    pub(crate) fn evidence(&self) -> Evidence {
        let mut names: Vec<String> = self.causes.iter().map(|c| c.name.clone()).collect();
        names.extend(["none".to_owned(), "unknown".to_owned()]);
        Evidence {
            names,
            weights: self.weights.clone(),
        }
    }

    /// Probabilities under a calibration, and the set of answers.
    pub(crate) fn rank(self, calibration: &Calibration) -> Ranking {
        let p = calibration.together(&self.weights);
        let mut said = calibration.said(&self.weights);
        let mut causes = self.causes;
        let misfits = calibration.led_by_a_misfit(&self.weights);
        let heard = calibration.heard(&self.weights);
        let nearly = calibration.nearly(&self.weights);
        let nearly = nearly.map(|k| causes[k].name.clone());
        // By the name of one cause by a free formula: two causes that say a little more.
        let behind: Vec<(String, String)> = (0..causes.len())
            .filter_map(|k| Some((k, best_behind(&self.weights, k)?)))
            .map(|(k, pair)| (causes[k].name.clone(), causes[pair].name.clone()))
            .collect();
        for (c, p) in causes.iter_mut().zip(&p) {
            c.probability = *p;
        }
        let mut unseen = vec![];
        for (first, both, part) in calibration.unseen(&self.weights) {
            causes[both].unseen_second = true;
            unseen.push((causes[first].name.clone(), causes[both].name.clone(), part));
        }
        let (mut probability_none, mut probability_unknown) =
            (p[causes.len()], p[causes.len() + 1]);
        let (none, unknown) = (causes.len(), causes.len() + 1);
        if self.inadequate_null {
            probability_unknown += probability_none;
            probability_none = 0.0;
            said[unknown] += said[none];
            said[none] = 0.0;
        }
        let names = causes.iter().map(|c| (c.name.clone(), c.unseen_second));
        let others = ["none", "unknown"].map(|name| (name.to_owned(), false));
        let mut answers: Vec<(f64, String)> = names
            .chain(others)
            .zip(&said)
            .filter(|((_, unseen), _)| !unseen)
            .map(|((name, _), said)| (*said, name))
            .collect();
        causes.sort_by(by_probability);
        descending(&mut answers, |a| a.0);
        let best = answers.first().map_or(0.0, |(best, _)| *best);
        let in_set = answers
            .into_iter()
            .filter(|(said, _)| calibration.holds(*said, best));
        let set: Vec<String> = in_set.map(|(_, name)| name).collect();
        let mut ranking = Ranking {
            causes,
            probability_none,
            probability_unknown,
            set,
            stand_in: None,
            nearly: None,
            misfits,
            heard,
            unseen,
        };
        let [with_it, by_itself] = &self.beside_soil;
        ranking.stand_in(with_it.as_deref(), by_itself.as_deref());
        if misfits {
            // What comes nearest is said beside `unknown`.
            ranking.add(ranking.causes.first().map(|c| c.name.clone()));
        }
        // A formula left free takes the place of what no library knows, or of a second cause, as easily as it is the cause's own;
        // so does one that leaves a little over.
        let top = ranking.causes.first();
        let top = top.filter(|c| ranking.set.first() == Some(&c.name));
        if let Some(name) = top.map(|c| c.name.clone()) {
            let free = top.is_some_and(|c| c.form == FREE);
            ranking.nearly = nearly.filter(|n| *n == name);
            if free || ranking.nearly.is_some() {
                let pair = behind.into_iter().find(|(single, _)| *single == name);
                ranking.add(pair.map(|(_, pair)| pair));
                ranking.doubt();
            }
        }
        ranking
    }
}

impl Ranking {
    /// Gives what may stand unseen beside a cause its part. The verdict is on the cause, whatever else is there unseen.
    pub(crate) fn tell_unseen(&mut self) {
        let mut moved = vec![];
        for (first, both, part) in &self.unseen {
            let of = self.causes.iter().find(|c| c.name == *first);
            moved.push((first, both, part * of.map_or(0.0, |c| c.probability)));
        }
        for c in &mut self.causes {
            for (first, both, p) in &moved {
                if c.name == **first {
                    c.probability -= p;
                } else if c.name == **both {
                    c.probability += p;
                }
            }
        }
        self.causes.sort_by(by_probability);
    }

    /// Puts `unknown` beside what the set holds.
    fn doubt(&mut self) {
        self.add(Some("unknown".to_owned()));
    }

    /// What leads may stand for a cause that is in no library: `unknown` has a share of its probability, by which it still leads,
    /// and is in the set.
    pub(crate) fn doubt_leading(&mut self, share: f64) {
        if let [top, others @ ..] = &mut self.causes[..]
            && top.kind != CauseKind::Structure
        {
            let next = others.first().map_or(0.0, |c| c.probability);
            let moved = (share * top.probability).min(top.probability - next);
            top.probability -= moved;
            self.probability_unknown += moved;
        }
        self.doubt();
    }

    /// A cause of which the data say nothing may stand for another soil than the rover file's, or for the ground's waves: nothing missing has a share of its
    /// probability, by which it still leads, and is in the set.
    pub(crate) fn doubt_start(&mut self, share: f64) {
        if self.set.iter().any(|answer| answer == "none") {
            return;
        }
        if let [top, others @ ..] = &mut self.causes[..] {
            let next = others.first().map_or(0.0, |c| c.probability);
            let next = next.max(self.probability_unknown);
            let moved = (share * top.probability).min((top.probability - next).max(0.0));
            top.probability -= moved;
            self.probability_none += moved;
        }
        self.add(Some("none".to_owned()));
    }

    /// Puts an answer into the set.
    pub(crate) fn add(&mut self, answer: Option<String>) {
        if let Some(answer) = answer.filter(|name| !self.set.contains(name)) {
            self.set.push(answer);
        }
    }
}

/// The effect of the ground that says most.
fn of_the_ground(causes: &[Cause]) -> Option<String> {
    let of_it = |c: &&Cause| {
        let mut effects = c.weighed.hypothesis.effects().iter();
        c.kind == CauseKind::Effect && effects.all(|e| !is_instrument(&**e))
    };
    let all = causes.iter().filter(of_it);
    let most = all.max_by(|a, b| a.log_evidence_gain.total_cmp(&b.log_evidence_gain));
    most.map(|c| c.name.clone())
}

/// The more probable first. Where something unknown takes all, the floor leaves all causes alike: their evidences still order
/// them.
pub(crate) fn by_probability(a: &Cause, b: &Cause) -> Ordering {
    b.probability
        .total_cmp(&a.probability)
        .then_with(|| b.log_evidence_gain.total_cmp(&a.log_evidence_gain))
        .then_with(|| a.name.cmp(&b.name))
}

/// ln of the mean evidence of one name: half of its prior is the nominal structure's, shared by the forms; the other half is
/// shared by all else.
fn averaged(forms: &[(usize, &Weighed)], nominal: &str) -> f64 {
    let (own, other): (Vec<f64>, Vec<f64>) = forms.iter().fold((vec![], vec![]), |mut sides, f| {
        let side = if f.1.hypothesis.law.model().name() == nominal {
            &mut sides.0
        } else {
            &mut sides.1
        };
        side.push(f.1.log_evidence);
        sides
    });
    let mean = |of: &[f64]| log_sum_exp(of.iter().copied()) - (of.len() as f64).ln();
    match (own.is_empty(), other.is_empty()) {
        (false, false) => log_sum_exp([mean(&own), mean(&other)]) - std::f64::consts::LN_2,
        (false, true) => mean(&own),
        (true, _) => mean(&other),
    }
}

/// Pairs whose second cause was not asked for, each once.
fn unseen(rivals: &Rivals) -> impl Iterator<Item = &Weighed> {
    let mut names: Vec<String> = rivals
        .pairs
        .iter()
        .map(|w| w.hypothesis.effect_name())
        .collect();
    names.extend(rivals.behind.iter().map(|w| w.hypothesis.effect_name()));
    let all = rivals.beside.iter().flat_map(|b| &b.unseen);
    all.filter(move |w| {
        let name = w.hypothesis.effect_name();
        let new = !names.contains(&name);
        names.push(name);
        new
    })
}

/// The form that a cause is told in: the usual one, where the best is no better by more than chance.
fn usual_form<'a>(
    forms: &[(usize, &'a Weighed)],
    best: (usize, &'a Weighed),
) -> (usize, &'a Weighed) {
    let all = |w: &Weighed, is: fn(&str) -> bool| {
        let mut effects = w.hypothesis.effects().iter();
        effects.all(|e| is(e.form()))
    };
    let near = |w: &Weighed| w.log_evidence >= best.1.log_evidence - ANOTHER_FORM;
    if all(best.1, is_made) {
        return best;
    }
    let usual = forms
        .iter()
        .filter(|(_, w)| all(w, |form| form == "default") && near(w));
    let usual = usual.max_by(|a, b| a.1.log_evidence.total_cmp(&b.1.log_evidence));
    usual.copied().unwrap_or(best)
}

/// Single effects, averaged over forms and structures under one name.
fn singles(rivals: &Rivals) -> Vec<Cause> {
    let (singles, screen) = (&rivals.singles, &rivals.screen);
    let mut names: Vec<&str> = singles
        .iter()
        .map(|(k, _)| screen[*k].name.as_str())
        .collect();
    names.sort_unstable();
    names.dedup();
    let mut causes = vec![];
    for name in names {
        let forms: Vec<(usize, &Weighed)> = singles
            .iter()
            .filter(|(k, _)| screen[*k].name == name)
            .flat_map(|(k, w)| w.iter().map(move |w| (*k, w)))
            .collect();
        let Some((k, best)) = forms
            .iter()
            .max_by(|a, b| a.1.log_evidence.total_cmp(&b.1.log_evidence))
        else {
            continue;
        };
        let (k, best) = usual_form(&forms, (*k, *best));
        let evidence = averaged(&forms, rivals.null.law.model().name());
        let score = &screen[k].score;
        let mut alike: Vec<String> = vec![];
        for s in screen {
            let same = s.name != name && s.score.cosine(score).abs() > LOOK_ALIKE;
            if same && !alike.contains(&s.name) {
                alike.push(s.name.clone());
            }
        }
        let s = best.fit.x.get(best.hypothesis.soil_len());
        let s = s.copied().unwrap_or(0.0);
        causes.push(Cause {
            name: name.to_owned(),
            kind: CauseKind::Effect,
            probability: 0.0,
            log_evidence_gain: evidence - rivals.null_weighed.log_evidence,
            absorbed: Some(score.absorbed),
            power: Some(score.information * s * s),
            form: best
                .hypothesis
                .effects()
                .first()
                .map_or_else(String::new, |e| e.form().to_owned()),
            indistinguishable_from: alike,
            unseen_second: false,
            on_other_soil: false,
            weighed: best.clone(),
        });
    }
    causes
}
