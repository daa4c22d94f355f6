//! From evidences to probabilities that mean what they say: a temperature, a threshold and the width of the set, learned
//! from cases whose truth was known.
//!
//! # Equation
//! P_k = (1 - ε) π_k exp(g_k / T) / Σ + ε π_k, g = ln Z - ln Z of the nominal model: with probability ε the evidence says
//! nothing, as where the truth is no hypothesis at all. Two causes that follow a log together may stand for one of them in
//! another form, or for what is in no library: a share δ of a pair's probability goes to unknown by one half and by the
//! other to the part that says more alone. An effect whose formula had to be left free may stand for one that is in no
//! library as well: a share of its probability goes to unknown, by choice, or by half to the best two causes that say a
//! little more than it. Where something unknown says more than all causes, but one cause alone leaves over no more than a
//! tolerated share of it, the remainder is an error of that cause's formula as easily: unknown keeps the same share of its
//! probability, and the cause has the rest. An explanation that itself misfits by more than is adequate keeps little: the
//! rest of its probability is unknown's. A second cause needs a gain γ over the best single one: chosen among hundreds of
//! pairs, it gains by chance. T, ε, δ and γ minimise Σ -ln P(truth), γ only where cases with two causes say what it costs, else
//! it is the 95 % quantile of what needless ones gained. The set is the smallest whose probability reaches the level that held
//! the truth in 90 % of the cases, .75 at least, or else all that the floor leaves; a name needs a gain above the 95 % quantile
//! of what the best effect gained on cases without any.
//!
//! # Reference
//! C. Guo et al., ICML 2017 (temperature); V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World, 2005
//! (the set's level).

use serde::{Deserialize, Serialize};

use crate::error::GapError;
use crate::evidence::log_sum_exp;
use crate::settings::LogKind;
use terra_model::order::ascending;

/// How raw evidences become probabilities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Kind of design it was made for: `ramp`, `rich`, `rig`, `contrast` or `kinematic`.
    pub design: String,
    /// T: 1 takes evidences as they are.
    pub temperature: f64,
    /// ε: how often evidence, however strong, says nothing.
    #[serde(default)]
    pub floor: f64,
    /// δ: how often two causes stand for something else.
    #[serde(default)]
    pub pair_doubt: f64,
    /// Share of the probability of an effect by a free formula that goes to what it may stand for: a choice, not learned.
    #[serde(default)]
    pub free_doubt: f64,
    /// Share of what something unknown explains that one cause may leave over and still be the cause, by another formula: a
    /// choice, not learned.
    #[serde(default)]
    pub form_tolerance: f64,
    /// Share of the probability of an explanation that misfits which goes to unknown: a choice, not learned.
    #[serde(default)]
    pub misfit_doubt: f64,
    /// Probability that a set must reach to hold the truth in 90 % of cases.
    pub set_probability: f64,
    /// Gain \[nats\] that the best effect stays below on 95 % of logs without any.
    pub null_gain: f64,
    /// γ \[nats\]: what a second cause must add to the best one alone.
    pub second_gain: f64,
    /// Cases it was made from; 0 when it is a choice.
    pub cases: usize,
    /// Where it comes from.
    pub source: String,
}

/// One answer before calibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Weight {
    pub(crate) ln_prior: f64,
    /// ln Z less that of the nominal model.
    pub(crate) gain: f64,
    /// It holds a second cause, which must earn its place.
    pub(crate) second: bool,
    /// Where its two causes stand alone among the answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<[usize; 2]>,
    /// It needs a formula that was left free.
    #[serde(default)]
    pub(crate) free: bool,
    /// Two causes that do little more than one by a free formula: where that one stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) behind: Option<usize>,
    /// With it the data still misfit by more than is adequate.
    #[serde(default)]
    pub(crate) misfits: bool,
}

impl Weight {
    fn is_alone(&self) -> bool {
        !self.second && self.behind.is_none()
    }
}

/// Of the pairs that say a little more than the cause at `k` by a free formula, the one that says most.
pub(crate) fn best_behind(weights: &[Weight], k: usize) -> Option<usize> {
    let behind = (0..weights.len()).filter(|i| weights[*i].behind == Some(k));
    behind.max_by(|a, b| weights[*a].gain.total_cmp(&weights[*b].gain))
}

/// All answers of one diagnosis with their priors and evidences: the causes, then none, then unknown.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Evidence {
    pub(crate) names: Vec<String>,
    pub(crate) weights: Vec<Weight>,
}

impl Evidence {
    /// A case for calibration, the truth being known: an effect, `effect+effect`, `none` or `unknown`. A truth that was not
    /// among the answers counts as unknown.
    pub fn case(&self, truth: &str) -> Case {
        let last = self.names.len().saturating_sub(1);
        Case {
            truth: self.names.iter().position(|n| n == truth).unwrap_or(last),
            causes: self.names.len().saturating_sub(2),
            weights: self.weights.clone(),
            another_form: false,
        }
    }
}

/// One case with known truth.
#[derive(Clone, Debug)]
pub struct Case {
    /// Index of the true answer.
    pub(crate) truth: usize,
    /// Number of causes: after them come none and unknown.
    pub(crate) causes: usize,
    /// Every answer.
    pub(crate) weights: Vec<Weight>,
    /// The truth has another form than any answer.
    pub(crate) another_form: bool,
}

impl Case {
    /// The same case, its effect being in a form that no answer has: a second cause is not needless there.
    #[must_use]
    pub fn in_another_form(self) -> Self {
        Case {
            another_form: true,
            ..self
        }
    }

    /// The largest gain of one cause, or of two.
    fn best(&self, second: bool) -> Option<f64> {
        let causes = self.weights.iter().take(self.causes);
        causes
            .filter(|w| if second { w.second } else { w.is_alone() })
            .map(|w| w.gain)
            .max_by(f64::total_cmp)
    }

    fn is_null(&self) -> bool {
        self.truth == self.causes
    }

    /// What a second cause gained although there was one alone.
    fn needless_gain(&self) -> Option<f64> {
        let single = self
            .weights
            .get(self.truth)
            .is_some_and(|w| w.is_alone() && self.truth < self.causes && !self.another_form);
        single.then(|| Some(self.best(true)? - self.best(false)?))?
    }
}

/// Frozen calibrations, with the campaigns that made them.
const FROZEN: &str = include_str!("calibration.toml");
/// Manoeuvres from which a drive counts as rich.
const RICH: usize = 5;
const HIGHEST_TEMPERATURE: f64 = 30.0;
/// Floors that are tried.
const FLOORS: [f64; 9] = [0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2];
/// Doubts that are tried.
const DOUBTS: [f64; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Gains \[nats\] of a second cause that are tried: up to the last, in steps of one half.
const SECOND_GAINS: u32 = 40;
/// Loss \[nats\] over all cases by which two such gains are as good as each other.
const FLAT: f64 = 0.01;
/// Probability that every set reaches: where most cases are clear the truth is held often enough by first answers alone, and
/// a case that is not clear would be answered by a name as probable as a coin's side.
const LEAST_SET: f64 = 0.75;
/// Cases with two causes from which they say what asking more of a second one costs.
const ENOUGH_PAIRS: usize = 20;

#[derive(Deserialize)]
struct Table {
    design: Vec<Calibration>,
}

impl Calibration {
    /// The frozen one for this kind of log, by its number of manoeuvres or trials.
    ///
    /// # Errors
    /// A file of calibrations that cannot be read.
    pub fn frozen(kind: LogKind, groups: usize) -> Result<Self, GapError> {
        Self::named(match kind {
            LogKind::Rig => "rig",
            LogKind::Kinematic => "kinematic",
            LogKind::Drive if groups >= RICH => "rich",
            LogKind::Drive => "ramp",
        })
    }

    /// The frozen one for a rig's log against an outside simulator's.
    ///
    /// # Errors
    /// As [`frozen`](Self::frozen).
    pub fn frozen_contrast() -> Result<Self, GapError> {
        Self::named("contrast")
    }

    fn named(name: &str) -> Result<Self, GapError> {
        let table: Table =
            toml::from_str(FROZEN).map_err(|e| GapError::Calibration(e.to_string()))?;
        table
            .design
            .into_iter()
            .find(|c| c.design == name)
            .ok_or_else(|| GapError::Calibration(format!("no design {name}")))
    }

    /// A row of the file of calibrations.
    ///
    /// # Errors
    /// Numbers that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, GapError> {
        #[derive(Serialize)]
        struct Row<'a> {
            design: [&'a Calibration; 1],
        }
        toml::to_string(&Row { design: [self] }).map_err(|e| GapError::Calibration(e.to_string()))
    }

    /// Probabilities of answers.
    pub(crate) fn probabilities(&self, weights: &[Weight]) -> Vec<f64> {
        let alone = weights.iter().filter(|w| w.is_alone()).map(|w| w.gain);
        let bar = alone.fold(f64::NEG_INFINITY, f64::max) + self.second_gain;
        let logs: Vec<f64> = weights
            .iter()
            .map(|w| {
                if w.behind.is_some() || (w.second && w.gain < bar) {
                    f64::NEG_INFINITY
                } else {
                    w.ln_prior + w.gain / self.temperature
                }
            })
            .collect();
        let total = log_sum_exp(logs.iter().copied());
        let prior = log_sum_exp(weights.iter().map(|w| w.ln_prior));
        let mut said: Vec<f64> = logs.iter().map(|l| (l - total).exp()).collect();
        for (k, w) in weights.iter().enumerate() {
            let Some(parts) = w.parts else {
                continue;
            };
            let moved = self.pair_doubt * said[k];
            said[k] -= moved;
            let gain = |part: usize| weights.get(part).map_or(f64::NEG_INFINITY, |w| w.gain);
            let part = parts[usize::from(gain(parts[1]) > gain(parts[0]))];
            // Unknown is the last answer.
            for to in [weights.len() - 1, part] {
                said[to] += 0.5 * moved;
            }
        }
        for (k, _) in weights.iter().enumerate().filter(|(_, w)| w.free) {
            let moved = self.free_doubt * said[k];
            said[k] -= moved;
            let behind = best_behind(weights, k).unwrap_or(weights.len() - 1);
            for to in [weights.len() - 1, behind] {
                said[to] += 0.5 * moved;
            }
        }
        for (k, _) in weights.iter().enumerate().filter(|(_, w)| w.misfits) {
            let moved = self.misfit_doubt * said[k];
            said[k] -= moved;
            said[weights.len() - 1] += moved;
        }
        if let Some(k) = self.nearly(weights) {
            let moved = (1.0 - self.free_doubt) * said[weights.len() - 1];
            said[weights.len() - 1] -= moved;
            said[k] += moved;
        }
        weights
            .iter()
            .zip(said)
            .map(|(w, said)| {
                let before = (w.ln_prior - prior).exp();
                said + self.floor * (before - said)
            })
            .collect()
    }

    /// True where an explanation that misfits would lead, were it not doubted for that.
    pub(crate) fn led_by_a_misfit(&self, weights: &[Weight]) -> bool {
        let trusting = Calibration {
            misfit_doubt: 0.0,
            ..self.clone()
        };
        let p = trusting.probabilities(weights);
        let first = (0..p.len()).max_by(|a, b| p[*a].total_cmp(&p[*b]));
        first.is_some_and(|k| weights[k].misfits)
    }

    /// The one cause that leaves over so little of what something unknown explains, and this more than all causes, that its
    /// formula may be what is wrong.
    pub(crate) fn nearly(&self, weights: &[Weight]) -> Option<usize> {
        let (unknown, others) = weights.split_last()?;
        let (_, causes) = others.split_last()?;
        let bar = (1.0 - self.form_tolerance) * unknown.gain;
        if self.form_tolerance == 0.0 || causes.iter().any(|w| w.gain >= unknown.gain) {
            return None;
        }
        let near = (0..causes.len()).filter(|k| causes[*k].is_alone() && causes[*k].gain >= bar);
        near.max_by(|a, b| causes[*a].gain.total_cmp(&causes[*b].gain))
    }

    /// Learns from cases; what they are too few to show stays as `fallback` has it. A case without answers, of a log that
    /// tells nothing, teaches nothing and is not counted.
    pub fn learn(cases: &[Case], fallback: &Calibration, source: String) -> Self {
        let cases: Vec<&Case> = cases.iter().filter(|c| !c.weights.is_empty()).collect();
        let mut out = Calibration {
            cases: cases.len(),
            source,
            ..fallback.clone()
        };
        if cases.is_empty() {
            return out;
        }
        let needless = cases.iter().filter_map(|c| c.needless_gain());
        let needless: Vec<f64> = needless.collect();
        if let Some(gain) = upper_quantile(&needless, 0.95) {
            out.second_gain = gain.max(0.0);
        }
        out.learn_doubts(&cases);
        let pairs = cases.iter().filter(|c| c.weights[c.truth].second);
        if pairs.count() >= ENOUGH_PAIRS {
            out.learn_second_gain(&cases);
            out.learn_doubts(&cases);
        }
        let levels: Vec<f64> = cases.iter().map(|c| out.level_of(c)).collect();
        if let Some(level) = upper_quantile(&levels, 0.9) {
            // What the floor spreads over all answers no set of a few can gather: it would name thirty to hold the few cases
            // in which evidence says nothing.
            out.set_probability = level.clamp(LEAST_SET, 1.0 - out.floor.max(0.001));
        }
        let nulls: Vec<f64> = cases
            .iter()
            .filter(|c| c.is_null())
            .filter_map(|c| c.best(false))
            .collect();
        if let Some(gain) = upper_quantile(&nulls, 0.95) {
            out.null_gain = gain.max(0.0);
        }
        out
    }

    /// Σ -ln P(truth).
    fn loss(&self, cases: &[&Case]) -> f64 {
        let surprise = |c: &&Case| -self.probabilities(&c.weights)[c.truth].max(1e-9).ln();
        cases.iter().map(surprise).sum()
    }

    /// Temperature, floor and doubt of pairs of the least loss, on a grid: it is smooth and its minimum broad.
    fn learn_doubts(&mut self, cases: &[&Case]) {
        let steps = 60;
        let mut best = f64::INFINITY;
        for (floor, pair_doubt) in FLOORS.iter().flat_map(|f| DOUBTS.map(|d| (*f, d))) {
            for k in 0..=steps {
                let mut trial = self.clone();
                (trial.floor, trial.pair_doubt) = (floor, pair_doubt);
                trial.temperature = HIGHEST_TEMPERATURE.powf(f64::from(k) / f64::from(steps));
                let loss = trial.loss(cases);
                if loss < best {
                    (best, *self) = (loss, trial);
                }
            }
        }
    }

    /// Gain of a second cause of the least loss. Between the largest needless gain and the least one of a true pair the loss
    /// is flat: the middle is as far from either mistake.
    fn learn_second_gain(&mut self, cases: &[&Case]) {
        let losses = (0..=SECOND_GAINS).map(|k| {
            let mut trial = self.clone();
            trial.second_gain = 0.5 * f64::from(k);
            (trial.second_gain, trial.loss(cases))
        });
        let losses: Vec<(f64, f64)> = losses.collect();
        let least = losses.iter().map(|l| l.1).fold(f64::INFINITY, f64::min);
        let flat: Vec<f64> = losses
            .iter()
            .filter(|l| l.1 <= least + FLAT)
            .map(|l| l.0)
            .collect();
        if let (Some(first), Some(last)) = (flat.first(), flat.last()) {
            self.second_gain = 0.5 * (first + last);
        }
    }

    /// Probability that must be gathered, best first, before the truth joins the set.
    fn level_of(&self, case: &Case) -> f64 {
        let p = self.probabilities(&case.weights);
        let truth = p[case.truth];
        // The set takes answers until the level is reached: what stands before the truth must fall short of it.
        p.iter().filter(|q| **q > truth).sum::<f64>() + 1e-9
    }
}

/// The smallest value not below a share of draws to come: the ceil((n + 1) share)-th; none where the draws are too few.
fn upper_quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    ascending(&mut sorted, |v| *v);
    let rank = ((values.len() + 1) as f64 * share).ceil() as usize;
    sorted.get(rank.checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> Calibration {
        Calibration {
            design: "test".to_owned(),
            temperature: 1.0,
            floor: 0.0,
            pair_doubt: 0.0,
            free_doubt: 0.0,
            form_tolerance: 0.0,
            misfit_doubt: 0.0,
            set_probability: 0.9,
            null_gain: 3.0,
            second_gain: 3.0,
            cases: 0,
            source: String::new(),
        }
    }

    fn single(ln_prior: f64, gain: f64) -> Weight {
        Weight {
            ln_prior,
            gain,
            second: false,
            parts: None,
            free: false,
            behind: None,
            misfits: false,
        }
    }

    /// Evidences that are right seven times out of ten whatever they claim: P(truth) must come out as .7.
    #[test]
    fn overconfident_evidence_is_cooled() {
        let half = 0.5f64.ln();
        let cases: Vec<Case> = (0..100)
            .map(|k| Case {
                truth: usize::from(k % 10 >= 7),
                causes: 2,
                weights: vec![single(half, 8.0), single(half, 0.0)],
                another_form: false,
            })
            .collect();
        let learned = Calibration::learn(&cases, &start(), "test".to_owned());
        let p = learned.probabilities(&cases[0].weights)[0];
        assert!((p - 0.7).abs() < 0.02, "{p}");
        // Three in ten truths stand behind .7 of probability: the set must go past it.
        assert!(learned.set_probability >= 0.68, "{learned:?}");
        assert_eq!(learned.null_gain, 3.0);
    }

    /// A log that tells nothing has no answers, and a case of it changes nothing.
    #[test]
    fn a_case_without_answers_teaches_nothing() {
        let cases = |silent: usize| -> Vec<Case> {
            let told = |k: usize| Case {
                truth: k % 2,
                causes: 1,
                weights: vec![single(-0.7, 5.0), single(-0.7, 0.0)],
                another_form: false,
            };
            let silent = (0..silent).map(|_| Evidence::default().case("slope"));
            (0..20).map(told).chain(silent).collect()
        };
        let learned = |silent| Calibration::learn(&cases(silent), &start(), "test".to_owned());
        assert_eq!(learned(3), learned(0));
        assert_eq!(learned(3).cases, 20);
        let nothing: Vec<Case> = cases(3).split_off(20);
        assert_eq!(
            Calibration::learn(&nothing, &start(), String::new()).cases,
            0
        );
    }

    /// Evidence of a hundred nats that is wrong once in ten: no temperature mends that, the floor does.
    #[test]
    fn what_no_hypothesis_knows_is_left_to_the_prior() {
        let half = 0.5f64.ln();
        let cases: Vec<Case> = (0..100)
            .map(|k| Case {
                truth: usize::from(k % 10 == 0),
                causes: 2,
                weights: vec![single(half, 100.0), single(half, 0.0)],
                another_form: false,
            })
            .collect();
        let learned = Calibration::learn(&cases, &start(), "test".to_owned());
        let p = learned.probabilities(&cases[0].weights);
        assert!((p[0] - 0.9).abs() < 0.02, "{learned:?} {p:?}");
        assert!((p[0] + p[1] - 1.0).abs() < 1e-12);
    }

    /// 95 % of 19 nulls lie at or below the largest: ceil(20 * .95) = 19.
    #[test]
    fn the_threshold_is_the_quantile_of_nulls() {
        let cases: Vec<Case> = (0..19)
            .map(|k| Case {
                truth: 1,
                causes: 1,
                weights: vec![single(0.0, f64::from(k) / 4.0), single(0.0, 0.0)],
                another_form: false,
            })
            .collect();
        let learned = Calibration::learn(&cases, &start(), String::new());
        assert_eq!(learned.null_gain, 4.5);
        assert_eq!(upper_quantile(&[1.0, 2.0], 0.95), None);
    }

    /// A second cause that gains less than it does where it is needless gets nothing; one that gains more is weighed.
    #[test]
    fn a_second_cause_must_earn_its_place() {
        let pair = |gain| Weight {
            ln_prior: -3.0,
            gain,
            second: true,
            parts: None,
            free: false,
            behind: None,
            misfits: false,
        };
        let c = start();
        assert_eq!(c.probabilities(&[single(-1.0, 10.0), pair(12.9)])[1], 0.0);
        let p = c.probabilities(&[single(-1.0, 10.0), pair(15.0)])[1];
        assert!((p - 1.0 / (1.0 + (2.0f64 - 5.0).exp())).abs() < 1e-12);
    }

    /// One cause beside which a needless second one gains up to 8 nats, two causes of which the second gains 16 or more: what is
    /// asked for lies between, nearer to neither. With one cause alone in every case it is the quantile of what is needless.
    #[test]
    fn what_a_second_cause_must_gain_weighs_both_mistakes() {
        let case = |pair: f64, two: bool| Case {
            truth: if two { 1 } else { 0 },
            causes: 2,
            weights: vec![
                single(-1.0, 10.0),
                Weight {
                    ln_prior: -3.0,
                    gain: 10.0 + pair,
                    second: true,
                    parts: Some([0, 0]),
                    free: false,
                    behind: None,
                    misfits: false,
                },
                single(-1.0, 0.0),
                single(-3.0, 0.0),
            ],
            another_form: false,
        };
        let mut cases: Vec<Case> = (0..80).map(|k| case(f64::from(k) / 10.0, false)).collect();
        let alone = Calibration::learn(&cases, &start(), "test".to_owned());
        assert!((alone.second_gain - 7.6).abs() < 1e-9, "{alone:?}");
        cases.extend((0..20).map(|k| case(16.0 + f64::from(k), true)));
        let both = Calibration::learn(&cases, &start(), "test".to_owned());
        assert!((9.0..15.0).contains(&both.second_gain), "{both:?}");
    }

    /// Pairs that are right half of the time and otherwise something unknown, in as strong a voice: half of their probability
    /// goes, and singles keep theirs.
    #[test]
    fn pairs_that_stand_for_something_else_are_doubted() {
        let weights = |pair: f64| {
            let second = Weight {
                ln_prior: -3.0,
                gain: pair,
                second: true,
                parts: Some([0, 1]),
                free: false,
                behind: None,
                misfits: false,
            };
            let none = single(-2.0, 0.0);
            vec![
                single(-2.0, 50.0),
                single(-2.0, 20.0),
                second,
                none,
                single(-2.0, 0.0),
            ]
        };
        let cases: Vec<Case> = (0..80)
            .map(|k| {
                let (truth, gain) = match k % 4 {
                    0 => (2, 150.0),
                    1 => (4, 150.0),
                    _ => (0, 40.0),
                };
                Case {
                    truth,
                    causes: 3,
                    weights: weights(gain),
                    another_form: false,
                }
            })
            .collect();
        let learned = Calibration::learn(&cases, &start(), "test".to_owned());
        let pair = learned.probabilities(&weights(150.0));
        assert!((0.3..0.6).contains(&pair[2]), "{learned:?} {pair:?}");
        assert!(
            (pair[4] - pair[0]).abs() < 1e-3 && pair[0] > 0.2 && pair[1] < 1e-3,
            "{pair:?}"
        );
        assert!((pair.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let one = learned.probabilities(&weights(40.0));
        assert!(one[0] > 0.98, "{learned:?} {one:?}");
    }

    /// Two fifths of what an effect by a free formula has go to unknown, the last answer, and all else stays.
    #[test]
    fn a_free_formula_leaves_a_share_to_unknown() {
        let half = 0.5f64.ln();
        let free = Weight {
            free: true,
            ..single(half, 40.0)
        };
        let weights = [
            free,
            single(half, 38.0),
            single(half, 0.0),
            single(half, 0.0),
        ];
        let plain = start().probabilities(&weights);
        let doubting = Calibration {
            free_doubt: 0.4,
            ..start()
        };
        let p = doubting.probabilities(&weights);
        assert!((p[0] - 0.6 * plain[0]).abs() < 1e-12);
        assert!((p[3] - plain[3] - 0.4 * plain[0]).abs() < 1e-12);
        assert_eq!(p[1..3], plain[1..3]);
        // Two causes that say a little more have half of it.
        let pair = Weight {
            behind: Some(0),
            ..single(half, 45.0)
        };
        let [free, other, none, unknown] = weights;
        let with = doubting.probabilities(&[free, other, pair, none, unknown]);
        assert!((with[0] - 0.6 * plain[0]).abs() < 1e-12);
        assert!((with[2] - 0.2 * plain[0]).abs() < 1e-12);
        assert!((with[4] - plain[3] - 0.2 * plain[0]).abs() < 1e-12);
    }

    /// A cause that leaves over one part in a hundred of what something unknown explains may have another formula; one that
    /// leaves over three does not, nor does any where two causes explain it all.
    #[test]
    fn a_small_remainder_may_be_the_formula_s() {
        let third = -(3.0f64.ln());
        let c = Calibration {
            form_tolerance: 0.02,
            free_doubt: 0.4,
            ..start()
        };
        let of = |gain| {
            let (none, unknown) = (single(third, 0.0), single(third, 1000.0));
            vec![single(third, gain), none, unknown]
        };
        assert_eq!(c.nearly(&of(990.0)), Some(0));
        let p = c.probabilities(&of(990.0));
        assert!(
            (p[0] - 0.6).abs() < 1e-4 && (p[2] - 0.4).abs() < 1e-4,
            "{p:?}"
        );
        assert_eq!(c.nearly(&of(970.0)), None);
        assert!(c.probabilities(&of(970.0))[2] > 0.99);
        assert_eq!(c.nearly(&of(1001.0)), None);
        let mut two = of(990.0);
        let pair = Weight {
            second: true,
            ..single(third, 1001.0)
        };
        two.insert(1, pair);
        assert_eq!(c.nearly(&two), None);
    }

    /// Nine tenths of what an explanation has that misfits go to unknown; one that fits keeps all.
    #[test]
    fn an_explanation_that_misfits_leaves_most_to_unknown() {
        let misfit = Weight {
            misfits: true,
            ..single(-1.0, 40.0)
        };
        let doubting = Calibration {
            misfit_doubt: 0.9,
            ..start()
        };
        let weights = [
            misfit,
            single(-1.0, 39.0),
            single(-1.0, 0.0),
            single(-1.0, 0.0),
        ];
        let plain = start().probabilities(&weights);
        let p = doubting.probabilities(&weights);
        assert!((p[0] - 0.1 * plain[0]).abs() < 1e-12);
        assert!((p[3] - plain[3] - 0.9 * plain[0]).abs() < 1e-12);
        assert_eq!(p[1..3], plain[1..3]);
    }

    #[test]
    fn frozen_calibrations_can_be_read() {
        for (kind, groups) in [(LogKind::Rig, 1), (LogKind::Drive, 1), (LogKind::Drive, 9)] {
            let c = Calibration::frozen(kind, groups).unwrap();
            assert!(c.temperature >= 1.0 && (0.5..1.0).contains(&c.set_probability));
            assert!((0.0..0.5).contains(&c.floor));
        }
    }
}
