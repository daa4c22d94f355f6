//! How a calibration is learned from cases whose truth was known.
//!
//! # Equation
//! T, ε, δ, η, γ and ρ minimise Σ -ln P(truth), γ and ρ only where cases with two causes say what they cost, else γ is the 95 %
//! quantile of what needless ones gained. The set holds all answers k with p_k >= r max p, p being P without the floor: r is
//! the largest that kept the truth in 90 % of the cases, between 1/20 and 1/5; a name needs a gain above the 97.5 % quantile of
//! what the best explanation gained on cases without any effect, or of fewer than 39 of them above all.
//!
//! # Reference
//! D. Madigan, A. E. Raftery, J. American Statistical Association 89:1535-1546, 1994 (Occam's window, 1/20); V. Vovk, A.
//! Gammerman, G. Shafer, Algorithmic Learning in a Random World, 2005 (a level learned from cases).

use terra_model::order::ascending;

use super::{Calibration, Weight};

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

/// The lowest is 1: on sealed logs evidence says a little less than it could, and on a log whose noise is not as stated that is what
/// keeps a null from being named.
pub(crate) const HIGHEST_TEMPERATURE: f64 = 30.0;
/// Floors that are tried.
const FLOORS: [f64; 9] = [0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2];
/// Doubts that are tried.
const DOUBTS: [f64; 12] = [0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Shares for what stands unseen beside one cause that are tried.
const UNSEEN: [f64; 9] = [0.0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3];
/// Gains \[nats\] of none that are tried: up to the last, in steps of a tenth. A log without a cause must not be talked into one.
const NONE_GAINS: u32 = 20;
/// Gains \[nats\] of a second cause that are tried: up to the last, in steps of one half.
const SECOND_GAINS: u32 = 40;
/// Loss \[nats\] over all cases by which two such gains are as good as each other.
const FLAT: f64 = 0.01;
/// An answer of which evidence says twenty times less than of the best is none, however many of them it would take to hold the
/// truth of the few cases in which evidence says nothing.
const WIDEST_SET: f64 = 0.05;
/// One of which it says a fifth as much is one, even where most cases are so clear that first answers alone hold the truth
/// often enough.
const NARROWEST_SET: f64 = 0.2;
/// Share of nulls on which the best explanation stays unheard: of some sixty then seldom more than one in twenty is heard.
const UNHEARD: f64 = 0.975;
/// The same of fewer than 39: the largest gain of them all, from nineteen on.
const UNHEARD_OF_FEW: f64 = 0.95;
/// Cases with two causes from which they say what asking more of a second one costs.
const ENOUGH_PAIRS: usize = 20;

impl Calibration {
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
        out.learn_none_gain(&cases);
        let pairs = cases.iter().filter(|c| c.weights[c.truth].second);
        if pairs.count() >= ENOUGH_PAIRS {
            // What a second cause that falls short still has changes what it must gain.
            for _ in 0..2 {
                out.learn_second_gain(&cases);
                out.learn_unseen(&cases);
                out.learn_doubts(&cases);
                out.learn_none_gain(&cases);
            }
        }
        let odds: Vec<f64> = cases.iter().map(|c| out.odds_of_best(c)).collect();
        if let Some(odds) = upper_quantile(&odds, 0.9) {
            out.set_ratio = odds.recip().clamp(WIDEST_SET, NARROWEST_SET);
        }
        out.learn_null_gain(&cases);
        out
    }

    /// The same with the gain of nulls learned from these cases: a quantile needs more of them than all the rest does.
    #[must_use]
    pub fn with_nulls(mut self, cases: &[Case]) -> Self {
        let cases: Vec<&Case> = cases.iter().filter(|c| !c.weights.is_empty()).collect();
        self.learn_null_gain(&cases);
        self
    }

    /// Gain that the best explanation stays below on nearly all of those cases in which nothing is missing.
    fn learn_null_gain(&mut self, cases: &[&Case]) {
        let nulls = cases.iter().filter(|c| c.is_null() && c.causes > 0);
        let heard: Vec<f64> = nulls.map(|c| self.heard(&c.weights)).collect();
        let quantile = |share| upper_quantile(&heard, share);
        if let Some(gain) = quantile(UNHEARD).or_else(|| quantile(UNHEARD_OF_FEW)) {
            self.null_gain = gain.max(0.0);
        }
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

    /// Gain of none of the least loss.
    fn learn_none_gain(&mut self, cases: &[&Case]) {
        let gains = (0..=NONE_GAINS).map(|k| f64::from(k) / 10.0);
        self.take_best(gains, cases, |c, gain| c.none_gain = gain);
    }

    /// Share for what stands unseen beside one cause of the least loss.
    fn learn_unseen(&mut self, cases: &[&Case]) {
        self.take_best(UNSEEN.into_iter(), cases, |c, share| {
            c.unseen_second = share
        });
    }

    /// Sets one of its numbers to the value of the least loss.
    fn take_best(
        &mut self,
        values: impl Iterator<Item = f64>,
        cases: &[&Case],
        set: impl Fn(&mut Calibration, f64),
    ) {
        let losses = values.map(|value| {
            let mut trial = self.clone();
            set(&mut trial, value);
            (trial.loss(cases), value)
        });
        if let Some((_, best)) = losses.min_by(|a, b| a.0.total_cmp(&b.0)) {
            set(self, best);
        }
    }

    /// How many times as much as of the truth evidence says of the best answer.
    fn odds_of_best(&self, case: &Case) -> f64 {
        let said = self.said(&case.weights);
        said.iter().copied().fold(0.0, f64::max) / said[case.truth]
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
    use super::super::Evidence;
    use super::super::tests::{single, start};
    use super::*;

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
        // Cooled, it says .3 / .7 as much of the truth there as of the best: the narrowest set holds it.
        assert_eq!(learned.set_ratio, NARROWEST_SET, "{learned:?}");
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

    /// 95 % of 19 nulls lie at or below the largest: ceil(20 * .95) = 19. Of 79 one may be heard: ceil(80 * .975) = 78.
    #[test]
    fn the_threshold_is_the_quantile_of_nulls() {
        let cases: Vec<Case> = (0..19)
            .map(|k| Case {
                truth: 1,
                causes: 1,
                weights: vec![
                    single(0.0, f64::from(k) / 4.0),
                    single(0.0, 0.0),
                    single(0.0, 0.0),
                ],
                another_form: false,
            })
            .collect();
        let learned = Calibration::learn(&cases, &start(), String::new());
        assert_eq!(learned.null_gain, 4.5);
        // More of them change that alone.
        let more: Vec<Case> = cases.iter().take(10).cloned().cycle().take(30).collect();
        let with_more = learned.clone().with_nulls(&more);
        assert_eq!(with_more.null_gain, 2.25);
        let many: Vec<Case> = cases.iter().take(18).cloned().cycle().take(77).collect();
        let largest = &cases[18..];
        let many = [&many[..], largest, largest].concat();
        assert_eq!(learned.clone().with_nulls(&many).null_gain, 4.5);
        let lower = [&many[..78], &cases[..1]].concat();
        assert_eq!(learned.clone().with_nulls(&lower).null_gain, 4.25);
        assert_eq!(
            Calibration {
                null_gain: 4.5,
                ..with_more
            },
            learned
        );
        assert_eq!(upper_quantile(&[1.0, 2.0], 0.95), None);
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
                    beside: None,
                    free: false,
                    behind: None,
                    misfits: false,
                    without_pairs: None,
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

    /// One cause in ten has a second beside it that no evidence shows, in one of two places alike: a tenth of what the first
    /// has goes there.
    #[test]
    fn what_stands_unseen_beside_one_cause_is_counted() {
        let beside = Weight {
            second: true,
            beside: Some((0, 0.5)),
            ..single(-3.0, 38.0)
        };
        let cases: Vec<Case> = (0..200)
            .map(|k| Case {
                truth: if k % 10 == 0 { 1 + (k / 10) % 2 } else { 0 },
                causes: 3,
                weights: vec![
                    single(-1.0, 40.0),
                    beside,
                    beside,
                    single(-1.0, 0.0),
                    single(-1.0, 0.0),
                ],
                another_form: false,
            })
            .collect();
        let learned = Calibration::learn(&cases, &start(), "test".to_owned());
        let p = learned.probabilities(&cases[0].weights);
        assert!(
            (p[0] - 0.9).abs() < 0.03 && (p[1] - 0.05).abs() < 0.015,
            "{learned:?} {p:?}"
        );
        // Where no case has two there is nothing to learn it from.
        let alone: Vec<Case> = cases.into_iter().map(|c| Case { truth: 0, ..c }).collect();
        assert_eq!(
            Calibration::learn(&alone, &start(), String::new()).unseen_second,
            0.0
        );
    }

    /// Evidence leaves one part in three to twenty effects that hardly show, and is that of none nine times out of ten: their part
    /// becomes a tenth. Where it is none half of the time nothing is taken from none.
    #[test]
    fn what_hardly_shows_takes_no_more_from_none_than_it_is_there() {
        let weights = || {
            let third = (1.0f64 / 3.0).ln();
            let mut all = vec![single(third - 20f64.ln(), 0.0); 20];
            all.extend([single(third + 2f64.ln(), 0.0), single(-30.0, 0.0)]);
            all
        };
        let learned = |effects: usize| {
            let cases: Vec<Case> = (0..400)
                .map(|k| Case {
                    truth: if k % 20 < effects { k / 20 } else { 20 },
                    causes: 20,
                    weights: weights(),
                    another_form: false,
                })
                .collect();
            Calibration::learn(&cases, &start(), "test".to_owned())
        };
        let seldom = learned(2);
        let p = seldom.probabilities(&weights());
        assert!((p[20] - 0.9).abs() < 0.01, "{seldom:?} {p:?}");
        assert!((p[0] - p[19]).abs() < 1e-12 && (p[0] - 0.005).abs() < 5e-4);
        assert_eq!(learned(10).none_gain, 0.0);
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
                beside: None,
                free: false,
                behind: None,
                misfits: false,
                without_pairs: None,
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
}
