//! From evidences to probabilities that mean what they say: a temperature, a threshold and the width of the set, learned
//! from cases whose truth was known (`learn`).
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
//! pairs, it gains by chance. One that gains less may still be there unseen: a share ρ of the first one's probability goes to
//! such pairs, by what they say. Thirty effects that a log neither shows nor rules out take from "none" together, each a little,
//! but one that is there mostly shows: none has η nats beside its evidence, which is never more than what evidence says too little
//! of it.
//!
//! # Reference
//! C. Guo et al., ICML 2017 (temperature).

mod learn;

use serde::{Deserialize, Serialize};

use crate::error::GapError;
use crate::evidence::log_sum_exp;
use crate::settings::LogKind;

pub use learn::Case;
pub(crate) use learn::HIGHEST_TEMPERATURE;

/// How raw evidences become probabilities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Kind of design it was made for: `ramp`, `rich`, `rig` or `kinematic`; against an outside simulator's log `contrast` (a rig's),
    /// `rich-contrast` or `ramp-contrast`.
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
    /// r: the set holds every answer of which evidence says at least this many times as much as of the best one.
    pub set_ratio: f64,
    /// η \[nats\], at least zero: how much likelier than by its evidence it is that nothing is missing.
    #[serde(default)]
    pub none_gain: f64,
    /// Gain \[nats\] that the best explanation stays below on 97.5 % of logs without any effect, or on all of a few.
    pub null_gain: f64,
    /// γ \[nats\]: what a second cause must add to the best one alone.
    pub second_gain: f64,
    /// ρ: how often one cause that explains a log has a second beside it that the log does not show.
    #[serde(default)]
    pub unseen_second: f64,
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
    /// Where the first of its two causes stands alone, and its share among all pairs of that one with another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) beside: Option<(usize, f64)>,
    /// It needs a formula that was left free.
    #[serde(default)]
    pub(crate) free: bool,
    /// Two causes that do little more than one by a free formula: where that one stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) behind: Option<usize>,
    /// With it the data still misfit by more than is adequate.
    #[serde(default)]
    pub(crate) misfits: bool,
    /// Of something unknown: its gain where no second cause has earned its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) without_pairs: Option<f64>,
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

/// Frozen calibrations, with the campaigns that made them.
const FROZEN: &str = include_str!("calibration.toml");
/// Manoeuvres from which a drive counts as rich.
const RICH: usize = 5;
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

    /// The frozen one for such a log against an outside simulator's.
    ///
    /// # Errors
    /// As [`frozen`](Self::frozen).
    pub fn frozen_contrast(kind: LogKind, groups: usize) -> Result<Self, GapError> {
        Self::named(match kind {
            LogKind::Rig => "contrast",
            LogKind::Kinematic => "motion-contrast",
            LogKind::Drive if groups >= RICH => "rich-contrast",
            LogKind::Drive => "ramp-contrast",
        })
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

    /// The gain that a second cause needs.
    fn bar(&self, weights: &[Weight]) -> f64 {
        // What two causes leave to something unknown is no bar to them.
        let alone = weights.iter().filter(|w| w.is_alone());
        let alone = alone.map(|w| w.without_pairs.unwrap_or(w.gain));
        alone.fold(f64::NEG_INFINITY, f64::max) + self.second_gain
    }

    /// Gain \[nats\] of an answer.
    fn gain(&self, weights: &[Weight], w: &Weight) -> f64 {
        let bar = self.bar(weights);
        let earned = || weights.iter().any(|w| w.second && w.gain > bar);
        match w.without_pairs {
            Some(gain) if !earned() => gain,
            _ => w.gain,
        }
    }

    /// Gain \[nats\] of the best explanation: of one cause, or of two where the second has earned its place, which one that
    /// falls short, or that only a tangent promises, has not.
    pub(crate) fn heard(&self, weights: &[Weight]) -> f64 {
        let bar = self.bar(weights);
        // After the causes come none and unknown.
        let causes = weights.iter().take(weights.len().saturating_sub(2));
        causes
            .filter(|w| w.is_alone() || (w.second && w.gain > bar))
            .map(|w| w.gain)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Two causes of which one would do: where the first stands alone, where both, and the part of the first one's probability
    /// that they have.
    pub(crate) fn unseen(&self, weights: &[Weight]) -> Vec<(usize, usize, f64)> {
        let bar = self.bar(weights);
        let all = weights.iter().enumerate().filter(|(_, w)| w.gain <= bar);
        all.filter_map(|(k, w)| {
            let (first, share) = w.beside?;
            Some((first, k, self.unseen_second * share))
        })
        .collect()
    }

    /// Probabilities of answers.
    pub(crate) fn probabilities(&self, weights: &[Weight]) -> Vec<f64> {
        let together = self.together(weights);
        let mut p = together.clone();
        for (first, k, part) in self.unseen(weights) {
            let moved = part * together.get(first).unwrap_or(&0.0);
            p[first] -= moved;
            p[k] += moved;
        }
        p
    }

    /// The same, one cause and whatever may stand unseen beside it being one answer.
    pub(crate) fn together(&self, weights: &[Weight]) -> Vec<f64> {
        let prior = log_sum_exp(weights.iter().map(|w| w.ln_prior));
        let said = weights.iter().zip(self.said(weights));
        said.map(|(w, said)| said + self.floor * ((w.ln_prior - prior).exp() - said))
            .collect()
    }

    /// What evidence says where it says something: the same without the floor.
    pub(crate) fn said(&self, weights: &[Weight]) -> Vec<f64> {
        let bar = self.bar(weights);
        let mut logs: Vec<f64> = weights
            .iter()
            .map(|w| {
                if w.behind.is_some() || (w.second && w.gain <= bar) {
                    f64::NEG_INFINITY
                } else {
                    w.ln_prior + self.gain(weights, w) / self.temperature
                }
            })
            .collect();
        // None is the last answer but one.
        if let [.., none, _] = &mut logs[..] {
            *none += self.none_gain;
        }
        let total = log_sum_exp(logs.iter().copied());
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
        said
    }

    /// True where an answer is in the set, by what evidence [`said`](Self::said) of it and of the best one. What share all the
    /// others have together does not matter: thirty answers that the evidence leaves alike weak are not a reason to list them, nor
    /// is the floor, which all have alike.
    pub(crate) fn holds(&self, said: f64, best: f64) -> bool {
        said >= self.set_ratio * best
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
        let unknown = self.gain(weights, unknown);
        let earned = self.bar(weights);
        let bar = (1.0 - self.form_tolerance) * unknown;
        let more = |w: &Weight| w.gain >= unknown && (!w.second || w.gain > earned);
        if self.form_tolerance == 0.0 || causes.iter().any(more) {
            return None;
        }
        let near = (0..causes.len()).filter(|k| causes[*k].is_alone() && causes[*k].gain >= bar);
        near.max_by(|a, b| causes[*a].gain.total_cmp(&causes[*b].gain))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn start() -> Calibration {
        Calibration {
            design: "test".to_owned(),
            temperature: 1.0,
            floor: 0.0,
            pair_doubt: 0.0,
            free_doubt: 0.0,
            form_tolerance: 0.0,
            misfit_doubt: 0.0,
            set_ratio: 0.05,
            none_gain: 0.0,
            null_gain: 3.0,
            second_gain: 3.0,
            unseen_second: 0.0,
            cases: 0,
            source: String::new(),
        }
    }

    pub(super) fn single(ln_prior: f64, gain: f64) -> Weight {
        Weight {
            ln_prior,
            gain,
            second: false,
            parts: None,
            beside: None,
            free: false,
            behind: None,
            misfits: false,
            without_pairs: None,
        }
    }

    /// A second cause that gains less than it does where it is needless gets nothing; one that gains more is weighed.
    #[test]
    fn a_second_cause_must_earn_its_place() {
        let pair = |gain| Weight {
            ln_prior: -3.0,
            gain,
            second: true,
            parts: None,
            beside: None,
            free: false,
            behind: None,
            misfits: false,
            without_pairs: None,
        };
        let c = start();
        assert_eq!(c.probabilities(&[single(-1.0, 10.0), pair(12.9)])[1], 0.0);
        let p = c.probabilities(&[single(-1.0, 10.0), pair(15.0)])[1];
        assert!((p - 1.0 / (1.0 + (2.0f64 - 5.0).exp())).abs() < 1e-12);
    }

    /// A pair beside one cause of ten nats is heard where it gains more than three beyond that, or beyond what something unknown
    /// gains; before that the one cause is, and unknown never.
    #[test]
    fn what_has_not_earned_its_place_is_not_heard() {
        let heard = |pair: f64, unknown: f64| {
            let pair = Weight {
                second: true,
                ..single(-3.0, pair)
            };
            let weights = [
                single(-1.0, 10.0),
                pair,
                single(0.0, 0.0),
                single(0.0, unknown),
            ];
            start().heard(&weights)
        };
        assert_eq!(heard(12.9, -5.0), 10.0);
        assert_eq!(heard(13.1, -5.0), 13.1);
        assert_eq!(heard(13.1, 11.0), 10.0);
        assert_eq!(heard(12.9, 30.0), 10.0);
    }

    /// A second cause that gains less than it must has its part of the share that the first cause leaves to what stands unseen
    /// beside it; one that gains enough is weighed like any other, and nothing else changes.
    #[test]
    fn a_second_cause_may_stand_unseen_beside_the_first() {
        let beside = |gain: f64, share: f64| Weight {
            second: true,
            beside: Some((0, share)),
            ..single(0.1f64.ln(), gain)
        };
        let (none, unknown) = (single(0.0, 0.0), single(0.0, 0.0));
        let weights =
            |second: Weight| vec![single(0.0, 10.0), second, beside(9.0, 0.1), none, unknown];
        let calibration = Calibration {
            unseen_second: 0.08,
            ..start()
        };
        let short = weights(beside(10.5, 0.4));
        let (blind, p) = (
            start().probabilities(&short),
            calibration.probabilities(&short),
        );
        assert_eq!(blind[1..3], [0.0, 0.0]);
        assert!((p[1] - 0.08 * 0.4 * blind[0]).abs() < 1e-12);
        assert!((p[2] - 0.08 * 0.1 * blind[0]).abs() < 1e-12);
        assert!((p[0] - (1.0 - 0.08 * 0.5) * blind[0]).abs() < 1e-12);
        assert_eq!(p[3..], blind[3..]);
        assert_eq!(calibration.together(&short), blind);
        let earned = weights(beside(14.0, 0.4));
        let (blind, p) = (
            start().probabilities(&earned),
            calibration.probabilities(&earned),
        );
        assert_eq!(p[1], blind[1]);
        assert!(p[1] > 0.5 && calibration.unseen(&earned).iter().all(|u| u.1 == 2));
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
    /// leaves over three does not, nor does any where two causes explain it all and have earned their place.
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
        two[3].without_pairs = Some(995.0);
        let asking = |second_gain| Calibration {
            second_gain,
            ..c.clone()
        };
        assert_eq!(asking(5.0).nearly(&two), None);
        assert_eq!(asking(7.0).nearly(&two), Some(0));
    }

    /// One cause that explains the data, and two that say more but have not earned their place: what they leave to something unknown,
    /// which is more than one cause says, is no doubt in that. Where they have earned it, it is.
    #[test]
    fn two_causes_that_are_not_heard_feed_nothing_unknown() {
        let pair = Weight {
            second: true,
            ..single(-1.0, 60.0)
        };
        let unknown = Weight {
            without_pairs: Some(32.0),
            ..single(-1.0, 52.0)
        };
        let weights = [single(-1.0, 40.0), pair, single(-1.0, 0.0), unknown];
        let asking = |second_gain| Calibration {
            second_gain,
            ..start()
        };
        let p = asking(30.0).probabilities(&weights);
        assert!(p[0] > 0.99 && p[1] == 0.0, "{p:?}");
        let p = asking(10.0).probabilities(&weights);
        assert!(p[1] > 0.99 && p[3] < 1e-3 && p[3] > p[0], "{p:?}");
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

    /// The set goes by how far an answer is behind the best one, not by how many weak ones there are beside it, nor by what the
    /// floor leaves to one of a large prior.
    #[test]
    fn weak_answers_join_no_set_however_many() {
        let c = Calibration {
            floor: 0.2,
            ..start()
        };
        for weak in [3, 60] {
            let mut weights = vec![single(0.0, 12.0), single(0.0, 9.5)];
            weights.extend((0..weak).map(|_| single(0.0, 8.5)));
            weights.push(single(3.0, 0.0));
            let said = c.said(&weights);
            let held = said.iter().filter(|s| c.holds(**s, said[0]));
            // e^-2.5 = .08 is enough, e^-3.5 = .03 is not.
            assert_eq!(held.count(), 2, "{said:?}");
            let p = c.probabilities(&weights);
            assert!(p[weak + 2] > 0.04 * p[0], "{p:?}");
        }
    }

    #[test]
    fn frozen_calibrations_can_be_read() {
        for (kind, groups) in [(LogKind::Rig, 1), (LogKind::Drive, 1), (LogKind::Drive, 9)] {
            let alone = Calibration::frozen(kind, groups).unwrap();
            let against = Calibration::frozen_contrast(kind, groups).unwrap();
            for c in [&alone, &against] {
                assert!(c.temperature >= 1.0 && (0.05..=0.2).contains(&c.set_ratio));
                assert!((0.0..0.5).contains(&c.floor));
            }
            assert_ne!(alone.design, against.design);
        }
    }
}
